//! What a lens does to the light of one point in one channel, ray by ray: wavefront and pupil, and
//! what the sensor does to the picture that they draw.

use super::Wavefront;
use crate::moments::CentralMoments;
use crate::sensor::Sensor;

/// Most circles that can bound a pupil, its own rim included: two of vignetting as fitted, two more as
/// added, thirteen blades of an iris.
pub const MAX_STOPS: usize = 18;

/// How much light passes at pupil point u: `exp(-(square |u|² + fourth |u|⁴))`, one in the middle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Transmission {
    /// By the squared radius.
    pub square: f64,
    /// By its fourth power.
    pub fourth: f64,
}

impl Transmission {
    /// Whether the pupil is evenly lit.
    pub fn is_uniform(&self) -> bool {
        self.square == 0.0 && self.fourth == 0.0
    }

    /// The share of light that passes at pupil point `u`, one in the middle.
    pub fn at(&self, u: [f64; 2]) -> f64 {
        let r2 = u[0] * u[0] + u[1] * u[1];
        (-(self.square + self.fourth * r2) * r2).exp()
    }
}

/// A circle that light must pass within, in units of the pupil's radius.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// Centre, image axes.
    pub centre: [f64; 2],
    /// Radius.
    pub radius: f64,
}

impl Stop {
    const RIM: Self = Self {
        centre: [0.0, 0.0],
        radius: 1.0,
    };

    /// How far `u` lies within the circle; negative outside.
    fn depth(&self, u: [f64; 2]) -> f64 {
        self.radius - (u[0] - self.centre[0]).hypot(u[1] - self.centre[1])
    }
}

/// Wavefront, pupil and symmetric blur of one image point in one channel. Lengths in px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalPupil {
    /// Where rays land.
    pub wavefront: Wavefront,
    stops: [Stop; MAX_STOPS],
    stop_count: usize,
    /// Variance along any direction of what blurs the picture besides the rays, px²; on pixels that are not
    /// square along y alone.
    pub blur_variance_px2: f64,
    /// That along x over that along y.
    blur_ratio: f64,
    /// How evenly the pupil is lit.
    pub transmission: Transmission,
    /// Factors on where rays land along image x and y: other than one behind an anamorphic lens.
    pub squeeze: [f64; 2],
    /// Twice the f-number times the wavelength, px: what makes light a wave. Zero: rays.
    pub wave_px: f64,
    /// What the sensor does to the picture.
    pub sensor: Sensor,
}

impl LocalPupil {
    /// An evenly lit round pupil behind `wavefront`.
    pub fn circular(wavefront: Wavefront, blur_variance_px2: f64) -> Self {
        Self {
            wavefront,
            stops: [Stop::RIM; MAX_STOPS],
            stop_count: 1,
            blur_variance_px2,
            blur_ratio: 1.0,
            transmission: Transmission::default(),
            squeeze: [1.0; 2],
            wave_px: 0.0,
            sensor: Sensor::default(),
        }
    }

    /// Puts a round rim of `radius` pupil radii about the axis in place of the pupil's own; other stops
    /// stay.
    pub fn set_rim_radius(&mut self, radius: f64) {
        self.stops[0] = Stop {
            radius,
            ..Stop::RIM
        };
    }

    /// Clips the pupil by `stop` as well. One that clips nothing is not kept.
    ///
    /// # Panics
    /// Where there are [`MAX_STOPS`] already.
    pub fn clip(&mut self, stop: Stop) {
        if stop.radius - stop.centre[0].hypot(stop.centre[1]) >= self.stops[0].radius {
            return;
        }
        assert!(self.stop_count < MAX_STOPS, "at most {MAX_STOPS} stops");
        self.stops[self.stop_count] = stop;
        self.stop_count += 1;
    }

    /// The circles whose common part is the pupil, its own rim first.
    pub fn stops(&self) -> &[Stop] {
        &self.stops[..self.stop_count]
    }

    /// The same light on a grid of which `scale` pixels make up one of the present ones.
    #[must_use]
    pub fn rescaled(&self, scale: f64) -> Self {
        Self {
            wavefront: self.wavefront.rescaled(scale),
            blur_variance_px2: self.blur_variance_px2 * scale * scale,
            wave_px: self.wave_px * scale,
            sensor: self.sensor.rescaled(scale),
            ..*self
        }
    }

    /// The same light on pixels of which `factor` lie where one did along x: as stretched along x by it.
    #[must_use]
    pub fn stretched_x(&self, factor: f64) -> Self {
        Self {
            blur_ratio: self.blur_ratio * factor * factor,
            squeeze: [self.squeeze[0] * factor, self.squeeze[1]],
            sensor: self.sensor.stretched_x(factor),
            ..*self
        }
    }

    /// Variances along x and y of what blurs the picture besides the rays, px².
    pub fn blur_variances_px2(&self) -> [f64; 2] {
        [
            self.blur_variance_px2 * self.blur_ratio,
            self.blur_variance_px2,
        ]
    }

