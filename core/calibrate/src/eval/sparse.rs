//! Figure 13: M_FB against the number of training tiles, by repeated random splits.
//!
//! A split is a random permutation of the tiles. Its first n tiles train S1..S10 for every n; its last tiles,
//! which no n reaches, are the test tiles. All n of a split share the test tiles, so their choice does not
//! blur the curve.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::SplitMean;
use crate::fit::plane::{Weighting, fit_plane};
use crate::measure::MeasuredTile;
use crate::score::BlurScorer;
use crate::score::PreparedTile;
use crate::score::{render_kernel, with_pixel_integration};
use crate::stage::Stage;
use seidel_optics::error::Result;
use seidel_optics::field::Frame;
use seidel_optics::numeric::SplitMix64;
use seidel_optics::psf::{Gaussian, LocalBlur, PsfModel, SkewNormal};

/// Settings of Figure 13.
#[derive(Debug, Clone, PartialEq)]
pub struct SparseSettings {
    /// Numbers of training tiles; those above 80 % of a group's tiles are skipped.
    pub counts: Vec<usize>,
    /// Number of random splits.
    pub splits: usize,
    /// Maximum number of test tiles per split.
    pub test_tiles: usize,
    /// Seed of the splits.
    pub seed: u64,
    /// Weights of the residuals in the fits.
    pub weighting: Weighting,
}

impl Default for SparseSettings {
    fn default() -> Self {
        Self {
            counts: vec![
                3, 4, 5, 6, 8, 10, 15, 20, 30, 50, 70, 100, 150, 200, 300, 500,
            ],
            splits: 20,
            test_tiles: 30,
            seed: 13,
            weighting: Weighting::default(),
        }
    }
}

/// M_FB against the number of training tiles, for one channel at one distance.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct SparseCurve {
    /// One point per number of training tiles, rising.
    pub points: Vec<SparsePoint>,
    /// Number of random splits.
    pub splits: usize,
    /// Number of test tiles per split.
    pub test_tiles: usize,
}

/// Scores for one number of training tiles.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct SparsePoint {
    /// Training tiles.
    pub training: usize,
    /// Splits whose tiles do not determine S1..S10; they have no score.
    pub undetermined: usize,
    /// Score of the Gaussian; `None` where no split was determined.
    pub gaussian: Option<SplitMean>,
    /// Score of the meridional skew-normal; `None` where no split was determined.
    pub skew_normal: Option<SplitMean>,
}

/// The tiles of a group, all lists in the same order.
pub(super) struct GroupTiles<'a> {
    pub(super) measured: &'a [&'a MeasuredTile],
    pub(super) tiles: &'a [PreparedTile],
    /// V(P) of every tile.
    pub(super) signal_powers: &'a [f64],
}

/// Computes the curve of one group.
///
/// # Errors
/// Cancellation in `stage`.
pub(super) fn curve(
    frame: &Frame,
    group: &GroupTiles,
    scorer: &BlurScorer,
    settings: &SparseSettings,
    stage: Stage,
) -> Result<SparseCurve> {
    let GroupTiles {
        measured,
        tiles: placed,
        signal_powers,
    } = *group;
    let tiles = measured.len();
    let mut counts: Vec<usize> = settings
        .counts
        .iter()
        .copied()
        .filter(|&n| n > 0 && 5 * n <= 4 * tiles)
        .collect();
    counts.sort_unstable();
    counts.dedup();
    let largest = counts.last().copied().unwrap_or(0);
    let test_tiles = settings.test_tiles.min(tiles - largest);
    let splits = if test_tiles == 0 { 0 } else { settings.splits };
    // By split, then by count: mean dB of the two models, or `None` if undetermined.
    let done = AtomicUsize::new(0);
    let scores = (0..splits).into_par_iter().map(|split| {
        stage
            .part_of(done.fetch_add(1, Ordering::Relaxed), splits)
            .reach(0.0)?;
        let order = split_order(settings.seed, split, tiles);
        let tested = &order[tiles - test_tiles..];
        let scores = counts
            .iter()
            .map(|&n| {
                let training: Vec<&MeasuredTile> =
                    order[..n].iter().map(|&k| measured[k]).collect();
                let s = fit_plane(frame, &training, settings.weighting).ok()?.s;
                let models: [&dyn PsfModel; 2] = [&Gaussian, &SkewNormal];
                Some(models.map(|model| {
                    let total: f64 = tested
                        .iter()
                        .map(|&k| {
                            let field = placed[k].field;
                            let of_lens =
                                LocalBlur::from_moments(s.moments(field), field.meridian());
                            let blur = with_pixel_integration(of_lens);
                            let kernel = render_kernel(model, &blur, &placed[k], scorer.side());
                            placed[k].snr_db(scorer, signal_powers[k], &kernel)
                        })
                        .sum();
                    total / test_tiles as f64
                }))
            })
            .collect();
        Ok(scores)
    });
    let scores: Vec<Vec<Option<[f64; 2]>>> = scores.collect::<Result<_>>()?;
    let points = counts
        .iter()
        .enumerate()
        .map(|(at, &training)| {
            let of_model = |model: usize| {
                let means: Vec<f64> = scores
                    .iter()
                    .filter_map(|split| split[at].map(|pair| pair[model]))
                    .collect();
                SplitMean::of(&means)
            };
            SparsePoint {
                training,
                undetermined: scores.iter().filter(|split| split[at].is_none()).count(),
                gaussian: of_model(0),
                skew_normal: of_model(1),
            }
        })
        .collect();
    Ok(SparseCurve {
        points,
        splits,
        test_tiles,
    })
}

