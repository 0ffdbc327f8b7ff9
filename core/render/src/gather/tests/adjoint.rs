//! The operator and its adjoint: <A x, y> = <x, A^T y> on random fields.

use super::{TestLens, lens, plate_of, render, scene};
use crate::{Edges, Gather, Operator, Quality, Scene};
use seidel_optics::psf::{Gaussian, PsfModel, Pupil, SkewNormal};

/// Independent values of either sign.
fn noise(seed: u32, count: usize) -> Vec<f32> {
    let mut state = u64::from(seed) * 2 + 1;
    let mut next = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 40) as f32 / (1 << 23) as f32 - 1.0
    };
    (0..count).map(|_| next()).collect()
}

fn dot(a: &[Vec<f32>], b: &[Vec<f32>]) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
}

fn norm(a: &[Vec<f32>]) -> f64 {
    dot(a, a).sqrt()
}

fn weights() -> Vec<Vec<f64>> {
    vec![vec![0.0, 0.0, 1.0], vec![1.0 / 3.0; 3]]
}

#[test]
fn the_adjoint_satisfies_its_definition() {
    let models: [(&dyn PsfModel, f64, bool); 4] = [
        (&Gaussian, 2.0, false),
        (&SkewNormal, 7.0, false),
        (&Gaussian, 24.0, false),
        (&Pupil, 9.0, true),
    ];
    for (model, sigma, rays) in models {
        for edges in [Edges::Mirror, Edges::Black] {
            // Levels divide the second size: light is folded back before it is upsampled.
            for (width, height) in [(150, 110), (152, 104)] {
                let lens = TestLens {
                    rays,
                    ..lens(sigma)
                };
                let scene = Scene {
                    width,
                    height,
                    edges,
                    ..scene(&lens, model)
                };
                let operator =
                    Operator::new(&scene, &weights(), Quality::Final).expect("a sound scene");
                let count = width * height;
                for seed in [1, 2] {
                    let x = vec![noise(seed, count), noise(seed + 10, count)];
                    let y = vec![noise(seed + 20, count), noise(seed + 30, count)];
                    let forward = operator.apply(&x).expect("planes");
                    let back = operator.adjoint(&y).expect("planes");
                    let (left, right) = (dot(&forward, &y), dot(&x, &back));
                    let scale = norm(&forward) * norm(&y);
                    assert!(
                        (left - right).abs() < 1e-6 * scale,
                        "{} {sigma} {edges:?} {width}: {left} {right}, {scale}",
                        model.id()
                    );
                }
                // Light of one sign, where nothing cancels.
                let x = vec![plate_of(3, width, height), plate_of(4, width, height)];
                let (forward, back) = (operator.apply(&x), operator.adjoint(&x));
                let (forward, back) = (forward.expect("planes"), back.expect("planes"));
                let (left, right) = (dot(&forward, &x), dot(&x, &back));
                assert!(
                    (left / right - 1.0).abs() < 1e-6,
                    "{} {sigma} {edges:?} {width}: {left} {right}",
                    model.id()
                );
            }
        }
    }
}

/// Without highlights the operator equals the fast renderer.
#[test]
fn the_operator_equals_the_renderer() {
    let lens = lens(6.0);
    let scene = scene(&lens, &SkewNormal);
    let samples = plate_of(8, scene.width, scene.height);
    let rendered = render(&Gather::default(), &scene, &samples);
    let weights: Vec<Vec<f64>> = super::WEIGHTS.iter().map(|w| w.to_vec()).collect();
    let operator = Operator::new(&scene, &weights, Quality::Final).expect("a sound scene");
    let applied = operator.apply(&[samples.clone(), samples]).expect("planes");
    assert!(applied == rendered);
}

#[test]
fn wrong_planes_are_refused() {
    let lens = lens(3.0);
    let scene = scene(&lens, &Gaussian);
    let operator = Operator::new(&scene, &weights(), Quality::Draft).expect("a sound scene");
    let short = vec![vec![0.0; 3]; 2];
    assert!(operator.apply(&short).is_err() && operator.adjoint(&short).is_err());
    let one = vec![vec![0.0; operator.pixel_count()]];
    assert!(operator.apply(&one).is_err() && operator.adjoint(&one).is_err());
}

#[test]
fn plates_too_small_for_a_grid_have_an_adjoint() {
    let lens = lens(3.0);
    for (width, height) in [(1, 1), (3, 2), (1, 40), (13, 7)] {
        for edges in [Edges::Mirror, Edges::Black] {
            let scene = Scene {
                width,
                height,
                edges,
                ..scene(&lens, &Gaussian)
            };
            let operator = Operator::new(&scene, &weights(), Quality::Final).expect("sound");
            let count = width * height;
            let x = vec![noise(1, count), noise(2, count)];
            let y = vec![noise(3, count), noise(4, count)];
            let (forward, back) = (operator.apply(&x), operator.adjoint(&y));
            let (forward, back) = (forward.expect("planes"), back.expect("planes"));
            let apart = (dot(&forward, &y) - dot(&x, &back)).abs();
            assert!(
                apart < 1e-6 * norm(&x) * norm(&y),
                "{width} {height}: {apart}"
            );
        }
    }
}

/// Only the part of the kernels that lands on the plate is computed.
#[test]
fn a_blur_much_wider_than_the_plate_has_an_adjoint() {
    let lens = TestLens {
        rays: true,
        centre: 1.0,
        ..lens(300.0)
    };
    let (width, height) = (48, 40);
    let scene = Scene {
        width,
        height,
        edges: Edges::Black,
        ..scene(&lens, &Pupil)
    };
    let weights = super::WEIGHTS.map(|w| w.to_vec());
    let operator = Operator::new(&scene, &weights, Quality::Final).expect("a sound scene");
    let mut light = vec![0.0; width * height];
    (light[0], light[900]) = (2e6, 1e6);
    let blurred = operator
        .apply(&[light.clone(), light.clone()])
        .expect("planes");
    let exact = render(&crate::Scatter, &scene, &light);
    for (found, exact) in blurred.iter().flatten().zip(exact.iter().flatten()) {
        assert!((found - exact).abs() < 0.02 * exact, "{found} {exact}");
    }
    let y = vec![noise(3, light.len()), noise(4, light.len())];
    let back = operator.adjoint(&y).expect("planes");
    let apart = (dot(&blurred, &y) - dot(&[light.clone(), light], &back)).abs();
    assert!(apart < 1e-6 * norm(&blurred) * norm(&y), "{apart}");
}
