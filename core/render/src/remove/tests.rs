//! Removal against pictures that are known.

use super::canvas::{Canvas, part_of};
use super::test_scenes::{
    Deviates, HEIGHT, WEIGHTS, WIDTH, discs, lens, plate, psnr_db, removed, scene, seen, sharpened,
    texture,
};
use super::view::View;
use super::{Lights, Removal, Saturation};
use crate::{Edges, Plane, RenderWindow, Scatter, Scene, VergencePass, cancelled};
use rustfft::num_complex::Complex;

/// Above the best that Wiener filters by local spectra reach, their one number chosen by the truth, where edges are all there
/// is; not behind where there are none, for which they are made.
#[test]
fn more_comes_back_than_by_wiener_filters() {
    let lens = lens(1.0);
    let scene = scene(&lens);
    let canvas = Canvas::of(&scene);
    let view = View::new(&scene, &canvas, &WEIGHTS).expect("a lens");
    let (edges, soft) = (discs(WIDTH, HEIGHT), texture(WIDTH, HEIGHT));
    for (sharp, noise, least_gain, least_lead) in [
        (&edges, 0.001, 5.0, 0.5),
        (&edges, 0.01, 3.5, 0.5),
        (&soft, 0.001, 12.0, 0.2),
        (&soft, 0.01, 6.0, -0.3),
    ] {
        let plate = seen(&scene, &Scatter, sharp, noise);
        // The plate is mirrored beyond its edges, lens and all, which neither can know.
        let inside = RenderWindow {
            column: 12,
            row: 12,
            width: WIDTH - 24,
            height: HEIGHT - 24,
        };
        let psnr_db = |found: &[f32]| psnr_db(&inside.cut(WIDTH, found), &inside.cut(WIDTH, sharp));
        let before = psnr_db(&plate);
        let mirrored = canvas.mirrored(&plate);
        let wiener = |by_slope: bool| {
            let tried = (-60..0).step_by(2).map(|k| {
                let prior = 10.0_f32.powf(k as f32 / 10.0);
                let filter = |h: Complex<f32>, slope: f32| {
                    let damping = if by_slope { prior * slope } else { prior };
                    h.conj() / (h.norm_sqr() + damping + 1e-9)
                };
                let found = view.filtered(&mirrored, filter).expect("a plane");
                psnr_db(&canvas.cropped(&found))
            });
            tried.fold(f64::NEG_INFINITY, f64::max)
        };
        let best = wiener(false).max(wiener(true));
        let found = psnr_db(&sharpened(&scene, &plate, Removal::default()));
        assert!(
            found > before + least_gain && found > best + least_lead,
            "noise {noise}: {before} before, {best} by Wiener, {found} found"
        );
    }
}

/// Light from beyond the edges that no mirror would have there: near them, too, the picture is nearer to the truth than the
/// plate is.
#[test]
fn edges_do_not_ring() {
    let lens = lens(1.0);
    let whole = scene(&lens);
    let sharp = discs(WIDTH, HEIGHT);
    let window = RenderWindow {
        column: 30,
        row: 25,
        width: 110,
        height: 100,
    };
    let plate = window.cut(WIDTH, &plate(0.002));
    let sharp = window.cut(WIDTH, &sharp);
    let found = sharpened(&part_of(&whole, window), &plate, Removal::default());
    let error = |found: &[f32], near: bool| {
        let (mut sum, mut count) = (0.0, 0);
        for k in 0..sharp.len() {
            let (x, y) = (k % window.width, k / window.width);
            let inside = x
                .min(window.width - 1 - x)
                .min(y)
                .min(window.height - 1 - y);
            if (inside < 6) == near {
                sum += f64::from(found[k] - sharp[k]).powi(2);
                count += 1;
            }
        }
        (sum / f64::from(count)).sqrt()
    };
    assert!(
        error(&found, true) < 0.7 * error(&plate, true)
            && error(&found, true) < 2.0 * error(&found, false),
        "{:?} {:?}",
        [true, false].map(|near| error(&found, near)),
        [true, false].map(|near| error(&plate, near))
    );
}

