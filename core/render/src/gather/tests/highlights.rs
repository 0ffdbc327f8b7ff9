//! Plates with small lights far brighter than the rest: their pictures against the exact renderer's.

use super::{HEIGHT, TestLens, WIDTH, lens, plate, render, scene};
use crate::Gather;
use crate::{Displacement, Edges, Scatter, Scene};
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

/// The largest difference over the largest value, about each light.
fn apart(found: &[Vec<f32>], exact: &[Vec<f32>]) -> f32 {
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
fn lights_are_right_to_their_own_peak() {
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
                let found = apart(&render(&Gather::default(), &scene, &samples), &exact);
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

/// [`Pupil`] with a kernel of its own for every pixel: the exact renderer lets neighbours share them.
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

/// On black nothing is left for the fast way.
#[test]
fn lights_on_black_are_exact() {
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
            let found = apart(&render(&Gather::default(), &scene, &samples), &exact);
            assert!(found < 1e-6, "{} {displacement:?}: {found}", model.id());
        }
    }
}

/// What a plate gains by lights is what the exact renderer makes of them.
#[test]
fn lights_drawn_ray_by_ray_are_exact_on_a_plate() {
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
    let found = apart(&gained, &exact);
    assert!(found < 1e-5, "{found}");
}

#[test]
fn threads_change_nothing_about_lights() {
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
