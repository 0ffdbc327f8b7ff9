//! How well a lens describes PSFs that took no part in its fit.

use rayon::prelude::*;

use super::job::Job;
use crate::measure::MeasuredTile;
use crate::score::ImageCorrelation;
use crate::score::{TestImage, kernel_of_lens, place_tiles};
use seidel_optics::distance::ObjectDistance;
use seidel_optics::error::Result;
use seidel_optics::predict::Predictor;
use seidel_optics::profile::{HeldOut, HeldOutGroup, LensProfile};

/// How they were chosen, in words.
const RULE: &str =
    "a fifth by field zone: of five rings of equal counts, one sector of 72 degrees each";

/// Scores `lens` on the tiles of `job` that were kept aside; `None` where there are none.
pub(super) fn held_out(job: &Job, lens: &LensProfile) -> Result<Option<HeldOut>> {
    if !job.aside.contains(&true) {
        return Ok(None);
    }
    let natural;
    let picture = match &job.settings.picture {
        Some(picture) => picture,
        None => {
            natural = TestImage::natural();
            &natural
        }
    };
    let correlation = ImageCorrelation::new(picture);
    let predictor = Predictor::new(lens)?;
    let mut groups = Vec::new();
    let (mut decibels, mut gaps) = (Vec::new(), Vec::new());
    for (channel, name) in job.channel_names().iter().enumerate() {
        for distance in distances(job) {
            let tiles: Vec<&MeasuredTile> = job
                .measured
                .iter()
                .zip(&job.aside)
                .filter(|(m, aside)| **aside && m.channel == channel && m.distance == distance)
                .map(|(m, _)| m)
                .collect();
            if tiles.is_empty() {
                continue;
            }
            let vergence = predictor.vergence(distance)?;
            // Squares may hold tiles of several sets, each measured in its own.
            let (side, placed) = place_tiles(job.sets, &tiles, &job.frame, job.settings.support);
            let scorer = correlation.scorer(side);
            let scores: Vec<(f64, f64)> = placed
                .par_iter()
                .map(|tile| {
                    let kernel = kernel_of_lens(&predictor, channel, vergence, tile, side);
                    let square = scorer.mean_square(&tile.truth);
                    let norm: f64 = tile.truth.iter().map(|v| v * v).sum();
                    let pairs = tile.truth.iter().zip(&kernel);
                    let gap = pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>() / norm;
                    (scorer.decibels(&tile.truth, square, &kernel), gap)
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

fn distances(job: &Job) -> Vec<ObjectDistance> {
    let mut all: Vec<ObjectDistance> = Vec::new();
    for tile in job.measured {
        if !all.contains(&tile.distance) {
            all.push(tile.distance);
        }
    }
    let rank = |d: &ObjectDistance| d.vergence_per_m().unwrap_or(f64::INFINITY);
    all.sort_by(|a, b| rank(a).total_cmp(&rank(b)));
    all
}
