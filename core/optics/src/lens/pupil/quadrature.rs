//! Quadrature over a pupil: rays from a point of it outwards, and the moments of the light that they carry.

use std::sync::LazyLock;

use super::{LocalPupil, PINHOLE_RADIUS, Stop, Transmission};
use crate::lens::wavefront::{Directions, SlopesAlong};
use crate::moments::CentralMoments;

/// Directions of the quadrature: more than the exact integration of products of three slopes (degree 15) needs, for
/// clipped pupils.
static FEW_DIRECTIONS: LazyLock<Directions> = LazyLock::new(|| Directions::new(48));
/// Directions for more than [`FEW_STOPS`] stops, whose common part has many corners, and for a pupil with an obstruction.
pub(super) static MORE_DIRECTIONS: LazyLock<Directions> = LazyLock::new(|| Directions::new(120));
/// Number of stops up to which [`FEW_DIRECTIONS`] suffice.
const FEW_STOPS: usize = 3;

/// Terms that are summed side by side, in one vector of the processor; the number of directions is a multiple of it.
const LANES: usize = 8;

/// Rays for quadrature over a pupil, from a point of it outwards.
pub(super) struct Fan {
    /// The point, pupil radii.
    pub(super) centre: [f64; 2],
    pub(super) directions: &'static Directions,
    /// Distances from the point between which rays lie, by direction.
    pub(super) inner: Vec<f64>,
    pub(super) outer: Vec<f64>,
    /// A disc whose rays are left out.
    pub(super) dark: Option<Stop>,
}

impl Fan {
    /// Writes the distance of the rays of one node of [`RADII`] from the centre, and their light where the transmission is one.
    #[inline(always)]
    fn ring(&self, (radius, weight): (f64, f64), distances: &mut [f64], light: &mut [f64]) {
        let ends = self.inner.iter().zip(&self.outer);
        for ((inner, outer), (r, light)) in ends.zip(distances.iter_mut().zip(light)) {
            let ring = outer * outer - inner * inner;
            *r = (inner * inner + ring * (radius * radius)).sqrt();
            *light = weight * ring;
        }
    }

    /// Returns the light of each ray, and its pupil point. Rays in the dark have none.
    fn all_rays(&self, transmission: &Transmission) -> impl Iterator<Item = (f64, [f64; 2])> {
        let is_uniform = transmission.is_uniform();
        let count = self.outer.len();
        let [mut distances, mut light] = [0; 2].map(|_| vec![0.0; count]);
        RADII.iter().flat_map(move |node| {
            self.ring(*node, &mut distances, &mut light);
            let rays = distances.iter().zip(&light).zip(self.directions.vectors());
            let rays = rays.map(|((r, light), direction)| {
                let u = [0, 1].map(|axis| self.centre[axis] + r * direction[axis]);
                let is_dark = self.dark.is_some_and(|disc| disc.depth(u) > 0.0);
                let passed = match (is_dark, is_uniform) {
                    (true, _) => 0.0,
                    (false, true) => *light,
                    (false, false) => light * transmission.at(u),
                };
                (passed, u)
            });
            rays.collect::<Vec<_>>()
        })
    }

    /// Returns the light of each ray that has some, and its pupil point.
    pub(super) fn rays(&self, transmission: &Transmission) -> Vec<(f64, [f64; 2])> {
        let rays = self.all_rays(transmission);
        rays.filter(|(light, _)| *light > 0.0).collect()
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
        let directions: &'static Directions =
            if self.stop_count > FEW_STOPS || self.transmission.picture.is_some() {
                &MORE_DIRECTIONS
            } else {
                &FEW_DIRECTIONS
            };
        let (centre, depth) = self.inner_point();
        let outer = if depth > 0.0 {
            self.edges(centre, directions)
        } else {
            vec![PINHOLE_RADIUS; directions.vectors().len()]
        };
        Fan {
            centre,
            directions,
            inner: vec![0.0; directions.vectors().len()],
            outer,
            dark: None,
        }
    }

    /// Returns the distance from the inner point `from` to the edge in each direction, as [`LocalPupil::edge`].
    pub(super) fn edges(&self, from: [f64; 2], directions: &Directions) -> Vec<f64> {
        pulp::Arch::new().dispatch(EdgeSearch {
            pupil: self,
            from,
            directions: directions.vectors(),
        })
    }

