//! How far light goes from its source.

use crate::{Displacement, Scene, VergencePass, Window};
use seidel_optics::psf::KernelBounds;

/// Room about the light beyond what kernels at a few places need: kernels between may be larger.
const SPARE_SHARE: f64 = 0.1;
const SPARE_PX: f64 = 4.0;

/// Vergences at which a depth pass is tried, from its least to its largest.
const TRIED: usize = 9;

/// How far kernels reach along x and along y from anywhere on the plate at any of its vergences, plate px.
pub(crate) fn reach_of_pass(scene: &Scene) -> (f64, f64) {
    let (least, largest) = match scene.vergence {
        VergencePass::Constant(vergence) => (vergence, vergence),
        VergencePass::PerPixel(pass) => {
            let ends = |(low, high): (f32, f32), v: &f32| (low.min(*v), high.max(*v));
            let ends = pass.iter().fold((f32::INFINITY, f32::NEG_INFINITY), ends);
            (f64::from(ends.0), f64::from(ends.1))
        }
    };
    let (mut x, mut y) = (0.0_f64, 0.0_f64);
    for step in 0..TRIED {
        let vergence = least + (largest - least) * step as f64 / (TRIED - 1) as f64;
        let far = reach(scene, Window::whole(scene), vergence);
        x = x.max(far.left_px).max(far.right_px);
        y = y.max(far.up_px).max(far.down_px);
    }
    (x, y)
}

/// How far kernels of sources within `light` on the plate reach at `vergence`, plate px, probed at nine places; a
/// million px for what cannot be drawn.
pub(crate) fn reach(scene: &Scene, light: Window, vergence: f64) -> KernelBounds {
    let mut far = [0.0_f64; 4];
    let scale = scene.map.scale;
    for (x, y) in (0..9).map(|k| (k % 3, k / 3)) {
        let column = light.column + (light.width - 1) * x / 2;
        let row = light.row + (light.height - 1) * y / 2;
        let at = scene
            .lens
            .frame()
            .field_point(scene.map.frame_point(column, row));
        for channel in 0..scene.lens.channel_count() {
            let placed = scene.lens.blur_at(channel, at, vergence);
            let reach = scene.model.kernel_bounds(&placed.blur.rescaled(scale));
            // Towards the mean of channels or not: twice the whole displacement bounds both.
            let shift = match scene.displacement {
                Displacement::None => 0.0,
                _ => 2.0 * scale * placed.displacement_px.0.hypot(placed.displacement_px.1),
            };
            let sides = [reach.left_px, reach.right_px, reach.up_px, reach.down_px];
            for (far, side) in far.iter_mut().zip(sides) {
                *far = far.max(side + shift);
            }
        }
    }
    // Not a number, or larger than any plate: the inner renderer says what is wrong.
    let [left_px, right_px, up_px, down_px] = far.map(|far| {
        let roomy = far * (1.0 + SPARE_SHARE) + SPARE_PX;
        if roomy < 1e6 { roomy } else { 1e6 }
    });
    KernelBounds {
        left_px,
        right_px,
        up_px,
        down_px,
    }
}
