//! The map of pixels that were edited after removal. The residual of their plate, its grain and what the lens does not
//! explain, is no longer valid there.

use rayon::prelude::*;
use seidel_optics::error::{Error, Result};

/// A difference between two samples: a share of the sample plus a multiple of the noise's standard deviation.
struct Difference {
    share: f32,
    deviations: f32,
}

/// Largest difference that counts as unchanged.
const UNCHANGED: Difference = Difference {
    share: 0.01,
    deviations: 1.0,
};
/// Smallest difference that counts as wholly changed.
const CHANGED: Difference = Difference {
    share: 0.1,
    deviations: 3.0,
};

/// Returns the change of each pixel from the planes `before` to the planes `now`, 0 to 1, row-major: the largest over all
/// planes.
///
/// `noise` has the standard deviation of the noise of each plane, in its own units, 0 or more. A difference d counts as
/// 3 t² - 2 t³ with t = (d - a) / (b - a), clamped to 0..1; a is 1 % of the sample before plus one standard deviation, b
/// 10 % plus three.
///
/// # Errors
/// Planes that differ in number or size.
pub fn change_map(now: &[&[f32]], before: &[&[f32]], noise: &[f64]) -> Result<Vec<f32>> {
    let count = now.first().map_or(0, |plane| plane.len());
    let same_size = now.iter().chain(before).all(|plane| plane.len() == count);
    if now.len() != before.len() || now.len() != noise.len() || !same_size {
        return Err(Error::new(
            "planes",
            "of the picture now and before differ in number or size",
            "give the same planes of the same pixels, and one noise each",
        ));
    }
    let mut largest = vec![0.0_f32; count];
    for ((now, before), noise) in now.iter().zip(before).zip(noise) {
        let noise = *noise as f32;
        let pairs = now.par_iter().zip(before.par_iter());
        largest
            .par_iter_mut()
            .zip(pairs)
            .for_each(|(largest, (now, before))| {
                *largest = largest.max(change(*now, *before, noise));
            });
    }
    Ok(largest)
}

/// Returns the change of one sample, 0 to 1.
fn change(now: f32, before: f32, noise: f32) -> f32 {
    let difference = (now - before).abs();
    if difference == 0.0 {
        return 0.0;
    }
    let [from, to] =
        [UNCHANGED, CHANGED].map(|bound| bound.share * before.abs() + bound.deviations * noise);
    if difference >= to || difference.is_nan() {
        return 1.0;
    }
    let t = ((difference - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn change_of(now: f32, before: f32, noise: f64) -> f32 {
        change_map(&[&[now]], &[&[before]], &[noise]).expect("valid planes")[0]
    }

    #[test]
    fn small_differences_are_no_change() {
        for before in [0.0, 1e-6, -0.5, 3.0, 1000.0] {
            assert_eq!(change_of(before, before, 0.0), 0.0);
            // The quantisation of half floats.
            assert_eq!(change_of(before * (1.0 + 1e-3), before, 0.0), 0.0);
        }
        assert_eq!(change_of(0.009, 0.0, 0.01), 0.0);
    }

    #[test]
    fn change_grows_with_the_difference_from_0_to_1() {
        let mut last = 0.0;
        for step in 0..=100 {
            let now = change_of(0.5 + 0.001 * step as f32, 0.5, 0.004);
            assert!((last..=1.0).contains(&now), "{step}: {now}");
            last = now;
        }
        assert_eq!(last, 1.0);
        // Half way between 0.009 and 0.062.
        assert!((change_of(0.5 - 0.0355, 0.5, 0.004) - 0.5).abs() < 1e-3);
        // A share of black is zero: without noise any difference is a change.
        assert_eq!(change_of(1e-6, 0.0, 0.0), 1.0);
        assert_eq!(change_of(f32::NAN, 0.3, 0.0), 1.0);
    }

    #[test]
    fn the_plane_with_the_largest_change_counts() {
        let (first, second) = ([0.5, 0.5, 0.5], [0.2, 0.2, 0.2]);
        let (a, b) = ([0.5, 0.9, 0.5], [0.2, 0.2, 0.0]);
        let got = change_map(&[&a, &b], &[&first, &second], &[0.01; 2]).expect("valid planes");
        assert_eq!(got, [0.0, 1.0, 1.0]);
    }

    #[test]
    fn planes_of_different_number_or_size_are_rejected() {
        let plane: &[f32] = &[0.5; 4];
        for (now, before, noise) in [
            (vec![plane], vec![&plane[1..]], vec![0.0]),
            (vec![plane], vec![plane, plane], vec![0.0]),
            (vec![plane], vec![plane], vec![]),
        ] {
            let error = change_map(&now, &before, &noise).expect_err("invalid planes");
            assert!(error.to_string().contains("number or size"), "{error}");
        }
        assert!(change_map(&[], &[], &[]).expect("no planes").is_empty());
    }
}
