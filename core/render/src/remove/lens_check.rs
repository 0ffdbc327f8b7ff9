//! Whether a lens blurs as a plate shows it: pictures without their blur have few, steep slopes; too little taken off
//! leaves them spread out, and too much rings.

use super::canvas::part_of;
use super::prior::{all_slope_lengths, slope_lengths, slope_of_noise};
use super::sums::Typical;
use super::{Lights, Removal, Removed};
use crate::{AdjustedLens, Plane, RenderWindow, Scene, VergencePass, kernel_reach};
use rayon::prelude::*;
use seidel_optics::error::Result;

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
/// The same where the lens as it is is better than what is next to it, and for the least share tried, which may be but the
/// end of a slope.
const FAR_BETTER: f64 = 0.1;
const END_BETTER: f64 = 0.25;
/// Planes less wide or high than this tell too little, px.
const LEAST_SIDE: usize = SIDE / 2;
/// How much larger slopes must be than those of noise alone, root mean square.
const DETAIL: f64 = 1.25;
/// Least share of a square from which blur can be removed: lights and depth edges keep theirs.
const TOLD: f64 = 0.4;
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
    /// [`LensCheck::of`] planes from which blur is all removed alike.
    ///
    /// # Errors
    /// Those of [`LensCheck::of`].
    pub fn check_lens(
        &self,
        scene: &Scene,
        planes: &[Plane],
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<LensCheck> {
        let alike: Vec<_> = planes.iter().map(|plane| (*self, *plane)).collect();
        LensCheck::of(scene, &alike, progress)
    }
}

