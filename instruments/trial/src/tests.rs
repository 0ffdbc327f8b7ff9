//! Tiles against closed forms, and properties of cases.

use std::f64::consts::PI;

use super::conditions::Size;
use super::draw::{draw, draw_further};
use super::expose::{
    Alignment, Cause, GapOptions, TileOptions, difference, gap, noise_sigma, spot_tiles, tile_of,
};
use super::further_capture::FurtherCapture;
use super::lens::{CHANNELS, Lens, LensConstraints, Place};
use super::pencil::Pencil;
use super::perturb::effect;
use super::perturb_sensor::line;
use super::plan::{LARGEST_GAP, LEAST_LIMITS, attempt_at};
use super::rays::CELLS;
use super::recipe::{Kind, KindClass, Recipe, Selection, Simulator, may_pair, recipes};
use super::rng::Rng;
use super::third_order::{EFFECTS, UNKNOWN};

const TILE: usize = 33;
const SMALL: Size = Size {
    design: 2,
    real: 5,
    holdout: 2,
    tile: TILE,
};

/// Returns a recipe with few tiles.
fn small(kind: Kind, seed: u64) -> Recipe {
    Recipe::new(kind, Simulator::ThirdOrder, seed, Some(SMALL))
}

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
        distances: 2,
        room: 1.0,
    };
    Lens::draw_for(&mut Rng::new(seed), constraints, TILE)
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
    let recipe = small(Kind::Single("decentre"), 11);
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
        let recipe = small(kind, 7);
        let case = draw(&recipe);
        let gap = case.answer.gap;
        let least = LEAST_LIMITS * case.answer.parameters["real.detection_limit"];
        let most = if kind == Kind::Single("distortion") {
            2.0
        } else {
            LARGEST_GAP
        };
        assert!(
            (least..=most).contains(&gap),
            "{kind:?}: {gap}, at least {least}"
        );
        for set in [&case.design, &case.real, &case.holdout] {
            assert_eq!(set.faults(), [], "{kind:?}");
        }
        let conditions = &recipe.conditions;
        assert_eq!(
            case.real.observations.len(),
            conditions.distances * SMALL.real
        );
        assert_eq!(case.real.distances().len(), conditions.distances);
        let real = &case.real.observations[0];
        assert_eq!(real.ideal.is_some(), conditions.ideal_positions, "{kind:?}");
        let held_out = &case.holdout.observations;
        assert!(held_out.iter().all(|o| o.ideal.is_some()), "{kind:?}");
        assert_eq!(
            real.noise_sigma[0].is_some(),
            conditions.noise_stated,
            "{kind:?}"
        );
    }
}

#[test]
fn two_and_three_causes_have_comparable_gaps() {
    for kind in [
        Kind::Pair("motion", "defocus_offset"),
        Kind::Pair("vignetting", "diffraction"),
        Kind::Triple(["decentre", "veiling_glare", "axial_colour"]),
    ] {
        let answer = draw(&small(kind, 3)).answer;
        let least = LEAST_LIMITS * answer.parameters["real.detection_limit"];
        let causes = kind.causes();
        let alone = causes
            .iter()
            .map(|id| answer.parameters[&format!("{id}.gap_alone")]);
        let alone: Vec<f64> = alone.collect();
        let smallest = alone.iter().copied().fold(f64::INFINITY, f64::min);
        let greatest = alone.iter().copied().fold(0.0, f64::max);
        assert!(smallest >= least, "{answer:?}");
        assert!(3.0 * smallest >= greatest, "{answer:?}");
        assert_eq!(answer.effects, causes);
        assert!(answer.gap <= LARGEST_GAP);
    }
}

#[test]
fn strong_distortion_moves_psfs_by_many_pixels() {
    let farthest = |seed: u64| {
        let case = draw(&small(Kind::Single("distortion"), seed));
        let answer = &case.answer;
        // The corner of the frame is at h = 1.147.
        let corner = answer.parameters["distortion.shift"].abs() * 1.147_f64.powi(3);
        assert!(corner <= 24.1, "{corner}");
        assert_eq!(case.real.faults(), []);
        corner
    };
    let most = (0..5).map(farthest).fold(0.0, f64::max);
    assert!(most > 6.0, "{most}");
}

