//! Recovery of synthetic lenses, from exact moments and from noisy ones with outliers.

use super::*;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::field::{FieldPoint, ImagePoint};
use seidel_optics::moments::{CentralMoments, FourthMoments};
use seidel_optics::numeric::SplitMix64;

fn frame() -> Frame {
    Frame::new(2000, 1200, None).expect("valid")
}

fn between(random: &mut SplitMix64, low: f64, high: f64) -> f64 {
    low + (high - low) * random.unit()
}

fn normal(random: &mut SplitMix64) -> f64 {
    let radius = (-2.0 * (1.0 - random.unit()).ln()).sqrt();
    radius * (std::f64::consts::TAU * random.unit()).cos()
}

/// A lens that is in focus near the middle of the range of distances.
fn lens(random: &mut SplitMix64, distances: &[ObjectDistance]) -> InitialEstimate {
    let sign = |random: &mut SplitMix64| if random.unit() < 0.5 { -1.0 } else { 1.0 };
    let alpha = if distances.len() > 1 {
        let slope = between(random, 20.0, 60.0);
        [-slope * between(random, -0.1, 0.6), slope]
    } else {
        [sign(random) * between(random, 2.0, 15.0), 0.0]
    };
    let bend = sign(random);
    InitialEstimate {
        alpha,
        beta: sign(random) * between(random, 0.5, 5.0),
        gamma: sign(random) * between(random, 0.2, 3.0),
        delta: if distances.len() > 1 { bend } else { 1.0 } * between(random, 0.2, 3.0),
        phi: sign(random) * between(random, 0.1, 2.0),
        misfit: 0.0,
    }
}

/// Exact moments at 40 places per distance.
fn tiles(
    random: &mut SplitMix64,
    lens: &InitialEstimate,
    distances: &[ObjectDistance],
) -> Vec<MeasuredTile> {
    let mut all = Vec::new();
    for &distance in distances {
        let numbers = lens.reduced(distance.vergence_per_m().unwrap_or(0.0));
        for observation in 0..40 {
            let at = FieldPoint::new(between(random, -1.0, 1.0), between(random, -0.6, 0.6));
            all.push(MeasuredTile {
                set: 0,
                observation,
                file: String::new(),
                channel: 0,
                distance,
                centroid: ImagePoint::new(0.0, 0.0),
                ideal: Some(frame().image_point(at)),
                origin: Some(frame().image_point(at)),
                is_registered: false,
                is_mosaic: false,
                optical: numbers.coefficients().moments(at),
                fourth: numbers.fourth_coefficients().moments(at),
                noise: [0.0; 7],
            });
        }
    }
    all
}

/// Adds noise of `share` times size^order to every moment; every 20th tile is an outlier.
fn add_noise_and_outliers(random: &mut SplitMix64, tiles: &mut [MeasuredTile], share: f64) {
    for (index, tile) in tiles.iter_mut().enumerate() {
        let size = tile.optical.trace().sqrt();
        let share = if index % 20 == 7 { 0.7 } else { share };
        let mut add = |value: f64, order: i32| value + share * size.powi(order) * normal(random);
        let [a, b, c, d, e, f, g] = tile.optical.to_array();
        tile.optical = CentralMoments::from_array([
            add(a, 2),
            add(b, 2),
            add(c, 2),
            add(d, 3),
            add(e, 3),
            add(f, 3),
            add(g, 3),
        ]);
        tile.fourth = FourthMoments::from_array(tile.fourth.to_array().map(|m| add(m, 4)));
    }
}

fn distances(count: usize) -> Vec<ObjectDistance> {
    [
        ObjectDistance::Metres(2.0),
        ObjectDistance::Infinity,
        ObjectDistance::Metres(7.0),
        ObjectDistance::Metres(3.0),
    ][..count]
        .to_vec()
}

/// Largest difference relative to the largest number.
fn difference(got: &InitialEstimate, want: &InitialEstimate) -> f64 {
    let of = |s: &InitialEstimate| [s.alpha[0], s.alpha[1], s.beta, s.gamma, s.delta, s.phi];
    let scale = of(want).iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let far = of(got)
        .into_iter()
        .zip(of(want))
        .map(|(g, w)| (g - w).abs());
    far.fold(0.0, f64::max) / scale
}

fn found(tiles: &[MeasuredTile], most: usize) -> Vec<InitialEstimate> {
    let all: Vec<&MeasuredTile> = tiles.iter().collect();
    initial_estimates(&frame(), &all, most)
}

fn assert_planted(count: usize, seeds: std::ops::Range<u64>, noise: f64, tolerance: f64) {
    let distances = distances(count);
    for seed in seeds {
        let mut random = SplitMix64::new(seed);
        let lens = lens(&mut random, &distances);
        let mut tiles = tiles(&mut random, &lens, &distances);
        if noise > 0.0 {
            add_noise_and_outliers(&mut random, &mut tiles, noise);
        }
        let found = found(&tiles, 3);
        assert!(!found.is_empty() && found.len() <= 3);
        assert!(found.windows(2).all(|w| w[0].misfit <= w[1].misfit));
        let nearest = found.iter().map(|s| difference(s, &lens));
        let nearest = nearest.fold(f64::INFINITY, f64::min);
        assert!(
            nearest < tolerance,
            "seed {seed}: {nearest}, {found:#?} for {lens:?}"
        );
    }
}

#[test]
fn exact_moments_at_one_distance_give_the_lens() {
    assert_planted(1, 0..12, 0.0, 1e-6);
}

#[test]
fn exact_moments_at_four_distances_give_the_lens() {
    assert_planted(4, 0..12, 0.0, 1e-6);
}

#[test]
fn noise_and_outliers_leave_the_lens_close() {
    // At one distance noise can trade alpha against beta by more, even from the true solution. These lenses
    // are not of that kind.
    assert_planted(1, 100..108, 0.02, 0.05);
    assert_planted(4, 100..108, 0.02, 0.05);
}

#[test]
fn without_coma_both_signs_of_beta_are_returned() {
    let distances = distances(1);
    let mut random = SplitMix64::new(5);
    let lens = InitialEstimate {
        phi: 0.0,
        ..lens(&mut random, &distances)
    };
    let tiles = tiles(&mut random, &lens, &distances);
    for most in [2, 6] {
        let found = found(&tiles, most);
        assert!(difference(&found[0], &lens) < 1e-6, "{found:?}");
        let other = InitialEstimate {
            alpha: [lens.alpha[0] + 4.0 / 3.0 * lens.beta, 0.0],
            beta: -lens.beta,
            ..lens
        };
        assert!(
            found.iter().any(|s| difference(s, &other) < 0.1),
            "{found:?} {lens:?}"
        );
    }
}

#[test]
fn degenerate_sets_give_finite_estimates() {
    assert!(initial_estimates(&frame(), &[], 3).is_empty());
    let mut random = SplitMix64::new(9);
    let distances = [ObjectDistance::Unknown];
    let lens = lens(&mut random, &distances);
    let mut tiles = tiles(&mut random, &lens, &distances);
    let found_all = found(&tiles, 3);
    assert!(difference(&found_all[0], &lens) < 1e-6 && found_all[0].alpha[1] == 0.0);
    tiles[3].optical.mu20 = f64::NAN;
    assert!(difference(&found(&tiles, 3)[0], &lens) < 1e-6);
    assert!(found(&tiles, 0).is_empty());
    // One tile does not determine the lens; estimates must still be finite.
    for start in found(&tiles[..1], 3) {
        assert!(start.misfit.is_finite() && start.alpha[0].is_finite());
    }
}
