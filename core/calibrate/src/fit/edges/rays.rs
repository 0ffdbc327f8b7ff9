//! Rays of a pupil, projected onto the normal of an edge.

use std::f64::consts::{PI, TAU};

use seidel_optics::lens::LocalPupil;
use seidel_optics::numeric::dot;

/// Turn between neighbouring rings of rays: the golden angle, so that their projections do not coincide.
const RING_TURN: f64 = 2.399_963_229_728_653;
/// Radius of a pinhole where the stops pass no light, pupil radii.
const PINHOLE_RADIUS: f64 = 0.02;

/// A ray in a star-shaped pupil: its distance from the centre over that of the pupil's edge, its direction, and its weight.
#[derive(Debug, Clone, Copy)]
struct Node {
    radius: f64,
    cos: f64,
    sin: f64,
    weight: f64,
}

/// Rays for quadrature over pupils: Gauss-Legendre in the squared radius, even in angle.
#[derive(Debug, Clone)]
pub(super) struct Quadrature {
    nodes: Vec<Node>,
}

impl Quadrature {
    pub(super) fn new(rings: usize, angles: usize) -> Self {
        let mut nodes = Vec::with_capacity(rings * angles);
        for (ring, (square, weight)) in gauss_legendre(rings).into_iter().enumerate() {
            for k in 0..angles {
                let angle = TAU * k as f64 / angles as f64 + RING_TURN * ring as f64;
                let (sin, cos) = angle.sin_cos();
                nodes.push(Node {
                    radius: square.sqrt(),
                    cos,
                    sin,
                    weight,
                });
            }
        }
        Self { nodes }
    }

    /// Returns the rays of `pupil` along `normal`, with polar coordinates about `centre`, a point within it.
    pub(super) fn project(
        &self,
        pupil: &LocalPupil,
        centre: PupilCentre,
        normal: [f64; 2],
    ) -> ProjectedRays {
        let mut rays = ProjectedRays {
            at: Vec::with_capacity(self.nodes.len()),
            light: Vec::with_capacity(self.nodes.len()),
        };
        for node in &self.nodes {
            let reach = if centre.is_open {
                pupil.edge(centre.point, node.cos, node.sin).0
            } else {
                PINHOLE_RADIUS
            };
            let r = reach * node.radius;
            let u = [
                centre.point[0] + r * node.cos,
                centre.point[1] + r * node.sin,
            ];
            let [x, y] = pupil.landing(u);
            rays.at.push(x * normal[0] + y * normal[1]);
            (rays.light).push(node.weight * reach * reach * pupil.transmission.at(u));
        }
        let total: f64 = rays.light.iter().sum();
        rays.light.iter_mut().for_each(|w| *w /= total);
        let mean = dot(&rays.at, &rays.light);
        rays.at.iter_mut().for_each(|p| *p -= mean);
        rays
    }
}

/// The centre of polar coordinates in a pupil.
#[derive(Debug, Clone, Copy)]
pub(super) struct PupilCentre {
    point: [f64; 2],
    is_open: bool,
}

impl PupilCentre {
    pub(super) fn of(pupil: &LocalPupil) -> Self {
        let (point, depth) = pupil.inscribed_circle();
        Self {
            point,
            is_open: depth > 0.0,
        }
    }
}

/// Rays along the normal of an edge.
#[derive(Debug, Clone)]
pub(super) struct ProjectedRays {
    /// Landing points from their centroid, px.
    pub(super) at: Vec<f64>,
    /// Light, with sum one.
    pub(super) light: Vec<f64>,
}

/// Returns the nodes and weights of the Gauss-Legendre rule on 0 to 1, by Newton's method.
fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    let n = count as f64;
    (0..count)
        .map(|k| {
            let mut x = (PI * (k as f64 + 0.75) / (n + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..50 {
                let (mut below, mut value) = (0.0, 1.0);
                for j in 0..count {
                    let j = j as f64;
                    let next = ((2.0 * j + 1.0) * x * value - j * below) / (j + 1.0);
                    (below, value) = (value, next);
                }
                slope = n * (x * value - below) / (x * x - 1.0);
                let step = value / slope;
                x -= step;
                if step.abs() < 1e-15 {
                    break;
                }
            }
            ((1.0 + x) / 2.0, 1.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_optics::field::FieldPoint;
    use seidel_optics::lens::{ReducedNumbers, Wavefront};

    #[test]
    fn projected_rays_have_the_moments_of_the_pupil() {
        let numbers = ReducedNumbers {
            alpha: 3.0,
            beta: 1.5,
            gamma: 2.0,
            delta: -1.0,
            phi: 0.8,
        };
        let at = FieldPoint::new(0.6, -0.5);
        let pupil = LocalPupil::circular(Wavefront::third_order(&numbers, at), 0.0);
        let want = numbers.coefficients().moments(at);
        let normal = [0.6, 0.8];
        let rays = Quadrature::new(6, 20).project(&pupil, PupilCentre::of(&pupil), normal);
        let moment = |n: i32| -> f64 {
            let terms = rays.at.iter().zip(&rays.light);
            terms.map(|(p, w)| w * p.powi(n)).sum()
        };
        let [x, y] = normal;
        let second = want.mu20 * x * x + 2.0 * want.mu11 * x * y + want.mu02 * y * y;
        let third = want.mu30 * x.powi(3)
            + 3.0 * want.mu21 * x * x * y
            + 3.0 * want.mu12 * x * y * y
            + want.mu03 * y.powi(3);
        assert!((moment(2) - second).abs() < 1e-10, "{} {second}", moment(2));
        assert!((moment(3) - third).abs() < 1e-10, "{} {third}", moment(3));
    }
}
