//! Cases by exact ray trace: published lens prescriptions with errors of manufacture.
//!
//! A second simulator beside the pencils of third order in `lens` and `pencil`. Rays obey Snell's law at every surface and
//! pass the real stop; indices follow a dispersion formula; errors move and bend surfaces. The sensor, the blades and the
//! noise are those of the first simulator.
//!
//! The steps of a tile: `lens` gives a designed `assembly`; `errors` or `unknown` changes it; `beam` traces a grid of rays
//! through it onto a fine grid; `tiles` integrates that over pixels.

mod approximation;
mod assembly;
mod beam;
mod change;
mod colour;
mod dispersion;
mod draw;
mod errors;
mod figure;
mod lens;
mod pairing;
mod paraxial;
mod prescription;
mod surface;
mod tiles;
mod unknown;
mod vector;

#[cfg(test)]
mod tests;

pub(super) use lens::GlassLens;

/// Identifiers of the effects that a case of a traced lens can have.
pub(crate) const EFFECTS: [&str; 17] = [
    "defocus_offset",
    "depth_scale",
    "sensor_tilt",
    "decentre",
    "pupil_scale",
    "vignetting",
    "aperture_polygon",
    "apodisation",
    "higher_order",
    "axial_colour",
    "lateral_colour",
    "distortion",
    "anamorphic",
    "pixel_footprint",
    "motion",
    "veiling_glare",
    "tone_curve",
];

/// Families of causes of traced lenses that are not in the effect library.
///
/// `air_space` and `glass_index` change the aberrations of third order themselves, with the sensor focused again and the
/// image size kept: no effect of the library has these terms.
pub(crate) const UNKNOWN: [&str; 9] = [
    "central_obstruction",
    "trefoil",
    "ripple",
    "ghost",
    "sharpening",
    "bleeding",
    "radial_smear",
    "air_space",
    "glass_index",
];
