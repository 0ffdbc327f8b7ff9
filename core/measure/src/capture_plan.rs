//! Capture plans: distances, sizes and exposures for a lens.
//!
//! The formulas and their sources are in `docs/background/measure-chart.md`.

use seidel_optics::error::{Error, Result};

/// The camera, and the range of distances that the lens is needed for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CapturedLens {
    /// Focal length, mm.
    pub focal_mm: f64,
    /// f-number.
    pub f_number: f64,
    /// Focus distance, m; infinite for infinity.
    pub focus_m: f64,
    /// Pixel pitch, µm.
    pub pitch_um: f64,
    /// Width and height of the sensor, mm.
    pub sensor_mm: [f64; 2],
    /// Nearest distance needed, m; chosen from the largest blur if `None`.
    pub near_m: Option<f64>,
    /// Farthest distance that can be photographed, m; infinite for stars or lights far away.
    pub far_m: f64,
    /// Number of distances.
    pub count: usize,
}

/// One distance to photograph.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlannedDistance {
    /// Distance from the entrance pupil, m; infinite for infinity.
    pub distance_m: f64,
    /// Diameter of the geometric circle of confusion, px.
    pub blur_px: f64,
    /// Largest diameter of a light, mm; `None` at infinity, where its angle counts.
    pub largest_light_mm: Option<f64>,
    /// Largest angle of a light, seconds of arc.
    pub largest_light_arcsec: f64,
    /// Width and height of a chart that fills the frame, m; `None` at infinity.
    pub chart_m: Option<[f64; 2]>,
    /// Least distance between lights, px.
    pub light_step_px: f64,
}

/// A capture plan.
#[derive(Debug, Clone, PartialEq)]
pub struct CapturePlan {
    /// Distances, from the farthest, even in vergence.
    pub distances: Vec<PlannedDistance>,
    /// Diameter of the Airy disc to its first zero at 550 nm, px.
    pub airy_px: f64,
    /// Places of the frame to measure at every distance, at least.
    pub least_places: usize,
    /// Places that bring the errors of a lens down to those of its model.
    pub good_places: usize,
}

/// Variance that a light's own size may add, as a share of the variance of the blur.
const LIGHT_VARIANCE_SHARE: f64 = 0.01;
/// The same for PSFs in focus, px²: 1 % of a third-order lens that is sharp to 1.5 pixels.
const LEAST_LIGHT_VARIANCE_PX2: f64 = 0.02;
/// Blur at the nearest distance where none is given, px, over the sharpest that is still needed.
const LARGEST_BLUR_PX: f64 = 30.0;
/// Fewest and most distances.
const COUNT_RANGE: std::ops::RangeInclusive<usize> = 1..=12;
/// Places of the frame: a 6 x 4 grid, and a 9 x 6 grid.
const LEAST_PLACES: usize = 24;
const GOOD_PLACES: usize = 54;
/// Wavelength of the Airy disc, µm, and its diameter to the first zero in wavelengths times the f-number.
const WAVELENGTH_UM: f64 = 0.55;
const AIRY_DIAMETER: f64 = 2.44;
/// Distance between lights over the diameter of their blur, and its least value, px.
const LIGHT_STEP: f64 = 5.0;
const LEAST_LIGHT_STEP_PX: f64 = 24.0;
const ARCSEC_PER_RADIAN: f64 = 206_264.806;

/// Returns the largest diameter of a light in the image, px, for a blur of diameter `blur_px`.
///
/// A disc of diameter d has a variance of d²/16 along each axis. It may add `LIGHT_VARIANCE_SHARE` of the variance of the
/// blur, which is a disc too.
pub fn largest_light_px(blur_px: f64) -> f64 {
    let variance = (LIGHT_VARIANCE_SHARE * blur_px * blur_px / 16.0).max(LEAST_LIGHT_VARIANCE_PX2);
    4.0 * variance.sqrt()
}

impl CapturedLens {
    /// Returns the diameter of the circle of confusion of a point at vergence `per_m`, px.
    ///
    /// For a thin lens of focal length f and aperture f/N focused at s, it is f² / (N (1 - f/s)) |1/z - 1/s|: linear in the
    /// vergence 1/z.
    pub fn blur_px(&self, per_m: f64) -> f64 {
        self.blur_per_vergence() * (per_m - 1.0 / self.focus_m).abs()
    }

    fn blur_per_vergence(&self) -> f64 {
        let f = self.focal_mm / 1000.0;
        f * f / (self.f_number * (1.0 - f / self.focus_m)) / (self.pitch_um * 1e-6)
    }

    /// Plans the photographs.
    ///
    /// # Errors
    /// Values out of range, and a focus within the focal length.
    pub fn plan(&self) -> Result<CapturePlan> {
        self.check()?;
        let far = 1.0 / self.far_m;
        let focus = 1.0 / self.focus_m;
        let near = match self.near_m {
            Some(near_m) => 1.0 / near_m,
            None => {
                // As much blur in front of the focus as behind it, within limits.
                let blur = self.blur_px(far).clamp(8.0, LARGEST_BLUR_PX);
                let nearest = 1000.0 / (4.0 * self.focal_mm);
                (focus + blur / self.blur_per_vergence()).min(nearest)
            }
        };
        if near <= far && self.count > 1 {
            return Err(Error::new(
                "near_m",
                "is not nearer than the farthest distance",
                "give a nearest distance below the farthest",
            ));
        }
        let step = (near - far) / (self.count.max(2) - 1) as f64;
        let distances = (0..self.count).map(|k| {
            let single = self.count == 1;
            self.distance(if single { focus } else { far + k as f64 * step })
        });
        Ok(CapturePlan {
            distances: distances.collect(),
            airy_px: AIRY_DIAMETER * WAVELENGTH_UM * self.f_number / self.pitch_um,
            least_places: LEAST_PLACES,
            good_places: GOOD_PLACES,
        })
    }

