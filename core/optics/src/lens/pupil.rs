//! The pupil of a lens for one image point in one channel: wavefront, stops, transmission and sensor.

mod mirrored;
mod obstruction;
mod picture;
mod quadrature;

pub use obstruction::Shadow;
pub use picture::AperturePicture;

use super::wavefront::{DEGREE, TERMS, Wavefront, powers};
use crate::sensor::Sensor;

/// Largest number of circles that bound a pupil: its rim, thirteen iris blades, and two each of the fitted vignetting, of
/// the added one, and of the one that a diagnosis tries.
pub const MAX_STOPS: usize = 20;
/// Largest number of circles outside the rim that are kept: those of vignetting.
const MAX_OUTER_STOPS: usize = 6;

/// The transmission of a filter at pupil point u: `exp(-(square |u - centre|² + fourth |u - centre|⁴))`, one at its centre.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Transmission {
    /// Coefficient of the squared radius.
    pub square: f64,
    /// Coefficient of the fourth power of the radius.
    pub fourth: f64,
    /// Centre (x, y) of the filter, pupil radii.
    pub centre: [f64; 2],
    /// A picture whose transmission multiplies that of the filter. Derivatives leave it as it is.
    pub picture: Option<PictureMask>,
}

/// A picture over the pupil.
#[derive(Debug, Clone, PartialEq)]
pub struct PictureMask {
    /// The picture.
    pub picture: AperturePicture,
    /// Factor on pupil points before they are looked up; negative for a picture turned by 180 degrees.
    pub scale: f64,
}

impl Transmission {
    /// Returns whether the transmission is one everywhere.
    pub fn is_uniform(&self) -> bool {
        self.square == 0.0 && self.fourth == 0.0 && self.picture.is_none()
    }

    /// Returns the transmission at pupil point `u`.
    pub fn at(&self, u: [f64; 2]) -> f64 {
        let (_, r2) = self.offset(u);
        let filter = (-(self.square + self.fourth * r2) * r2).exp();
        match &self.picture {
            None => filter,
            Some(mask) => filter * mask.picture.at(u.map(|u| u * mask.scale)),
        }
    }

    /// Returns the gradient (x, y) of the logarithm of the transmission at pupil point `u`.
    pub fn log_gradient(&self, u: [f64; 2]) -> [f64; 2] {
        let (offset, r2) = self.offset(u);
        offset.map(|o| -2.0 * (self.square + 2.0 * self.fourth * r2) * o)
    }

    /// Returns the derivative of the logarithm of the transmission at pupil point `u` if the numbers change at `rates`.
    pub fn log_derivative(&self, rates: &Self, u: [f64; 2]) -> f64 {
        let (_, r2) = self.offset(u);
        let [x, y] = self.log_gradient(u);
        -(rates.square + rates.fourth * r2) * r2 - x * rates.centre[0] - y * rates.centre[1]
    }

    /// Returns `u` from the centre, and its squared length.
    fn offset(&self, u: [f64; 2]) -> ([f64; 2], f64) {
        let offset = [u[0] - self.centre[0], u[1] - self.centre[1]];
        (offset, offset[0] * offset[0] + offset[1] * offset[1])
    }
}

/// A circular stop, in pupil radii. Light passes inside the circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// Centre (x, y), in image axes.
    pub centre: [f64; 2],
    /// Radius.
    pub radius: f64,
}

impl Stop {
    const RIM: Self = Self {
        centre: [0.0, 0.0],
        radius: 1.0,
    };

    /// Returns the distance of `u` from the edge, positive inside.
    pub(crate) fn depth(&self, u: [f64; 2]) -> f64 {
        self.radius - (u[0] - self.centre[0]).hypot(u[1] - self.centre[1])
    }
}

