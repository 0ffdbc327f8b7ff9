//! Where a sharp picture was worked on: there, what its plate had beside it, grain and what the lens does not explain,
//! no longer holds.

use rayon::prelude::*;
use seidel_optics::error::{Error, Result};

/// A sample has begun to change where it differs by this share of its size and this many standard deviations of the
/// noise, and is another where it differs by these.
const BEGUN: (f32, f32) = (0.01, 1.0);
const DONE: (f32, f32) = (0.1, 3.0);

/// How much each pixel was changed from `before` to `now`, 0 to 1, row-major: the most over all planes. Each plane has
/// the standard deviation of its noise in `noise`, in its own units, 0 or more. A sample that differs by d counts as
/// changed by 3 t^2 - 2 t^3, t = (d - b) / (e - b) held within 0..1, b being 1 % of the size of the sample before and
/// one standard deviation, e 10 % and three.
///
/// # Errors
/// Planes that differ in number or size.
pub fn changed(now: &[&[f32]], before: &[&[f32]], noise: &[f64]) -> Result<Vec<f32>> {
    let count = now.first().map_or(0, |plane| plane.len());
    let same_size = now.iter().chain(before).all(|plane| plane.len() == count);
    if now.len() != before.len() || now.len() != noise.len() || !same_size {
        return Err(Error::new(
            "planes",
            "of the picture now and before differ in number or size",
            "give the same planes of the same pixels, and one noise each",
        ));
    }
    let mut most = vec![0.0_f32; count];
    for ((now, before), noise) in now.iter().zip(before).zip(noise) {
        let noise = *noise as f32;
        let pairs = now.par_iter().zip(before.par_iter());
        most.par_iter_mut().zip(pairs).for_each(|(most, pair)| {
            *most = most.max(share(*pair.0, *pair.1, noise));
        });
    }
    Ok(most)
}

/// By how much one sample was changed.
fn share(now: f32, before: f32, noise: f32) -> f32 {
    let away = (now - before).abs();
    if away == 0.0 {
        return 0.0;
    }
    let [begun, done] = [BEGUN, DONE].map(|(part, times)| part * before.abs() + times * noise);
    if away >= done || away.is_nan() {
        return 1.0;
    }
    let t = ((away - begun) / (done - begun)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(now: f32, before: f32, noise: f64) -> f32 {
        changed(&[&[now]], &[&[before]], &[noise]).expect("sound")[0]
    }

    #[test]
    fn what_is_as_it_was_is_not_changed() {
        for before in [0.0, 1e-6, -0.5, 3.0, 1000.0] {
            assert_eq!(of(before, before, 0.0), 0.0);
            // As far as half floats go.
            assert_eq!(of(before * (1.0 + 1e-3), before, 0.0), 0.0);
        }
        assert_eq!(of(0.009, 0.0, 0.01), 0.0);
    }

    #[test]
    fn changes_grow_from_none_to_all() {
        let mut last = 0.0;
        for step in 0..=100 {
            let now = of(0.5 + 0.001 * step as f32, 0.5, 0.004);
            assert!((last..=1.0).contains(&now), "{step}: {now}");
            last = now;
        }
        assert_eq!(last, 1.0);
        // Half way between 0.009 and 0.062.
        assert!((of(0.5 - 0.0355, 0.5, 0.004) - 0.5).abs() < 1e-3);
        // Black has no size of its own.
        assert_eq!(of(1e-6, 0.0, 0.0), 1.0);
        assert_eq!(of(f32::NAN, 0.3, 0.0), 1.0);
    }

    #[test]
    fn the_plane_that_changed_most_counts() {
        let (first, second) = ([0.5, 0.5, 0.5], [0.2, 0.2, 0.2]);
        let (a, b) = ([0.5, 0.9, 0.5], [0.2, 0.2, 0.0]);
        let got = changed(&[&a, &b], &[&first, &second], &[0.01; 2]).expect("sound");
        assert_eq!(got, [0.0, 1.0, 1.0]);
    }

    #[test]
    fn planes_that_do_not_belong_together_are_refused() {
        let plane: &[f32] = &[0.5; 4];
        for (now, before, noise) in [
            (vec![plane], vec![&plane[1..]], vec![0.0]),
            (vec![plane], vec![plane, plane], vec![0.0]),
            (vec![plane], vec![plane], vec![]),
        ] {
            let error = changed(&now, &before, &noise).expect_err("refused");
            assert!(error.to_string().contains("number or size"), "{error}");
        }
        assert!(changed(&[], &[], &[]).expect("nothing").is_empty());
    }
}
