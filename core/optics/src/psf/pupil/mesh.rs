//! A triangle mesh over a pupil, ring by ring, and the landing points of its corners.
//!
//! Ring k has 6 k corners at k / n of the way from an inner point to the edge of the pupil. The triangles are nearly
//! equilateral, and the outermost ring lies on the edge, including the cusps of a clipped pupil.
//!
//! The ray map is linear within a triangle. To correct the mean error of that, the corners use the wavefront minus a
//! share of its Laplacian ([`INTERPOLATION`]). The mean landing point of a triangle is then exact to fourth order in
//! its size.

use std::f64::consts::TAU;

use super::PupilDerivative;
use crate::lens::{
    DEGREE, LocalPupil, PINHOLE_RADIUS, Shadow, Stop, TERMS, Transmission, Wavefront, powers,
};

/// Mean error of linear interpolation over the triangles, per Laplacian and squared ring spacing.
///
/// A triangle of base b and height h has the error f_bb b²/16 + f_hh h²/12; here b = 2 pi / 6 and h = 1.
const INTERPOLATION: f64 = ((TAU / 6.0) * (TAU / 6.0) / 16.0 + 1.0 / 12.0) / 2.0;

/// Largest number of monomials of a slope: powers (i, j) with i + j < [`DEGREE`].
const SLOPE_TERMS: usize = TERMS - DEGREE;

/// Largest number of derivatives that change the light of triangles: centre (x, y) and radius of each stop, and the four
/// numbers of the transmission.
pub(super) const MAX_LIGHT_DERIVATIVES: usize = 3 * crate::lens::MAX_STOPS + 4;

/// Values per pack: the width of common SIMD vectors of 64-bit numbers.
pub(super) const LANES: usize = 4;

/// A group of values that are processed together.
pub(super) type Pack = [f64; LANES];

/// Values that are summed together: eight registers of AVX2, four of AVX-512.
const BLOCK: usize = 8 * LANES;

/// Smallest cosine between the direction from the centre and the normal of the edge that is used as a divisor.
const LEAST_FACING: f64 = 0.2;

/// Returns the number of packs that hold `count` values.
pub(super) const fn packs(count: usize) -> usize {
    count.div_ceil(LANES)
}

/// Returns the sum of `rows`, each times its weight.
///
/// Four registers at a time: compilers keep an array of sums in memory here, and a fit then takes a third more time.
#[inline(always)]
fn weighted_sum<S: pulp::Simd>(simd: S, weights: &[f64], rows: &[[f64; BLOCK]]) -> [f64; BLOCK] {
    const REGISTERS: usize = 4;
    let mut sums = [0.0; BLOCK];
    for start in (0..BLOCK).step_by(REGISTERS * S::F64_LANES) {
        let [mut a, mut b, mut c, mut d] = [simd.splat_f64s(0.0); REGISTERS];
        for (weight, row) in weights.iter().zip(rows) {
            let weight = simd.splat_f64s(*weight);
            if let [p, q, r, s, ..] = S::as_simd_f64s(&row[start..]).0 {
                a = simd.add_f64s(a, simd.mul_f64s(weight, *p));
                b = simd.add_f64s(b, simd.mul_f64s(weight, *q));
                c = simd.add_f64s(c, simd.mul_f64s(weight, *r));
                d = simd.add_f64s(d, simd.mul_f64s(weight, *s));
            }
        }
        let values = S::as_mut_simd_f64s(&mut sums[start..]).0.iter_mut();
        for (value, sum) in values.zip([a, b, c, d]) {
            *value = sum;
        }
    }
    sums
}

/// One corner ring of the mesh.
#[derive(Debug, Default)]
pub(super) struct Ring {
    /// Pupil points.
    pub(super) u: Vec<[f64; 2]>,
    /// Landing points, px.
    pub(super) landing: Vec<[f64; 2]>,
    /// Derivatives of the landing points, corner by corner: all x, then all y.
    pub(super) velocity: Vec<Pack>,
    /// Derivatives (x, y) of the pupil points by each parameter that moves stops or changes the transmission, corner by corner.
    pub(super) drift: Vec<[f64; 2]>,
}

