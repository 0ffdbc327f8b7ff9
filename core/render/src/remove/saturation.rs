//! Clipped samples of a plate: lower bounds of the light, not measurements of it.

/// The rule by which a plane's clipped samples are found.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Saturation {
    /// From the histogram: the brightest samples are clipped if many more of them lie within a fraction of the noise than in
    /// bands of that width below. Planes without noise count as rendered, and not as clipped.
    #[default]
    Auto,
    /// Samples at this level and above are clipped.
    Level(f64),
    /// No sample is clipped.
    Never,
}

/// Width of a histogram band, standard deviations of the noise.
const BAND_DEVIATIONS: f64 = 0.5;
/// Largest width of a band, as a share of the brightest sample.
const MAX_BAND_SHARE: f64 = 0.001;
/// Noise below this share of the brightest sample counts as no noise: no camera has so little, and the estimate takes some texture for
/// noise.
const MIN_NOISE_SHARE: f64 = 3e-4;
/// Number of bands below the brightest with which it is compared.
const BANDS_BELOW: usize = 20;
/// Least number of samples in the brightest band of a clipped plane.
const MIN_COUNT: usize = 9;
/// Least ratio of that number to the average of the bands below.
const MIN_EXCESS: f64 = 4.0;

impl Saturation {
    /// Returns the level at and above which samples of `plane` are clipped, if any are; `noise` is its standard deviation.
    pub(super) fn level(self, plane: &[f32], noise: f64) -> Option<f32> {
        match self {
            Self::Never => None,
            Self::Level(level) => Some(level as f32),
            Self::Auto => detect_level(plane, noise),
        }
    }
}

fn detect_level(plane: &[f32], noise: f64) -> Option<f32> {
    let peak = f64::from(plane.iter().fold(0.0_f32, |most, v| most.max(*v)));
    if peak <= 0.0 || noise < MIN_NOISE_SHARE * peak {
        return None;
    }
    let share = (BAND_DEVIATIONS * noise / peak).min(MAX_BAND_SHARE);
    let mut counts = [0_usize; BANDS_BELOW + 1];
    for sample in plane {
        let band = ((1.0 - f64::from(*sample) / peak) / share) as usize;
        if let Some(count) = counts.get_mut(band) {
            *count += 1;
        }
    }
    let below = counts[1..].iter().sum::<usize>() as f64 / BANDS_BELOW as f64;
    let clipped = counts[0] >= MIN_COUNT && counts[0] as f64 >= MIN_EXCESS * below.max(1.0);
    clipped.then_some((peak * (1.0 - share)) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::remove::test_scenes::NormalDeviates;

    /// Two Gaussian lights of different size on a uniform background.
    fn lights() -> Vec<f32> {
        let light = |x: f32, y: f32, size: f32| (-(x * x + y * y) / (2.0 * size * size)).exp();
        (0..160 * 120)
            .map(|k| {
                let (x, y) = ((k % 160) as f32, (k / 160) as f32);
                let far = light(x - 120.3, y - 70.2, 5.0);
                0.1 + 3.0 * light(x - 40.0, y - 50.0, 20.0) + 2.0 * far
            })
            .collect()
    }

    fn noisy(plane: &[f32], noise: f64) -> Vec<f32> {
        let mut deviates = NormalDeviates(4);
        let noisy = plane.iter().map(|v| v + (noise * deviates.next()) as f32);
        noisy.collect()
    }

    #[test]
    fn a_clipped_plateau_is_detected_and_a_round_peak_is_not() {
        let noise = 0.004;
        let whole = noisy(&lights(), noise);
        assert_eq!(Saturation::Auto.level(&whole, noise), None);
        let clipped: Vec<f32> = whole.iter().map(|v| v.min(1.2)).collect();
        let level = Saturation::Auto
            .level(&clipped, noise)
            .expect("a clipped plateau");
        assert!((1.19..1.2).contains(&level), "{level}");
    }

    #[test]
    fn a_uniform_bright_area_is_not_clipped() {
        let even: Vec<f32> = lights()
            .iter()
            .map(|v| if *v > 1.0 { 1.0 } else { 0.2 })
            .collect();
        assert_eq!(Saturation::Auto.level(&noisy(&even, 0.004), 0.004), None);
        assert_eq!(Saturation::Auto.level(&even, 0.0), None);
    }

    #[test]
    fn a_plane_without_light_is_not_clipped() {
        assert_eq!(Saturation::Auto.level(&[], 0.1), None);
        assert_eq!(Saturation::Auto.level(&[0.0; 40], 0.1), None);
        assert_eq!(Saturation::Auto.level(&[-1.0; 40], 0.1), None);
    }

    #[test]
    fn a_given_level_is_used() {
        assert_eq!(Saturation::Level(0.5).level(&[0.1, 0.9], 0.0), Some(0.5));
        assert_eq!(Saturation::Never.level(&[1.0; 40], 0.1), None);
    }
}
