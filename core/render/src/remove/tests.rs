//! Removal of blur from plates whose sharp image is known.

mod depth_split;
mod lights;

use super::canvas::window_scene;
use super::lens_operator::LensOperator;
use super::test_scenes::{
    HEIGHT, NormalDeviates, WEIGHTS, WIDTH, blurred, discs, lens, plate, psnr_db, remove, scene,
    sharpen, texture,
};
use super::{Canvas, Deconvolver, Saturation, estimate_blur_share, find_lights};
use crate::{Edges, Plane, RenderWindow, Scatter, Scene, VergencePass, cancelled};
use seidel_fourier::Complex;

/// The Wiener filters work on local spectra, and their damping is the best in hindsight. They are optimal for texture
/// without edges.
#[test]
fn edges_are_restored_better_than_by_wiener_filters_and_texture_as_well() {
    let lens = lens(1.0);
    let scene = scene(&lens);
    let canvas = Canvas::new(&scene);
    let operator = LensOperator::new(&scene, &canvas, &WEIGHTS).expect("a valid lens");
    let (edges, texture) = (discs(WIDTH, HEIGHT), texture(WIDTH, HEIGHT));
    for (sharp, noise, least_gain, least_lead) in [
        (&edges, 0.001, 5.0, 0.5),
        (&edges, 0.01, 3.5, 0.5),
        (&texture, 0.001, 12.0, 0.2),
        (&texture, 0.01, 6.0, -0.3),
    ] {
        let plate = blurred(&scene, &Scatter, sharp, noise);
        // The renderer mirrors the lens at the edges as well, which neither method models.
        let inside = RenderWindow {
            column: 12,
            row: 12,
            width: WIDTH - 24,
            height: HEIGHT - 24,
        };
        let psnr_db = |found: &[f32]| psnr_db(&inside.cut(WIDTH, found), &inside.cut(WIDTH, sharp));
        let before = psnr_db(&plate);
        let mirrored = canvas.extend_by_mirroring(&plate);
        let wiener = |prior: &(dyn Fn(f32) -> f32 + Sync)| {
            let tried = (-60..0).step_by(2).map(|k| {
                let damping = 10.0_f32.powf(k as f32 / 10.0);
                let gain = |h: Complex<f32>, gradient_power: f32| {
                    h.conj() / (h.norm_sqr() + damping * prior(gradient_power) + 1e-9)
                };
                let found = operator.filter(&mirrored, gain);
                psnr_db(&canvas.crop(&found.expect("a plane of the canvas")))
            });
            tried.fold(f64::NEG_INFINITY, f64::max)
        };
        let best = wiener(&|_| 1.0).max(wiener(&|gradient_power| gradient_power));
        let found = psnr_db(&sharpen(&scene, &plate, Deconvolver::default()));
        assert!(
            found > before + least_gain && found > best + least_lead,
            "noise {noise}: {before} before, {best} by Wiener, {found} found"
        );
    }
}

