//! Tiles against closed forms, and properties of cases.

use std::f64::consts::PI;

use super::draw::{GAPS, attempt_at, draw};
use super::expose::{Cause, TileOptions, difference, gap, spot_tiles, tile_of};
use super::lens::{CHANNELS, Lens, LensConstraints, Place};
use super::pencil::Pencil;
use super::perturb::effect;
use super::perturb_sensor::line;
use super::rays::CELLS;
use super::recipe::{EFFECTS, Kind, Recipe, Size, UNKNOWN, recipes};
use super::rng::Rng;

const TILE: usize = 33;
const SMALL: Size = Size {
    design: 2,
    real: 5,
    holdout: 2,
    tile: TILE,
};

/// Returns sum, centroid from the centre of the tile, and central second moments xx, xy, yy.
fn moments(tile: &[f64]) -> (f64, [f64; 2], [f64; 3]) {
    let at = |i: usize| {
        let half = (TILE / 2) as f64;
        ((i % TILE) as f64 - half, (i / TILE) as f64 - half)
    };
    let mean = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
        let sum = |(i, v): (usize, &f64)| v * f(at(i).0, at(i).1);
        tile.iter().enumerate().map(sum).sum()
    };
    let light = mean(&|_, _| 1.0);
    let (x, y) = (mean(&|x, _| x) / light, mean(&|_, y| y) / light);
    let second = [
        mean(&|a, _| (a - x) * (a - x)) / light,
        mean(&|a, b| (a - x) * (b - y)) / light,
        mean(&|_, b| (b - y) * (b - y)) / light,
    ];
    (light, [x, y], second)
}

fn any_lens(seed: u64) -> Lens {
    let constraints = LensConstraints {
        slow: false,
        depth_ratio: 1.1,
    };
    Lens::draw(&mut Rng::new(seed), constraints, TILE)
}

/// Returns an off-axis pencil of a random lens, and a pixel centre near its centroid.
fn any_pencil(seed: u64) -> (Pencil, [f64; 2]) {
    let lens = any_lens(seed);
    let pencil = lens.pencil(&Place {
        ideal: [0.2 * f64::from(lens.frame.width_px()), 200.3],
        depth_m: lens.depths_m[seed as usize % 2],
        channel: seed as usize % CHANNELS.len(),
    });
    let centre = pencil.centroid().map(|c| c.floor() + 0.5);
    (pencil, centre)
}

#[test]
fn a_defocused_point_is_a_disc() {
    let alpha = 5.3;
    let mut pencil = Pencil::sharp([0.0; 2], [100.7, 100.4]);
    pencil.defocus(alpha);
    let drawn = tile_of(&pencil, [100.5, 100.5], TILE, CELLS);
    // Share of the disc in each pixel: chords clipped to the pixel, summed over its width.
    let share = |i: usize| {
        let half = (TILE / 2) as f64;
        let x0 = (i % TILE) as f64 - half - 0.5 - 0.2;
        let y0 = (i / TILE) as f64 - half - 0.5 + 0.1;
        let lines = 400;
        let chord = |k: usize| {
            let x = x0 + (k as f64 + 0.5) / f64::from(lines);
            let chord = (alpha * alpha - x * x).max(0.0).sqrt();
            ((y0 + 1.0).min(chord) - y0.max(-chord)).max(0.0)
        };
        (0..lines as usize).map(chord).sum::<f64>() / f64::from(lines) / (PI * alpha * alpha)
    };
    let exact: Vec<f64> = (0..TILE * TILE).map(share).collect();
    let apart = difference(&exact, &drawn);
    assert!(apart < 1e-6, "{apart:e}");
}

#[test]
fn light_is_conserved_and_more_rays_change_nothing() {
    for seed in 0..6 {
        let (pencil, centre) = any_pencil(seed);
        let drawn = tile_of(&pencil, centre, TILE, CELLS);
        let finer = tile_of(&pencil, centre, TILE, 3 * CELLS);
        let (light, _, _) = moments(&drawn);
        assert!((light - 1.0).abs() < 1e-9, "{light}");
        let apart = difference(&finer, &drawn);
        assert!(apart < 3e-6, "seed {seed}: {apart:e}");
    }
}

#[test]
fn slopes_are_the_gradient_of_the_wavefront() {
    let mut rng = Rng::new(5);
    let (mut pencil, _) = any_pencil(1);
    pencil.coma5 = [0.3, -0.8];
    pencil.spherical5 = 1.1;
    pencil.oblique = 0.9;
    pencil.elliptical = -1.2;
    pencil.trefoil = [0.4, 0.7];
    pencil.coma[0] += 0.2;
    let step = 1e-4;
    for _ in 0..20 {
        let [x, y] = [rng.between(-0.7, 0.7), rng.between(-0.7, 0.7)];
        let w = |dx: f64, dy: f64| pencil.wavefront([x + dx, y + dy]);
        let gradient = [
            (w(step, 0.0) - w(-step, 0.0)) / (2.0 * step),
            (w(0.0, step) - w(0.0, -step)) / (2.0 * step),
        ];
        let slope = pencil.slope([x, y]);
        for i in 0..2 {
            assert!(
                (gradient[i] - slope[i]).abs() < 1e-6,
                "{gradient:?} {slope:?}"
            );
        }
    }
}