/// About a clipped light the picture is as it would be about one that is not.
#[test]
fn clipped_lights_do_not_ring() {
    let lens = lens(1.0);
    let scene = scene(&lens);
    let mut sharp = discs(WIDTH, HEIGHT);
    let far = |k: usize| ((k % WIDTH) as f64 - 120.0).hypot((k / WIDTH) as f64 - 60.0);
    for (k, sample) in sharp.iter_mut().enumerate() {
        if far(k) < 7.0 {
            *sample = 6.0;
        }
    }
    let plate = seen(&scene, &Scatter, &sharp, 0.002);
    let plate: Vec<f32> = plate.iter().map(|v| v.min(1.0)).collect();
    let about = |found: &[f32], sharp: &[f32], from: f64, to: f64| {
        let ring = (0..sharp.len()).filter(|k| (from..to).contains(&far(*k)));
        let (sum, count) = ring.fold((0.0, 0), |(sum, count), k| {
            (sum + f64::from(found[k] - sharp[k]).powi(2), count + 1)
        });
        (sum / f64::from(count)).sqrt()
    };
    let told = removed(&scene, &plate, Removal::default());
    let (level, count) = told.clipped.expect("a light is clipped");
    assert!(
        (0.99..=1.0).contains(&level) && (100..400).contains(&count),
        "{level} {count}"
    );
    let never = Removal {
        saturation: Saturation::Never,
        ..Removal::default()
    };
    let (found, rung) = (
        told.canvas.cropped(&told.sharp),
        sharpened(&scene, &plate, never),
    );
    let dark = discs(WIDTH, HEIGHT);
    let unlit = sharpened(
        &scene,
        &super::test_scenes::plate(0.002),
        Removal::default(),
    );
    let (ours, theirs) = (
        about(&found, &sharp, 10.0, 18.0),
        about(&rung, &sharp, 10.0, 18.0),
    );
    assert!(ours < 2.0 * about(&unlit, &dark, 10.0, 18.0), "{ours}");
    assert!(ours < 0.5 * theirs, "{ours} {theirs}");
    assert!((0..plate.len()).all(|k| plate[k] < 1.0 || told.confidence[k] == 0.0));
}

/// What blur was taken off can be put back: by the exact renderer, over all of the plate, without noise.
#[test]
fn the_plate_comes_back() {
    let lens = lens(1.0);
    let scene = scene(&lens);
    let plate = plate(0.0);
    let removed = removed(&scene, &plate, Removal::default());
    let again = seen(
        &Scene {
            edges: Edges::Black,
            ..removed.canvas.scene(&scene, None)
        },
        &Scatter,
        &removed.sharp,
        0.0,
    );
    let psnr = psnr_db(&removed.canvas.cropped(&again), &plate);
    assert!(psnr > 55.0, "{psnr}");
}