    fn distance(&self, per_m: f64) -> PlannedDistance {
        let blur_px = self.blur_px(per_m);
        let light_px = largest_light_px(blur_px);
        let (f, pitch_mm) = (self.focal_mm, self.pitch_um / 1000.0);
        let distance_m = 1.0 / per_m;
        // Length at the object over length on the sensor.
        let scale = distance_m
            .is_finite()
            .then(|| (1000.0 * distance_m - f) / f);
        PlannedDistance {
            distance_m,
            blur_px,
            largest_light_mm: scale.map(|s| light_px * pitch_mm * s),
            largest_light_arcsec: light_px * pitch_mm / f * ARCSEC_PER_RADIAN,
            chart_m: scale.map(|s| self.sensor_mm.map(|v| v * s / 1000.0)),
            light_step_px: (LIGHT_STEP * blur_px).max(LEAST_LIGHT_STEP_PX),
        }
    }

    fn check(&self) -> Result<()> {
        let near = self.near_m.unwrap_or(1.0);
        let values = [
            ("focal_mm", self.focal_mm),
            ("f_number", self.f_number),
            ("pitch_um", self.pitch_um),
            ("sensor_mm", self.sensor_mm[0].min(self.sensor_mm[1])),
            ("near_m", near),
        ];
        for (name, value) in values {
            if !(value.is_finite() && value > 0.0) {
                return Err(Error::new(
                    name,
                    "is not positive",
                    "give a positive number",
                ));
            }
        }
        // Not finite means infinity.
        let nearest = 2.0 * self.focal_mm / 1000.0;
        for (name, value) in [("focus_m", self.focus_m), ("far_m", self.far_m)] {
            if value.is_nan() || value <= nearest {
                return Err(Error::new(
                    name,
                    format!("is within twice the focal length, {nearest} m"),
                    "give a distance in metres from the entrance pupil, or inf",
                ));
            }
        }
        if self.near_m.is_some() && near <= nearest {
            return Err(Error::new(
                "near_m",
                format!("is within twice the focal length, {nearest} m"),
                "give a distance in metres from the entrance pupil",
            ));
        }
        if !COUNT_RANGE.contains(&self.count) {
            return Err(Error::new("count", "is out of range", "give 1 to 12"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENS: CapturedLens = CapturedLens {
        focal_mm: 50.0,
        f_number: 2.0,
        focus_m: 3.0,
        pitch_um: 4.0,
        sensor_mm: [36.0, 24.0],
        near_m: None,
        far_m: f64::INFINITY,
        count: 5,
    };

    #[test]
    fn the_blur_is_that_of_a_thin_lens() {
        // By similar triangles: aperture 25 mm, image distances of 3 m and 2 m.
        let image = |z: f64| 50.0 * z / (z - 50.0);
        let want = 25.0 * (image(2000.0) - image(3000.0)).abs() / image(2000.0) / 0.004;
        let got = LENS.blur_px(0.5);
        assert!((got - want).abs() < 1e-9 * want, "{got} {want}");
    }

    #[test]
    fn distances_are_even_in_vergence() {
        let plan = LENS.plan().expect("a plan");
        assert_eq!(plan.distances.len(), 5);
        let vergences: Vec<f64> = plan.distances.iter().map(|d| 1.0 / d.distance_m).collect();
        assert_eq!(vergences[0], 0.0);
        let steps: Vec<f64> = vergences.windows(2).map(|w| w[1] - w[0]).collect();
        for step in &steps {
            assert!((step - steps[0]).abs() < 1e-12 && *step > 0.0);
        }
        assert!(plan.distances[0].chart_m.is_none());
        let near = LENS.with_near(1.0).plan().expect("a plan").distances[4];
        let [width, _] = near.chart_m.expect("a size");
        assert!((near.distance_m - 1.0).abs() < 1e-12 && (width - 0.684).abs() < 1e-9);
    }

    #[test]
    fn a_light_adds_a_hundredth_of_the_variance() {
        let blur = 20.0_f64;
        let ratio = largest_light_px(blur).powi(2) / blur.powi(2);
        assert!((ratio - 0.01).abs() < 1e-12);
        assert!((largest_light_px(0.0) - 4.0 * 0.02_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn impossible_values_are_refused() {
        for lens in [
            CapturedLens {
                focus_m: 0.05,
                ..LENS
            },
            CapturedLens {
                f_number: 0.0,
                ..LENS
            },
            CapturedLens { count: 0, ..LENS },
            CapturedLens {
                near_m: Some(5.0),
                far_m: 4.0,
                ..LENS
            },
        ] {
            assert!(lens.plan().is_err(), "{lens:?}");
        }
    }

    impl CapturedLens {
        fn with_near(self, near_m: f64) -> Self {
            Self {
                near_m: Some(near_m),
                ..self
            }
        }
    }
}
