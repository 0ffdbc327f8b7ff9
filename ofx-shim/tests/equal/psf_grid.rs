//! The output PSF Grid.

use seidel_c::{SEIDEL_EDGES_BLACK, SEIDEL_QUALITY_EXACT};

use crate::rig::Rig;
use crate::{Picture, WHOLE};

/// Columns and rows of the grid, pixels from one point to the next, and the first point.
const SIZE: (i32, i32) = (7, 5);
const STEP: i32 = 8;
const FIRST: (i32, i32) = (4, 3);

#[test]
fn the_psf_grid_shows_blurred_points() {
    let mut rig = Rig::new();
    rig.host.set("lensScale", 2.0);
    rig.host.set("distance", 2.0);
    rig.host.choose("output", "PSF Grid");
    let settings = &mut rig.abi.settings;
    settings.lens_scale = 2.0;
    settings.distance = 2.0;
    settings.quality = SEIDEL_QUALITY_EXACT;
    // Mirrored points would add light from beyond the frame.
    settings.edges = SEIDEL_EDGES_BLACK;
    let mut expected = Picture::new(WHOLE, 4, |_, _, c| f32::from(u8::from(c == 3)));
    for k in 0..SIZE.0 * SIZE.1 {
        let at = (FIRST.0 + STEP * (k % SIZE.0), FIRST.1 + STEP * (k / SIZE.0));
        // One point per plate, because the renderer may share a kernel between neighbours.
        let point = Picture::new(WHOLE, 4, |x, y, _| f32::from(u8::from((x, y) == at)));
        add_scaled_to_peak(&mut expected, &rig.abi.apply(&point, WHOLE));
    }
    let difference = rig.rendered().max_difference(&expected);
    assert!(difference < 1e-5, "{difference}");
}

/// Adds the colours of `drawn` over the largest of them to `sum`.
fn add_scaled_to_peak(sum: &mut Picture, drawn: &Picture) {
    let colours = || (0..drawn.samples.len()).filter(|k| k % 4 != 3);
    let peak = colours().map(|k| drawn.samples[k]).fold(0.0, f32::max);
    assert!(peak > 0.0 && peak < 0.6, "it blurs: {peak}");
    for k in colours() {
        sum.samples[k] += drawn.samples[k] / peak;
    }
}