/// The mesh of one pupil, generated ring by ring.
pub(super) struct Mesh<'a> {
    pupil: &'a LocalPupil,
    derivatives: &'a [PupilDerivative],
    /// Number of derivatives that move stops or change the transmission; they are the last ones.
    light_derivatives: usize,
    /// Degree of the wavefront and its derivatives.
    degree: usize,
    rings: usize,
    centre: [f64; 2],
    /// The shadow that the rings surround.
    annulus: Option<Annulus>,
    /// A shadow that does not hold the centre: triangles are dark if their centroid is.
    part_shadow: Option<Stop>,
    /// The corners of the outermost ring.
    rim: Vec<RimPoint>,
    /// Derivatives of those corners by each parameter that moves stops or changes the transmission.
    rim_motion: Vec<[f64; 2]>,
    /// Coefficients of the wavefront slope (x, y), monomial by monomial.
    landing: [[f64; 2]; SLOPE_TERMS],
    /// Coefficients of the second derivatives (xx, xy, yy) of the wavefront, monomial by monomial; empty if no
    /// stop moves.
    curvature: Vec<[f64; 3]>,
    /// Coefficients of the slopes of the derivatives, all x, then all y in blocks; the blocks one after the other, each
    /// monomial by monomial.
    velocities: Vec<[f64; BLOCK]>,
}

/// The hole of a mesh over a pupil with an obstruction, about the centre of the mesh.
#[derive(Clone, Copy)]
struct Annulus {
    /// Distance of the corners on the edge of the hole, so that their polygon has the area of the hole.
    radius: f64,
    /// The ring on the edge of the hole, at least 1.
    first: usize,
}

/// A corner of the outermost ring.
#[derive(Clone, Copy)]
struct RimPoint {
    /// Position from the centre of the mesh.
    edge: [f64; 2],
    /// Index of the stop that bounds the pupil here.
    stop: usize,
    /// Index of the other stop at a cusp.
    other: Option<usize>,
}

impl RimPoint {
    fn reach(&self) -> f64 {
        self.edge[0].hypot(self.edge[1])
    }

    fn direction(&self) -> [f64; 2] {
        self.edge.map(|e| e / self.reach())
    }
}

impl<'a> Mesh<'a> {
    /// Creates a mesh of `rings` rings over `pupil`; the last `light_derivatives` of `derivatives` move stops or change the
    /// transmission.
    pub(super) fn new(
        pupil: &'a LocalPupil,
        derivatives: &'a [PupilDerivative],
        light_derivatives: usize,
        rings: usize,
    ) -> Self {
        let (mut centre, depth) = pupil.inscribed_circle();
        let is_open = depth > PINHOLE_RADIUS;
        let shadow = if is_open { pupil.shadow() } else { None };
        let (mut hole, mut part_shadow) = (None, None);
        match shadow {
            Some(Shadow::Ring(disc)) => {
                centre = disc.centre;
                hole = Some(disc.radius);
            }
            Some(Shadow::Part(disc)) => part_shadow = Some(disc),
            None => {}
        }
        let mut mesh = Self {
            pupil,
            derivatives,
            light_derivatives,
            degree: (derivatives.iter().map(|d| d.wavefront.degree()))
                .fold(pupil.wavefront.degree(), usize::max),
            rings,
            centre,
            annulus: None,
            part_shadow,
            rim: Vec::new(),
            rim_motion: Vec::new(),
            landing: [[0.0; 2]; SLOPE_TERMS],
            curvature: Vec::new(),
            velocities: Vec::new(),
        };
        mesh.set_rim(is_open);
        mesh.rim_motion = mesh.rim_motions();
        // Where a shadow hides the rim, the mesh has no area.
        let hidden = hole.unwrap_or(0.0);
        let squares = mesh.rim.iter().map(|s| s.reach().powi(2));
        let (sum, count) = (squares.filter(|square| *square > hidden * hidden))
            .fold((0.0, 0), |(sum, count), square| (sum + square, count + 1));
        let area = sum / f64::from(count);
        mesh.annulus = hole.map(|radius| Annulus::new(radius, area.sqrt(), rings));
        mesh.set_slopes(INTERPOLATION * area / (rings * rings) as f64);
        mesh
    }

