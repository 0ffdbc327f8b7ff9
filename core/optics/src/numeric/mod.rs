//! Numerical utilities: the product's random generator, the normal distribution.

mod normal;
mod random;

pub use normal::{StandardNormal, normal_cdf};
pub use random::SplitMix64;