/// Returns the permutation of the tiles in split number `split`.
fn split_order(seed: u64, split: usize, tiles: usize) -> Vec<usize> {
    // Each split has its own generator, so it does not depend on the number of splits.
    let mut seeds = SplitMix64::new(seed);
    let mut own = seeds.next_u64();
    for _ in 0..split {
        own = seeds.next_u64();
    }
    SplitMix64::new(own).permutation(tiles)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::measure;
    use crate::score::ImageAutocorrelation;
    use crate::score::{TestImage, prepare_tiles};
    use seidel_optics::field::FieldPoint;
    use seidel_optics::moments::support::Support;
    use seidel_optics::no_progress;

    #[test]
    fn no_tile_is_scored_that_was_trained_on() {
        let lens = crate::eval::tests::lens();
        let set = crate::eval::tests::drawn(&lens);
        let mut measured = measure(std::slice::from_ref(&set), Support::Auto, &mut Vec::new());
        let (tiles, tested) = (measured.len(), 8);
        let settings = SparseSettings {
            counts: vec![5, 20, 32, 33],
            splits: 1,
            ..SparseSettings::default()
        };
        let order = split_order(settings.seed, 0, tiles);
        // Training on a test tile, or scoring a training tile, would show as NaN.
        for &k in &order[tiles - tested..] {
            measured[k].optical.mu20 = f64::NAN;
            measured[k].optical.mu30 = f64::NAN;
        }
        let measured: Vec<&MeasuredTile> = measured.iter().collect();
        let (side, mut placed) = prepare_tiles(
            std::slice::from_ref(&set),
            &measured,
            &lens.frame,
            Support::Auto,
        );
        for &k in &order[..tiles - tested] {
            placed[k].measured.fill(f64::NAN);
        }
        let scorer = ImageAutocorrelation::new(&TestImage::natural()).scorer(side);
        let signal_powers: Vec<f64> = placed
            .iter()
            .map(|t| scorer.blurred_power(&t.measured))
            .collect();
        let group = GroupTiles {
            measured: &measured,
            tiles: &placed,
            signal_powers: &signal_powers,
        };
        let stage = Stage::whole(&no_progress, "evaluation");
        let curve = curve(&lens.frame, &group, &scorer, &settings, stage).expect("not cancelled");
        // 33 of 40 is more than 80 %.
        let counts: Vec<usize> = curve.points.iter().map(|p| p.training).collect();
        assert_eq!((counts, curve.test_tiles), (vec![5, 20, 32], tested));
        for point in &curve.points {
            assert_eq!(point.undetermined, 0);
            let mean = point.skew_normal.expect("determined").mean_db;
            assert!(mean.is_finite() && mean > 20.0, "{point:?}");
        }
    }

    #[test]
    fn tiles_at_one_radius_are_counted_as_undetermined() {
        let lens = crate::eval::tests::lens();
        let mut set = crate::eval::tests::drawn(&lens);
        for (k, observation) in set.observations.iter_mut().enumerate() {
            let (sin, cos) = (k as f64).sin_cos();
            observation.ideal = Some(
                lens.frame
                    .image_point(FieldPoint::new(0.5 * cos, 0.5 * sin)),
            );
        }
        let measured = measure(std::slice::from_ref(&set), Support::Auto, &mut Vec::new());
        let measured: Vec<&MeasuredTile> = measured.iter().collect();
        let (side, placed) = prepare_tiles(
            std::slice::from_ref(&set),
            &measured,
            &lens.frame,
            Support::Auto,
        );
        let scorer = ImageAutocorrelation::new(&TestImage::natural()).scorer(side);
        let signal_powers: Vec<f64> = placed
            .iter()
            .map(|t| scorer.blurred_power(&t.measured))
            .collect();
        let settings = SparseSettings {
            counts: vec![10],
            splits: 3,
            ..SparseSettings::default()
        };
        let group = GroupTiles {
            measured: &measured,
            tiles: &placed,
            signal_powers: &signal_powers,
        };
        let stage = Stage::whole(&no_progress, "evaluation");
        let curve = curve(&lens.frame, &group, &scorer, &settings, stage).expect("not cancelled");
        assert_eq!(curve.points[0].undetermined, 3);
        assert_eq!(curve.points[0].skew_normal, None);
    }

    #[test]
    fn splits_differ_and_repeat() {
        assert_eq!(split_order(1, 3, 50), split_order(1, 3, 50));
        assert_ne!(split_order(1, 3, 50), split_order(1, 4, 50));
        assert_ne!(split_order(1, 3, 50), split_order(2, 3, 50));
    }
}