    /// Returns the innermost ring: the centre, or the edge of a shadow.
    pub(super) fn first_ring(&self) -> usize {
        self.annulus.map_or(0, |annulus| annulus.first)
    }

    /// Returns the shadow in which triangles are dark.
    pub(super) fn part_shadow(&self) -> Option<Stop> {
        self.part_shadow
    }

    /// Number of rings.
    pub(super) fn rings(&self) -> usize {
        self.rings
    }

    /// Returns the changes of transmission by the parameters that change the light.
    pub(super) fn transmission_rates(&self) -> Vec<Transmission> {
        let first = self.derivatives.len() - self.light_derivatives;
        let changing = self.derivatives[first..].iter();
        changing.map(|d| d.transmission.clone()).collect()
    }

    /// Number of derivatives of each landing point.
    pub(super) fn derivative_count(&self) -> usize {
        self.derivatives.len()
    }

    /// Places the corners of the outermost ring; `open` is false if the stops pass no light.
    fn set_rim(&mut self, open: bool) {
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
            RimPoint {
                edge,
                stop,
                other: None,
            }
        };
        let mut rim: Vec<RimPoint> = (0..count).map(|k| at(k as f64 * spacing)).collect();
        if open && self.pupil.stops().len() > 1 {
            // Moves the corner nearest to each cusp onto it.
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
                rim[nearest] = RimPoint {
                    stop: here,
                    other: Some(next),
                    ..at(low)
                };
            }
        }
        // An inscribed polygon lacks area. Moving its corners out by a twelfth of the squared chord over the
        // radius of curvature restores it.
        for point in &mut rim {
            let Some(stop) = self.pupil.stops().get(point.stop) else {
                continue;
            };
            let [cos, sin] = point.direction();
            let normal = [0, 1].map(|axis| {
                (self.centre[axis] + point.edge[axis] - stop.centre[axis]) / stop.radius
            });
            let facing = (normal[0] * cos + normal[1] * sin).max(LEAST_FACING);
            let reach = point.reach();
            let chord = reach * spacing / facing;
            let grown = 1.0 + chord * chord / (12.0 * stop.radius * facing) / reach;
            point.edge = point.edge.map(|e| e * grown);
        }
        self.rim = rim;
    }

    /// Returns the derivatives of each corner of the rim by the parameters that move stops or change the transmission.
    fn rim_motions(&self) -> Vec<[f64; 2]> {
        let mut drifts = Vec::with_capacity(self.rim.len() * self.light_derivatives);
        for point in &self.rim {
            for derivative in &self.derivatives[self.derivatives.len() - self.light_derivatives..] {
                let own = self.edge_derivative(point, point.stop, derivative);
                // A cusp moves with the mean of its two edges.
                let rate = point.other.map_or(own, |other| {
                    (own + self.edge_derivative(point, other, derivative)) / 2.0
                });
                drifts.push(point.direction().map(|d| rate * d));
            }
        }
        drifts
    }

    /// Returns the derivative of the distance of the edge of `stop` from the centre at `point`.
    fn edge_derivative(&self, point: &RimPoint, stop: usize, derivative: &PupilDerivative) -> f64 {
        let Some(circle) = self.pupil.stops().get(stop) else {
            return 0.0;
        };
        let (moved, [cos, sin]) = (&derivative.stops[stop], point.direction());
        let n = [0, 1].map(|axis| {
            (self.centre[axis] + point.edge[axis] - circle.centre[axis]) / circle.radius
        });
        let facing = (n[0] * cos + n[1] * sin).max(LEAST_FACING);
        (moved.radius + moved.centre[0] * n[0] + moved.centre[1] * n[1]) / facing
    }

    /// Sets the slope polynomials of the wavefront and of the derivatives, with the Laplacian correction.
    fn set_slopes(&mut self, correction: f64) {
        let corrected = |w: &Wavefront| w.add_scaled(-correction, &w.laplacian());
        let half = packs(self.derivatives.len());
        let terms = slope_terms(self.degree);
        let mut velocities = vec![[0.0; BLOCK]; terms * (2 * half * LANES).div_ceil(BLOCK)];
        let mut add = |term: usize, column: usize, value: f64| {
            velocities[column / BLOCK * terms + term][column % BLOCK] += value;
        };
        let [along_x, along_y] = self.pupil.squeeze;
        for ((i, j), c) in powers().zip(corrected(&self.pupil.wavefront).coefficients()) {
            if i + j > self.degree {
                break;
            }
            if i > 0 {
                self.landing[slope_index(i - 1, j)][0] += along_x * i as f64 * c;
            }
            if j > 0 {
                self.landing[slope_index(i, j - 1)][1] += along_y * j as f64 * c;
            }
        }
        if self.light_derivatives > 0 {
            self.set_curvature();
        }
        for (which, derivative) in self.derivatives.iter().enumerate() {
            for ((i, j), c) in powers().zip(corrected(&derivative.wavefront).coefficients()) {
                if i + j > self.degree {
                    break;
                }
                if i > 0 {
                    add(slope_index(i - 1, j), which, along_x * i as f64 * c);
                }
                if j > 0 {
                    let column = half * LANES + which;
                    add(slope_index(i, j - 1), column, along_y * j as f64 * c);
                }
            }
        }
        self.velocities = velocities;
    }

    /// Sets the second derivatives of the wavefront.
    fn set_curvature(&mut self) {
        self.curvature = vec![[0.0; 3]; slope_terms(self.degree - 1)];
        for ((i, j), c) in powers().zip(self.pupil.wavefront.coefficients()) {
            if i + j > self.degree {
                break;
            }
            let (a, b) = (i as f64, j as f64);
            if i > 1 {
                self.curvature[slope_index(i - 2, j)][0] += c * a * (a - 1.0);
            }
            if i > 0 && j > 0 {
                self.curvature[slope_index(i - 1, j - 1)][1] += c * a * b;
            }
            if j > 1 {
                self.curvature[slope_index(i, j - 2)][2] += c * b * (b - 1.0);
            }
        }
    }

    /// Fills `ring` with ring `k`.
    #[inline(always)]
    pub(super) fn ring<S: pulp::Simd>(&self, simd: S, k: usize, ring: &mut Ring) {
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
            if let Some(annulus) = &self.annulus {
                let shares = [(parts - part) as f64, part as f64].map(|p| p / parts as f64);
                let outer = [0, 1].map(|x| shares[0] * a[x] + shares[1] * b[x]);
                let (from_centre, outward) = annulus.corner(outer, k, self.rings);
                let u = [0, 1].map(|x| self.centre[x] + from_centre[x]);
                let monomials = self.push_corner(simd, u, ring);
                let from = [(first, outward * shares[0]), (second, outward * shares[1])];
                self.push_drift(&monomials, from, ring);
                part += self.rings;
                while k > 0 && part >= k {
                    part -= k;
                    first += 1;
                }
                continue;
            }
            let u = [0, 1].map(|x| self.centre[x] + weights[0] * a[x] + weights[1] * b[x]);
            let monomials = self.push_corner(simd, u, ring);
            self.push_drift(
                &monomials,
                [(first, weights[0]), (second, weights[1])],
                ring,
            );
            // Advances by rings / k corners of the rim.
            part += self.rings;
            while k > 0 && part >= k {
                part -= k;
                first += 1;
            }
        }
    }

    /// Appends the corner at pupil point `u` to `ring`: its landing point and derivatives. Returns the monomials there.
    #[inline(always)]
    fn push_corner<S: pulp::Simd>(
        &self,
        simd: S,
        u: [f64; 2],
        ring: &mut Ring,
    ) -> [f64; SLOPE_TERMS] {
        let mut all = [0.0; SLOPE_TERMS];
        let monomials = &mut all;
        let mut last = 1;
        monomials[0] = 1.0;
        // Degree by degree: the previous row times x, then its last monomial times y.
        let mut before = 0;
        for degree in 1..self.degree {
            for k in 0..degree {
                monomials[last + k] = monomials[before + k] * u[0];
            }
            monomials[last + degree] = monomials[before + degree - 1] * u[1];
            before = last;
            last += degree + 1;
        }
        let mut landing = [0.0; 2];
        let monomials = &all[..slope_terms(self.degree)];
        for (monomial, row) in monomials.iter().zip(&self.landing) {
            landing[0] += monomial * row[0];
            landing[1] += monomial * row[1];
        }
        ring.u.push(u);
        ring.landing.push(landing);
        let width = 2 * packs(self.derivatives.len());
        let start = ring.velocity.len();
        for rows in self.velocities.chunks_exact(monomials.len()) {
            let sums = weighted_sum(simd, monomials, rows);
            let (packs, _) = sums.as_chunks::<LANES>();
            ring.velocity.extend_from_slice(packs);
        }
        // The last block is padded.
        ring.velocity.truncate(start + width);
        all
    }

    /// Adds the motion of the last corner of `ring` with the stops: the weighted mean of that of two rim corners.
    #[inline(always)]
    fn push_drift(&self, monomials: &[f64; SLOPE_TERMS], from: [(usize, f64); 2], ring: &mut Ring) {
        if self.light_derivatives == 0 {
            return;
        }
        let half = packs(self.derivatives.len());
        let start = ring.velocity.len() - 2 * half;
        let [mut xx, mut xy, mut yy] = [0.0; 3];
        for (monomial, [of_xx, of_xy, of_yy]) in monomials.iter().zip(&self.curvature) {
            xx += monomial * of_xx;
            xy += monomial * of_xy;
            yy += monomial * of_yy;
        }
        let [along_x, along_y] = self.pupil.squeeze;
        for which in 0..self.light_derivatives {
            let [a, b] = from.map(|(rim, weight)| {
                let drift = &self.rim_motion[rim * self.light_derivatives + which];
                [weight * drift[0], weight * drift[1]]
            });
            let drift = [a[0] + b[0], a[1] + b[1]];
            let place = self.derivatives.len() - self.light_derivatives + which;
            let (pack, lane) = (start + place / LANES, place % LANES);
            ring.velocity[pack][lane] += along_x * (xx * drift[0] + xy * drift[1]);
            ring.velocity[pack + half][lane] += along_y * (xy * drift[0] + yy * drift[1]);
            ring.drift.push(drift);
        }
    }
}

