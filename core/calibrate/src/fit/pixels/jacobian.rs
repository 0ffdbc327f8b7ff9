//! Derivative of a local pupil with respect to a model parameter.

use seidel_optics::lens::{LocalPupil, MAX_STOPS, Stop, TERMS, Wavefront};

/// Number of parameters of the stops other than the rim: centre and radius of each.
pub(super) const STOP_PARAMETERS: usize = 3 * (MAX_STOPS - 1);

/// Derivative of a local pupil with respect to one model parameter.
#[derive(Debug, Clone)]
pub(super) struct ParameterDerivative {
    /// Index of the parameter.
    pub(super) slot: usize,
    /// Derivative of the wavefront.
    pub(super) wavefront: Wavefront,
    /// Derivatives of centre (x, y) and radius of each stop other than the rim.
    pub(super) stops: [f64; STOP_PARAMETERS],
    /// Derivative of the blur's variance, px².
    pub(super) blur: f64,
}

impl ParameterDerivative {
    pub(super) fn between(
        slot: usize,
        here: &LocalPupil,
        low: &LocalPupil,
        high: &LocalPupil,
        distance: f64,
    ) -> Self {
        let (a, b) = (low.wavefront.coefficients(), high.wavefront.coefficients());
        let mut coefficients = [0.0; TERMS];
        for (k, c) in coefficients.iter_mut().enumerate() {
            *c = (b[k] - a[k]) / distance;
        }
        let mut stops = [0.0; STOP_PARAMETERS];
        let counts = [here, low, high].map(|p| p.stops().len());
        // A stop that only begins to clip has no derivative yet.
        if counts[0] == counts[1] && counts[0] == counts[2] {
            let pairs = low.stops().iter().zip(high.stops()).skip(1);
            for (rates, (a, b)) in stops.chunks_exact_mut(3).zip(pairs) {
                let rate = |f: fn(&Stop) -> f64| (f(b) - f(a)) / distance;
                rates[0] = rate(|s| s.centre[0]);
                rates[1] = rate(|s| s.centre[1]);
                rates[2] = rate(|s| s.radius);
            }
        }
        Self {
            slot,
            wavefront: Wavefront::from_coefficients(coefficients),
            stops,
            blur: (high.blur_variance_px2 - low.blur_variance_px2) / distance,
        }
    }
}