#[test]
fn designs_that_are_too_rich_differ_from_every_third_order_lens() {
    let recipe = small(Kind::TooSimple, 5);
    let case = draw(&recipe);
    assert_eq!((case.answer.gap, case.answer.effects.len()), (0.0, 0));
    assert_eq!(case.answer.kind, "too_simple");
    let own = |id: &str| {
        case.answer
            .parameters
            .contains_key(&format!("design.{id}.strength"))
    };
    let count = ["decentre", "anamorphic", "higher_order", "vignetting"]
        .iter()
        .filter(|id| own(id))
        .count();
    assert!(count >= 2, "{:?}", case.answer.parameters);
    // The design has its own effects; the bare lens of the same plan has none.
    let (_, plan) = attempt_at::<Lens>(&recipe, 0);
    let spot = &plan.spots[0][0];
    let options = TileOptions {
        tile: TILE,
        cells: CELLS,
        raw: false,
    };
    let bare = spot_tiles(&plan.lens, &[], spot, options, None);
    let light = case.design.observations[0].light(1);
    let seen: Vec<f64> = light.samples().iter().map(|v| f64::from(*v)).collect();
    let apart = difference(&seen, &bare.tiles[1]);
    assert!(apart > 0.005, "{apart}");
}

#[test]
fn a_wider_iris_scales_pencils_but_not_other_stops() {
    let (mut pencil, _) = any_pencil(4);
    let nominal = pencil.clone();
    pencil.mask.pupil_scale = 1.2;
    let (wide, same) = (pencil.slope([0.5, -0.25]), nominal.slope([0.6, -0.3]));
    assert!((wide[0] - same[0]).abs() < 1e-12 && (wide[1] - same[1]).abs() < 1e-12);
    // A circle about the axis that just lets the nominal pencil pass cuts the wider one to it.
    pencil.mask.clips.push([0.0, 0.0, 1.0]);
    let centre = nominal.centroid().map(|c| c.floor() + 0.5);
    let cut = tile_of(&pencil, centre, TILE, CELLS);
    let apart = difference(&tile_of(&nominal, centre, TILE, CELLS), &cut);
    assert!(apart < 1e-4, "{apart:e}");
    // The Airy disc of an iris 1.2 times as wide is that of q / 1.2.
    let mut airy = Pencil::sharp([0.0; 2], [10.6, 10.3]);
    airy.wave_px = Some(3.0 / 1.2);
    let narrow = tile_of(&airy, [10.5, 10.5], TILE, CELLS);
    airy.wave_px = Some(3.0);
    airy.mask.pupil_scale = 1.2;
    let apart = difference(&narrow, &tile_of(&airy, [10.5, 10.5], TILE, CELLS));
    assert!(apart < 1e-6, "{apart:e}");
}

