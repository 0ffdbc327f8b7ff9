//! Rays of the demo's scene and what they hit.

/// A position or direction in m, or scene-linear R, G, B.
pub(super) type V3 = nalgebra::Vector3<f64>;

pub(super) const fn v3(x: f64, y: f64, z: f64) -> V3 {
    V3::new(x, y, z)
}

/// Hits closer than this are the surface that the ray leaves, m.
const NEAREST_M: f64 = 1e-6;

/// A ray from `origin` along `direction`, which need not have unit length.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ray {
    pub(super) origin: V3,
    pub(super) direction: V3,
}

/// A surface point that a ray reaches after `t` lengths of its direction, and the light it sends back.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hit {
    pub(super) t: f64,
    pub(super) light: V3,
}

/// A point of a surface, with the unit normal that faces the ray.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surface {
    pub(super) t: f64,
    pub(super) at: V3,
    pub(super) normal: V3,
}

impl Ray {
    pub(super) fn at(&self, t: f64) -> V3 {
        self.origin + self.direction * t
    }

    /// Returns the ray mirrored at a surface, with a direction of unit length.
    pub(super) fn mirrored(&self, surface: &Surface) -> Self {
        let view = self.direction.normalize();
        let n = surface.normal;
        Self {
            origin: surface.at,
            direction: view - n * (2.0 * view.dot(&n)),
        }
    }

    /// Returns where the ray crosses the plane through `point`, in front of its origin.
    pub(super) fn plane(&self, point: V3, normal: V3) -> Option<Surface> {
        let t = (point - self.origin).dot(&normal) / self.direction.dot(&normal);
        (t.is_finite() && t > NEAREST_M).then(|| Surface {
            t,
            at: self.at(t),
            normal,
        })
    }

    /// Returns where the ray enters a sphere.
    pub(super) fn sphere(&self, centre: V3, radius: f64) -> Option<Surface> {
        let off = self.origin - centre;
        let (a, b) = (self.direction.norm_squared(), off.dot(&self.direction));
        let root = b * b - a * (off.norm_squared() - radius * radius);
        if b > 0.0 || root <= 0.0 {
            return None;
        }
        let t = (-b - root.sqrt()) / a;
        (t > NEAREST_M).then(|| Surface {
            t,
            at: self.at(t),
            normal: (self.at(t) - centre) / radius,
        })
    }

    /// Returns where the ray enters an upright cylinder without ends.
    pub(super) fn cylinder(&self, axis: V3, radius: f64) -> Option<Surface> {
        let level = |v: V3| v3(v.x, 0.0, v.z);
        let seen_from_above = Self {
            origin: level(self.origin),
            direction: level(self.direction),
        };
        let circle = seen_from_above.sphere(level(axis), radius)?;
        Some(Surface {
            at: self.at(circle.t),
            ..circle
        })
    }
}

impl Surface {
    /// Returns the hit of this surface, which sends back `light`.
    pub(super) fn lit(&self, light: V3) -> Hit {
        Hit { t: self.t, light }
    }
}

/// Returns the nearest of `hits`.
pub(super) fn nearest(hits: impl IntoIterator<Item = Option<Hit>>) -> Option<Hit> {
    let hits = hits.into_iter().flatten();
    hits.min_by(|a, b| a.t.total_cmp(&b.t))
}

/// Returns 0 below `from`, 1 above `to`, and a cubic ramp between them.
pub(super) fn smooth_step(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