/// Near and far, each with its own blur: away from the edge between them nearly as good as alone.
#[test]
fn depths_have_their_own_blur() {
    let lens = lens(0.8);
    let edge = 85;
    let pass: Vec<f32> = (0..WIDTH * HEIGHT)
        .map(|k| if k % WIDTH < edge { 0.8 } else { 0.0 })
        .collect();
    let at = |vergence| Scene {
        vergence,
        ..scene(&lens)
    };
    let sharp = discs(WIDTH, HEIGHT);
    let deep = at(VergencePass::PerPixel(&pass));
    let plate = seen(&deep, &Scatter, &sharp, 0.002);
    let found = sharpened(&deep, &plate, Removal::default());
    let (near, far) = (
        sharpened(&at(VergencePass::Constant(0.8)), &plate, Removal::default()),
        sharpened(&at(VergencePass::Constant(0.0)), &plate, Removal::default()),
    );
    let error = |found: &[f32], columns: std::ops::Range<usize>| {
        let of_row = |row: usize| columns.clone().map(move |x| row * WIDTH + x);
        let squares = (0..HEIGHT)
            .flat_map(of_row)
            .map(|k| f64::from(found[k] - sharp[k]).powi(2));
        (squares.sum::<f64>() / (columns.len() * HEIGHT) as f64).sqrt()
    };
    // The kernels of neither side reach farther.
    let (left, right) = (0..edge - 14, edge + 14..WIDTH);
    assert!(error(&found, left.clone()) < 1.35 * error(&near, left.clone()));
    assert!(error(&found, right.clone()) < 1.35 * error(&far, right.clone()));
    // Each side with the other's blur is worse; errors at the edge stay within bounds.
    assert!(error(&found, left.clone()) < 0.9 * error(&far, left));
    assert!(error(&found, right.clone()) < 0.9 * error(&near, right));
    let (at_edge, before) = (
        error(&found, edge - 14..edge + 14),
        error(&plate, edge - 14..edge + 14),
    );
    assert!(at_edge < 2.0 * before, "{at_edge} {before}");
}

/// Too much and too little blur are seen in what is left, the right one is left alone.
#[test]
fn a_wrong_lens_is_told() {
    let plate = plate(0.003);
    for (strength, least, most) in [(1.0, 1.0, 1.0), (1.35, 0.6, 0.9), (0.75, 1.1, 1.6)] {
        let lens = lens(strength);
        let planes = [Plane {
            samples: &plate,
            weights: &WEIGHTS,
        }];
        let check = Removal::default().check_lens(&scene(&lens), &planes, &|_| true);
        let share = check.expect("a sound scene").blur_share;
        assert!((least..=most).contains(&share), "{strength}: {share}");
    }
}

/// The gain told is that of noise which it has not seen.
#[test]
fn noise_is_amplified_as_told() {
    let lens = lens(1.0);
    let scene = scene(&lens);
    let (clean, noise) = (plate(0.0), 0.01);
    let with = |seed: u64| {
        let mut chance = Deviates(seed);
        let noisy = clean.iter().map(|v| v + (noise * chance.next()) as f32);
        noisy.collect::<Vec<f32>>()
    };
    let removal = Removal {
        noise: Some(noise),
        ..Removal::default()
    };
    let (plate, others) = (with(1), [with(2), with(3), with(4), with(5)]);
    let first = removed(&scene, &plate, removal);
    let planes = [Plane {
        samples: &plate,
        weights: &WEIGHTS,
    }];
    let told = removal.noise_gain(
        &Lights::of(&planes, WIDTH),
        &scene,
        &planes,
        &[first],
        &|_| true,
    );
    let told = told.expect("a sound scene").swap_remove(0);
    let found = others.map(|plate| sharpened(&scene, &plate, removal));
    for (x, y) in [(30, 30), (85, 75), (140, 40), (40, 120), (120, 110)] {
        let (mut sum, mut count) = (0.0, 0.0);
        for row in y - 14..y + 15 {
            for column in x - 14..x + 15 {
                let at = found
                    .each_ref()
                    .map(|found| f64::from(found[row * WIDTH + column]));
                let mean = at.iter().sum::<f64>() / 4.0;
                sum += at.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
                count += 3.0;
            }
        }
        let right = (sum / count).sqrt() / noise;
        let told = f64::from(told[y * WIDTH + x]);
        assert!(
            (told / right - 1.0).abs() < 0.4,
            "({x}, {y}): {told} told, {right}"
        );
    }
}

/// Less is told by noisier plates, and where more blur is.
#[test]
fn confidence_falls_with_noise_and_blur() {
    let lens = lens(1.0);
    let scene = scene(&lens);
    let confidence = |noise| removed(&scene, &plate(noise), Removal::default()).confidence;
    let (clear, noisy) = (confidence(0.001), confidence(0.03));
    let (middle, corner) = (75 * WIDTH + 85, 10 * WIDTH + 10);
    for k in [middle, corner] {
        assert!((0.0..=1.0).contains(&clear[k]) && noisy[k] < 0.9 * clear[k]);
    }
    assert!(clear[corner] < 0.8 * clear[middle]);
}

