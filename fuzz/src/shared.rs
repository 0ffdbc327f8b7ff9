//! The seeds of the attack. It uses some parts that are not used here.

#[path = "../../tests/attack/src/seeds/exr.rs"]
pub(crate) mod exr;
#[path = "../../tests/attack/src/seeds/photographs.rs"]
pub(crate) mod photographs;
#[path = "../../tests/attack/src/seeds/pixels.rs"]
mod pixels;
#[path = "../../tests/attack/src/seeds/raster.rs"]
pub(crate) mod raster;
#[path = "../../tests/attack/src/seeds/texts.rs"]
pub(crate) mod texts;

pub(crate) use pixels::{HEIGHT, WIDTH, plane, read, sample};
