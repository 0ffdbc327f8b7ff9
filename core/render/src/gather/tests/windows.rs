//! Windows of a plate against the whole, to the bit.

use super::{HEIGHT, WIDTH, lens, plate, scene};
use crate::{Edges, Gather, Plane, Quality, RenderWindow, Renderer, Scatter, Scene};
use seidel_optics::psf::{Gaussian, PsfModel, Pupil, SkewNormal};

const WEIGHTS: [[f64; 3]; 2] = [[0.0, 0.0, 1.0], [0.5, 0.5, 0.0]];

/// Returns whether several windows equal the same part of the whole to the bit.
pub(super) fn windows_are_parts(
    renderer: &dyn Renderer,
    scene: &Scene,
    plates: [&[f32]; 2],
) -> bool {
    let planes: Vec<Plane> = plates
        .iter()
        .zip(&WEIGHTS)
        .map(|(samples, weights)| Plane { samples, weights })
        .collect();
    let whole = renderer.render(scene, &planes, &|_| true);
    let whole = whole.expect("sound").planes;
    let (w, h) = (scene.width, scene.height);
    let windows = [
        (0, 0, w, h),
        (0, 0, 40, 30),
        (w - 37, h - 29, 37, 29),
        (31, 17, 64, 64),
        (w / 2, 0, 1, h),
        (5, h - 1, w - 9, 1),
    ];
    windows.into_iter().all(|(column, row, width, height)| {
        let window = RenderWindow {
            column,
            row,
            width,
            height,
        };
        let part = renderer.render_window(scene, &planes, window, &|_| true);
        let part = part.expect("sound").planes;
        part.iter().zip(&whole).all(|(part, whole)| {
            let rows = part.chunks_exact(width).zip(row..);
            part.len() == width * height
                && rows.into_iter().all(|(line, y)| {
                    let expected = &whole[y * w + column..][..width];
                    line.iter()
                        .zip(expected)
                        .all(|(a, b)| a.to_bits() == b.to_bits())
                })
        })
    })
}

#[test]
pub(super) fn windows_are_parts_of_the_whole() {
    let mut lit = plate(3);
    // Highlights are scattered separately.
    for at in [41 * WIDTH + 60, WIDTH - 1] {
        lit[at] = 1e4;
    }
    let plates = [&lit[..], &plate(8)];
    for sigma in [1.6, 9.0, 30.0] {
        for edges in [Edges::Mirror, Edges::Black] {
            for (model, rays) in [
                (&Gaussian as &dyn PsfModel, false),
                (&SkewNormal, false),
                (&Pupil, true),
            ] {
                let mut lens = lens(if rays { sigma / 2.0 } else { sigma });
                lens.rays = rays;
                // In focus near the centre of the field: several levels at once.
                lens.centre = 0.05;
                let scene = Scene {
                    edges,
                    ..scene(&lens, model)
                };
                let gather = Gather {
                    quality: Quality::Final,
                    kernels: None,
                };
                assert!(
                    windows_are_parts(&gather, &scene, plates),
                    "{} {sigma} {edges:?}",
                    model.id()
                );
            }
        }
    }
}

/// Mirrored light is folded back at coarse levels where sizes allow it.
#[test]
fn windows_of_plates_folded_early_are_parts_too() {
    let (width, height) = (128, 96);
    let lens = lens(30.0);
    let scene = Scene {
        width,
        height,
        ..scene(&lens, &Gaussian)
    };
    let samples = &plate(5)[..width * height];
    assert!(windows_are_parts(
        &Gather::default(),
        &scene,
        [samples, samples]
    ));
}

#[test]
fn the_exact_renderer_cuts_windows_and_invalid_ones_are_refused() {
    let lens = lens(2.0);
    let scene = scene(&lens, &Gaussian);
    let plates = [&plate(1)[..], &plate(2)];
    assert!(windows_are_parts(&Scatter, &scene, plates));
    for (column, width) in [(0, 0), (WIDTH - 3, 4), (usize::MAX, 2)] {
        let window = RenderWindow {
            column,
            row: 0,
            width,
            height: HEIGHT,
        };
        for renderer in [&Scatter as &dyn Renderer, &Gather::default()] {
            let refused = renderer.render_window(&scene, &[], window, &|_| true);
            assert_eq!(refused.expect_err("refused").place, "window");
        }
    }
}
