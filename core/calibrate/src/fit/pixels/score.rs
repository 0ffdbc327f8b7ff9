//! Held-out score of a fitted lens.

use rayon::prelude::*;

use super::adequacy::{self, TileResidual};
use super::context::FitContext;
use crate::measure::MeasuredTile;
use crate::score::ImageAutocorrelation;
use crate::score::{TestImage, misplaced_light, predicted_kernel, prepare_tiles};
use seidel_optics::distance::ObjectDistance;
use seidel_optics::error::Result;
use seidel_optics::predict::Predictor;
use seidel_optics::profile::{HeldOut, HeldOutGroup, LensProfile};

/// Description of the held-out split in the profile.
const RULE: &str =
    "a fifth by field zone: of five rings of equal counts, one sector of 72 degrees each";

/// Scores of one tile.
struct TileScore {
    snr_db: f64,
    pixel_gap: f64,
    misplaced_light: f64,
}

/// Scores `lens` on the held-out tiles; `None` where there are none.
pub(super) fn held_out(context: &FitContext, lens: &LensProfile) -> Result<Option<HeldOut>> {
    if !context.held_out.contains(&true) {
        return Ok(None);
    }
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
    let mut scores = Vec::new();
    let mut residuals = Vec::new();
    for (channel, name) in context.channel_names().iter().enumerate() {
        for distance in distances(context) {
            let of = |wanted: bool| -> Vec<&MeasuredTile> {
                let tiles = context.measured.iter().zip(&context.held_out);
                tiles
                    .filter(|(m, held_out)| {
                        **held_out == wanted && m.channel == channel && m.distance == distance
                    })
                    .map(|(m, _)| m)
                    .collect()
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
            let of_group: Vec<(Option<TileScore>, TileResidual)> = placed
                .par_iter()
                .enumerate()
                .map(|(k, tile)| {
                    let kernel = predicted_kernel(&predictor, channel, vergence, tile, side);
                    let residual = TileResidual::new(tile, &kernel, side);
                    let score = (k < held.len()).then(|| {
                        let square = scorer.blurred_power(&tile.measured);
                        TileScore {
                            snr_db: tile.snr_db(&scorer, square, &kernel),
                            pixel_gap: residual.gap,
                            misplaced_light: misplaced_light(&tile.compared_with(&kernel), &kernel),
                        }
                    });
                    (score, residual)
                })
                .collect();
            let (of_tiles, of_group): (Vec<_>, Vec<_>) = of_group.into_iter().unzip();
            let of_tiles: Vec<TileScore> = of_tiles.into_iter().flatten().collect();
            groups.push(HeldOutGroup {
                channel: name.clone(),
                distance,
                tiles: of_tiles.len(),
                snr_db: mean(&of_tiles, |s| s.snr_db),
                pixel_gap: mean(&of_tiles, |s| s.pixel_gap),
                misplaced_light: Some(mean(&of_tiles, |s| s.misplaced_light)),
            });
            residuals.push(adequacy::Group {
                channel: name.clone(),
                distance,
                held_out: of_group[..held.len()].to_vec(),
                fitted: of_group[held.len()..].to_vec(),
            });
            scores.extend(of_tiles);
        }
    }
    Ok(Some(HeldOut {
        tiles: scores.len(),
        rule: RULE.to_owned(),
        snr_db: mean(&scores, |s| s.snr_db),
        pixel_gap: mean(&scores, |s| s.pixel_gap),
        misplaced_light: Some(mean(&scores, |s| s.misplaced_light)),
        groups,
        adequacy: Some(adequacy::of(&residuals, context.frame.corner_radius())),
    }))
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
