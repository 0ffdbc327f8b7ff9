//! Valid inputs of every reader, made by the project's own writers or composed here.

pub(crate) mod exr;
pub(crate) mod lenses;
pub(crate) mod photographs;
mod pixels;
pub(crate) mod raster;
pub(crate) mod texts;

pub(crate) use pixels::{HEIGHT, WIDTH, plane, read, sample};
