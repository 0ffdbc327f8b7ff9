//! The black level: a dark background whose noise is too small for its light, or which lies below zero.

use super::{Concern, Severity};
use crate::background::Background;
use crate::photograph::Photograph;

/// Share of the noise of photons below which a background is not light. A tenth allows for an unknown gain.
const MIN_PHOTON_SHARE: f64 = 0.1;
/// Level below zero, standard deviations of a pixel, from which on the black level is too high.
const MAX_BELOW_ZERO: f64 = 1.0;

/// Returns whether the level of `background`, of one channel of `photo`, cannot be light.
pub fn check(photo: &Photograph, background: &Background) -> Option<Concern> {
    if !photo.white.is_finite() {
        return None;
    }
    let (level, sigma) = (background.typical_level(), background.typical_sigma());
    let below = level < -MAX_BELOW_ZERO * sigma;
    let photons = MIN_PHOTON_SHARE * photo.assumed_gain() * level;
    if !below && (level < 5.0 * sigma || sigma * sigma > photons) {
        return None;
    }
    let problem = if below {
        format!("has a dark background of {level:.0} counts: the black level is too high")
    } else {
        format!(
            "has a dark background of {level:.0} counts with a noise of {sigma:.1}, too little for so much light: the black level is too low"
        )
    };
    let remedy = "state the black level, which the margin of the sensor or a dark frame shows; the background is taken off the lights in any case";
    Some(Concern::new(Severity::Note, &photo.name, problem, remedy))
}