/// Returns light, centroid relative to the chief ray and second moments, averaged over positions within a pixel, on which
/// the moments of undersampled PSFs depend.
fn mean_moments(pencil: &Pencil, centre: [f64; 2]) -> (f64, [f64; 2], [f64; 3]) {
    const STEPS: usize = 4;
    let mut mean = (0.0, [0.0; 2], [0.0; 3]);
    for phase in 0..STEPS * STEPS {
        let mut moved = pencil.clone();
        moved.chief[0] += (phase % STEPS) as f64 / STEPS as f64 - 0.375;
        moved.chief[1] += (phase / STEPS) as f64 / STEPS as f64 - 0.375;
        let (light, at, second) = moments(&tile_of(&moved, centre, TILE, CELLS));
        let weight = 1.0 / (STEPS * STEPS) as f64;
        mean.0 += weight * light;
        for i in 0..2 {
            mean.1[i] += weight * (centre[i] + at[i] - moved.chief[i]);
        }
        for (sum, moment) in mean.2.iter_mut().zip(second) {
            *sum += weight * moment;
        }
    }
    mean
}

#[test]
fn motion_adds_its_own_second_moment() {
    let (mut pencil, centre) = any_pencil(2);
    let (_, at, still) = mean_moments(&pencil, centre);
    let expected = pencil.centroid();
    for i in 0..2 {
        assert!((at[i] + pencil.chief[i] - expected[i]).abs() < 0.01);
    }
    let [lx, ly] = [2.7, -1.6];
    pencil.sensor.spread(&line([lx, ly]));
    let (light, _, moved) = mean_moments(&pencil, centre);
    let expected = [lx * lx / 12.0, lx * ly / 12.0, ly * ly / 12.0];
    assert!((light - 1.0).abs() < 1e-9, "{light}");
    for i in 0..3 {
        let added = moved[i] - still[i];
        assert!(
            (added - expected[i]).abs() < 0.01,
            "{added} {}",
            expected[i]
        );
    }
}

#[test]
fn the_focused_wave_is_the_airy_pattern() {
    for q in [1.5, 3.0] {
        let mut pencil = Pencil::sharp([0.0; 2], [10.6, 10.3]);
        pencil.wave_px = Some(q);
        let drawn = tile_of(&pencil, [10.5, 10.5], TILE, CELLS);
        // (2 J1(v) / v)² pi / q², v = 2 pi r / q, over each pixel.
        const PARTS: usize = 10;
        let mut exact = vec![0.0; TILE * TILE];
        for (i, pixel) in exact.iter_mut().enumerate() {
            for part in 0..PARTS * PARTS {
                let within = |k: usize| (k as f64 + 0.5) / PARTS as f64 - 0.5;
                let x = (i % TILE) as f64 - (TILE / 2) as f64 + within(part % PARTS) - 0.1;
                let y = (i / TILE) as f64 - (TILE / 2) as f64 + within(part / PARTS) + 0.2;
                let v = (2.0 * PI * x.hypot(y) / q).max(1e-9);
                let amplitude = 2.0 * libm::j1(v) / v;
                *pixel += amplitude * amplitude * PI / (q * q) / (PARTS * PARTS) as f64;
            }
        }
        // Without normalisation, to check the total light as well.
        let apart: f64 = exact.iter().zip(&drawn).map(|(e, d)| (e - d).powi(2)).sum();
        let whole: f64 = exact.iter().map(|e| e * e).sum();
        assert!(apart / whole < 1e-4, "q {q}: {:e}", apart / whole);
    }
}

#[test]
fn waves_converge_to_rays() {
    let (mut pencil, centre) = any_pencil(3);
    let rays = tile_of(&pencil, centre, TILE, CELLS);
    let mut last = f64::INFINITY;
    for q in [2.0, 1.0, 0.5] {
        pencil.wave_px = Some(q);
        let wave = tile_of(&pencil, centre, TILE, CELLS);
        let apart = difference(&rays, &wave);
        assert!(apart < last, "q {q}: {apart}");
        last = apart;
        let (light, at, _) = moments(&wave);
        assert!(light > 0.96 && light < 1.001, "{light}");
        let (_, expected, _) = moments(&rays);
        for i in 0..2 {
            assert!((at[i] - expected[i]).abs() < 0.15, "{at:?} {expected:?}");
        }
    }
    assert!(last < 0.1, "{last}");
}

#[test]
fn the_same_recipe_is_the_same_case_on_any_number_of_threads() {
    let recipe = Recipe {
        kind: Kind::Single("decentre"),
        seed: 11,
        size: SMALL,
    };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().expect("threads can be started");
        pool.install(|| draw(&recipe))
    };
    let case = on(1);
    assert_eq!(case, on(3));
    assert_ne!(case, draw(&Recipe { seed: 12, ..recipe }));
}

