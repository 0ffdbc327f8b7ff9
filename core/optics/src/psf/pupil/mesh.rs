//! A mesh of triangles over the pupil of one point, ring by ring, and where its corners land.
//!
//! Ring k has 6 k corners at k / n of the way from a point inside to the pupil's edge, so that the
//! triangles are nearly equilateral and the outermost ring lies on the edge, cusps of a clipped
//! pupil included. Within a triangle the ray map is taken as linear. What that neglects is mended in
//! the mean: the corners are those of the wavefront less a share of its Laplacian
//! ([`INTERPOLATION`]), so that the mean landing point of every triangle is right to fourth order
//! in its size.

use std::f64::consts::TAU;

use super::PupilDerivative;
use crate::lens::{DEGREE, LocalPupil, PINHOLE_RADIUS, TERMS, Wavefront, powers};

/// Mean interpolation error of a function over the mesh's triangles, per Laplacian and squared ring
/// spacing: a triangle of base b and height h errs by f_bb b²/16 + f_hh h²/12, and here b = 2 pi / 6
/// and h = 1.
const INTERPOLATION: f64 = ((TAU / 6.0) * (TAU / 6.0) / 16.0 + 1.0 / 12.0) / 2.0;

/// Monomials of a slope: powers (i, j) with i + j < [`DEGREE`].
const SLOPE_TERMS: usize = TERMS - DEGREE;

/// Most tangents that may move stops: centre and radius of each.
pub(super) const MOST_STOP_TANGENTS: usize = 3 * crate::lens::MAX_STOPS;

/// Values are handled by fours, the width of common vectors.
pub(super) const LANES: usize = 4;

/// As many values as are handled at once.
pub(super) type Pack = [f64; LANES];

/// Least cosine between a direction from the centre and the edge's normal that is divided by.
const LEAST_FACING: f64 = 0.2;

/// Packs that hold `tangents` values.
pub(super) const fn packs(tangents: usize) -> usize {
    tangents.div_ceil(LANES)
}

/// One corner ring of the mesh.
#[derive(Debug, Default)]
pub(super) struct Ring {
    /// Pupil points.
    pub(super) u: Vec<[f64; 2]>,
    /// Where they land, px.
    pub(super) landing: Vec<[f64; 2]>,
    /// How fast they land elsewhere along each tangent, corner by corner: all x, then all y.
    pub(super) velocity: Vec<Pack>,
    /// How fast the pupil points themselves move along each stop tangent (x, y), corner by corner.
    pub(super) drift: Vec<[f64; 2]>,
}

/// The mesh of one pupil, made to be walked through once.
pub(super) struct Mesh<'a> {
    pupil: &'a LocalPupil,
    tangents: &'a [PupilDerivative],
    /// How many of the tangents, the last ones, move stops.
    stop_tangents: usize,
    rings: usize,
    centre: [f64; 2],
    /// The corners of the outermost ring.
    rim: Vec<Spoke>,
    /// Their rates along each tangent that moves stops.
    rim_drift: Vec<[f64; 2]>,
    /// Slope of the wavefront, monomial by monomial.
    landing: [[f64; 2]; SLOPE_TERMS],
    /// Slopes of the tangents, monomial by monomial: all x, then all y.
    velocities: Vec<Pack>,
}

/// A corner of the outermost ring.
#[derive(Clone, Copy)]
struct Spoke {
    /// Where it is, from the mesh's centre.
    edge: [f64; 2],
    /// Which stop bounds the pupil there; on a cusp, which two.
    stop: usize,
    other: Option<usize>,
}

impl Spoke {
    fn reach(&self) -> f64 {
        self.edge[0].hypot(self.edge[1])
    }

    fn direction(&self) -> [f64; 2] {
        self.edge.map(|e| e / self.reach())
    }
}

impl<'a> Mesh<'a> {
    /// A mesh of `rings` rings over `pupil`, of whose tangents the last `stop_tangents` move stops.
    pub(super) fn new(
        pupil: &'a LocalPupil,
        tangents: &'a [PupilDerivative],
        stop_tangents: usize,
        rings: usize,
    ) -> Self {
        let (centre, depth) = pupil.inscribed_circle();
        let mut mesh = Self {
            pupil,
            tangents,
            stop_tangents,
            rings,
            centre,
            rim: Vec::new(),
            rim_drift: Vec::new(),
            landing: [[0.0; 2]; SLOPE_TERMS],
            velocities: Vec::new(),
        };
        mesh.lay_rim(depth > PINHOLE_RADIUS);
        mesh.rim_drift = mesh.drifts();
        let squares = mesh.rim.iter().map(|s| s.reach().powi(2));
        let area = squares.sum::<f64>() / mesh.rim.len() as f64;
        mesh.lay_slopes(INTERPOLATION * area / (rings * rings) as f64);
        mesh
    }