/// Wavefront, stops, transmission and symmetric blur of one image point in one channel. Lengths are in px.
#[derive(Debug, Clone, PartialEq)]
pub struct LocalPupil {
    /// The wavefront, whose slope gives the landing points of rays.
    pub wavefront: Wavefront,
    stops: [Stop; MAX_STOPS],
    stop_count: usize,
    /// Number of leading `stops` that bound the iris: its rim and its blades. They scale with it.
    iris_stop_count: usize,
    /// Circles outside the rim, which would clip a wider iris.
    outer: [Stop; MAX_OUTER_STOPS],
    outer_count: usize,
    /// An opaque disc in the light's way, such as the secondary mirror of a catadioptric lens.
    obstruction: Option<Stop>,
    /// Variance of the symmetric blur, px²: along any direction, or along y if pixels are not square.
    pub blur_variance_px2: f64,
    /// Variance of the symmetric blur along x over that along y.
    blur_ratio: f64,
    /// Transmission of the pupil.
    pub transmission: Transmission,
    /// Factors on the landing points along image x and y; they differ from one for an anamorphic lens.
    pub squeeze: [f64; 2],
    /// Twice the f-number times the wavelength, px: the scale of diffraction. Zero for rays only.
    pub wave_px: f64,
    /// The sensor behind the lens.
    pub sensor: Sensor,
}

impl LocalPupil {
    /// Creates a circular pupil of even transmission with `wavefront`.
    pub fn circular(wavefront: Wavefront, blur_variance_px2: f64) -> Self {
        Self {
            wavefront,
            stops: [Stop::RIM; MAX_STOPS],
            stop_count: 1,
            iris_stop_count: 1,
            outer: [Stop::RIM; MAX_OUTER_STOPS],
            outer_count: 0,
            obstruction: None,
            blur_variance_px2,
            blur_ratio: 1.0,
            transmission: Transmission::default(),
            squeeze: [1.0; 2],
            wave_px: 0.0,
            sensor: Sensor::default(),
        }
    }

    /// Replaces the rim of the pupil by a circle of `radius` pupil radii about the axis; other stops stay.
    pub fn set_rim_radius(&mut self, radius: f64) {
        self.stops[0] = Stop {
            radius,
            ..Stop::RIM
        };
    }

    /// Adds `stop`. Outside the rim it clips nothing, until the iris is opened ([`LocalPupil::with_pupil`]).
    ///
    /// # Panics
    /// If there are [`MAX_STOPS`] already.
    pub fn clip(&mut self, stop: Stop) {
        if !self.lies_within_rim(stop) {
            if self.outer_count < MAX_OUTER_STOPS {
                self.outer[self.outer_count] = stop;
                self.outer_count += 1;
            }
            return;
        }
        assert!(self.stop_count < MAX_STOPS, "at most {MAX_STOPS} stops");
        self.stops[self.stop_count] = stop;
        self.stop_count += 1;
    }

    /// Adds `stop` as an edge of the iris, which scales with the iris, unless it lies outside the rim.
    ///
    /// # Panics
    /// If there are [`MAX_STOPS`] already.
    pub fn clip_iris(&mut self, stop: Stop) {
        if self.lies_within_rim(stop) {
            self.clip(stop);
            self.stops[self.iris_stop_count..self.stop_count].rotate_right(1);
            self.iris_stop_count += 1;
        }
    }

    /// Returns whether a part of `stop` lies within the rim, so that it clips.
    fn lies_within_rim(&self, stop: Stop) -> bool {
        stop.radius - stop.centre[0].hypot(stop.centre[1]) < self.stops[0].radius
    }

    /// Returns the circles whose intersection is the pupil; the rim is the first.
    pub fn stops(&self) -> &[Stop] {
        &self.stops[..self.stop_count]
    }

    /// Returns the pupil on a grid with `scale` times as many pixels along each axis.
    #[must_use]
    pub fn rescaled(&self, scale: f64) -> Self {
        Self {
            wavefront: self.wavefront.rescaled(scale),
            blur_variance_px2: self.blur_variance_px2 * scale * scale,
            wave_px: self.wave_px * scale,
            sensor: self.sensor.rescaled(scale),
            ..self.clone()
        }
    }

    /// Returns the pupil on a grid with `factor` times as many pixels along x, which stretches the PSF by `factor`.
    #[must_use]
    pub fn stretched_x(&self, factor: f64) -> Self {
        Self {
            blur_ratio: self.blur_ratio * factor * factor,
            squeeze: [self.squeeze[0] * factor, self.squeeze[1]],
            sensor: self.sensor.stretched_x(factor),
            ..self.clone()
        }
    }

