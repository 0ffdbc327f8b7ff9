//! Central moments of PSFs: size, elongation and skewness.

mod central;
mod fourth;
mod meridional;
pub mod pixels;
pub mod support;

pub use central::CentralMoments;
pub use fourth::FourthMoments;
pub use meridional::MeridionalMoments;
