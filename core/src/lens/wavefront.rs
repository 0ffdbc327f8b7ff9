//! The wavefront: an open-ended sum of terms whose slope over the pupil says where rays land.

use super::ReducedNumbers;
use crate::field::FieldPoint;

/// One part of the wavefront, scaled so that its slope over the unit pupil is the lateral ray offset
/// on the sensor.
pub trait WavefrontTerm: Send + Sync {
    /// Height at pupil point `u` (unit disc) for field position `at`, in PSF length.
    fn height(&self, at: FieldPoint, u: [f64; 2]) -> f64;

    /// Gradient of the height by u: the ray's offset from the chief ray, in PSF length.
    fn slope(&self, at: FieldPoint, u: [f64; 2]) -> [f64; 2];
}

/// The sum of wavefront terms of a lens at one depth and channel.
#[derive(Default)]
pub struct Wavefront {
    /// The terms; heights and slopes add.
    pub terms: Vec<Box<dyn WavefrontTerm>>,
}

impl Wavefront {
    /// The wavefront of a third-order lens.
    pub fn third_order(numbers: ReducedNumbers) -> Self {
        Self {
            terms: vec![Box::new(ThirdOrder(numbers))],
        }
    }

    /// Lateral offset from the chief ray of the ray through pupil point `u`, in PSF length.
    pub fn slope(&self, at: FieldPoint, u: [f64; 2]) -> [f64; 2] {
        self.terms.iter().fold([0.0, 0.0], |sum, term| {
            let slope = term.slope(at, u);
            [sum[0] + slope[0], sum[1] + slope[1]]
        })
    }
}

/// Defocus, spherical aberration, astigmatism, field curvature and coma: Eqs 5-6 without distortion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThirdOrder(pub ReducedNumbers);

impl WavefrontTerm for ThirdOrder {
    fn height(&self, at: FieldPoint, u: [f64; 2]) -> f64 {
        let n = &self.0;
        let u2 = u[0] * u[0] + u[1] * u[1];
        let h2 = at.x * at.x + at.y * at.y;
        let along = at.x * u[0] + at.y * u[1];
        (n.alpha + n.delta * h2) * u2 / 2.0 + n.beta * u2 * u2 / 4.0 + n.gamma * along * along / 2.0
            - n.phi * u2 * along
    }

    fn slope(&self, at: FieldPoint, u: [f64; 2]) -> [f64; 2] {
        let n = &self.0;
        let u2 = u[0] * u[0] + u[1] * u[1];
        let h2 = at.x * at.x + at.y * at.y;
        let along = at.x * u[0] + at.y * u[1];
        let radial = n.alpha + n.beta * u2 + n.delta * h2 - 2.0 * n.phi * along;
        let chief = n.gamma * along - n.phi * u2;
        [radial * u[0] + chief * at.x, radial * u[1] + chief * at.y]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slope_is_the_gradient_of_the_height() {
        let term = ThirdOrder(ReducedNumbers {
            alpha: 1.3,
            beta: -0.7,
            gamma: 0.4,
            delta: 0.9,
            phi: -0.5,
        });
        let at = FieldPoint::new(0.6, -0.4);
        let step = 1e-5;
        for u in [[0.2, 0.5], [-0.7, 0.1], [0.0, 0.0]] {
            let slope = term.slope(at, u);
            for axis in 0..2 {
                let (mut low, mut high) = (u, u);
                low[axis] -= step;
                high[axis] += step;
                let numeric = (term.height(at, high) - term.height(at, low)) / (2.0 * step);
                assert!((slope[axis] - numeric).abs() < 1e-9);
            }
        }
    }
}