#[test]
fn every_cause_gives_valid_sets_with_a_gap_in_range() {
    let kinds = EFFECTS.iter().map(|id| Kind::Single(id));
    let families = UNKNOWN.iter().map(|id| Kind::Unknown(id));
    for kind in kinds.chain(families) {
        let recipe = Recipe {
            kind,
            seed: 7,
            size: SMALL,
        };
        let case = draw(&recipe);
        let gap = case.answer.gap;
        assert!((GAPS[0]..=GAPS[1]).contains(&gap), "{kind:?}: {gap}");
        for set in [&case.design, &case.real, &case.holdout] {
            assert_eq!(set.faults(), [], "{kind:?}");
        }
        assert_eq!(case.real.observations.len(), 2 * SMALL.real);
        assert_eq!(case.real.distances().len(), 2);
    }
}

#[test]
fn two_causes_have_comparable_gaps() {
    for (a, b) in [("motion", "defocus_offset"), ("vignetting", "diffraction")] {
        let recipe = Recipe {
            kind: Kind::Pair(a, b),
            seed: 3,
            size: SMALL,
        };
        let answer = draw(&recipe).answer;
        let alone = |id: &str| answer.parameters[&format!("{id}.gap_alone")];
        assert!(alone(a).min(alone(b)) >= 0.03, "{answer:?}");
        assert!(3.0 * alone(a).min(alone(b)) >= alone(a).max(alone(b)));
        assert_eq!(answer.effects, [a, b]);
        assert!(answer.gap <= GAPS[1]);
    }
}

#[test]
fn cases_without_a_cause_differ_by_noise_only() {
    for seed in 0..4 {
        let recipe = Recipe {
            kind: Kind::None,
            seed,
            size: SMALL,
        };
        let case = draw(&recipe);
        assert_eq!(case.answer.gap, 0.0);
        let (_, plan) = attempt_at(&recipe, 0);
        let snr = case.answer.parameters["real.snr"];
        let (mut sum, mut count) = (0.0, 0);
        for (spot, seen) in plan.spots[1].iter().zip(&case.real.observations) {
            let options = TileOptions {
                tile: TILE,
                cells: CELLS,
                raw: true,
            };
            let bare = spot_tiles(&plan.lens, &[], spot, options, None);
            assert_eq!(seen.centre.x_px, bare.centre[0]);
            for (channel, pixels) in bare.tiles.iter().enumerate() {
                // Fits the scale only.
                let light = seen.light(channel);
                let dot = |f: &dyn Fn(usize) -> f64| (0..pixels.len()).map(f).sum::<f64>();
                let samples = |i: usize| f64::from(light.samples()[i]);
                let scale = dot(&|i| samples(i) * pixels[i]) / dot(&|i| pixels[i] * pixels[i]);
                let rms = dot(&|i| (samples(i) - scale * pixels[i]).powi(2)) / pixels.len() as f64;
                let stated = seen.noise_sigma[channel];
                let peak = scale * pixels.iter().copied().fold(0.0, f64::max);
                let sigma = stated.unwrap_or(peak / snr);
                sum += rms / (sigma * sigma);
                count += 1;
            }
        }
        let chi2 = sum / f64::from(count);
        assert!((chi2 - 1.0).abs() < 0.03, "seed {seed}: {chi2}");
    }
}

#[test]
fn gaps_grow_with_strength_and_are_zero_without() {
    let lens = any_lens(9);
    let mut rng = Rng::new(4);
    let spots = super::expose::spots(&lens, 3, 0.5, &mut rng);
    let mut cause = Cause {
        change: effect("defocus_offset", &lens, &mut rng),
        strength: 0.0,
    };
    assert!(gap(&lens, &[&cause], &spots, TILE) < 1e-12);
    let mut last = 0.0;
    for strength in [0.1, 0.3, 0.9] {
        cause.strength = strength;
        let now = gap(&lens, &[&cause], &spots, TILE);
        assert!(now > last, "{strength}: {now}");
        last = now;
    }
}

#[test]
fn recipes_are_balanced_and_repeatable() {
    let list = recipes(200, 1, Size::default());
    let count = |f: &dyn Fn(&Kind) -> bool| list.iter().filter(|r| f(&r.kind)).count();
    assert_eq!(list.len(), 200);
    assert_eq!(count(&|k| matches!(k, Kind::None)), 20);
    assert_eq!(count(&|k| matches!(k, Kind::Pair(..))), 30);
    assert_eq!(count(&|k| matches!(k, Kind::Unknown(_))), 30);
    for id in EFFECTS {
        let singles = count(&|k| *k == Kind::Single(id));
        assert!((7..=8).contains(&singles), "{id}: {singles}");
    }
    for id in UNKNOWN {
        assert!(count(&|k| *k == Kind::Unknown(id)) >= 3, "{id}");
    }
    assert_eq!(list, recipes(200, 1, Size::default()));
    assert_ne!(list, recipes(200, 2, Size::default()));
    for few in 0..12 {
        assert_eq!(recipes(few, 1, SMALL).len(), few);
    }
}
