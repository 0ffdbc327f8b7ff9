//! Where a plate is clipped: its samples say only that there was at least as much light.

/// How a plane's clipped samples are found.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Saturation {
    /// Told from the plane: its brightest samples are clipped if many more of them lie closer together than its noise
    /// would leave them than lie below. Planes without noise are taken to be rendered, and not clipped.
    #[default]
    Told,
    /// Samples of this and more are clipped.
    From(f64),
    /// None are.
    Never,
}

/// Samples within this many standard deviations of the noise of the brightest could be clipped with it, but within no more
/// than this share of it.
const BAND_OF_NOISE: f64 = 0.5;
const MOST_BAND: f64 = 0.001;
/// Noise that is less than this share of the brightest sample is none.
const LEAST_NOISE: f64 = 1e-5;
/// As many bands below it are looked at.
const BANDS_BELOW: usize = 20;
/// Clipped samples are at least so many, and at least so many times what such bands below hold on average.
const LEAST_COUNT: usize = 9;
const LEAST_EXCESS: f64 = 4.0;

impl Saturation {
    /// The level from which on samples of `plane` are clipped, if any are; `noise` is its standard deviation.
    pub(super) fn level(self, plane: &[f32], noise: f64) -> Option<f32> {
        match self {
            Self::Never => None,
            Self::From(level) => Some(level as f32),
            Self::Told => told(plane, noise),
        }
    }
}

fn told(plane: &[f32], noise: f64) -> Option<f32> {
    let peak = f64::from(plane.iter().fold(0.0_f32, |most, v| most.max(*v)));
    if peak <= 0.0 || noise < LEAST_NOISE * peak {
        return None;
    }
    let share = (BAND_OF_NOISE * noise / peak).min(MOST_BAND);
    let mut counts = [0_usize; BANDS_BELOW + 1];
    for sample in plane {
        let band = ((1.0 - f64::from(*sample) / peak) / share) as usize;
        if let Some(count) = counts.get_mut(band) {
            *count += 1;
        }
    }
    let below = counts[1..].iter().sum::<usize>() as f64 / BANDS_BELOW as f64;
    let clipped = counts[0] >= LEAST_COUNT && counts[0] as f64 >= LEAST_EXCESS * below.max(1.0);
    clipped.then_some((peak * (1.0 - share)) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::remove::test_scenes::Deviates;

    /// Smooth lights of several sizes on an even ground.
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
        let mut chance = Deviates(4);
        let noisy = plane.iter().map(|v| v + (noise * chance.next()) as f32);
        noisy.collect()
    }

    #[test]
    fn a_plateau_is_told_from_a_round_top() {
        let noise = 0.004;
        let whole = noisy(&lights(), noise);
        assert_eq!(Saturation::Told.level(&whole, noise), None);
        let clipped: Vec<f32> = whole.iter().map(|v| v.min(1.2)).collect();
        let level = Saturation::Told.level(&clipped, noise).expect("a plateau");
        assert!((1.19..1.2).contains(&level), "{level}");
    }

    #[test]
    fn even_light_is_not_clipped() {
        let even: Vec<f32> = lights()
            .iter()
            .map(|v| if *v > 1.0 { 1.0 } else { 0.2 })
            .collect();
        assert_eq!(Saturation::Told.level(&noisy(&even, 0.004), 0.004), None);
        assert_eq!(Saturation::Told.level(&even, 0.0), None);
    }

    #[test]
    fn what_has_no_light_is_not_clipped() {
        assert_eq!(Saturation::Told.level(&[], 0.1), None);
        assert_eq!(Saturation::Told.level(&[0.0; 40], 0.1), None);
        assert_eq!(Saturation::Told.level(&[-1.0; 40], 0.1), None);
    }

    #[test]
    fn a_level_can_be_given() {
        assert_eq!(Saturation::From(0.5).level(&[0.1, 0.9], 0.0), Some(0.5));
        assert_eq!(Saturation::Never.level(&[1.0; 40], 0.1), None);
    }
}
