//! Real lens blur: lenses learned from measured point-spread functions (PSFs), applied to plates, removed from
//! them and diagnosed.
#![forbid(unsafe_code)]

pub use seidel_calibrate::{diagnose, eval, fit, measure, score};
pub use seidel_optics::{
    camera, distance, effects, error, field, lens, moments, numeric, observations, predict,
    profile, psf, sensor, tile,
};
pub use seidel_render as render;
pub use seidel_render::{plate, remove};

pub use error::{Error, ErrorKind, Fault, Result};
