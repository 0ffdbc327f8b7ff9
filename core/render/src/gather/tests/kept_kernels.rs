//! Kernels kept from one render to the next: they change no result, and no other lens uses them.

use super::sparse::shapes;
use super::*;
use crate::gather::KernelStore;

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
