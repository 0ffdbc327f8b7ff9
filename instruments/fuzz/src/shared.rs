//! The seeds of the attack. It uses some parts that are not used here.

#[path = "../../attack/src/seeds/exr.rs"]
pub(crate) mod exr;
#[path = "../../attack/src/seeds/photographs.rs"]
pub(crate) mod photographs;
#[path = "../../attack/src/seeds/pixels.rs"]
mod pixels;
#[path = "../../attack/src/seeds/raster.rs"]
pub(crate) mod raster;
#[path = "../../attack/src/seeds/texts.rs"]
pub(crate) mod texts;

pub(crate) use pixels::{HEIGHT, WIDTH, plane, read, sample};
