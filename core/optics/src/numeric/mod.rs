//! Numerical utilities: the product's random generator.

mod random;

pub use random::SplitMix64;