    /// Returns the variances of the symmetric blur along x and y, px².
    pub fn blur_variances_px2(&self) -> [f64; 2] {
        [
            self.blur_variance_px2 * self.blur_ratio,
            self.blur_variance_px2,
        ]
    }

    /// Returns the pupil with `variance_px2` added to the symmetric blur along both axes.
    #[must_use]
    pub fn blurred_by(&self, variance_px2: f64) -> Self {
        let [along_x, along_y] = self.blur_variances_px2().map(|v| v + variance_px2);
        Self {
            blur_variance_px2: along_y,
            blur_ratio: if self.blur_ratio != 1.0 && along_y > 0.0 {
                along_x / along_y
            } else {
                self.blur_ratio
            },
            ..self.clone()
        }
    }

    /// Returns the same lens with an iris `ratio` times as wide; stops outside the iris keep their place and size.
    #[must_use]
    pub fn with_pupil(&self, ratio: f64) -> Self {
        let scaled = |stop: &Stop| Stop {
            centre: stop.centre.map(|c| c / ratio),
            radius: stop.radius / ratio,
        };
        let mut changed = Self {
            obstruction: self.obstruction.as_ref().map(scaled),
            transmission: Transmission {
                square: self.transmission.square * ratio.powi(2),
                fourth: self.transmission.fourth * ratio.powi(4),
                centre: self.transmission.centre.map(|c| c / ratio),
                picture: self.transmission.picture.clone().map(|mask| PictureMask {
                    scale: mask.scale * ratio,
                    ..mask
                }),
            },
            squeeze: self.squeeze,
            blur_ratio: self.blur_ratio,
            wave_px: self.wave_px / ratio,
            sensor: self.sensor,
            ..Self::circular(self.wavefront.with_pupil(ratio), self.blur_variance_px2)
        };
        changed.stops = self.stops;
        changed.stop_count = self.iris_stop_count;
        changed.iris_stop_count = self.iris_stop_count;
        let outside = &self.stops()[self.iris_stop_count..];
        for stop in outside.iter().chain(&self.outer[..self.outer_count]) {
            changed.clip(scaled(stop));
        }
        changed
    }

    /// Returns whether diffraction is drawn; fringes too fine for a pixel are drawn by rays.
    pub fn diffracts(&self) -> bool {
        self.wave_px >= LEAST_WAVE_PX
    }

    /// Returns whether light passes at pupil point `u`.
    pub fn passes(&self, u: [f64; 2]) -> bool {
        let in_shadow = self.obstruction.is_some_and(|disc| disc.depth(u) > 0.0);
        !in_shadow && self.depth(u) >= 0.0
    }

    /// Returns the distance of `u` from the nearest edge of a stop, positive inside all stops.
    fn depth(&self, u: [f64; 2]) -> f64 {
        let depths = self.stops().iter().map(|stop| stop.depth(u));
        depths.fold(f64::INFINITY, f64::min)
    }

    /// Returns centre and radius of (nearly) the largest circle inside the pupil, in pupil radii.
    ///
    /// A negative radius means that the stops pass no light.
    pub fn inscribed_circle(&self) -> ([f64; 2], f64) {
        self.circle_within_stops(200, 0.95)
    }

    /// Searches a large circle inside the pupil in so many `steps`, each shorter than the last by the factor `shrink`.
    fn circle_within_stops(&self, steps: usize, shrink: f64) -> ([f64; 2], f64) {
        let centre = [0.0, 0.0];
        if self.stop_count == 1 {
            return (centre, self.depth(centre));
        }
        let mut best = (centre, f64::NEG_INFINITY);
        // Moves away from the nearest edge by decreasing steps; the depth is concave.
        let mut at = centre;
        let mut step: f64 = 0.5;
        for _ in 0..=steps {
            // One square root a stop: `hypot` took a third of the time of a render with an iris of many blades.
            let (mut depth, mut inwards, mut far) = (f64::INFINITY, [0.0; 2], 0.0);
            for stop in self.stops() {
                let to_centre = [stop.centre[0] - at[0], stop.centre[1] - at[1]];
                let distance = (to_centre[0] * to_centre[0] + to_centre[1] * to_centre[1]).sqrt();
                if stop.radius - distance < depth {
                    (depth, inwards, far) = (stop.radius - distance, to_centre, distance);
                }
            }
            if depth > best.1 {
                best = (at, depth);
            }
            if far < 1e-12 {
                break;
            }
            let stride = step.min(far);
            at = [0, 1].map(|axis| at[axis] + stride * inwards[axis] / far);
            step *= shrink;
        }
        best
    }

