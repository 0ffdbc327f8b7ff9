//! Where a plate is clipped: its samples say only that there was at least as much light.

/// How a plane's clipped samples are found.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Saturation {
    /// Told from the plane: its brightest samples are clipped if many more of them lie close together than below.
    #[default]
    Told,
    /// Samples of this and more are clipped.
    From(f64),
    /// None are.
    Never,
}

/// Samples within this share of the brightest could be clipped with it.
const BAND: f64 = 0.001;
/// As many bands below it are looked at.
const BANDS_BELOW: usize = 20;
/// Clipped samples are at least so many, and at least so many times what such bands below hold on average.
const LEAST_COUNT: usize = 9;
const LEAST_EXCESS: f64 = 4.0;

impl Saturation {
    /// The level from which on samples of `plane` are clipped, if any are.
    pub(super) fn level(self, plane: &[f32]) -> Option<f32> {
        match self {
            Self::Never => None,
            Self::From(level) => Some(level as f32),
            Self::Told => told(plane),
        }
    }
}

fn told(plane: &[f32]) -> Option<f32> {
    let peak = f64::from(plane.iter().fold(0.0_f32, |most, v| most.max(*v)));
    if peak <= 0.0 {
        return None;
    }
    let mut counts = [0_usize; BANDS_BELOW + 1];
    for sample in plane {
        let band = ((1.0 - f64::from(*sample) / peak) / BAND) as usize;
        if let Some(count) = counts.get_mut(band) {
            *count += 1;
        }
    }
    let below = counts[1..].iter().sum::<usize>() as f64 / BANDS_BELOW as f64;
    let clipped = counts[0] >= LEAST_COUNT && counts[0] as f64 >= LEAST_EXCESS * below.max(1.0);
    clipped.then_some((peak * (1.0 - BAND)) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn a_plateau_is_told_from_a_round_top() {
        let whole = lights();
        assert_eq!(Saturation::Told.level(&whole), None);
        let clipped: Vec<f32> = whole.iter().map(|v| v.min(1.2)).collect();
        let level = Saturation::Told.level(&clipped).expect("a plateau");
        assert!((1.19..1.2).contains(&level), "{level}");
    }

    #[test]
    fn what_has_no_light_is_not_clipped() {
        assert_eq!(Saturation::Told.level(&[]), None);
        assert_eq!(Saturation::Told.level(&[0.0; 40]), None);
        assert_eq!(Saturation::Told.level(&[-1.0; 40]), None);
    }

    #[test]
    fn a_level_can_be_given() {
        assert_eq!(Saturation::From(0.5).level(&[0.1, 0.9]), Some(0.5));
        assert_eq!(Saturation::Never.level(&[1.0; 40]), None);
    }
}
