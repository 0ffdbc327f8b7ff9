//! Numerical utilities.

mod random;

pub use random::SplitMix64;
