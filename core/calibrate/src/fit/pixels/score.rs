//! Held-out score of a fitted lens, beside that of the neighbouring tiles without a model.

use rayon::prelude::*;

use super::adequacy::{self, TileResidual};
use super::context::FitContext;
use super::outliers::{self, Scored};
use crate::measure::{MeasuredTile, Rejection};
use crate::score::ImageAutocorrelation;
use crate::score::{PreparedTile, TestImage, misplaced_light, predicted_kernel, prepare_tiles};
use seidel_optics::distance::ObjectDistance;
use seidel_optics::error::Result;
use seidel_optics::predict::Predictor;
use seidel_optics::profile::{HeldOut, HeldOutGroup, LensProfile};

/// Description of the held-out split in the profile.
const RULE: &str =
    "a fifth by field zone: of five rings of equal counts, one sector of 72 degrees each";
/// Neighbours that are averaged in place of a model.
const NEIGHBOURS: usize = 4;

/// Scores of one held-out tile.
struct TileScore {
    snr_db: f64,
    pixel_gap: f64,
    misplaced_light: f64,
    /// Signal-to-noise ratio of the nearest fitted tiles in its place, dB.
    neighbours_snr_db: Option<f64>,
}

/// The score of a lens, and the tiles that are not of it.
pub(super) struct Score {
    pub(super) held_out: HeldOut,
    pub(super) outliers: Vec<Rejection>,
}

/// A tile of one channel and distance, compared with the lens.
struct Compared<'a> {
    measured: &'a MeasuredTile,
    residual: TileResidual,
    /// Of held-out tiles.
    score: Option<TileScore>,
}

/// The tiles of one channel at one distance.
struct ComparedGroup<'a> {
    channel: usize,
    distance: ObjectDistance,
    tiles: Vec<Compared<'a>>,
}

/// Scores `lens` on the held-out tiles; `None` where there are none.
pub(super) fn held_out(context: &FitContext, lens: &LensProfile) -> Result<Option<Score>> {
    if !context.held_out.contains(&true) {
        return Ok(None);
    }
    let mut groups = compare(context, lens)?;
    let outliers = outliers::of(groups.iter().flat_map(|group| {
        let tiles = group.tiles.iter();
        tiles.map(|tile| Scored {
            measured: tile.measured,
            excess_gap: tile.residual.excess(),
        })
    }));
    for group in &mut groups {
        group.tiles.retain(|tile| {
            let mut strange = outliers.iter();
            !strange.any(|outlier| std::ptr::eq(outlier.measured, tile.measured))
        });
    }
    let names = context.channel_names();
    let mut of_groups = Vec::new();
    let mut residuals = Vec::new();
    let mut scores = Vec::new();
    for group in groups {
        let channel = names[group.channel].clone();
        let (held, fitted): (Vec<_>, Vec<_>) = group
            .tiles
            .into_iter()
            .partition(|tile| tile.score.is_some());
        if held.is_empty() {
            continue;
        }
        let residuals_of =
            |tiles: &[Compared]| tiles.iter().map(|tile| tile.residual.clone()).collect();
        residuals.push(adequacy::Group {
            channel: channel.clone(),
            distance: group.distance,
            held_out: residuals_of(&held),
            fitted: residuals_of(&fitted),
        });
        let of_tiles: Vec<TileScore> = held.into_iter().filter_map(|tile| tile.score).collect();
        of_groups.push(HeldOutGroup {
            channel,
            distance: group.distance,
            tiles: of_tiles.len(),
            snr_db: mean(&of_tiles, |s| s.snr_db),
            pixel_gap: mean(&of_tiles, |s| s.pixel_gap),
            misplaced_light: Some(mean(&of_tiles, |s| s.misplaced_light)),
        });
        scores.extend(of_tiles);
    }
    if scores.is_empty() {
        return Ok(None);
    }
    let neighbours: Option<Vec<f64>> = scores.iter().map(|s| s.neighbours_snr_db).collect();
    Ok(Some(Score {
        held_out: HeldOut {
            tiles: scores.len(),
            rule: RULE.to_owned(),
            snr_db: mean(&scores, |s| s.snr_db),
            pixel_gap: mean(&scores, |s| s.pixel_gap),
            misplaced_light: Some(mean(&scores, |s| s.misplaced_light)),
            neighbours_snr_db: neighbours.map(|all| all.iter().sum::<f64>() / all.len() as f64),
            groups: of_groups,
            adequacy: Some(adequacy::of(&residuals, context.frame.corner_radius())),
        },
        outliers: (outliers.into_iter())
            .map(|outlier| outlier.rejection(names))
            .collect(),
    }))
}

