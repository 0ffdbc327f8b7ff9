//! Plates that are mostly black: their light is scattered tile by tile.

use super::windows::windows_are_parts;
use super::*;

/// Returns bright shapes on black: a disc in the middle, a bar across a corner, a strip along an edge.
pub(super) fn shapes(width: usize, height: usize) -> Vec<f32> {
    let (w, h) = (width as f64, height as f64);
    (0..width * height)
        .map(|index| {
            let (x, y) = ((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
            let disc = (x - 0.55 * w).hypot(y - 0.4 * h) < 11.0;
            let bar = (x + y - 40.0).abs() < 3.0;
            let strip = x > w - 4.0 && (y / h - 0.7).abs() < 0.1;
            let light = 0.4 + 0.3 * (0.4 * x).sin() * (0.3 * y).cos();
            if disc || bar || strip {
                light as f32
            } else {
                0.0
            }
        })
        .collect()
}

/// Returns the PSNR of shapes on a plate of this size, dB.
fn decibels(lens: &TestLens, model: &dyn PsfModel, size: (usize, usize), edges: Edges) -> f64 {
    let scene = Scene {
        width: size.0,
        height: size.1,
        edges,
        ..scene(lens, model)
    };
    let samples = shapes(size.0, size.1);
    let fast = render(&Gather::default(), &scene, &samples);
    psnr_db(&fast, &render(&Scatter, &scene, &samples))
}

#[test]
fn shapes_on_black_meet_the_stated_psnr() {
    for edges in [Edges::Mirror, Edges::Black] {
        // Whole levels, an odd size, and blur from the finest level to the third.
        for size in [(192, 160), (187, 149)] {
            for (sigma, at_least) in [(2.0, 75.0), (8.0, 60.0), (24.0, 60.0)] {
                let found = decibels(&lens(sigma), &SkewNormal, size, edges);
                assert!(found > at_least, "{sigma} px, {size:?}, {edges:?}: {found}");
            }
        }
        let rays = TestLens {
            rays: true,
            ..lens(12.0)
        };
        let found = decibels(&rays, &Pupil, (192, 160), edges);
        assert!(found > 50.0, "rays, {edges:?}: {found}");
    }
}

#[test]
fn windows_of_sparse_plates_are_parts() {
    let (lens, samples) = (lens(6.0), shapes(WIDTH, HEIGHT));
    for edges in [Edges::Mirror, Edges::Black] {
        let scene = Scene {
            edges,
            ..scene(&lens, &SkewNormal)
        };
        assert!(windows_are_parts(
            &Gather::default(),
            &scene,
            [&samples, &samples]
        ));
    }
}

#[test]
fn scattered_light_does_not_depend_on_threads() {
    let (lens, samples) = (lens(6.0), shapes(WIDTH, HEIGHT));
    let scene = scene(&lens, &SkewNormal);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a thread pool")
            .install(|| render(&Gather::default(), &scene, &samples))
    };
    assert_eq!(with(1), with(3));
}
