//! Held-out score of a fitted lens.

use rayon::prelude::*;

use super::context::FitContext;
use crate::measure::MeasuredTile;
use crate::score::ImageAutocorrelation;
use crate::score::{TestImage, predicted_kernel, prepare_tiles};
use seidel_optics::distance::ObjectDistance;
use seidel_optics::error::Result;
use seidel_optics::predict::Predictor;
use seidel_optics::profile::{HeldOut, HeldOutGroup, LensProfile};

/// Description of the held-out split in the profile.
const RULE: &str =
    "a fifth by field zone: of five rings of equal counts, one sector of 72 degrees each";

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
    let (mut decibels, mut gaps) = (Vec::new(), Vec::new());
    for (channel, name) in context.channel_names().iter().enumerate() {
        for distance in distances(context) {
            let tiles: Vec<&MeasuredTile> = context
                .measured
                .iter()
                .zip(&context.held_out)
                .filter(|(m, held_out)| {
                    **held_out && m.channel == channel && m.distance == distance
                })
                .map(|(m, _)| m)
                .collect();
            if tiles.is_empty() {
                continue;
            }
            let vergence = predictor.vergence(distance)?;
            // Tiles of several sets are prepared together, each by its own set.
            let (side, placed) = prepare_tiles(
                context.sets,
                &tiles,
                &context.frame,
                context.settings.support,
            );
            let scorer = correlation.scorer(side);
            let scores: Vec<(f64, f64)> = placed
                .par_iter()
                .map(|tile| {
                    let kernel = predicted_kernel(&predictor, channel, vergence, tile, side);
                    let square = scorer.blurred_power(&tile.measured);
                    let norm: f64 = tile.measured.iter().map(|v| v * v).sum();
                    let pairs = tile.measured.iter().zip(&kernel);
                    let gap = pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>() / norm;
                    (scorer.snr_db(&tile.measured, square, &kernel), gap)
                })
                .collect();
            let count = scores.len() as f64;
            groups.push(HeldOutGroup {
                channel: name.clone(),
                distance,
                tiles: scores.len(),
                snr_db: scores.iter().map(|s| s.0).sum::<f64>() / count,
                pixel_gap: scores.iter().map(|s| s.1).sum::<f64>() / count,
            });
            decibels.extend(scores.iter().map(|s| s.0));
            gaps.extend(scores.iter().map(|s| s.1));
        }
    }
    let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len().max(1) as f64;
    Ok(Some(HeldOut {
        tiles: decibels.len(),
        rule: RULE.to_owned(),
        snr_db: mean(&decibels),
        pixel_gap: mean(&gaps),
        groups,
    }))
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