    /// The same light with `variance_px2` more symmetric blur along both axes of the grid.
    #[must_use]
    pub fn blurred_by(&self, variance_px2: f64) -> Self {
        let [along_x, along_y] = self.blur_variances_px2().map(|v| v + variance_px2);
        Self {
            blur_variance_px2: along_y,
            blur_ratio: match self.blur_ratio != 1.0 && along_y > 0.0 {
                true => along_x / along_y,
                false => self.blur_ratio,
            },
            ..*self
        }
    }

    /// The same glass with its pupil `ratio` times as wide; stops but the rim stay where they are.
    #[must_use]
    pub fn with_pupil(&self, ratio: f64) -> Self {
        let mut changed = Self {
            transmission: Transmission {
                square: self.transmission.square * ratio.powi(2),
                fourth: self.transmission.fourth * ratio.powi(4),
            },
            squeeze: self.squeeze,
            blur_ratio: self.blur_ratio,
            wave_px: self.wave_px / ratio,
            sensor: self.sensor,
            ..Self::circular(self.wavefront.with_pupil(ratio), self.blur_variance_px2)
        };
        changed.stops[0] = self.stops[0];
        for stop in &self.stops()[1..] {
            changed.clip(Stop {
                centre: stop.centre.map(|c| c / ratio),
                radius: stop.radius / ratio,
            });
        }
        changed
    }

    /// Whether light is to be drawn as a wave: fringes finer than a pixel can tell are drawn as rays.
    pub fn diffracts(&self) -> bool {
        self.wave_px >= LEAST_WAVE_PX
    }

    /// Whether light passes at pupil point `u`.
    pub fn passes(&self, u: [f64; 2]) -> bool {
        self.stops().iter().all(|stop| stop.depth(u) >= 0.0)
    }

    /// A point well inside the pupil, from which its edge is seen whole, and how deep inside: the
    /// centre and radius of (nearly) the largest circle within. A negative radius means that the
    /// stops let nothing through.
    pub fn inscribed_circle(&self) -> ([f64; 2], f64) {
        let depth = |u| {
            let depths = self.stops().iter().map(|stop| stop.depth(u));
            depths.fold(f64::INFINITY, f64::min)
        };
        let mut best = ([0.0, 0.0], depth([0.0, 0.0]));
        if self.stop_count == 1 {
            return best;
        }
        // Away from whichever edge is nearest, by ever smaller steps: the depth is concave.
        let mut at: [f64; 2] = best.0;
        let mut step: f64 = 0.5;
        for _ in 0..200 {
            let nearest = self
                .stops()
                .iter()
                .min_by(|a, b| a.depth(at).total_cmp(&b.depth(at)))
                .expect("the rim is always there");
            let (dx, dy) = (nearest.centre[0] - at[0], nearest.centre[1] - at[1]);
            let far = dx.hypot(dy);
            if far < 1e-12 {
                break;
            }
            let stride = step.min(far);
            at = [at[0] + stride * dx / far, at[1] + stride * dy / far];
            let here = depth(at);
            if here > best.1 {
                best = (at, here);
            }
            step *= 0.95;
        }
        best
    }

    /// Distance from `from`, a point inside, to the pupil's edge in direction (`cos`, `sin`), and which
    /// stop is met there.
    pub fn edge(&self, from: [f64; 2], cos: f64, sin: f64) -> (f64, usize) {
        let mut nearest = (f64::INFINITY, 0);
        for (index, stop) in self.stops().iter().enumerate() {
            let (x, y) = (from[0] - stop.centre[0], from[1] - stop.centre[1]);
            let along = x * cos + y * sin;
            let across2 = (x * x + y * y - along * along).max(0.0);
            let reach = (stop.radius * stop.radius - across2).max(0.0).sqrt() - along;
            if reach < nearest.0 {
                nearest = (reach, index);
            }
        }
        nearest
    }

    /// Where the ray through pupil point `u` lands off the chief ray, px.
    #[inline]
    pub fn landing(&self, u: [f64; 2]) -> [f64; 2] {
        let [x, y] = self.wavefront.slope(u);
        [self.squeeze[0] * x, self.squeeze[1] * y]
    }

    /// Centroid of the light off the chief ray, px.
    pub fn centroid(&self) -> [f64; 2] {
        if self.stops() == [Stop::RIM] && self.transmission.is_uniform() {
            let [x, y] = self.wavefront.mean_slope();
            [self.squeeze[0] * x, self.squeeze[1] * y]
        } else {
            self.moments().1
        }
    }

