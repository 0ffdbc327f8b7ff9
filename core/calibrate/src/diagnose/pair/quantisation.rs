//! Variance of the rounding of integer samples.

/// Transfer function between stored integers and scene-linear values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StoredCurve {
    /// Integers are proportional to light.
    Linear,
    /// The sRGB transfer function (IEC 61966-2-1).
    Srgb,
}

/// The rounding of samples to integers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantisation {
    /// Difference between neighbouring integers, as a share of full scale: 1/255 for eight bits.
    pub step: f64,
    /// Transfer function of the stored integers.
    pub curve: StoredCurve,
}

impl Quantisation {
    /// Returns the variance that rounding adds to a sample of scene-linear value `light`: a twelfth of the squared
    /// step, times the squared slope of the curve there.
    pub fn variance(&self, light: f64) -> f64 {
        let slope = match self.curve {
            StoredCurve::Linear => 1.0,
            StoredCurve::Srgb if light <= 0.003_130_8 => 1.0 / 12.92,
            // Light is ((code + 0.055) / 1.055)^2.4.
            StoredCurve::Srgb => 2.4 / 1.055 * light.min(1.0).powf(1.4 / 2.4),
        };
        (self.step * slope).powi(2) / 12.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_variance_of_rounded_light_is_predicted() {
        let decode = |code: f64| {
            if code <= 0.04045 {
                code / 12.92
            } else {
                ((code + 0.055) / 1.055).powf(2.4)
            }
        };
        for (curve, about) in [
            (StoredCurve::Linear, 0.02),
            (StoredCurve::Srgb, 0.02),
            (StoredCurve::Srgb, 0.7),
        ] {
            let quantisation = Quantisation {
                step: 1.0 / 255.0,
                curve,
            };
            let light = |code: f64| match curve {
                StoredCurve::Linear => code,
                StoredCurve::Srgb => decode(code),
            };
            // Codes evenly spread around one whose light is `about`.
            let first = (0..255)
                .map(|k| f64::from(k) / 255.0)
                .find(|code| light(*code) >= about)
                .expect("below full scale");
            let errors = (0..20_000).map(|k| {
                let code = first + 8.0 / 255.0 * (f64::from(k) + 0.5) / 20_000.0;
                let rounded = (code * 255.0).round() / 255.0;
                let value = light(code);
                (
                    (light(rounded) - value).powi(2),
                    quantisation.variance(value),
                )
            });
            let (got, want) = errors.fold((0.0, 0.0), |s, e| (s.0 + e.0, s.1 + e.1));
            assert!(
                (got / want - 1.0).abs() < 0.03,
                "{curve:?} {about}: {got} {want}"
            );
        }
    }
}