    /// Number of rings.
    pub(super) fn rings(&self) -> usize {
        self.rings
    }

    fn lay_rim(&mut self, open: bool) {
        let count = 6 * self.rings;
        let spacing = TAU / count as f64;
        let at = |angle: f64| {
            let (sin, cos) = angle.sin_cos();
            let (reach, stop) = if open {
                self.pupil.edge(self.centre, cos, sin)
            } else {
                (PINHOLE_RADIUS, usize::MAX)
            };
            let edge = [reach * cos, reach * sin];
            Spoke {
                edge,
                stop,
                other: None,
            }
        };
        let mut rim: Vec<Spoke> = (0..count).map(|k| at(k as f64 * spacing)).collect();
        if open && self.pupil.stops().len() > 1 {
            // The corner nearest to each cusp is moved onto it.
            let stops: Vec<usize> = rim.iter().map(|s| s.stop).collect();
            for k in 0..count {
                let (here, next) = (stops[k], stops[(k + 1) % count]);
                if here == next {
                    continue;
                }
                let (mut low, mut high) = (k as f64 * spacing, (k + 1) as f64 * spacing);
                for _ in 0..40 {
                    let middle = (low + high) / 2.0;
                    if at(middle).stop == here {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                let nearest = if low - k as f64 * spacing < spacing / 2.0 {
                    k
                } else {
                    (k + 1) % count
                };
                rim[nearest] = Spoke {
                    stop: here,
                    other: Some(next),
                    ..at(low)
                };
            }
        }
        // A polygon within a curve lacks area: its corners are moved out by a twelfth of the chord
        // squared over the radius of curvature, as much as gives it back.
        for spoke in &mut rim {
            let Some(stop) = self.pupil.stops().get(spoke.stop) else {
                continue;
            };
            let [cos, sin] = spoke.direction();
            let normal = [0, 1].map(|axis| {
                (self.centre[axis] + spoke.edge[axis] - stop.centre[axis]) / stop.radius
            });
            let facing = (normal[0] * cos + normal[1] * sin).max(LEAST_FACING);
            let reach = spoke.reach();
            let chord = reach * spacing / facing;
            let grown = 1.0 + chord * chord / (12.0 * stop.radius * facing) / reach;
            spoke.edge = spoke.edge.map(|e| e * grown);
        }
        self.rim = rim;
    }

    /// How fast each corner of the rim moves along each tangent that moves stops.
    fn drifts(&self) -> Vec<[f64; 2]> {
        let mut drifts = Vec::with_capacity(self.rim.len() * self.stop_tangents);
        for spoke in &self.rim {
            for tangent in &self.tangents[self.tangents.len() - self.stop_tangents..] {
                let own = self.edge_rate(spoke, spoke.stop, tangent);
                // Half of what surrounds a cusp belongs to either edge.
                let rate = spoke.other.map_or(own, |other| {
                    (own + self.edge_rate(spoke, other, tangent)) / 2.0
                });
                drifts.push(spoke.direction().map(|d| rate * d));
            }
        }
        drifts
    }

    /// How fast the edge of `stop` moves away from the centre at `spoke`.
    fn edge_rate(&self, spoke: &Spoke, stop: usize, tangent: &PupilDerivative) -> f64 {
        let Some(circle) = self.pupil.stops().get(stop) else {
            return 0.0;
        };
        let (moved, [cos, sin]) = (&tangent.stops[stop], spoke.direction());
        let n = [0, 1].map(|axis| {
            (self.centre[axis] + spoke.edge[axis] - circle.centre[axis]) / circle.radius
        });
        let facing = (n[0] * cos + n[1] * sin).max(LEAST_FACING);
        (moved.radius + moved.centre[0] * n[0] + moved.centre[1] * n[1]) / facing
    }

    /// Lays down the slope polynomials of the wavefront and the tangents, each less its share of the
    /// Laplacian's.
    fn lay_slopes(&mut self, correction: f64) {
        let corrected = |w: &Wavefront| w.add_scaled(-correction, &w.laplacian());
        let half = packs(self.tangents.len());
        self.velocities = vec![Pack::default(); SLOPE_TERMS * 2 * half];
        let [along_x, along_y] = self.pupil.squeeze;
        for ((i, j), c) in powers().zip(corrected(&self.pupil.wavefront).coefficients()) {
            if i > 0 {
                self.landing[slope_index(i - 1, j)][0] += along_x * i as f64 * c;
            }
            if j > 0 {
                self.landing[slope_index(i, j - 1)][1] += along_y * j as f64 * c;
            }
        }
        for (which, tangent) in self.tangents.iter().enumerate() {
            let (pack, lane) = (which / LANES, which % LANES);
            for ((i, j), c) in powers().zip(corrected(&tangent.wavefront).coefficients()) {
                if i > 0 {
                    let row = slope_index(i - 1, j) * 2 * half;
                    self.velocities[row + pack][lane] += along_x * i as f64 * c;
                }
                if j > 0 {
                    let row = slope_index(i, j - 1) * 2 * half + half;
                    self.velocities[row + pack][lane] += along_y * j as f64 * c;
                }
            }
        }
    }

    /// Fills `ring` with ring `k`.
    #[inline(always)]
    pub(super) fn ring(&self, k: usize, ring: &mut Ring) {
        ring.u.clear();
        ring.landing.clear();
        ring.velocity.clear();
        ring.drift.clear();
        let parts = k.max(1);
        let unit = k as f64 / (self.rings * parts) as f64;
        let (mut first, mut part) = (0, 0);
        for _ in 0..(6 * k).max(1) {
            let weights = [(parts - part) as f64 * unit, part as f64 * unit];
            let second = if first + 1 == self.rim.len() {
                0
            } else {
                first + 1
            };
            let (a, b) = (&self.rim[first].edge, &self.rim[second].edge);
            let u = [0, 1].map(|x| self.centre[x] + weights[0] * a[x] + weights[1] * b[x]);
            self.corner(u, ring);
            self.drift(u, [(first, weights[0]), (second, weights[1])], ring);
            // On by rings / k corners of the rim.
            part += self.rings;
            while k > 0 && part >= k {
                part -= k;
                first += 1;
            }
        }
    }

    /// Landing point and velocities of pupil point `u`.
    #[inline(always)]
    fn corner(&self, u: [f64; 2], ring: &mut Ring) {
        let mut monomials = [0.0; SLOPE_TERMS];
        let mut last = 1;
        monomials[0] = 1.0;
        // Degree by degree: each row is the one before times x, and y times its last.
        let mut before = 0;
        for degree in 1..DEGREE {
            for k in 0..degree {
                monomials[last + k] = monomials[before + k] * u[0];
            }
            monomials[last + degree] = monomials[before + degree - 1] * u[1];
            before = last;
            last += degree + 1;
        }
        let mut landing = [0.0; 2];
        for (monomial, row) in monomials.iter().zip(&self.landing) {
            landing[0] += monomial * row[0];
            landing[1] += monomial * row[1];
        }
        ring.u.push(u);
        ring.landing.push(landing);
        let width = 2 * packs(self.tangents.len());
        for pack in 0..width {
            let mut sums = Pack::default();
            for (term, monomial) in monomials.iter().enumerate() {
                let row = &self.velocities[term * width + pack];
                for lane in 0..LANES {
                    sums[lane] += monomial * row[lane];
                }
            }
            ring.velocity.push(sums);
        }
    }

    /// Adds to the last corner of `ring` how the tangents that move stops move it: as the corners of
    /// the rim that it stands between move, by their weights.
    #[inline(always)]
    fn drift(&self, u: [f64; 2], from: [(usize, f64); 2], ring: &mut Ring) {
        if self.stop_tangents == 0 {
            return;
        }
        let half = packs(self.tangents.len());
        let start = ring.velocity.len() - 2 * half;
        let [xx, xy, yy] = self.pupil.wavefront.hessian(u);
        let [along_x, along_y] = self.pupil.squeeze;
        for which in 0..self.stop_tangents {
            let [a, b] = from.map(|(rim, weight)| {
                let drift = &self.rim_drift[rim * self.stop_tangents + which];
                [weight * drift[0], weight * drift[1]]
            });
            let drift = [a[0] + b[0], a[1] + b[1]];
            let place = self.tangents.len() - self.stop_tangents + which;
            let (pack, lane) = (start + place / LANES, place % LANES);
            ring.velocity[pack][lane] += along_x * (xx * drift[0] + xy * drift[1]);
            ring.velocity[pack + half][lane] += along_y * (xy * drift[0] + yy * drift[1]);
            ring.drift.push(drift);
        }
    }
}

/// Place of `u_x^i u_y^j` among the monomials of a slope.
const fn slope_index(i: usize, j: usize) -> usize {
    let n = i + j;
    n * (n + 1) / 2 + j
}