    /// Second and third central moments of the light, px² and px³, in image axes, and its centroid
    /// off the chief ray, px. By quadrature over the pupil; exact for an unclipped, evenly lit one. What
    /// waves and halos add has no finite moments and is left out.
    pub fn moments(&self) -> (CentralMoments, [f64; 2]) {
        let angles = if self.stop_count > FEW_STOPS {
            MORE_ANGLES
        } else {
            ANGLES
        };
        let mut landed: Vec<(f64, [f64; 2])> = Vec::with_capacity(RADII.len() * angles);
        let (centre, depth) = self.inscribed_circle();
        for k in 0..angles {
            let angle = std::f64::consts::TAU * (k as f64 + 0.5) / angles as f64;
            let (sin, cos) = angle.sin_cos();
            let reach = if depth > 0.0 {
                self.edge(centre, cos, sin).0
            } else {
                PINHOLE_RADIUS
            };
            for (radius, weight) in RADII {
                let r = reach * radius;
                let u = [centre[0] + r * cos, centre[1] + r * sin];
                let light = weight * reach * reach * self.transmission.at(u);
                landed.push((light, self.landing(u)));
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
                *sum += w * term / total;
            }
        }
        let mut moments = CentralMoments::from_array(sums);
        let [along_x, along_y] = self.blur_variances_px2();
        moments.mu20 += along_x;
        moments.mu02 += along_y;
        (self.sensor.blurred_moments(moments), mean)
    }
}

/// Twice the f-number times the wavelength, px, below which rays do: an f/1.2 lens on usual pixels. Waves
/// and rays then differ by half a per cent of the energy where nothing else blurs.
const LEAST_WAVE_PX: f64 = 0.2;

/// Radius of the pinhole, in pupil radii, that is drawn if the stops pass no light: a PSF always has light.
pub const PINHOLE_RADIUS: f64 = 0.02;

/// Directions of the quadrature: exact for products of three slopes (degree 15) and then some, for
/// the sake of clipped pupils.
const ANGLES: usize = 48;
/// The same behind more stops than this, which have many corners.
const MORE_ANGLES: usize = 120;
const FEW_STOPS: usize = 3;

/// Gauss-Legendre in the squared radius, ten points: radius over reach, and weight.
const RADII: [(f64, f64); 10] = radii();

const fn radii() -> [(f64, f64); 10] {
    // Nodes and weights of [-1, 1]; the square root is taken by Newton's method, in a constant.
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

const fn root(x: f64) -> f64 {
    let mut r = 1.0;
    let mut k = 0;
    while k < 60 {
        r = (r + x / r) / 2.0;
        k += 1;
    }
    r
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::FieldPoint;
    use crate::lens::ReducedNumbers;

    fn numbers() -> ReducedNumbers {
        ReducedNumbers {
            alpha: 6.0,
            beta: -2.0,
            gamma: 1.5,
            delta: 0.9,
            phi: -1.2,
        }
    }

    #[test]
    fn quadrature_agrees_with_the_closed_forms() {
        let at = FieldPoint::new(0.5, -0.7);
        let pupil = LocalPupil::circular(Wavefront::third_order(&numbers(), at), 0.3);
        let (got, centroid) = pupil.moments();
        let want = numbers()
            .coefficients()
            .moments(at)
            .with_added_variance(0.3);
        for (g, w) in got.to_array().iter().zip(want.to_array()) {
            assert!((g - w).abs() < 1e-11 * want.trace().powf(1.5), "{g} {w}");
        }
        // Centroid -phi X (docs/background/model.md section 3).
        assert!((centroid[0] - 1.2 * at.x).abs() < 1e-12);
        assert!((centroid[1] - 1.2 * at.y).abs() < 1e-12);
    }

    #[test]
    fn a_clipped_pupil_is_seen_whole_from_inside() {
        let mut pupil = LocalPupil::circular(Wavefront::default(), 0.0);
        pupil.clip(Stop {
            centre: [0.8, 0.0],
            radius: 1.0,
        });
        pupil.clip(Stop {
            centre: [0.0, 0.0],
            radius: 2.0,
        });
        assert_eq!(pupil.stops().len(), 2);
        let (centre, depth) = pupil.inscribed_circle();
        assert!((centre[0] - 0.4).abs() < 1e-3 && (depth - 0.6).abs() < 1e-3);
        let (reach, stop) = pupil.edge(centre, 1.0, 0.0);
        assert!((centre[0] + reach - 1.0).abs() < 1e-12 && stop == 0);
        let (reach, stop) = pupil.edge(centre, -1.0, 0.0);
        assert!((centre[0] - reach + 0.2).abs() < 1e-12 && stop == 1);
        assert!(pupil.passes([0.9, 0.0]) && !pupil.passes([-0.3, 0.0]));
    }

    #[test]
    fn stops_that_let_nothing_through_are_noticed() {
        let mut pupil = LocalPupil::circular(Wavefront::default(), 0.0);
        pupil.clip(Stop {
            centre: [3.0, 0.0],
            radius: 1.0,
        });
        assert!(pupil.inscribed_circle().1 < 0.0);
        assert!(pupil.moments().0.trace().is_finite());
    }
}
