//! Whether a lens blurs as a plate shows it: pictures without their blur have few, steep slopes; too little taken off
//! leaves them spread out, and too much rings.

use super::Removal;
use super::canvas::part_of;
use super::prior::slope_lengths;
use super::sums::Typical;
use crate::error::Result;
use crate::render::{Adjusted, Plane, Scene, VergencePass, Window, reach};
use rayon::prelude::*;

/// Blur that is tried, as shares of the lens's.
const TRIED: [f64; 9] = [0.5, 0.57, 0.66, 0.76, 0.87, 1.0, 1.15, 1.32, 1.52];
/// Place of the lens as it is.
const AS_IT_IS: usize = 5;
/// Side of the squares that are looked at, px, and how many.
const SIDE: usize = 192;
const SQUARES: usize = 3;
/// Weight of slopes' mean size beside how evenly they are spread: alone, the latter likes a little too much blur taken
/// off (found on photographs).
const SIZE_WEIGHT: f64 = 0.1;
/// By how much less and by how much more blur must be better than the lens as it is: taking too much off does harm.
const LESS_BETTER: f64 = 0.03;
const MORE_BETTER: f64 = 0.05;
/// What counts as noise, as a share of the light: more than for removing, that what rings at another share of the blur is
/// not what operators get wrong.
const INEXACT: f64 = 6e-3;

/// How a lens's blur compares with a plate's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LensCheck {
    /// The plate's blur as a share of the lens's: 1 where nothing speaks against the lens.
    pub blur_share: f64,
}

impl Removal {
    /// Tells from `planes`, of a few squares with much detail and blur, whether the lens of `scene` blurs as they show
    /// it: the share of its blur that leaves the sparsest slopes when removed (Krishnan, Tay and Fergus 2011: mean
    /// size over root mean square), in steps of about 15 %, from 0.5 to 1.5. Where lens and noise leave little to
    /// tell by it is one.
    ///
    /// # Errors
    /// Those of [`Removal::remove`].
    pub fn check_lens(
        &self,
        scene: &Scene,
        planes: &[Plane],
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<LensCheck> {
        scene.check(planes)?;
        let mut sums = [0.0; TRIED.len()];
        let squares = squares(scene, planes);
        let total = squares.len() * TRIED.len();
        let mut done = 0;
        for window in squares {
            for (sum, share) in sums.iter_mut().zip(TRIED) {
                *sum += self.unevenness(scene, planes, window, share, &|part| {
                    progress((f64::from(done) + part) / total as f64)
                })?;
                done += 1;
            }
        }
        let count = (total / TRIED.len() * planes.len()) as f64;
        let best = (0..TRIED.len()).min_by(|a, b| sums[*a].total_cmp(&sums[*b]));
        let better = best.filter(|best| {
            let least = if *best < AS_IT_IS {
                LESS_BETTER
            } else {
                MORE_BETTER
            };
            sums[*best] < sums[AS_IT_IS] - least * count
        });
        Ok(LensCheck {
            blur_share: TRIED[better.unwrap_or(AS_IT_IS)],
        })
    }

    /// How unlike a sharp picture a window of the planes is without `share` of its blur, summed over planes.
    fn unevenness(
        &self,
        scene: &Scene,
        planes: &[Plane],
        window: Window,
        share: f64,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<f64> {
        let scales = vec![share; scene.lens.channel_count()];
        let lens = Adjusted::new(scene.lens, 1.0, scales, (0.0, 0.0))?;
        let pass = match scene.vergence {
            VergencePass::Constant(_) => Vec::new(),
            VergencePass::PerPixel(pass) => window.cut(scene.width, pass),
        };
        let part = Scene {
            lens: &lens,
            vergence: match scene.vergence {
                VergencePass::PerPixel(_) => VergencePass::PerPixel(&pass),
                constant => constant,
            },
            ..part_of(scene, window)
        };
        let samples: Vec<Vec<f32>> = (planes.iter())
            .map(|plane| window.cut(scene.width, plane.samples))
            .collect();
        let cut: Vec<Plane> = (planes.iter().zip(&samples))
            .map(|(plane, samples)| Plane { samples, ..*plane })
            .collect();
        let removed = self.remove_by(&part, &cut, (INEXACT, false), progress)?;
        let uneven = removed.iter().map(|removed| {
            let sharp = removed.canvas.cropped(&removed.sharp);
            let slopes = slope_lengths(&sharp, window.width);
            let mean = |of: &dyn Fn(f64) -> f64| {
                slopes.iter().map(|v| of(f64::from(*v))).sum::<f64>() / slopes.len().max(1) as f64
            };
            let (size, square) = (mean(&|v| v), mean(&|v| v * v));
            if size > 0.0 {
                (size / square.sqrt()).ln() + SIZE_WEIGHT * size.ln()
            } else {
                0.0
            }
        });
        Ok(uneven.sum())
    }
}

/// The squares of a plate in which blur shows most: much detail, large kernels.
fn squares(scene: &Scene, planes: &[Plane]) -> Vec<Window> {
    let starts = |size: usize| {
        let count = size.div_ceil(SIDE).max(1);
        let last = size.saturating_sub(SIDE);
        (0..count).map(move |k| if count > 1 { last * k / (count - 1) } else { 0 })
    };
    let mut found: Vec<(f64, Window)> = starts(scene.height)
        .flat_map(|row| starts(scene.width).map(move |column| (column, row)))
        .map(|(column, row)| {
            let window = Window {
                column,
                row,
                width: SIDE.min(scene.width),
                height: SIDE.min(scene.height),
            };
            (0.0, window)
        })
        .collect();
    found.par_iter_mut().for_each(|(score, window)| {
        let detail = planes.iter().map(|plane| {
            let samples = window.cut(scene.width, plane.samples);
            Typical::of(slope_lengths(&samples, window.width)).root_mean_square
        });
        let middle =
            (window.row + window.height / 2) * scene.width + window.column + window.width / 2;
        let far = reach(scene, *window, scene.vergence_at(middle));
        *score = detail.sum::<f64>() * far.right_px.max(far.up_px);
    });
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found
        .into_iter()
        .take(SQUARES)
        .map(|(_, window)| window)
        .collect()
}
