//! Departures of a surface from its sphere.

/// A departure of a surface from its sphere: its sag along the axis of the surface, mm, at (x, y) mm from its vertex.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Figure {
    /// Coefficients of x² and y².
    pub(super) square: [f64; 2],
    /// Coefficient of r⁴.
    pub(super) quartic: f64,
    /// Coefficient of r⁶.
    pub(super) sextic: f64,
    /// Coefficients of x³ - 3 x y² and 3 x² y - y³.
    pub(super) trefoil: [f64; 2],
    pub(super) ripple: Option<Ripple>,
}

/// A sinusoidal ripple of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ripple {
    /// Amplitude, mm.
    pub(super) height: f64,
    /// Wave vector, radians per mm.
    pub(super) wave_number: [f64; 2],
    /// Phase, radians.
    pub(super) phase: f64,
}

/// A sag and its slopes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sag {
    pub(super) height: f64,
    pub(super) by_x: f64,
    pub(super) by_y: f64,
}

impl Figure {
    /// Returns the sum of two figures, with the ripple of `other` if it has one.
    pub(super) fn plus(self, other: Self) -> Self {
        let sum = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
        Self {
            square: sum(self.square, other.square),
            quartic: self.quartic + other.quartic,
            sextic: self.sextic + other.sextic,
            trefoil: sum(self.trefoil, other.trefoil),
            ripple: other.ripple.or(self.ripple),
        }
    }

    /// Returns the sag at (x, y).
    pub(super) fn sag(&self, x: f64, y: f64) -> Sag {
        let r2 = x * x + y * y;
        let [a, b] = self.square;
        let (q, s) = (self.quartic, self.sextic);
        let [t, u] = self.trefoil;
        let radial = 4.0 * q * r2 + 6.0 * s * r2 * r2;
        let (diff, double) = (x * x - y * y, 2.0 * x * y);
        let mut sag = Sag {
            height: a * x * x
                + b * y * y
                + (q + s * r2) * r2 * r2
                + t * x * (x * x - 3.0 * y * y)
                + u * y * (3.0 * x * x - y * y),
            by_x: 2.0 * a * x + radial * x + 3.0 * (t * diff + u * double),
            by_y: 2.0 * b * y + radial * y + 3.0 * (u * diff - t * double),
        };
        if let Some(ripple) = self.ripple {
            let [kx, ky] = ripple.wave_number;
            let (sin, cos) = libm::sincos(kx * x + ky * y + ripple.phase);
            sag.height += ripple.height * sin;
            sag.by_x += ripple.height * kx * cos;
            sag.by_y += ripple.height * ky * cos;
        }
        sag
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_derivatives_of_the_sag() {
        let figure = Figure {
            square: [0.3, -0.2],
            quartic: 0.05,
            sextic: -0.02,
            trefoil: [0.1, 0.07],
            ripple: Some(Ripple {
                height: 0.02,
                wave_number: [2.0, -3.0],
                phase: 0.4,
            }),
        };
        let step = 1e-5;
        for [x, y] in [[0.4, -0.9], [-1.1, 0.3], [0.0, 0.0]] {
            let at = |dx: f64, dy: f64| figure.sag(x + dx, y + dy).height;
            let sag = figure.sag(x, y);
            let by_x = (at(step, 0.0) - at(-step, 0.0)) / (2.0 * step);
            let by_y = (at(0.0, step) - at(0.0, -step)) / (2.0 * step);
            assert!((by_x - sag.by_x).abs() < 1e-8 && (by_y - sag.by_y).abs() < 1e-8);
        }
    }
}
