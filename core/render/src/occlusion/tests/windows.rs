//! Windows of plates in depth, against the whole.

use super::*;
use crate::{Gather, Quality};

const WIDTH: usize = 288;
const HEIGHT: usize = 176;

/// Returns vergences: a slanted floor, cards in front of and behind it.
fn vergences() -> Vec<f32> {
    let at = |x: usize, y: usize| {
        let card = (x / 40 + y / 33) % 5;
        match card {
            0 => 0.95,
            1 => 0.3,
            _ => 0.35 + 0.3 * y as f32 / HEIGHT as f32,
        }
    };
    (0..WIDTH * HEIGHT)
        .map(|k| at(k % WIDTH, k / WIDTH))
        .collect()
}

fn light() -> Vec<f32> {
    let mut light: Vec<f32> = (0..WIDTH * HEIGHT)
        .map(|k| ((k * 7919) % 101) as f32 / 100.0)
        .collect();
    // Lamps, alone and in a crowd, some of them behind an edge.
    for (x, y) in [
        (37, 30),
        (150, 90),
        (151, 90),
        (152, 91),
        (153, 92),
        (155, 90),
        (260, 160),
    ] {
        light[y * WIDTH + x] = 800.0;
    }
    light
}

#[test]
fn windows_are_parts_of_the_whole() {
    let (pass, light) = (vergences(), light());
    let matte: Vec<f32> = (0..light.len()).map(|k| (k % 3) as f32 / 4.0).collect();
    let planes = [plane(&light, RED), plane(&light, ALPHA)];
    let fast = Gather {
        quality: Quality::Final,
        kernels: None,
    };
    let held_out = Occlusion {
        holdout: Some(Holdout {
            matte: &matte,
            vergence: Some(VergencePass::Constant(0.6)),
        }),
        ..Occlusion::default()
    };
    let windows = [[0, 0, 60, 50], [140, 80, 33, 47], [280, 3, 8, 173]];
    for vergence in [VergencePass::PerPixel(&pass), VergencePass::Constant(0.7)] {
        for edges in [Edges::Mirror, Edges::Black] {
            let scene = Scene {
                width: WIDTH,
                height: HEIGHT,
                edges,
                ..scene(&EVEN, vergence)
            };
            for (inner, settings) in [
                (&Scatter as &dyn Renderer, Occlusion::default()),
                (&fast, Occlusion::default()),
                (&fast, held_out),
            ] {
                let layered = LayeredRenderer { inner, settings };
                let whole = layered.render(&scene, &planes, &|_| true);
                let whole = whole.expect("a valid scene").planes;
                for [column, row, width, height] in windows {
                    let window = RenderWindow {
                        column,
                        row,
                        width,
                        height,
                    };
                    let part = layered.render_window(&scene, &planes, window, &|_| true);
                    let part = part.expect("a valid window").planes;
                    for (part, whole) in part.iter().zip(&whole) {
                        let expected = window.cut(WIDTH, whole);
                        let difference = largest_difference(part, &expected);
                        assert_eq!(part.len(), expected.len());
                        assert!(
                            difference == 0.0,
                            "{}, {window:?}: {difference:e}",
                            inner.id()
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn crops_of_a_plate_have_its_lights_and_hidden_samples() {
    const FIRST: [usize; 2] = [13, 21];
    let (pass, light) = (vergences(), light());
    let whole = Scene {
        width: WIDTH,
        height: HEIGHT,
        ..scene(&EVEN, VergencePass::PerPixel(&pass))
    };
    let window = RenderWindow {
        column: FIRST[0],
        row: FIRST[1],
        width: WIDTH - FIRST[0],
        height: HEIGHT - FIRST[1],
    };
    let cut = [&pass, &light].map(|samples| window.cut(WIDTH, samples));
    let crop = Scene {
        width: window.width,
        height: window.height,
        map: whole.map.moved(FIRST[0] as f64, FIRST[1] as f64),
        ..scene(&EVEN, VergencePass::PerPixel(&cut[0]))
    };
    let of_whole = render(Occlusion::default(), &whole, &[plane(&light, RED)]).swap_remove(0);
    let of_crop = render(Occlusion::default(), &crop, &[plane(&cut[1], RED)]).swap_remove(0);
    // Away from the borders that the crop adds.
    let inside = |first: [usize; 2]| RenderWindow {
        column: 120 - first[0],
        row: 80 - first[1],
        width: WIDTH - 120,
        height: HEIGHT - 80,
    };
    let expected = inside([0, 0]).cut(WIDTH, &of_whole);
    let difference = largest_difference(&inside(FIRST).cut(window.width, &of_crop), &expected);
    assert!(difference < 1e-4, "{difference:e}");
}
