//! The score of a predicted point-spread function (PSF) against an observed one.

mod forward_blur;
mod kernel;
mod misplaced_light;
mod mosaic_gaps;
mod residuals;
mod spectrum;
mod test_image;
mod tiles;

pub use forward_blur::{BlurScorer, ImageAutocorrelation};
pub(crate) use kernel::{predicted_kernel, render_kernel, with_pixel_integration};
pub use misplaced_light::misplaced_light;
pub use residuals::{PixelResidual, pixel_residuals};
pub use test_image::TestImage;
pub(crate) use tiles::{PreparedTile, prepare_tiles, to_unit_sum};
