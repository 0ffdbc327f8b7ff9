//! Tuning of the overlap-add renderer: the widest grid and smallest kernels that reach a target accuracy.

use crate::accuracy::Reference;
use crate::overlap_add::OverlapAdd;
use seidel_render::{Plane, Scene};

/// Spacings of nodes tried, px.
const SPACINGS: [usize; 10] = [16, 24, 32, 48, 64, 96, 128, 192, 256, 384];
/// Index of the first spacing tried; its error predicts the best one.
const FIRST: usize = 4;
/// Truncated shares of kernels tried, smallest first.
const LEFT_OUT: [f64; 3] = [1e-5, 1e-4, 1e-3];

/// The tuned renderer; `reached` tells whether it meets the target.
pub(crate) struct Tuned {
    pub(crate) renderer: OverlapAdd,
    pub(crate) psnr_db: f64,
    pub(crate) reached: bool,
}

/// Returns the fastest settings that reach `target_db`.
pub(crate) fn tuned(scene: &Scene, planes: &[Plane], exact: &Reference, target_db: f64) -> Tuned {
    let of = |index: usize, left_out: f64| {
        let renderer = OverlapAdd {
            spacing: SPACINGS[index],
            left_out,
        };
        let psnr_db = exact.psnr_db(&renderer.render(scene, planes).planes);
        eprintln!(
            "  overlap-add, spacing {} px, {left_out:.0e} left out: {psnr_db:.1} dB",
            renderer.spacing
        );
        Tuned {
            renderer,
            psnr_db,
            reached: psnr_db >= target_db,
        }
    };
    let mut index = FIRST;
    let mut best = of(index, LEFT_OUT[0]);
    // The error grows with the square of the spacing.
    let factor = ((best.psnr_db - target_db) / 40.0)
        .exp2()
        .powf(std::f64::consts::LOG2_10);
    let wanted = SPACINGS[FIRST] as f64 * factor;
    let guess = SPACINGS.partition_point(|s| *s as f64 <= wanted).max(1) - 1;
    if guess != index {
        index = guess;
        best = of(index, LEFT_OUT[0]);
    }
    while !best.reached && index > 0 {
        index -= 1;
        best = of(index, LEFT_OUT[0]);
    }
    while best.reached && index + 1 < SPACINGS.len() {
        let wider = of(index + 1, LEFT_OUT[0]);
        if !wider.reached {
            break;
        }
        index += 1;
        best = wider;
    }
    for left_out in &LEFT_OUT[1..] {
        let smaller = of(index, *left_out);
        if !smaller.reached {
            break;
        }
        best = smaller;
    }
    best
}