/// The plate is cut from a larger one, so its surroundings are not its mirror image.
#[test]
fn edges_of_the_plate_do_not_ring() {
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
    let found = sharpen(
        &window_scene(&whole, window),
        &plate,
        Deconvolver::default(),
    );
    let error = |found: &[f32], near: bool| {
        let (mut sum, mut count) = (0.0, 0);
        for k in 0..sharp.len() {
            let (x, y) = (k % window.width, k / window.width);
            let distance = x
                .min(window.width - 1 - x)
                .min(y)
                .min(window.height - 1 - y);
            if (distance < 6) == near {
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

/// Around a clipped light the error is hardly larger than without the light, and half of that without clipping detection.
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
    let plate = blurred(&scene, &Scatter, &sharp, 0.002);
    let plate: Vec<f32> = plate.iter().map(|v| v.min(1.0)).collect();
    let error_around = |found: &[f32], sharp: &[f32]| {
        let ring = (0..sharp.len()).filter(|k| (10.0..18.0).contains(&far(*k)));
        let (sum, count) = ring.fold((0.0, 0), |(sum, count), k| {
            (sum + f64::from(found[k] - sharp[k]).powi(2), count + 1)
        });
        (sum / f64::from(count)).sqrt()
    };
    let removed = remove(&scene, &plate, Deconvolver::default());
    let clipping = removed.clipping.expect("a clipped light");
    assert!(
        (0.99..=1.0).contains(&clipping.level) && (100..400).contains(&clipping.count),
        "{clipping:?}"
    );
    let never = Deconvolver {
        saturation: Saturation::Never,
        ..Deconvolver::default()
    };
    let found = removed.canvas.crop(&removed.sharp);
    let ringing = sharpen(&scene, &plate, never);
    let without_light = sharpen(
        &scene,
        &super::test_scenes::plate(0.002),
        Deconvolver::default(),
    );
    let error = error_around(&found, &sharp);
    let error_without_light = error_around(&without_light, &discs(WIDTH, HEIGHT));
    let error_of_ringing = error_around(&ringing, &sharp);
    assert!(error < 2.0 * error_without_light, "{error}");
    assert!(error < 0.5 * error_of_ringing, "{error} {error_of_ringing}");
    assert!((0..plate.len()).all(|k| plate[k] < 1.0 || removed.confidence[k] == 0.0));
}

/// The exact renderer blurs the sharp image of a plate without noise.
#[test]
fn blurring_the_sharp_image_reproduces_the_plate() {
    let lens = lens(1.0);
    let scene = scene(&lens);
    let plate = plate(0.0);
    let removed = remove(&scene, &plate, Deconvolver::default());
    let again = blurred(
        &Scene {
            edges: Edges::Black,
            ..removed.canvas.scene(&scene, None)
        },
        &Scatter,
        &removed.sharp,
        0.0,
    );
    let psnr = psnr_db(&removed.canvas.crop(&again), &plate);
    assert!(psnr > 55.0, "{psnr}");
}

/// Away from the edge between near and far, the result is nearly as good as on a plate of one depth.
#[test]
fn each_depth_gets_its_own_blur_removed() {
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
    let plate = blurred(&deep, &Scatter, &sharp, 0.002);
    let found = sharpen(&deep, &plate, Deconvolver::default());
    let (near, far) = (
        sharpen(
            &at(VergencePass::Constant(0.8)),
            &plate,
            Deconvolver::default(),
        ),
        sharpen(
            &at(VergencePass::Constant(0.0)),
            &plate,
            Deconvolver::default(),
        ),
    );
    let error = |found: &[f32], columns: std::ops::Range<usize>| {
        let pixels = |row: usize| columns.clone().map(move |x| row * WIDTH + x);
        let squares = (0..HEIGHT)
            .flat_map(pixels)
            .map(|k| f64::from(found[k] - sharp[k]).powi(2));
        (squares.sum::<f64>() / (columns.len() * HEIGHT) as f64).sqrt()
    };
    // No kernel reaches farther than 14 px.
    let (left, right) = (0..edge - 14, edge + 14..WIDTH);
    assert!(error(&found, left.clone()) < 1.35 * error(&near, left.clone()));
    assert!(error(&found, right.clone()) < 1.35 * error(&far, right.clone()));
    // Removal of the other side's blur is worse, and errors at the edge are bounded.
    assert!(error(&found, left.clone()) < 0.9 * error(&far, left));
    assert!(error(&found, right.clone()) < 0.9 * error(&near, right));
    let (at_edge, before) = (
        error(&found, edge - 14..edge + 14),
        error(&plate, edge - 14..edge + 14),
    );
    assert!(at_edge < 2.0 * before, "{at_edge} {before}");
}

#[test]
fn blur_share_of_a_wrong_lens_is_found_and_the_right_lens_is_accepted() {
    let plate = plate(0.003);
    for (strength, least, most) in [(1.0, 1.0, 1.0), (1.35, 0.6, 0.9), (0.75, 1.1, 1.6)] {
        let lens = lens(strength);
        let plane = Plane {
            samples: &plate,
            weights: &WEIGHTS,
        };
        let planes = [(Deconvolver::default(), plane)];
        let share = estimate_blur_share(&scene(&lens), &planes, &|_| true);
        let share = share.expect("a valid scene");
        assert!((least..=most).contains(&share), "{strength}: {share}");
    }
}

/// The truth is the spread of the results for plates with other noise.
#[test]
fn noise_gain_is_within_40_percent_of_the_truth() {
    let lens = lens(1.0);
    let scene = scene(&lens);
    let (clean, noise) = (plate(0.0), 0.01);
    let with = |seed: u64| {
        let mut deviates = NormalDeviates(seed);
        let noisy = clean.iter().map(|v| v + (noise * deviates.next()) as f32);
        noisy.collect::<Vec<f32>>()
    };
    let deconvolver = Deconvolver {
        noise: Some(noise),
        ..Deconvolver::default()
    };
    let (plate, others) = (with(1), [with(2), with(3), with(4), with(5)]);
    let first = remove(&scene, &plate, deconvolver);
    let planes = [Plane {
        samples: &plate,
        weights: &WEIGHTS,
    }];
    let lights =
        find_lights(&scene, &[(deconvolver, planes[0])], &|_| true).expect("a valid scene");
    let gain = deconvolver.noise_gain(&lights[0], &scene, &planes[0], &first, &|_| true);
    let gain = gain.expect("a valid scene");
    let found = others.map(|plate| sharpen(&scene, &plate, deconvolver));
    for (x, y) in [(30, 30), (85, 75), (140, 40), (40, 120), (120, 110)] {
        let (mut sum, mut count) = (0.0, 0.0);
        for row in y - 14..y + 15 {
            for column in x - 14..x + 15 {
                let samples = found
                    .each_ref()
                    .map(|found| f64::from(found[row * WIDTH + column]));
                let mean = samples.iter().sum::<f64>() / 4.0;
                sum += samples.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
                count += 3.0;
            }
        }
        let truth = (sum / count).sqrt() / noise;
        let gain = f64::from(gain[y * WIDTH + x]);
        assert!(
            (gain / truth - 1.0).abs() < 0.4,
            "({x}, {y}): {gain}, should be {truth}"
        );
    }
}

#[test]
fn confidence_falls_with_noise_and_blur() {
    let lens = lens(1.0);
    let scene = scene(&lens);
    let confidence = |noise| remove(&scene, &plate(noise), Deconvolver::default()).confidence;
    let (clear, noisy) = (confidence(0.001), confidence(0.03));
    let (middle, corner) = (75 * WIDTH + 85, 10 * WIDTH + 10);
    for k in [middle, corner] {
        assert!((0.0..=1.0).contains(&clear[k]) && noisy[k] < 0.9 * clear[k]);
    }
    assert!(clear[corner] < 0.8 * clear[middle]);
}

/// Without noise nothing but the solver itself stands between the plate and its sharp image. Light from beyond the plate is
/// unknown, so that its border is left out.
#[test]
fn the_less_noise_the_better() {
    const BORDER: usize = 20;
    let lens = lens(1.0);
    let scene = scene(&lens);
    let inside = |plane: &[f32]| -> Vec<f32> {
        let rows = plane.chunks_exact(WIDTH).take(HEIGHT - BORDER);
        rows.skip(BORDER)
            .flat_map(|row| row[BORDER..WIDTH - BORDER].to_vec())
            .collect()
    };
    let sharp = discs(WIDTH, HEIGHT);
    let gain = |noise: f64| {
        let plate = plate(noise);
        let found = sharpen(&scene, &plate, Deconvolver::default());
        let error = |plane: &[f32]| psnr_db(&inside(plane), &inside(&sharp));
        error(&found) - error(&plate)
    };
    let gains = [0.01, 0.001, 0.0].map(gain);
    assert!(gains.is_sorted() && gains[2] > 25.0, "{gains:?}");
}

/// Film grain is shared by neighbouring pixels: the frequencies that the lens blocks have hardly any of it.
#[test]
fn film_grain_is_not_amplified() {
    let lens = lens(2.0);
    let scene = scene(&lens);
    let sharp = discs(WIDTH, HEIGHT);
    let mut plate = blurred(&scene, &Scatter, &sharp, 0.0);
    let white = NormalDeviates(4).plane(WIDTH * HEIGHT);
    let noise = 0.01;
    for (k, sample) in plate.iter_mut().enumerate() {
        let (x, y) = (k % WIDTH, k / WIDTH);
        let at = |dx: usize, dy: usize| white[(y + dy) % HEIGHT * WIDTH + (x + dx) % WIDTH];
        let row = |dy| at(0, dy) + 2.0 * at(1, dy) + at(2, dy);
        *sample += noise / 6.0 * (row(0) + 2.0 * row(1) + row(2));
    }
    let removed = remove(&scene, &plate, Deconvolver::default());
    let estimate = removed.noise as f32 / noise;
    assert!((1.0..4.0).contains(&estimate), "{estimate}");
    let found = psnr_db(&removed.canvas.crop(&removed.sharp), &sharp);
    let before = psnr_db(&plate, &sharp);
    assert!(found > before + 2.0, "{before} dB before, {found} dB found");
}

#[test]
fn strong_noise_is_not_amplified() {
    let lens = lens(1.0);
    let scene = scene(&lens);
    let sharp = discs(WIDTH, HEIGHT);
    let plate = plate(0.1);
    let found = sharpen(&scene, &plate, Deconvolver::default());
    assert!(psnr_db(&found, &sharp) > psnr_db(&plate, &sharp) + 1.0);
}

#[test]
fn uniform_planes_do_not_change() {
    let lens = lens(1.0);
    for level in [0.0_f32, 0.7, 1.0, 40.0] {
        let uniform = vec![level; WIDTH * HEIGHT];
        let found = remove(&scene(&lens), &uniform, Deconvolver::default());
        assert!(found.sharp.iter().all(|v| *v == level));
    }
}

#[test]
fn bright_lights_cost_less_than_1_db_elsewhere() {
    let lens = lens(1.0);
    let scene = scene(&lens);
    let mut sharp = discs(WIDTH, HEIGHT);
    let gain = |sharp: &[f32]| {
        let plate = blurred(&scene, &Scatter, sharp, 0.002);
        let found = sharpen(&scene, &plate, Deconvolver::default());
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

#[test]
fn result_scales_with_the_exposure_of_the_plate() {
    let lens = lens(1.0);
    let plate = plate(0.004);
    let bright: Vec<f32> = plate.iter().map(|v| 64.0 * v).collect();
    let sharp = |plate: &[f32]| sharpen(&scene(&lens), plate, Deconvolver::default());
    let (one, other) = (sharp(&plate), sharp(&bright));
    let differences = one.iter().zip(&other).map(|(a, b)| (a - b / 64.0).abs());
    assert!(differences.fold(0.0, f32::max) < 1e-3);
}

/// The depth pass is a pixel wrong at the edge, and the plate has no noise.
#[test]
fn detail_away_from_a_wrong_depth_edge_becomes_sharper() {
    let lens = lens(0.8);
    let edge_at = |edge: usize| -> Vec<f32> {
        let columns = (0..WIDTH * HEIGHT).map(|k| k % WIDTH);
        columns.map(|x| if x < edge { -0.4 } else { 1.0 }).collect()
    };
    let with = |vergence| Scene {
        vergence,
        ..scene(&lens)
    };
    let mut deviates = NormalDeviates(11);
    // Dots on one side, and hardly any detail on the other.
    let sharp: Vec<f32> = (0..WIDTH * HEIGHT)
        .map(|k| {
            let is_dot = k % WIDTH < 60 && deviates.unit() < 0.2;
            if is_dot { 0.9 } else { 0.1 }
        })
        .collect();
    let truth = edge_at(90);
    let plate = blurred(&with(VergencePass::PerPixel(&truth)), &Scatter, &sharp, 0.0);
    let pass = edge_at(91);
    let found = sharpen(
        &with(VergencePass::PerPixel(&pass)),
        &plate,
        Deconvolver::default(),
    );
    let window = RenderWindow {
        column: 10,
        row: 10,
        width: 50,
        height: HEIGHT - 20,
    };
    let psnr_db = |plane: &[f32]| psnr_db(&window.cut(WIDTH, plane), &window.cut(WIDTH, &sharp));
    let (before, after) = (psnr_db(&plate), psnr_db(&found));
    assert!(after > before + 6.0, "{before} before, {after} after");
}

#[test]
fn result_is_the_same_on_any_number_of_threads() {
    let lens = lens(1.0);
    let plate = plate(0.01);
    let deconvolver = Deconvolver {
        iterations: 2,
        ..Deconvolver::default()
    };
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().expect("a thread pool");
        pool.install(|| sharpen(&scene(&lens), &plate, deconvolver))
    };
    assert!(with(1) == with(3));
}

#[test]
fn invalid_settings_are_refused_and_progress_can_cancel() {
    let lens = lens(1.0);
    let plate = discs(WIDTH, HEIGHT);
    let planes = [Plane {
        samples: &plate,
        weights: &WEIGHTS,
    }];
    let default = Deconvolver::default();
    let refused = |deconvolver: Deconvolver, go_on: bool| {
        let error = deconvolver.remove(&scene(&lens), &planes, &|_| go_on);
        error.expect_err("refused").to_string()
    };
    let noise = Some(f64::NAN);
    assert!(refused(Deconvolver { noise, ..default }, true).contains("noise"));
    let saturation = Saturation::Level(f64::INFINITY);
    assert!(
        refused(
            Deconvolver {
                saturation,
                ..default
            },
            true
        )
        .contains("saturation")
    );
    assert_eq!(refused(default, false), cancelled().to_string());
}
