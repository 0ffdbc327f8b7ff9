//! The score of a predicted point-spread function (PSF) against an observed one.

mod forward_blur;
mod kernel;
mod spectrum;
mod test_image;
mod tiles;

pub use forward_blur::{BlurScorer, ImageCorrelation};
pub(crate) use kernel::{draw, kernel_of_lens, on_pixels};
pub(crate) use spectrum::quick_length;
pub use test_image::TestImage;
pub(crate) use tiles::{PlacedTile, place as place_tiles, to_unit_sum};