impl LensCheck {
    /// Tells from `planes`, of a few squares with much detail and blur, whether the lens of `scene` blurs as they show
    /// it: the share of its blur that leaves the sparsest slopes when removed (Krishnan, Tay and Fergus 2011: mean
    /// size over root mean square), tried in steps of about 15 %, from 0.5 to 1.5. Where size, lens and noise leave
    /// little to tell by it is one. Each plane comes with how its blur is removed.
    ///
    /// # Errors
    /// Those of [`Removal::remove`].
    pub fn of(
        scene: &Scene,
        planes: &[(Removal, Plane)],
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Self> {
        let all: Vec<Plane> = planes.iter().map(|(_, plane)| *plane).collect();
        scene.check(&all)?;
        let uneven = planes.iter().filter(|(_, plane)| !is_even(plane.samples));
        let planes: Vec<_> = uneven.copied().collect();
        let squares = match scene.width.min(scene.height) < LEAST_SIDE {
            true => Vec::new(),
            false => squares(scene, &planes),
        };
        let (mut sums, mut count) = ([0.0; TRIED.len()], 0.0);
        let total = (squares.len() * planes.len()) as f64;
        let each = (squares.iter()).flat_map(|window| planes.iter().map(move |p| (window, p)));
        for (done, (window, plane)) in each.enumerate() {
            let tell = |part| progress((done as f64 + part) / total);
            if let Some(uneven) = unevenness(scene, *plane, *window, &tell)? {
                count += 1.0;
                for (sum, uneven) in sums.iter_mut().zip(uneven) {
                    *sum += uneven;
                }
            }
        }
        let blur_share = best(&sums, count).map_or(1.0, between);
        Ok(Self { blur_share })
    }
}

/// The place of the least of `sums` over `count` squares and planes, where it is lower enough than that of the lens as
/// it is; with the sums about it.
fn best(sums: &[f64; TRIED.len()], count: f64) -> Option<(usize, [f64; 3])> {
    let best = (0..TRIED.len()).min_by(|a, b| sums[*a].total_cmp(&sums[*b]))?;
    let beside = sums[AS_IT_IS - 1].min(sums[AS_IT_IS + 1]);
    let least = match best {
        0 => END_BETTER,
        _ if sums[AS_IT_IS] < beside => FAR_BETTER,
        1..AS_IT_IS => LESS_BETTER,
        _ => MORE_BETTER,
    };
    let about = |place: usize| sums[place.min(TRIED.len() - 1)];
    (sums[best] < sums[AS_IT_IS] - least * count).then(|| {
        (
            best,
            [about(best.saturating_sub(1)), sums[best], about(best + 1)],
        )
    })
}

/// The share at the lowest point of the parabola through the sums at `place`, the least, and beside it, to a hundredth.
fn between((place, [before, here, after]): (usize, [f64; 3])) -> f64 {
    let bend = before + after - 2.0 * here;
    if place == 0 || place == TRIED.len() - 1 || bend <= 0.0 {
        return TRIED[place];
    }
    // Shares are as good as evenly apart in their logarithms.
    let along = 0.5 * (before - after) / bend;
    let step = match along < 0.0 {
        true => TRIED[place] / TRIED[place - 1],
        false => TRIED[place + 1] / TRIED[place],
    };
    (100.0 * TRIED[place] * step.powf(along)).round() / 100.0
}

fn is_even(samples: &[f32]) -> bool {
    samples.windows(2).all(|pair| pair[0] == pair[1])
}

/// How unlike a sharp picture a window of a plane is without each of the shares of its blur; none where there is
/// little but noise, or much that keeps its blur.
fn unevenness(
    scene: &Scene,
    (removal, plane): (Removal, Plane),
    window: RenderWindow,
    progress: &(dyn Fn(f64) -> bool + Sync),
) -> Result<Option<[f64; TRIED.len()]>> {
    let samples = window.cut(scene.width, plane.samples);
    let pass = match scene.vergence {
        VergencePass::Constant(_) => Vec::new(),
        VergencePass::PerPixel(pass) => window.cut(scene.width, pass),
    };
    let removed = |share: f64, done: usize| -> Result<Vec<Removed>> {
        let scales = vec![share; scene.lens.channel_count()];
        let lens = AdjustedLens::new(scene.lens, 1.0, scales, (0.0, 0.0))?;
        let part = Scene {
            lens: &lens,
            vergence: match scene.vergence {
                VergencePass::PerPixel(_) => VergencePass::PerPixel(&pass),
                constant => constant,
            },
            ..part_of(scene, window)
        };
        let cut = Plane {
            samples: &samples,
            ..plane
        };
        let tell = |part: f64| progress((done as f64 + part) / TRIED.len() as f64);
        let lights = Lights::of(&[cut], window.width);
        removal.remove_by(&lights, &part, &[cut], (INEXACT, false), &tell)
    };
    let mut uneven = [0.0; TRIED.len()];
    // Lights and depth edges keep their blur: slopes there tell nothing.
    let mut told = Vec::new();
    // The lens as it is first: it tells the noise, and where to look.
    let order = std::iter::once(AS_IT_IS).chain((0..TRIED.len()).filter(|k| *k != AS_IT_IS));
    for (done, place) in order.enumerate() {
        for removed in removed(TRIED[place], done)? {
            if place == AS_IT_IS {
                told = removed.confidence.iter().map(|told| *told > 0.0).collect();
                let count = told.iter().filter(|told| **told).count();
                if (count as f64) < TOLD * told.len() as f64
                    || !has_detail(&samples, window.width, removed.noise)
                {
                    return Ok(None);
                }
            }
            let sharp = removed.canvas.cropped(&removed.sharp);
            uneven[place] = spread(&sharp, window.width, &told);
        }
    }
    Ok(Some(uneven))
}

/// Whether a picture's slopes are more than those of its noise.
fn has_detail(samples: &[f32], width: usize, noise: f64) -> bool {
    let slopes = slope_lengths(samples, width);
    let squares = slopes.iter().map(|v| f64::from(*v).powi(2));
    let mean = squares.sum::<f64>() / slopes.len().max(1) as f64;
    mean > (DETAIL * noise).powi(2) * slope_of_noise()
}

/// How evenly slopes are spread over a picture where it is `told`, the larger they are the more so.
fn spread(sharp: &[f32], width: usize, told: &[bool]) -> f64 {
    let slopes = all_slope_lengths(sharp, width);
    let slopes: Vec<f32> = (slopes.into_iter().zip(told))
        .filter_map(|(slope, told)| told.then_some(slope))
        .collect();
    let mean = |of: &dyn Fn(f64) -> f64| {
        slopes.iter().map(|v| of(f64::from(*v))).sum::<f64>() / slopes.len().max(1) as f64
    };
    let (size, square) = (mean(&|v| v), mean(&|v| v * v));
    if size > 0.0 {
        (size / square.sqrt()).ln() + SIZE_WEIGHT * size.ln()
    } else {
        0.0
    }
}

/// The squares of a plate in which blur shows most: much detail, large kernels.
fn squares(scene: &Scene, planes: &[(Removal, Plane)]) -> Vec<RenderWindow> {
    let starts = |size: usize| {
        let count = size.div_ceil(SIDE).max(1);
        let last = size.saturating_sub(SIDE);
        (0..count).map(move |k| if count > 1 { last * k / (count - 1) } else { 0 })
    };
    let mut found: Vec<(f64, RenderWindow)> = starts(scene.height)
        .flat_map(|row| starts(scene.width).map(move |column| (column, row)))
        .map(|(column, row)| {
            let window = RenderWindow {
                column,
                row,
                width: SIDE.min(scene.width),
                height: SIDE.min(scene.height),
            };
            (0.0, window)
        })
        .collect();
    found.par_iter_mut().for_each(|(score, window)| {
        let detail = planes.iter().map(|(_, plane)| {
            let samples = window.cut(scene.width, plane.samples);
            Typical::of(slope_lengths(&samples, window.width)).root_mean_square
        });
        let middle =
            (window.row + window.height / 2) * scene.width + window.column + window.width / 2;
        let far = kernel_reach(scene, *window, scene.vergence_at(middle));
        *score = detail.sum::<f64>() * far.right_px.max(far.up_px);
    });
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found
        .into_iter()
        .take(SQUARES)
        .map(|(_, window)| window)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::test_scenes::{Deviates, WEIGHTS, discs, lens};
    use super::*;
    use crate::{Displacement, Edges, PlateMap};
    use seidel_optics::field::ImagePoint;
    use seidel_optics::psf::SkewNormal;

    fn share_of(width: usize, height: usize, samples: &[f32]) -> f64 {
        let lens = lens(1.0);
        let scene = Scene {
            lens: &lens,
            model: &SkewNormal,
            width,
            height,
            map: PlateMap {
                origin: ImagePoint::new(0.0, 0.0),
                scale: 1.0,
            },
            vergence: VergencePass::Constant(0.0),
            edges: Edges::Mirror,
            displacement: Displacement::None,
        };
        let planes = [Plane {
            samples,
            weights: &WEIGHTS,
        }];
        let check = Removal::default().check_lens(&scene, &planes, &|_| true);
        check.expect("a sound scene").blur_share
    }

    /// Without any blur they would all speak against the lens.
    #[test]
    fn small_and_empty_planes_tell_nothing() {
        for (width, height) in [(1, 1), (2, 1), (1, 3), (5, 4), (120, 60), (60, 120)] {
            assert_eq!(share_of(width, height, &discs(width, height)), 1.0);
        }
        assert!(share_of(120, 120, &discs(120, 120)) < 1.0);
        let mut chance = Deviates(9);
        let noise = (0..120 * 120).map(|_| 0.4 + 0.01 * chance.next() as f32);
        assert_eq!(share_of(120, 120, &noise.collect::<Vec<f32>>()), 1.0);
        assert_eq!(share_of(120, 120, &[0.4; 120 * 120]), 1.0);
    }

    /// A parabola in the logarithm of the share has its lowest point where it has it.
    #[test]
    fn shares_between_those_tried_are_found() {
        for share in [0.55, 0.62, 0.71, 0.8, 1.24, 1.4] {
            let sums = TRIED.map(|tried| (tried / share).ln().powi(2));
            let found = best(&sums, 0.1).map_or(1.0, between);
            assert!((found - share).abs() < 0.012, "{share}: {found}");
        }
        let nearly = TRIED.map(|tried| (tried / 0.97).ln().powi(2));
        assert_eq!(best(&nearly, 1.0), None);
        let (falling, rising) = (TRIED.map(|t| -t), TRIED);
        assert_eq!(best(&falling, 1.0).map(between), Some(1.52));
        assert_eq!(best(&rising, 1.0).map(between), Some(0.5));
    }
}
