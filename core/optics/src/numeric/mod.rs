//! Numerical tools that are not optics.

mod random;

pub use random::SplitMix64;
