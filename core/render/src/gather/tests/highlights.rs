//! Plates with small highlights, against the exact renderer.

use super::{HEIGHT, TestLens, WIDTH, lens, plate, render, scene};
use crate::{Displacement, Edges, Gather, Scatter, Scene};
use seidel_optics::psf::{
    Gaussian, KernelBounds, KernelRows, LocalBlur, PsfModel, Pupil, SampleGrid, SkewNormal,
};

/// Column, row and side of lights, far from one another.
const LIGHTS: [(usize, usize, usize); 4] = [(31, 31, 2), (120, 20, 1), (75, 80, 1), (10, 104, 2)];
const LIGHT: f32 = 1e4;

fn with_lights(mut samples: Vec<f32>) -> Vec<f32> {
    for (column, row, side) in LIGHTS {
        for y in row..row + side {
            samples[y * WIDTH + column..][..side].fill(LIGHT);
        }
    }
    samples
}

/// Returns the largest difference around any light, relative to the largest value there.
fn relative_error(found: &[Vec<f32>], exact: &[Vec<f32>]) -> f32 {
    let (mut worst, room) = (0.0_f32, 12);
    for (found, exact) in found.iter().zip(exact) {
        for (column, row, _) in LIGHTS {
            let (mut most, mut error) = (0.0_f32, 0.0_f32);
            for y in row.saturating_sub(room)..(row + room).min(HEIGHT) {
                for x in column.saturating_sub(room)..(column + room).min(WIDTH) {
                    let (found, exact) = (found[y * WIDTH + x], exact[y * WIDTH + x]);
                    most = most.max(exact);
                    error = error.max((found - exact).abs());
                }
            }
            worst = worst.max(error / most);
        }
    }
    worst
}

#[test]
fn highlights_are_accurate_relative_to_their_peak() {
    let samples = with_lights(plate(6));
    for sigma in [3.0, 12.0] {
        for model in [&Gaussian as &dyn PsfModel, &SkewNormal] {
            for edges in [Edges::Mirror, Edges::Black] {
                let lens = lens(sigma);
                let scene = Scene {
                    edges,
                    ..scene(&lens, model)
                };
                let exact = render(&Scatter, &scene, &samples);
                let found = relative_error(&render(&Gather::default(), &scene, &samples), &exact);
                assert!(found < 1e-4, "{} {sigma} {edges:?}: {found}", model.id());
            }
        }
    }
}

fn rays(sigma: f64) -> TestLens {
    TestLens {
        rays: true,
        ..lens(sigma)
    }
}

/// [`Pupil`] without kernels shared by neighbours.
struct Unshared;

impl PsfModel for Unshared {
    fn id(&self) -> &'static str {
        "unshared"
    }

    fn needs_rays(&self) -> bool {
        true
    }

    fn kernel_bounds(&self, blur: &LocalBlur) -> KernelBounds {
        Pupil.kernel_bounds(blur)
    }

    fn sample(&self, blur: &LocalBlur, window: &SampleGrid, out: &mut [f64]) {
        Pupil.sample(blur, window, out);
    }

    fn sample_f32(&self, blur: &LocalBlur, window: &SampleGrid, out: &mut [f32]) {
        Pupil.sample_f32(blur, window, out);
    }

    fn draw_rows(&self, blur: &LocalBlur, shift_px: (f64, f64), rows: &mut KernelRows) {
        Pupil.draw_rows(blur, shift_px, rows);
    }
}

/// On black the fast renderer has nothing left to gather.
#[test]
fn highlights_on_black_are_exact() {
    let samples = with_lights(vec![0.0; WIDTH * HEIGHT]);
    for (lens, model) in [
        (rays(6.0), &Unshared as &dyn PsfModel),
        (lens(6.0), &SkewNormal),
    ] {
        for displacement in [Displacement::None, Displacement::Full] {
            let scene = Scene {
                displacement,
                ..scene(&lens, model)
            };
            let exact = render(&Scatter, &scene, &samples);
            let found = relative_error(&render(&Gather::default(), &scene, &samples), &exact);
            assert!(found < 1e-6, "{} {displacement:?}: {found}", model.id());
        }
    }
}

/// The light added by highlights equals their exact render.
#[test]
fn ray_traced_highlights_are_exact_on_a_plate() {
    let lens = rays(6.0);
    let scene = scene(&lens, &Unshared);
    let dark = plate(7).iter().map(|v| 0.4 * v).collect::<Vec<_>>();
    let lit = with_lights(dark.clone());
    let alone: Vec<f32> = lit.iter().zip(&dark).map(|(a, b)| a - b).collect();
    let exact = render(&Scatter, &scene, &alone);
    let of = |samples: &[f32]| render(&Gather::default(), &scene, samples);
    let gained: Vec<Vec<f32>> = of(&lit)
        .iter()
        .zip(of(&dark))
        .map(|(lit, dark)| lit.iter().zip(dark).map(|(a, b)| a - b).collect())
        .collect();
    let found = relative_error(&gained, &exact);
    assert!(found < 1e-5, "{found}");
}

#[test]
fn highlights_do_not_depend_on_threads() {
    let lens = lens(9.0);
    let scene = scene(&lens, &SkewNormal);
    let samples = with_lights(plate(8));
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().expect("a pool");
        pool.install(|| render(&Gather::default(), &scene, &samples))
    };
    let (one, four) = (with(1), with(4));
    assert_eq!(one, four);
}
