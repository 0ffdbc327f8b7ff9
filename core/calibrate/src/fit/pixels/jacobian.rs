//! Derivative of a local pupil with respect to a model parameter.

use seidel_optics::lens::{LocalPupil, MAX_STOPS, Stop, TERMS, Transmission, Wavefront};

/// Number of parameters of the stops other than the rim: centre and radius of each.
pub(super) const STOP_PARAMETERS: usize = 3 * (MAX_STOPS - 1);

/// Number of parameters that change the light through the pupil: those of the stops, and four of the transmission.
pub(super) const LIGHT_PARAMETERS: usize = STOP_PARAMETERS + 4;

/// Number of parameters of the obstruction: centre and radius.
pub(super) const SHADOW_PARAMETERS: usize = 3;

/// The pupils on both sides of a value of a parameter.
pub(super) struct PupilChange {
    /// Index of the parameter.
    pub(super) slot: usize,
    pub(super) low: LocalPupil,
    pub(super) high: LocalPupil,
    /// Change of the parameter from `low` to `high`.
    pub(super) distance: f64,
}

/// Derivative of a local pupil with respect to one model parameter.
#[derive(Debug, Clone)]
pub(super) struct ParameterDerivative {
    /// Index of the parameter.
    pub(super) slot: usize,
    /// Derivative of the wavefront.
    pub(super) wavefront: Wavefront,
    /// Derivatives of centre (x, y) and radius of each stop other than the rim, then of the transmission: square, fourth,
    /// centre (x, y).
    pub(super) light: [f64; LIGHT_PARAMETERS],
    /// Derivatives of centre (x, y) and radius of the obstruction.
    pub(super) shadow: [f64; SHADOW_PARAMETERS],
    /// Derivative of the blur's variance, px².
    pub(super) blur: f64,
    /// Derivative of the centroid (x, y) from the chief ray, px.
    pub(super) centroid: [f64; 2],
}

impl ParameterDerivative {
    /// Returns the derivatives of `here` by all parameters that `changes` moves.
    pub(super) fn all(here: &LocalPupil, changes: impl Iterator<Item = PupilChange>) -> Vec<Self> {
        let mut all: Vec<Self> = changes.map(|change| Self::between(here, &change)).collect();
        let wavefronts: Vec<&Wavefront> = all.iter().map(|d| &d.wavefront).collect();
        let slopes = here.mean_slopes(&wavefronts);
        for (derivative, slope) in all.iter_mut().zip(slopes) {
            // Where the light changes the centroid was compared itself.
            if !derivative.changes_light() {
                derivative.centroid = slope;
            }
        }
        all
    }

    fn changes_light(&self) -> bool {
        self.light != [0.0; LIGHT_PARAMETERS] || self.shadow != [0.0; SHADOW_PARAMETERS]
    }

    fn between(here: &LocalPupil, change: &PupilChange) -> Self {
        let PupilChange {
            slot,
            ref low,
            ref high,
            distance,
        } = *change;
        let (a, b) = (low.wavefront.coefficients(), high.wavefront.coefficients());
        let mut coefficients = [0.0; TERMS];
        for (k, c) in coefficients.iter_mut().enumerate() {
            *c = (b[k] - a[k]) / distance;
        }
        let mut light = [0.0; LIGHT_PARAMETERS];
        let counts = [here, low, high].map(|p| p.stops().len());
        // A stop that only begins to clip has no derivative yet.
        if counts[0] == counts[1] && counts[0] == counts[2] {
            let pairs = low.stops().iter().zip(high.stops()).skip(1);
            for (rates, (a, b)) in light.chunks_exact_mut(3).zip(pairs) {
                let rate = |f: fn(&Stop) -> f64| (f(b) - f(a)) / distance;
                rates[0] = rate(|s| s.centre[0]);
                rates[1] = rate(|s| s.centre[1]);
                rates[2] = rate(|s| s.radius);
            }
        }
        let [from, to] = [low, high].map(|p| transmission_numbers(&p.transmission));
        for (k, rate) in light[STOP_PARAMETERS..].iter_mut().enumerate() {
            *rate = (to[k] - from[k]) / distance;
        }
        let mut derivative = Self {
            centroid: [0.0; 2],
            slot,
            wavefront: Wavefront::from_coefficients(coefficients),
            light,
            shadow: shadow_rates(low, high).map(|change| change / distance),
            blur: (high.blur_variance_px2 - low.blur_variance_px2) / distance,
        };
        if derivative.changes_light() {
            let (from, to) = (low.centroid(), high.centroid());
            derivative.centroid = [0, 1].map(|axis| (to[axis] - from[axis]) / distance);
        }
        derivative
    }
}

/// Returns the change of the obstruction's centre (x, y) and radius; none where there is no obstruction on one side.
fn shadow_rates(low: &LocalPupil, high: &LocalPupil) -> [f64; SHADOW_PARAMETERS] {
    let (Some(a), Some(b)) = (low.obstruction(), high.obstruction()) else {
        return [0.0; SHADOW_PARAMETERS];
    };
    [
        b.centre[0] - a.centre[0],
        b.centre[1] - a.centre[1],
        b.radius - a.radius,
    ]
}

fn transmission_numbers(transmission: &Transmission) -> [f64; 4] {
    let Transmission {
        square,
        fourth,
        centre: [x, y],
        picture: _,
    } = *transmission;
    [square, fourth, x, y]
}
