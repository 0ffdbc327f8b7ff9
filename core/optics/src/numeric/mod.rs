//! Numerical utilities: the product's random generator, the normal distribution.

mod normal;
mod random;

pub use normal::StandardNormal;
pub use random::SplitMix64;
