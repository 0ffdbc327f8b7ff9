//! Quadrature over a pupil: rays from a point of it outwards, and the moments of the light that they carry.

use std::sync::LazyLock;

use super::{LocalPupil, PINHOLE_RADIUS, Stop, Transmission};
use crate::moments::CentralMoments;

/// Directions of the quadrature: more than the exact integration of products of three slopes (degree 15) needs, for
/// clipped pupils.
const ANGLES: usize = 48;
/// Directions for more than [`FEW_STOPS`] stops, whose common part has many corners.
const MORE_ANGLES: usize = 120;
/// Number of stops up to which [`ANGLES`] directions suffice.
const FEW_STOPS: usize = 3;

static FEW_DIRECTIONS: LazyLock<Vec<[f64; 2]>> = LazyLock::new(|| directions(ANGLES));
static MORE_DIRECTIONS: LazyLock<Vec<[f64; 2]>> = LazyLock::new(|| directions(MORE_ANGLES));

/// Returns the cosine and sine of `count` evenly spread directions.
fn directions(count: usize) -> Vec<[f64; 2]> {
    let angle = |k: usize| std::f64::consts::TAU * (k as f64 + 0.5) / count as f64;
    let direction = |angle: f64| [angle.cos(), angle.sin()];
    (0..count).map(|k| direction(angle(k))).collect()
}

/// Cosine and sine of the directions for a pupil with an obstruction.
pub(super) fn many_directions() -> impl Iterator<Item = [f64; 2]> {
    MORE_DIRECTIONS.iter().copied()
}

/// Rays for quadrature over a pupil, from a point of it outwards.
pub(super) struct Fan {
    /// The point, pupil radii.
    pub(super) centre: [f64; 2],
    pub(super) spokes: Vec<Spoke>,
    /// A disc whose rays are left out.
    pub(super) dark: Option<Stop>,
}

/// The rays of a fan in one direction, between two distances from its centre.
pub(super) struct Spoke {
    /// Cosine and sine.
    pub(super) direction: [f64; 2],
    pub(super) inner: f64,
    pub(super) outer: f64,
}

impl Spoke {
    /// Returns the distance of each ray from the centre, and its light where the transmission is one.
    fn rays(&self) -> impl Iterator<Item = (f64, f64)> {
        let inner = self.inner * self.inner;
        let ring = self.outer * self.outer - inner;
        RADII.iter().map(move |(radius, weight)| {
            let r = if inner == 0.0 {
                self.outer * radius
            } else {
                (inner + ring * radius * radius).sqrt()
            };
            (r, weight * ring)
        })
    }
}

impl Fan {
    /// Returns the pupil point at distance `r` from the centre on `spoke`.
    fn point(&self, spoke: &Spoke, r: f64) -> [f64; 2] {
        [0, 1].map(|axis| self.centre[axis] + r * spoke.direction[axis])
    }

    /// Returns the light of the ray through pupil point `u` that would have the light `full`; `None` in the dark.
    fn light(&self, transmission: &Transmission, u: [f64; 2], full: f64) -> Option<f64> {
        let is_dark = self.dark.is_some_and(|disc| disc.depth(u) > 0.0);
        (!is_dark).then(|| full * transmission.at(u))
    }

    /// Returns the light of each ray, and its pupil point.
    pub(super) fn rays(&self, transmission: &Transmission) -> Vec<(f64, [f64; 2])> {
        let mut rays = Vec::with_capacity(RADII.len() * self.spokes.len());
        for spoke in &self.spokes {
            for (r, full) in spoke.rays() {
                let u = self.point(spoke, r);
                rays.extend(self.light(transmission, u, full).map(|light| (light, u)));
            }
        }
        rays
    }
}

impl LocalPupil {
    /// Returns rays over the pupil.
    pub(super) fn fan(&self) -> Fan {
        if self.obstruction.is_some() {
            self.fan_beside_obstruction()
        } else {
            self.fan_within_stops()
        }
    }