/// Where there is no detail but noise, nothing is invented: the picture is smoother than the plate.
#[test]
fn strong_noise_is_not_amplified() {
    let lens = lens(1.0);
    let scene = scene(&lens);
    let sharp = discs(WIDTH, HEIGHT);
    let plate = plate(0.1);
    let found = sharpened(&scene, &plate, Removal::default());
    assert!(psnr_db(&found, &sharp) > psnr_db(&plate, &sharp) + 1.0);
}

/// Light of one level is given back as it is.
#[test]
fn even_planes_stay_as_they_are() {
    let lens = lens(1.0);
    for level in [0.0_f32, 0.7, 1.0, 40.0] {
        let even = vec![level; WIDTH * HEIGHT];
        let found = removed(&scene(&lens), &even, Removal::default());
        assert!(found.sharp.iter().all(|v| *v == level));
    }
}

/// A few very bright lights do not spoil the rest.
#[test]
fn bright_lights_leave_the_rest_alone() {
    let lens = lens(1.0);
    let scene = scene(&lens);
    let mut sharp = discs(WIDTH, HEIGHT);
    let gain = |sharp: &[f32]| {
        let plate = seen(&scene, &Scatter, sharp, 0.002);
        let found = sharpened(&scene, &plate, Removal::default());
        let left = |plane: &[f32]| -> Vec<f32> {
            plane
                .chunks_exact(WIDTH)
                .flat_map(|row| row[..120].to_vec())
                .collect()
        };
        psnr_db(&left(&found), &left(sharp)) - psnr_db(&left(&plate), &left(sharp))
    };
    let without = gain(&sharp);
    for k in [60 * WIDTH + 150, 90 * WIDTH + 155, 91 * WIDTH + 155] {
        sharp[k] = 2000.0;
    }
    let with = gain(&sharp);
    assert!(with > without - 1.0, "{with} {without}");
}

/// The same whatever unit light is in.
#[test]
fn light_has_no_unit() {
    let lens = lens(1.0);
    let plate = plate(0.004);
    let bright: Vec<f32> = plate.iter().map(|v| 64.0 * v).collect();
    let of = |plate: &[f32]| sharpened(&scene(&lens), plate, Removal::default());
    let (one, other) = (of(&plate), of(&bright));
    let apart = one.iter().zip(&other).map(|(a, b)| (a - b / 64.0).abs());
    assert!(apart.fold(0.0, f32::max) < 1e-3);
}

#[test]
fn threads_change_nothing() {
    let lens = lens(1.0);
    let plate = plate(0.01);
    let removal = Removal {
        rounds: 2,
        ..Removal::default()
    };
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().expect("a pool");
        pool.install(|| sharpened(&scene(&lens), &plate, removal))
    };
    assert!(with(1) == with(3));
}

#[test]
fn what_cannot_be_is_refused() {
    let lens = lens(1.0);
    let plate = discs(WIDTH, HEIGHT);
    let planes = [Plane {
        samples: &plate,
        weights: &WEIGHTS,
    }];
    let default = Removal::default();
    let refused = |removal: Removal, go_on: bool| {
        let error = removal.remove(&scene(&lens), &planes, &|_| go_on);
        error.expect_err("refused").to_string()
    };
    let noise = Some(f64::NAN);
    assert!(refused(Removal { noise, ..default }, true).contains("noise"));
    let saturation = Saturation::From(f64::INFINITY);
    assert!(
        refused(
            Removal {
                saturation,
                ..default
            },
            true
        )
        .contains("saturation")
    );
    assert_eq!(refused(default, false), cancelled().to_string());
}