    /// Returns the distance from the inner point `from` to the edge in direction (`cos`, `sin`), and the index of the
    /// stop there.
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

    /// Returns the landing point of the ray through pupil point `u`, relative to the chief ray, px.
    #[inline]
    pub fn landing(&self, u: [f64; 2]) -> [f64; 2] {
        let [x, y] = self.wavefront.slope(u);
        [self.squeeze[0] * x, self.squeeze[1] * y]
    }

    /// Returns the centroid of the light relative to the chief ray, px.
    pub fn centroid(&self) -> [f64; 2] {
        if self.is_round_and_even() {
            let [x, y] = self.wavefront.mean_slope();
            [self.squeeze[0] * x, self.squeeze[1] * y]
        } else {
            self.moments().1
        }
    }

    /// Returns the mean slope of each of `wavefronts` over the light of this pupil, times the squeeze: the derivative of
    /// the centroid if such a wavefront is added, px.
    pub fn mean_slopes(&self, wavefronts: &[&Wavefront]) -> Vec<[f64; 2]> {
        let squeezed = |[x, y]: [f64; 2]| [self.squeeze[0] * x, self.squeeze[1] * y];
        if self.is_round_and_even() {
            let means = wavefronts.iter().map(|w| squeezed(w.mean_slope()));
            return means.collect();
        }
        let degree = wavefronts.iter().map(|w| w.degree()).fold(1, usize::max);
        let mut means = [0.0; TERMS];
        let mut total = 0.0;
        for (light, u) in self.fan().rays(&self.transmission) {
            total += light;
            // The light times u_x^i u_y^j, degree by degree.
            let mut monomials = [light; DEGREE];
            let mut at = 0;
            for below in 0..degree {
                for (mean, monomial) in means[at..].iter_mut().zip(&monomials[..=below]) {
                    *mean += monomial;
                }
                at += below + 1;
                if below + 1 < degree {
                    monomials[below + 1] = monomials[below] * u[1];
                    for monomial in &mut monomials[..=below] {
                        *monomial *= u[0];
                    }
                }
            }
        }
        let mean = |i: usize, j: usize| means[(i + j) * (i + j + 1) / 2 + j] / total;
        let slopes = wavefronts.iter().map(|wavefront| {
            let mut sum = [0.0; 2];
            for ((i, j), c) in powers().zip(wavefront.coefficients()) {
                if i + j > wavefront.degree() {
                    break;
                }
                if i > 0 {
                    sum[0] += c * i as f64 * mean(i - 1, j);
                }
                if j > 0 {
                    sum[1] += c * j as f64 * mean(i, j - 1);
                }
            }
            squeezed(sum)
        });
        slopes.collect()
    }

    fn is_round_and_even(&self) -> bool {
        self.stops() == [Stop::RIM] && self.transmission.is_uniform() && self.obstruction.is_none()
    }
}

/// Smallest [`LocalPupil::wave_px`] at which diffraction is drawn: that of an f/1.2 lens on common pixels.
///
/// Below it, diffraction and rays differ by at most half a per cent of the energy, without any other blur.
const LEAST_WAVE_PX: f64 = 0.2;

/// Radius of the pinhole, in pupil radii, that is drawn if the stops pass no light: a PSF always has light.
pub const PINHOLE_RADIUS: f64 = 0.02;

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
    fn edges_of_a_clipped_pupil_are_found_from_its_inscribed_circle() {
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
    fn stops_that_pass_no_light_have_a_negative_radius() {
        let mut pupil = LocalPupil::circular(Wavefront::default(), 0.0);
        pupil.clip(Stop {
            centre: [3.0, 0.0],
            radius: 1.0,
        });
        assert!(pupil.inscribed_circle().1 < 0.0);
        assert!(pupil.moments().0.trace().is_finite());
    }
}