#[test]
fn cases_without_a_cause_differ_by_noise_only() {
    for seed in 0..4 {
        let recipe = small(Kind::None, seed);
        let case = draw(&recipe);
        assert_eq!(case.answer.gap, 0.0);
        let (_, plan) = attempt_at::<Lens>(&recipe, 0);
        let snr = recipe.conditions.snr;
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
                let scaled: Vec<f64> = pixels.iter().map(|v| scale * v).collect();
                let sigma = stated.unwrap_or_else(|| noise_sigma(&scaled, peak, snr));
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
    let options = GapOptions {
        tile: TILE,
        alignment: Alignment::Frame,
    };
    assert!(gap(&lens, &[&cause], &spots, options) < 1e-12);
    let mut last = 0.0;
    for strength in [0.1, 0.3, 0.9] {
        cause.strength = strength;
        let now = gap(&lens, &[&cause], &spots, options);
        assert!(now > last, "{strength}: {now}");
        last = now;
    }
}

#[test]
fn gaps_by_shape_leave_common_shifts_out() {
    let lens = any_lens(9);
    let mut rng = Rng::new(4);
    let spots = super::expose::spots(&lens, 3, 0.5, &mut rng);
    let cause = Cause {
        change: effect("distortion", &lens, &mut rng),
        strength: 8.0,
    };
    let by = |alignment| {
        let options = GapOptions {
            tile: TILE,
            alignment,
        };
        gap(&lens, &[&cause], &spots, options)
    };
    assert!(by(Alignment::Frame) > 0.05);
    assert!(by(Alignment::Centroid) < 1e-9);
}

fn selection(count: usize, seed: u64) -> Selection {
    Selection {
        count,
        seed,
        only: None,
        size: None,
    }
}

#[test]
fn recipes_are_balanced_and_repeatable() {
    let list = recipes(&selection(200, 1));
    let count = |f: &dyn Fn(&Kind) -> bool| list.iter().filter(|r| f(&r.kind)).count();
    let of = |class: KindClass| count(&|k| k.class() == class);
    assert_eq!(KindClass::ALL.map(of), [16, 110, 24, 12, 24, 14]);
    for simulator in Simulator::ALL {
        let of = |kind: Kind| {
            let same = |r: &&Recipe| r.kind == kind && r.simulator == simulator;
            list.iter().filter(same).count()
        };
        for id in simulator.effects() {
            let singles = of(Kind::Single(id));
            assert!((3..=4).contains(&singles), "{simulator:?}, {id}: {singles}");
        }
        for id in simulator.unknown_families() {
            assert!(of(Kind::Unknown(id)) >= 1, "{simulator:?}, {id}");
        }
        let all = list.iter().filter(|r| r.simulator == simulator).count();
        assert!((97..=103).contains(&all), "{simulator:?}: {all}");
    }
    for recipe in &list {
        let causes = recipe.kind.causes();
        for (index, a) in causes.iter().enumerate() {
            assert!(causes[..index].iter().all(|b| may_pair(a, b)), "{causes:?}");
            let known = match recipe.kind {
                Kind::Unknown(_) => recipe.simulator.unknown_families(),
                _ => recipe.simulator.effects(),
            };
            assert!(known.contains(a), "{recipe:?}");
        }
    }
    assert_eq!(list, recipes(&selection(200, 1)));
    assert_ne!(list, recipes(&selection(200, 2)));
    for few in 0..12 {
        assert_eq!(recipes(&selection(few, 1)).len(), few);
    }
}

#[test]
fn one_kind_can_be_selected() {
    for class in KindClass::ALL {
        let only = Selection {
            only: Some(class),
            ..selection(9, 1)
        };
        let list = recipes(&only);
        assert_eq!(list.len(), 9);
        assert!(list.iter().all(|r| r.kind.class() == class), "{class:?}");
    }
}

#[test]
fn conditions_cover_their_ranges() {
    let list = recipes(&selection(400, 5));
    let count = |f: &dyn Fn(&Recipe) -> bool| list.iter().filter(|r| f(r)).count();
    let near = |found: usize, share: f64| {
        let expected = 400.0 * share;
        assert!(
            (found as f64 - expected).abs() < 40.0,
            "{found}, {expected}"
        );
    };
    near(count(&|r| r.conditions.distances == 1), 0.15);
    near(count(&|r| r.conditions.distances == 5), 0.15);
    near(count(&|r| r.conditions.size.tile == 49), 0.2);
    near(count(&|r| r.conditions.size.tile == 65), 0.1);
    near(count(&|r| !r.conditions.ideal_positions), 0.2);
    near(count(&|r| r.conditions.snr < 245.0), 0.5);
    for recipe in &list {
        let c = &recipe.conditions;
        assert!(
            (30.0..2000.0).contains(&c.snr) && (12..=30).contains(&c.size.real),
            "{c:?}"
        );
        let moves_only = recipe.kind.causes().contains(&"distortion");
        assert!(c.ideal_positions || !moves_only);
    }
    let fixed = Selection {
        size: Some(SMALL),
        ..selection(9, 1)
    };
    assert!(recipes(&fixed).iter().all(|r| r.conditions.size == SMALL));
}

#[test]
fn further_captures_add_to_the_real_set_and_keep_the_lens() {
    let mut recipe = small(Kind::Single("motion"), 3);
    recipe.conditions.distances = 1;
    let first = draw(&recipe);
    let more = draw_further(&recipe, FurtherCapture::MorePlaces).expect("places");
    let count = first.real.observations.len();
    assert_eq!(more.real.observations[..count], first.real.observations[..]);
    assert_eq!(more.real.observations.len(), 3 * count);
    assert_eq!(more.design, first.design);
    let other = draw_further(&recipe, FurtherCapture::OtherSideOfFocus).expect("one distance");
    assert_eq!(other.real.distances().len(), 2);
    assert_eq!(other.design.distances(), other.real.distances());
    let wide = draw_further(&recipe, FurtherCapture::DarkSurround).expect("tiles of 33 px");
    assert_eq!(wide.real.observations[0].tiles[0].width(), 65);
    recipe.conditions.distances = 2;
    assert!(draw_further(&recipe, FurtherCapture::OtherSideOfFocus).is_none());
}
