//! Refraction of a ray at a surface.

use super::figure::Figure;
use super::vector::{Vector, along, cross, dot, minus, unit};
use crate::lens::CHANNELS;

/// A ray: a point on it and its direction, a unit vector.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    pub(super) point: Vector,
    pub(super) direction: Vector,
}

/// A surface in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Surface {
    /// Its vertex, mm.
    pub(super) vertex: Vector,
    /// Its axis, a unit vector towards the sensor.
    pub(super) axis: Vector,
    /// 1 / radius, 1/mm; positive if the centre is on the side of the sensor.
    pub(super) curvature: f64,
    pub(super) figure: Option<Figure>,
    /// Radius within which light passes, mm.
    pub(super) clear_mm: Option<f64>,
    /// Index behind the surface in each channel.
    pub(super) index: [f64; CHANNELS.len()],
}

impl Surface {
    /// Returns two unit vectors across the axis, near x and y.
    #[inline(always)]
    pub(super) fn across(&self) -> [Vector; 2] {
        across(self.axis)
    }

    /// Returns the coordinates of `point` across the axis, from the vertex.
    #[inline(always)]
    pub(super) fn local(&self, point: Vector) -> [f64; 2] {
        let from = minus(point, self.vertex);
        self.across().map(|e| dot(from, e))
    }

    /// Returns where the ray meets the surface, and the unit normal towards the sensor; `None` if it misses.
    #[inline(always)]
    fn meet(&self, ray: Line) -> Option<Line> {
        let sphere = self.meet_sphere(ray)?;
        match &self.figure {
            Some(figure) => self.meet_figure(ray, sphere.point, figure),
            None => Some(sphere),
        }
    }

    #[inline(always)]
    fn meet_sphere(&self, ray: Line) -> Option<Line> {
        if self.curvature == 0.0 {
            let s = dot(minus(self.vertex, ray.point), self.axis) / dot(ray.direction, self.axis);
            return Some(Line {
                point: along(ray.point, s, ray.direction),
                direction: self.axis,
            });
        }
        let radius = 1.0 / self.curvature;
        let centre = along(self.vertex, radius, self.axis);
        let from = minus(ray.point, centre);
        let b = dot(from, ray.direction);
        let root = b * b - dot(from, from) + radius * radius;
        if root <= 0.0 {
            return None;
        }
        // The crossing on the side of the vertex.
        let point = along(ray.point, -b - radius.signum() * root.sqrt(), ray.direction);
        Some(Line {
            point,
            direction: minus(centre, point).map(|v| v * self.curvature),
        })
    }

    /// Refines a point of the sphere to one of the sphere with its figure, by Newton's method.
    #[inline(never)]
    fn meet_figure(&self, ray: Line, start: Vector, figure: &Figure) -> Option<Line> {
        const ITERATIONS: usize = 4;
        let [ex, ey] = self.across();
        let c = self.curvature;
        let mut point = start;
        let mut normal = self.axis;
        for _ in 0..=ITERATIONS {
            let from = minus(point, self.vertex);
            let (x, y, z) = (dot(from, ex), dot(from, ey), dot(from, self.axis));
            let r2 = x * x + y * y;
            let root = 1.0 - c * c * r2;
            if root <= 0.0 {
                return None;
            }
            let root = root.sqrt();
            let sag = figure.sag(x, y);
            let slopes = [c * x / root + sag.by_x, c * y / root + sag.by_y];
            let gradient = along(along(self.axis, -slopes[0], ex), -slopes[1], ey);
            let miss = z - c * r2 / (1.0 + root) - sag.height;
            point = along(point, -miss / dot(ray.direction, gradient), ray.direction);
            normal = unit(gradient);
        }
        Some(Line {
            point,
            direction: normal,
        })
    }

    /// Returns the ray behind the surface; `None` if it misses the surface or is totally reflected.
    ///
    /// `ratio` is the index before the surface over that behind it.
    #[inline(always)]
    pub(super) fn refract(&self, ray: Line, ratio: f64) -> Option<Line> {
        let met = self.meet(ray)?;
        if ratio == 1.0 {
            return Some(Line {
                point: met.point,
                direction: ray.direction,
            });
        }
        let cos = dot(ray.direction, met.direction);
        let rest = 1.0 - ratio * ratio * (1.0 - cos * cos);
        if rest <= 0.0 {
            return None;
        }
        let straight = ray.direction.map(|v| v * ratio);
        Some(Line {
            point: met.point,
            direction: along(straight, rest.sqrt() - ratio * cos, met.direction),
        })
    }
}

/// Returns two unit vectors across `axis`, near x and y.
#[inline(always)]
pub(super) fn across(axis: Vector) -> [Vector; 2] {
    let ex = unit(along([1.0, 0.0, 0.0], -axis[0], axis));
    [ex, cross(axis, ex)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surface(curvature: f64) -> Surface {
        Surface {
            vertex: [0.0, 0.0, 5.0],
            axis: [0.0, 0.0, 1.0],
            curvature,
            figure: None,
            clear_mm: None,
            index: [1.5; 3],
        }
    }

    #[test]
    fn refraction_obeys_snells_law_in_the_plane_of_incidence() {
        let ray = Line {
            point: [0.0, 0.0, 0.0],
            direction: unit([0.2, -0.1, 1.0]),
        };
        for curvature in [0.0, 0.04, -0.05] {
            let surface = surface(curvature);
            let normal = surface.meet(ray).expect("it meets the surface").direction;
            let out = surface
                .refract(ray, 1.0 / 1.5)
                .expect("it passes")
                .direction;
            let sine = |d: Vector| cross(normal, d);
            let (before, behind) = (sine(ray.direction), sine(out));
            for i in 0..3 {
                assert!((before[i] - 1.5 * behind[i]).abs() < 1e-14);
            }
            assert!((dot(out, out) - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn a_figure_of_the_sphere_of_another_radius_is_that_sphere() {
        // A small change of curvature is a figure of second and fourth degree.
        let (flat, bent) = (0.02, 0.020_01);
        let mut figured = surface(flat);
        figured.figure = Some(Figure {
            square: [(bent - flat) / 2.0; 2],
            quartic: (bent * bent * bent - flat * flat * flat) / 8.0,
            ..Figure::default()
        });
        let ray = Line {
            point: [3.0, 1.0, 0.0],
            direction: unit([0.1, 0.05, 1.0]),
        };
        let by_figure = figured.refract(ray, 1.0 / 1.5).expect("it passes");
        let by_radius = surface(bent).refract(ray, 1.0 / 1.5).expect("it passes");
        for i in 0..3 {
            assert!((by_figure.point[i] - by_radius.point[i]).abs() < 1e-8);
            assert!((by_figure.direction[i] - by_radius.direction[i]).abs() < 1e-8);
        }
    }
}