    /// Returns a point well inside the pupil, and its distance from the edge, pupil radii.
    ///
    /// Sixty steps reach the centre of [`LocalPupil::inscribed_circle`] within a hundredth of a radius, and any inner point serves a
    /// quadrature. A narrow pupil needs the full search.
    fn inner_point(&self) -> ([f64; 2], f64) {
        let found = self.circle_within_stops(60, 0.9);
        if found.1 > 0.1 {
            found
        } else {
            self.inscribed_circle()
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
        let light: Option<Vec<f64>> = (!is_even).then(|| {
            let rays = fan.all_rays(&self.transmission);
            rays.map(|(light, _)| light).collect()
        });
        let LandedLight { mean, sums } = pulp::Arch::new().dispatch(Landing {
            pupil: self,
            fan: &fan,
            light,
        });
        let mut moments = CentralMoments::from_array(sums);
        let [along_x, along_y] = self.blur_variances_px2();
        moments.mu20 += along_x;
        moments.mu02 += along_y;
        (self.sensor.blurred_moments(moments), mean)
    }
}

/// The search of the edge of a pupil from a point, in vectors of directions.
struct EdgeSearch<'a> {
    pupil: &'a LocalPupil,
    from: [f64; 2],
    directions: &'a [[f64; 2]],
}

impl pulp::NullaryFnOnce for EdgeSearch<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn call(self) -> Vec<f64> {
        let mut nearest = vec![f64::INFINITY; self.directions.len()];
        for stop in self.pupil.stops() {
            let [x, y] = [0, 1].map(|axis| self.from[axis] - stop.centre[axis]);
            let (away2, radius2) = (x * x + y * y, stop.radius * stop.radius);
            for (nearest, [cos, sin]) in nearest.iter_mut().zip(self.directions) {
                let along = x * cos + y * sin;
                let across2 = (away2 - along * along).max(0.0);
                let reach = (radius2 - across2).max(0.0).sqrt() - along;
                *nearest = if reach < *nearest { reach } else { *nearest };
            }
        }
        nearest
    }
}

/// The rays of a fan with the light of each, where it is not that of an even pupil. `pulp::Arch::dispatch` compiles their sums for the
/// widest vectors of the processor.
struct Landing<'a> {
    pupil: &'a LocalPupil,
    fan: &'a Fan,
    light: Option<Vec<f64>>,
}

/// The light of all rays where it lands.
struct LandedLight {
    mean: [f64; 2],
    /// Mean of the products of two, then of three coordinates about the mean.
    sums: [f64; 7],
}

impl pulp::NullaryFnOnce for Landing<'_> {
    type Output = LandedLight;

    #[inline(always)]
    fn call(self) -> LandedLight {
        let Self { pupil, fan, light } = self;
        // Along a spoke the slope is a polynomial in one variable.
        let slopes: SlopesAlong = fan.directions.slopes(&pupil.wavefront.about(fan.centre));
        let count = fan.outer.len();
        let mut distances = vec![0.0; count];
        let [mut own, mut x, mut y] = [0; 3].map(|_| vec![0.0; RADII.len() * count]);
        for (k, node) in RADII.iter().enumerate() {
            let ring = k * count..(k + 1) * count;
            fan.ring(*node, &mut distances, &mut own[ring.clone()]);
            slopes.at(&distances, &mut x[ring.clone()], &mut y[ring]);
        }
        let light = light.unwrap_or(own);
        let rays = || {
            let (w, _) = light.as_chunks::<LANES>();
            let ((x, _), (y, _)) = (x.as_chunks::<LANES>(), y.as_chunks::<LANES>());
            w.iter().zip(x.iter().zip(y))
        };
        let mut sums = [[0.0; LANES]; 3];
        for (w, (x, y)) in rays() {
            for k in 0..LANES {
                sums[0][k] += w[k];
                sums[1][k] += w[k] * x[k];
                sums[2][k] += w[k] * y[k];
            }
        }
        let [total, x, y] = sums.map(|sum| sum.iter().sum::<f64>());
        let centre = [x / total, y / total];
        let mut sums = [[0.0; LANES]; 7];
        for (w, (x, y)) in rays() {
            for k in 0..LANES {
                let (x, y) = (x[k] - centre[0], y[k] - centre[1]);
                let (xx, xy, yy) = (w[k] * x * x, w[k] * x * y, w[k] * y * y);
                let terms = [xx, xy, yy, xx * x, xx * y, yy * x, yy * y];
                for (sum, term) in sums.iter_mut().zip(terms) {
                    sum[k] += term;
                }
            }
        }
        let [sx, sy] = pupil.squeeze;
        let squeezed = [
            sx * sx,
            sx * sy,
            sy * sy,
            sx * sx * sx,
            sx * sx * sy,
            sx * sy * sy,
            sy * sy * sy,
        ];
        let mean_of = |k: usize| squeezed[k] * sums[k].iter().sum::<f64>() / total;
        LandedLight {
            mean: [sx * centre[0], sy * centre[1]],
            sums: std::array::from_fn(mean_of),
        }
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
