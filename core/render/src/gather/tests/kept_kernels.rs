//! Kernels kept from one render to the next: they change no result, and no other lens uses them.

use super::sparse::shapes;
use super::*;
use crate::gather::KernelStore;
use crate::gather::stencil::Stencil;
use crate::scatter::{Source, Sources};
use seidel_optics::psf::KernelRows;

fn rays(sigma_px: f64) -> TestLens {
    TestLens {
        rays: true,
        ..lens(sigma_px)
    }
}

#[test]
fn kept_kernels_change_no_result() {
    let store = KernelStore::default();
    // Gathered and scattered light, of one lens and of another.
    for sigma_px in [6.0, 12.0, 6.0] {
        let lens = rays(sigma_px);
        let scene = scene(&lens, &Pupil);
        for samples in [plate(3), shapes(WIDTH, HEIGHT), plate(4)] {
            for quality in [Quality::Draft, Quality::Final] {
                let with = |kernels| render(&Gather { quality, kernels }, &scene, &samples);
                store.begin_render();
                assert_eq!(with(Some(&store)), with(None), "{sigma_px} {quality:?}");
            }
        }
    }
}

#[test]
fn a_second_render_draws_nothing_new() {
    let store = KernelStore::default();
    let lens = rays(8.0);
    let scene = scene(&lens, &Pupil);
    let gather = Gather {
        quality: Quality::Final,
        kernels: Some(&store),
    };
    let sizes = [plate(3), plate(4)].map(|samples| {
        store.begin_render();
        render(&gather, &scene, &samples);
        store.bytes()
    });
    assert!(sizes[0] > 0);
    assert_eq!(sizes[0], sizes[1]);
}

/// The kernels of this blur hold millions of weights, of which a few thousand land on the plate.
#[test]
fn a_blur_much_wider_than_the_plate_is_drawn_where_it_lands() {
    let lens = TestLens {
        centre: 1.0,
        ..rays(350.0)
    };
    let (width, height) = (48, 32);
    let scene = Scene {
        width,
        height,
        edges: Edges::Black,
        ..scene(&lens, &Pupil)
    };
    let mut light = vec![0.0; width * height];
    // More pixels than count as a highlight, which would be drawn exactly.
    for row in light.chunks_exact_mut(width).skip(9).take(5) {
        row[3..11].fill(1e5);
    }
    let store = KernelStore::default();
    let with = |kernels| {
        let quality = Quality::Draft;
        render(&Gather { quality, kernels }, &scene, &light)
    };
    let found = with(Some(&store));
    assert_eq!(found, with(None));
    // A whole kernel takes 15 MB, which the store does not keep.
    assert!((1..32 << 20).contains(&store.bytes()), "{}", store.bytes());
    let exact = render(&Scatter, &scene, &light);
    for (found, exact) in found.iter().flatten().zip(exact.iter().flatten()) {
        assert!((found - exact).abs() < 0.02 * exact, "{found} {exact}");
    }
}

#[test]
fn kernels_opposite_across_the_axes_are_mirror_images() {
    let lens = rays(8.0);
    let scene = scene(&lens, &Pupil);
    let sources = Sources::new(&scene);
    let (axis, map) = (lens.frame().axis(), scene.map);
    let centre =
        [axis.x_px - map.origin.x_px, axis.y_px - map.origin.y_px].map(|px| px * map.scale);
    let drawn = |source: &Source| {
        let mut rows = KernelRows::default();
        Pupil.draw_interpolated_rows(&source.blur, source.shift_px, None, &mut rows);
        Stencil::from_kernel(&rows, None)
    };
    for (x, y) in [(16.0, 8.0), (24.0, 32.0), (0.0, 16.0)] {
        let places = [(x, y), (-x, y), (x, -y), (-x, -y)];
        let found = places.map(|(x, y)| {
            let at = (centre[0] + x, centre[1] + y);
            let mut found = Vec::new();
            sources
                .at(at, 0.0, |_| true, &mut found)
                .expect("a sound lens");
            found.swap_remove(1).expect("a used channel")
        });
        let (first, _) = found[0].unmirrored();
        for source in &found {
            let (one, along) = source.unmirrored();
            assert_eq!(one.blur.pupil, first.blur.pupil);
            assert_eq!(one.shift_px, first.shift_px);
            let (direct, mirrored) = (drawn(source), drawn(&one).mirrored_along(along));
            let apart = Stencil::weighted_sum(&[(&direct, 1.0), (&mirrored, -1.0)]);
            let apart: f32 = apart.weights.iter().map(|w| w.abs()).sum();
            assert!(apart < 1e-3, "({x}, {y}), {along:?}: {apart:e}");
        }
    }
}
