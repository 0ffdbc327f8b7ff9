//! Numerical utilities: dot products, medians and quantiles, the normal distribution, the product's random generator.

mod dot;
mod normal;
mod random;
mod robust;

pub use dot::dot;
pub use normal::{StandardNormal, normal_cdf};
pub use random::SplitMix64;
pub use robust::{median, quantile, scatter};
