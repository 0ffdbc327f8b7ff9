//! The mirrored pair: the mean of two skew-normal densities mirrored in the meridian.
//!
//! It represents mu12, which a single skew-normal cannot without breaking the mirror symmetry
//! (docs/background/model.md section 7).

use super::skew_normal_density::{PHI, SKEW_CAP, T_MAX};
use super::{LocalBlur, Mixture, MomentPsf, SkewNormalDensity};
use crate::field::Meridian;

/// The mean of two skew-normal densities with the skew vectors (s1, s2) and (s1, -s2) in the meridional frame.
///
/// It matches all seven moments if mu12 / mu30 is not negative and the skew is admissible. Otherwise mu30 comes
/// first: s1 is clamped to the admissible range, and s2² = mu12 / (PHI s1) to what then keeps the pair admissible.
/// So mu30 is exact wherever a skew-normal can have it, and mu12 as close as that allows.
#[derive(Debug, Clone, Copy)]
pub struct MirroredPair;

impl MomentPsf for MirroredPair {
    const ID: &'static str = "mirrored-pair";

    fn mixture(&self, blur: &LocalBlur) -> Mixture {
        let m = blur.moments.meridional(blur.meridian);
        let largest = SKEW_CAP * SKEW_CAP * T_MAX;
        let longest = (largest * m.mu20).sqrt();
        let along = (m.mu30 / PHI).cbrt().clamp(-longest, longest);
        // Uses the clamped s1: where clamping changed it, `room` is zero.
        let free = if along == 0.0 {
            0.0
        } else {
            m.mu12 / (PHI * along)
        };
        let room = ((largest - along * along / m.mu20) * m.mu02).max(0.0);
        let across = free.clamp(0.0, room).sqrt();
        let Meridian { cos, sin } = blur.meridian;
        let covariance = m.covariance(blur.meridian);
        let half = |t: f64| {
            SkewNormalDensity::new(covariance, [along * cos - t * sin, along * sin + t * cos])
        };
        if across == 0.0 {
            Mixture::One(half(0.0))
        } else {
            Mixture::Two([half(across), half(-across)])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::moments::CentralMoments;
    use crate::psf::{PsfModel, SampleGrid};

    /// mu20, mu02, mu30 and mu12 of the pair drawn for them, by sums over a fine grid.
    fn drawn(mu20: f64, mu02: f64, mu30: f64, mu12: f64) -> [f64; 4] {
        let blur = LocalBlur::from_moments(
            CentralMoments::from_array([mu20, 0.0, mu02, mu30, 0.0, mu12, 0.0]),
            Meridian::X,
        );
        let window = SampleGrid::for_tile(101, 101, 50.3, 50.8);
        let mut samples = vec![0.0; window.len()];
        MirroredPair.sample(&blur, &window, &mut samples);
        let mut sums = [0.0; 5];
        for (k, v) in samples.iter().enumerate() {
            let x = window.first_x_px + (k % 101) as f64;
            let y = window.first_y_px + (k / 101) as f64;
            for (sum, power) in sums
                .iter_mut()
                .zip([1.0, x * x, y * y, x * x * x, x * y * y])
            {
                *sum += v * power;
            }
        }
        [1, 2, 3, 4].map(|k| sums[k] / sums[0])
    }

    fn near(got: [f64; 4], want: [f64; 4]) {
        for (g, w) in got.iter().zip(want) {
            assert!((g - w).abs() < 0.02, "{got:?} {want:?}");
        }
    }

    #[test]
    fn admissible_moments_are_drawn_as_they_are() {
        near(drawn(16.0, 12.0, -20.0, -9.0), [16.0, 12.0, -20.0, -9.0]);
    }

    #[test]
    fn mu12_of_the_wrong_sign_is_dropped() {
        near(drawn(16.0, 12.0, 20.0, -9.0), [16.0, 12.0, 20.0, 0.0]);
    }

    #[test]
    fn mu12_gives_way_to_mu30() {
        let [_, _, mu30, mu12] = drawn(16.0, 12.0, 20.0, 60.0);
        assert!((mu30 - 20.0).abs() < 0.1, "{mu30}");
        let s1 = (20.0 / PHI).cbrt();
        let most = PHI * s1 * (SKEW_CAP * SKEW_CAP * T_MAX - s1 * s1 / 16.0) * 12.0;
        assert!(mu12 < 60.0 && (mu12 - most).abs() < 0.1, "{mu12} {most}");
        // More mu30 than a skew-normal can have: all of it, and no mu12.
        let [_, _, mu30, mu12] = drawn(16.0, 12.0, 100.0, 9.0);
        assert!(
            (mu30 / 64.0 - 0.995).abs() < 0.02 && mu12.abs() < 0.02,
            "{mu30} {mu12}"
        );
    }
}