/// Compares all tiles of channels and distances that have held-out tiles with `lens`.
fn compare<'a>(context: &'a FitContext, lens: &LensProfile) -> Result<Vec<ComparedGroup<'a>>> {
    let natural;
    let picture = match &context.settings.test_image {
        Some(picture) => picture,
        None => {
            natural = TestImage::natural();
            &natural
        }
    };
    let correlation = ImageAutocorrelation::new(picture);
    let predictor = Predictor::new(lens)?;
    let mut groups = Vec::new();
    for channel in 0..context.channel_names().len() {
        for distance in distances(context) {
            let of = |wanted: bool| {
                let tiles = context.measured.iter().zip(&context.held_out);
                let matching = tiles.filter(move |(m, held_out)| {
                    **held_out == wanted && m.channel == channel && m.distance == distance
                });
                matching.map(|(m, _)| m).collect::<Vec<&MeasuredTile>>()
            };
            let (held, fitted) = (of(true), of(false));
            if held.is_empty() {
                continue;
            }
            let vergence = predictor.vergence(distance)?;
            // Tiles of several sets are prepared together, each by its own set.
            let together: Vec<&MeasuredTile> = held.iter().chain(&fitted).copied().collect();
            let support = context.settings.support;
            let (side, placed) = prepare_tiles(context.sets, &together, &context.frame, support);
            let scorer = correlation.scorer(side);
            let tiles = placed.par_iter().zip(&together).enumerate();
            let tiles = tiles.map(|(k, (tile, measured))| {
                let kernel = predicted_kernel(&predictor, channel, vergence, tile, side);
                let residual = TileResidual::new(tile, &kernel, side);
                let score = (k < held.len()).then(|| {
                    let square = scorer.blurred_power(&tile.measured);
                    let neighbours = neighbours_mean(tile, &placed[held.len()..]);
                    TileScore {
                        snr_db: tile.snr_db(&scorer, square, &kernel),
                        pixel_gap: residual.gap,
                        misplaced_light: misplaced_light(&tile.compared_with(&kernel), &kernel),
                        neighbours_snr_db: neighbours.map(|n| tile.snr_db(&scorer, square, &n)),
                    }
                });
                Compared {
                    measured,
                    residual,
                    score,
                }
            });
            groups.push(ComparedGroup {
                channel,
                distance,
                tiles: tiles.collect(),
            });
        }
    }
    Ok(groups)
}

/// Returns the mean of the tiles among `fitted` nearest to `tile`, weighted by 1 / distance; `None` without any.
fn neighbours_mean(tile: &PreparedTile, fitted: &[PreparedTile]) -> Option<Vec<f64>> {
    let distance =
        |other: &PreparedTile| (other.field.x - tile.field.x).hypot(other.field.y - tile.field.y);
    let mut near: Vec<&PreparedTile> = fitted.iter().collect();
    near.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
    near.truncate(NEIGHBOURS);
    let weights: Vec<f64> = near
        .iter()
        .map(|other| 1.0 / distance(other).max(1e-6))
        .collect();
    let total: f64 = weights.iter().sum();
    (total > 0.0).then(|| {
        let pixels = 0..tile.measured.len();
        let each = near.iter().zip(&weights);
        let sum = |pixel| {
            each.clone()
                .map(|(other, w)| w * other.measured[pixel])
                .sum::<f64>()
        };
        pixels.map(|pixel| sum(pixel) / total).collect()
    })
}

/// Returns the mean of `value` over `scores`.
fn mean(scores: &[TileScore], value: impl Fn(&TileScore) -> f64) -> f64 {
    scores.iter().map(value).sum::<f64>() / scores.len().max(1) as f64
}

fn distances(context: &FitContext) -> Vec<ObjectDistance> {
    let mut all: Vec<ObjectDistance> = Vec::new();
    for tile in context.measured {
        if !all.contains(&tile.distance) {
            all.push(tile.distance);
        }
    }
    let rank = |d: &ObjectDistance| d.vergence_per_m().unwrap_or(f64::INFINITY);
    all.sort_by(|a, b| rank(a).total_cmp(&rank(b)));
    all
}
