//! Three numbers at a time: places and directions in metres, or linear R, G, B.

use std::ops::{Add, Mul, Neg, Sub};

/// Three numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct V3(pub(super) f64, pub(super) f64, pub(super) f64);

impl V3 {
    pub(super) const ZERO: Self = Self(0.0, 0.0, 0.0);

    pub(super) fn dot(self, o: Self) -> f64 {
        self.0 * o.0 + self.1 * o.1 + self.2 * o.2
    }

    pub(super) fn length(self) -> f64 {
        self.dot(self).sqrt()
    }

    pub(super) fn unit(self) -> Self {
        self * (1.0 / self.length())
    }

    /// `self` turned back by a mirror whose unit normal is `n`.
    pub(super) fn mirrored(self, n: Self) -> Self {
        self - n * (2.0 * self.dot(n))
    }

    /// Component by component, as of light by a coloured surface.
    pub(super) fn times(self, o: Self) -> Self {
        Self(self.0 * o.0, self.1 * o.1, self.2 * o.2)
    }

    pub(super) fn mix(self, o: Self, share: f64) -> Self {
        self * (1.0 - share) + o * share
    }
}

impl Add for V3 {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self(self.0 + o.0, self.1 + o.1, self.2 + o.2)
    }
}

impl Sub for V3 {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self(self.0 - o.0, self.1 - o.1, self.2 - o.2)
    }
}

impl Mul<f64> for V3 {
    type Output = Self;
    fn mul(self, k: f64) -> Self {
        Self(self.0 * k, self.1 * k, self.2 * k)
    }
}

impl Neg for V3 {
    type Output = Self;
    fn neg(self) -> Self {
        self * -1.0
    }
}

/// A ray from `from` along `along`, which need not be of unit length.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ray {
    pub(super) from: V3,
    pub(super) along: V3,
}

impl Ray {
    pub(super) fn at(&self, t: f64) -> V3 {
        self.from + self.along * t
    }
}

/// Where a ray meets something, in lengths of its direction, and the light that comes back.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hit {
    pub(super) t: f64,
    pub(super) light: V3,
}

/// The nearer of two hits.
pub(super) fn nearer(a: Option<Hit>, b: Option<Hit>) -> Option<Hit> {
    match (a, b) {
        (Some(a), Some(b)) => Some(if a.t <= b.t { a } else { b }),
        (a, b) => a.or(b),
    }
}

/// 0 below `from`, 1 above `to`, smooth between.
pub(super) fn smooth_step(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