    /// Returns rays as [`LocalPupil::fan`], without the obstruction.
    pub(super) fn fan_within_stops(&self) -> Fan {
        let directions = if self.stop_count > FEW_STOPS || self.transmission.picture.is_some() {
            &MORE_DIRECTIONS
        } else {
            &FEW_DIRECTIONS
        };
        let (centre, depth) = self.inscribed_circle();
        let spoke = |direction: &[f64; 2]| {
            let [cos, sin] = *direction;
            let outer = if depth > 0.0 {
                self.edge(centre, cos, sin).0
            } else {
                PINHOLE_RADIUS
            };
            Spoke {
                direction: [cos, sin],
                inner: 0.0,
                outer,
            }
        };
        Fan {
            centre,
            spokes: directions.iter().map(spoke).collect(),
            dark: None,
        }
    }

    /// Returns the second and third central moments of the light (image axes, px² and px³) and its centroid relative to
    /// the chief ray (px).
    ///
    /// By quadrature over the pupil; exact for a circular pupil of even transmission. Diffraction and halo are left
    /// out: their moments may not exist.
    pub fn moments(&self) -> (CentralMoments, [f64; 2]) {
        let fan = self.fan();
        let is_even = fan.dark.is_none() && self.transmission.is_uniform();
        // Along a spoke the slope is a polynomial in one variable.
        let wavefront = self.wavefront.about(fan.centre);
        let mut landed: Vec<(f64, [f64; 2])> = Vec::with_capacity(RADII.len() * fan.spokes.len());
        for spoke in &fan.spokes {
            let slope = wavefront.slope_along(spoke.direction);
            for (r, full) in spoke.rays() {
                let light = if is_even {
                    Some(full)
                } else {
                    fan.light(&self.transmission, fan.point(spoke, r), full)
                };
                landed.extend(light.map(|light| {
                    let [x, y] = slope.at(r);
                    (light, [self.squeeze[0] * x, self.squeeze[1] * y])
                }));
            }
        }
        let total: f64 = landed.iter().map(|(w, _)| w).sum();
        let mean = [0, 1].map(|k| landed.iter().map(|(w, p)| w * p[k]).sum::<f64>() / total);
        let mut sums = [0.0; 7];
        for (w, p) in &landed {
            let (x, y) = (p[0] - mean[0], p[1] - mean[1]);
            let terms = [
                x * x,
                x * y,
                y * y,
                x * x * x,
                x * x * y,
                x * y * y,
                y * y * y,
            ];
            for (sum, term) in sums.iter_mut().zip(terms) {
                *sum += w * term;
            }
        }
        let mut moments = CentralMoments::from_array(sums.map(|sum| sum / total));
        let [along_x, along_y] = self.blur_variances_px2();
        moments.mu20 += along_x;
        moments.mu02 += along_y;
        (self.sensor.blurred_moments(moments), mean)
    }
}

/// Ten-point Gauss-Legendre rule in the squared radius: radius over the distance to the edge, and weight.
const RADII: [(f64, f64); 10] = radii();

const fn radii() -> [(f64, f64); 10] {
    // Nodes and weights on [-1, 1].
    const HALF: [(f64, f64); 5] = [
        (0.148_874_338_981_631_2, 0.295_524_224_714_752_87),
        (0.433_395_394_129_247_2, 0.269_266_719_309_996_35),
        (0.679_409_568_299_024_4, 0.219_086_362_515_982_04),
        (0.865_063_366_688_984_5, 0.149_451_349_150_580_6),
        (0.973_906_528_517_171_7, 0.066_671_344_308_688_14),
    ];
    let mut all = [(0.0, 0.0); 10];
    let mut k = 0;
    while k < 5 {
        let (node, weight) = HALF[k];
        all[2 * k] = (root((1.0 + node) / 2.0), weight / 2.0);
        all[2 * k + 1] = (root((1.0 - node) / 2.0), weight / 2.0);
        k += 1;
    }
    all
}

/// Returns the square root of `x` by Newton's method, which can run in a constant.
const fn root(x: f64) -> f64 {
    let mut r = 1.0;
    let mut k = 0;
    while k < 60 {
        r = (r + x / r) / 2.0;
        k += 1;
    }
    r
}