impl Annulus {
    /// Creates the hole of `radius` in a pupil of mean radius `reach` whose mesh has `rings` rings.
    fn new(radius: f64, reach: f64, rings: usize) -> Self {
        let first = (rings as f64 * radius / reach).round() as usize;
        let first = first.clamp(1, rings - 1);
        let spacing = TAU / (6 * first) as f64;
        Self {
            radius: radius * (1.0 + spacing * spacing / 12.0),
            first,
        }
    }

    /// Returns the corner of ring `k` of `rings` towards the point `outer` of the rim, from the centre, and its share of the
    /// way from the hole to the rim.
    #[inline(always)]
    fn corner(&self, outer: [f64; 2], k: usize, rings: usize) -> ([f64; 2], f64) {
        let outward = (k - self.first) as f64 / (rings - self.first) as f64;
        let reach = outer[0].hypot(outer[1]);
        // Where the hole crosses the rim, triangles have no area.
        let inner = self.radius.min(reach) / reach;
        let scale = inner + outward * (1.0 - inner);
        (outer.map(|x| x * scale), outward)
    }
}

/// Returns the number of monomials of the slope of a wavefront of `degree`.
const fn slope_terms(degree: usize) -> usize {
    degree * (degree + 1) / 2
}

/// Returns the index of `u_x^i u_y^j` among the monomials of a slope.
const fn slope_index(i: usize, j: usize) -> usize {
    let n = i + j;
    n * (n + 1) / 2 + j
}
