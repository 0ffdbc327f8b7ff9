//! Upper estimates of how far kernels spread light.

use crate::{Displacement, RenderWindow, Scene, VergencePass};
use seidel_optics::psf::KernelBounds;

/// Margin added to the reach found at the probes, as a share and in px: kernels between probes may be larger.
const MARGIN_SHARE: f64 = 0.1;
const MARGIN_PX: f64 = 4.0;

/// Vergences probed from the smallest to the largest of a depth pass.
const VERGENCE_PROBES: usize = 9;

/// Reach reported for kernels that are not finite or larger than any plate, px. The renderer then names the fault.
const UNBOUNDED_PX: f64 = 1e6;

impl Scene<'_> {
    /// Estimates how far the light of any pixel travels along x and along y, plate px.
    ///
    /// The lens is probed at nine places and nine vergences, and a margin is added. A lens that cannot be drawn
    /// reaches a million pixels.
    pub fn reach_px(&self) -> (f64, f64) {
        self.reach_within(RenderWindow::whole(self))
    }

    /// As [`Self::reach_px`], with the lens probed at nine places of a `window` of the plate.
    pub(crate) fn reach_within(&self, window: RenderWindow) -> (f64, f64) {
        let (lowest, highest) = match self.vergence {
            VergencePass::Constant(vergence) => (vergence, vergence),
            VergencePass::PerPixel(pass) => {
                let ends = |(low, high): (f32, f32), v: &f32| (low.min(*v), high.max(*v));
                let ends = pass.iter().fold((f32::INFINITY, f32::NEG_INFINITY), ends);
                (f64::from(ends.0), f64::from(ends.1))
            }
        };
        let (mut x, mut y) = (0.0_f64, 0.0_f64);
        for step in 0..VERGENCE_PROBES {
            let vergence = lowest + (highest - lowest) * step as f64 / (VERGENCE_PROBES - 1) as f64;
            let reach = kernel_reach(self, window, vergence);
            x = x.max(reach.left_px).max(reach.right_px);
            y = y.max(reach.up_px).max(reach.down_px);
        }
        (x, y)
    }
}

/// Estimates how far kernels of sources within `sources` spread at `vergence`, plate px.
///
/// The lens is probed at nine places of the window. A lens that cannot be drawn reaches a million pixels.
pub(crate) fn kernel_reach(scene: &Scene, sources: RenderWindow, vergence: f64) -> KernelBounds {
    let mut largest = [0.0_f64; 4];
    let scale = scene.map.scale;
    for (x, y) in (0..9).map(|k| (k % 3, k / 3)) {
        let column = sources.column + (sources.width - 1) * x / 2;
        let row = sources.row + (sources.height - 1) * y / 2;
        let at = scene
            .lens
            .frame()
            .field_point(scene.map.frame_point(column, row));
        for channel in 0..scene.lens.channel_count() {
            let displaced = scene.lens.blur_at(channel, at, vergence);
            let reach = scene.model.kernel_bounds(&displaced.blur.rescaled(scale));
            // Lateral displacement is relative to the mean of channels: twice the whole displacement bounds it.
            let shift = match scene.displacement {
                Displacement::None => 0.0,
                _ => {
                    2.0 * scale
                        * displaced
                            .displacement_px
                            .0
                            .hypot(displaced.displacement_px.1)
                }
            };
            let sides = [reach.left_px, reach.right_px, reach.up_px, reach.down_px];
            for (largest, side) in largest.iter_mut().zip(sides) {
                *largest = largest.max(side + shift);
            }
        }
    }
    // The comparison also fails for NaN.
    let [left_px, right_px, up_px, down_px] = largest.map(|reach| {
        let with_margin = reach * (1.0 + MARGIN_SHARE) + MARGIN_PX;
        if with_margin < UNBOUNDED_PX {
            with_margin
        } else {
            UNBOUNDED_PX
        }
    });
    KernelBounds {
        left_px,
        right_px,
        up_px,
        down_px,
    }
}
