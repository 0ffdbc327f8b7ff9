//! How a pupil changes with one free number of a lens.

use seidel_optics::lens::{LocalPupil, MAX_STOPS, Stop, TERMS, Wavefront};

/// Numbers of the stops besides the rim: centre and radius of each.
pub(super) const STOP_NUMBERS: usize = 3 * (MAX_STOPS - 1);

/// How a pupil changes with one free number.
#[derive(Debug, Clone)]
pub(super) struct Change {
    /// Which.
    pub(super) slot: usize,
    /// Rate of the wavefront.
    pub(super) wavefront: Wavefront,
    /// Rates of centre (x, y) and radius of each stop but the rim.
    pub(super) stops: [f64; STOP_NUMBERS],
    /// Rate of the blur's variance, px².
    pub(super) blur: f64,
}

impl Change {
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
        let mut stops = [0.0; STOP_NUMBERS];
        let counts = [here, low, high].map(|p| p.stops().len());
        // A stop that only just begins to clip has no effect yet.
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
