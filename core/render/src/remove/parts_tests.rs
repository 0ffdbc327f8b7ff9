//! The parts that removal is made of.

use super::canvas::Canvas;
use super::noise;
use super::prior::{Slopes, response};
use super::test_scenes::{Deviates, HEIGHT, WEIGHTS, WIDTH, discs, lens, plate, scene};
use super::view::{Care, View};
use crate::{Scene, VergencePass};

fn noisy_plane(chance: &mut Deviates, count: usize) -> Vec<f32> {
    (0..count).map(|_| chance.next() as f32).collect()
}

#[test]
fn noise_is_told_from_the_plate() {
    let lens = lens(1.0);
    let scene = scene(&lens);
    let canvas = Canvas::of(&scene);
    let view = View::new(&scene, &canvas, &WEIGHTS).expect("a lens");
    for noise in [0.001, 0.01, 0.03] {
        let told = noise::deviation(&plate(noise), &canvas, &view);
        assert!((told / noise - 1.0).abs() < 0.06, "{noise}: {told}");
    }
}

#[test]
fn squares_put_together_are_the_plane() {
    let lens = lens(1.0);
    let scene = scene(&lens);
    let canvas = Canvas::of(&scene);
    let view = View::new(&scene, &canvas, &WEIGHTS).expect("a lens");
    let plane = canvas.mirrored(&discs(WIDTH, HEIGHT));
    let same = view.filtered(&plane, |_, _| 1.0.into()).expect("a plane");
    let apart = plane.iter().zip(&same).map(|(a, b)| (a - b).abs());
    assert!(apart.fold(0.0, f32::max) < 1e-5);
    let ones = view.mean_over_waves(|_, _| 1.0).expect("a plane");
    assert!(ones.iter().all(|v| (v - 1.0).abs() < 1e-5));
}

/// With one layer and with several.
#[test]
fn views_are_turned_round_by_their_adjoint() {
    let lens = lens(1.0);
    let pass: Vec<f32> = (0..WIDTH * HEIGHT)
        .map(|k| {
            if k % WIDTH < 60 {
                1.0
            } else {
                0.004 * (k / WIDTH) as f32
            }
        })
        .collect();
    let flat = scene(&lens);
    let deep = Scene {
        vergence: VergencePass::PerPixel(&pass),
        ..scene(&lens)
    };
    let mut chance = Deviates(3);
    for scene in [flat, deep] {
        let canvas = Canvas::of(&scene);
        let view = View::new(&scene, &canvas, &WEIGHTS).expect("a lens");
        let count = canvas.size().0 * canvas.size().1;
        let (x, y) = (
            noisy_plane(&mut chance, count),
            noisy_plane(&mut chance, count),
        );
        let seen = view.blurred(&x, Care::Quick).expect("a plane");
        let back = view.adjoint(y.clone()).expect("a plane");
        let dot = |a: &[f32], b: &[f32]| {
            let pairs = a.iter().zip(b);
            pairs
                .map(|(a, b)| f64::from(*a) * f64::from(*b))
                .sum::<f64>()
        };
        let scale = (dot(&seen, &seen) * dot(&y, &y)).sqrt();
        assert!((dot(&seen, &y) - dot(&x, &back)).abs() < 1e-5 * scale);
    }
}

/// Near and far meet at an edge: even light stays even there.
#[test]
fn views_keep_even_light_even() {
    let lens = lens(1.0);
    let pass: Vec<f32> = (0..WIDTH * HEIGHT)
        .map(|k| if k % WIDTH < 60 { 1.0 } else { 0.0 })
        .collect();
    let scene = Scene {
        vergence: VergencePass::PerPixel(&pass),
        ..scene(&lens)
    };
    let canvas = Canvas::of(&scene);
    let view = View::new(&scene, &canvas, &WEIGHTS).expect("a lens");
    let even = vec![0.7; canvas.size().0 * canvas.size().1];
    let seen = canvas.cropped(&view.blurred(&even, Care::Exact).expect("a plane"));
    assert!(seen.iter().all(|v| (v - 0.7).abs() < 1e-4));
}

#[test]
fn slopes_are_gathered_by_their_adjoint() {
    let mut chance = Deviates(3);
    let count = WIDTH * HEIGHT;
    let (x, y) = (
        noisy_plane(&mut chance, count),
        noisy_plane(&mut chance, count),
    );
    let (of_x, of_y) = (Slopes::of(&x, WIDTH), Slopes::of(&y, WIDTH));
    let pairs = x.iter().zip(of_y.gathered());
    let back: f64 = pairs.map(|(a, b)| f64::from(*a) * f64::from(b)).sum();
    let scale = (of_x.dot(&of_x) * of_y.dot(&of_y)).sqrt();
    assert!((of_x.dot(&of_y) - back).abs() < 1e-6 * scale);
}

/// D^T D of a wave is the wave, as much stronger as told.
#[test]
fn waves_have_the_slopes_told() {
    let (u, v) = (0.11, 0.23);
    let turn = |k: usize| std::f64::consts::TAU * (u * (k % WIDTH) as f64 + v * (k / WIDTH) as f64);
    let wave: Vec<f32> = (0..WIDTH * HEIGHT).map(|k| turn(k).cos() as f32).collect();
    let found = Slopes::of(&wave, WIDTH).gathered();
    let at = 70 * WIDTH + 80;
    for k in at..at + 9 {
        let wanted = response(u, v) * f64::from(wave[k]);
        assert!((f64::from(found[k]) - wanted).abs() < 1e-4, "{k}");
    }
}

#[test]
fn canvases_hold_the_plate_and_what_is_about_it() {
    let lens = lens(1.0);
    let scene = scene(&lens);
    let canvas = Canvas::of(&scene);
    assert!(
        canvas.margin_x > 3 && canvas.margin_x < WIDTH / 2,
        "{canvas:?}"
    );
    let plane: Vec<f32> = (0..WIDTH * HEIGHT).map(|k| k as f32).collect();
    let mirrored = canvas.mirrored(&plane);
    assert!(canvas.cropped(&mirrored) == plane);
    let row = canvas.margin_y * canvas.size().0;
    assert_eq!(mirrored[row + canvas.margin_x - 2], 1.0);
    assert_eq!(canvas.extended(&plane)[row + canvas.margin_x - 2], 0.0);
}
