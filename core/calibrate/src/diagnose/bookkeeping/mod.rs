//! Mistakes in keeping books: a frame that is mirrored, a unit, exchanged labels. They are tried before effects.
//!
//! Each is a change of the set, whose amount if any is estimated, so that it costs a prediction and no fit. The right one leaves what the
//! lens always leaves; an effect of optics is closed by none. Beside a strong effect a mistake is only suspected: it is one if effects do
//! not explain the gap with it, and do without it.

mod crop;
mod encodings;
mod estimates;
pub(super) mod exchanged;
mod mistakes;
mod sharpening;
#[cfg(test)]
mod tests;

use schemars::JsonSchema;
use seidel_optics::error::Result;
use seidel_optics::observations::ObservationSet;
use seidel_optics::predict::Predictor;
use seidel_optics::profile::{LensProfile, PupilChannel};
use serde::Serialize;

use super::Verdict;
use super::gap_problem::mean_gap;
use super::hypothesis::Hypothesis;
use super::jitter;
use super::tiles::{TileData, TileSet};
use mistakes::Mistake;

/// Least gap that a mistake of any weight leaves.
const MIN_GAP: f64 = 0.01;
/// Ratio of that gap to the own gap of the lens.
const MIN_RATIO: f64 = 4.0;
/// Gaps up to this ratio to the least are equal: of equal mistakes the commonest is named.
const EQUAL: f64 = 1.25;
/// Largest gap that the right mistake leaves: what an effect beside it makes.
const MAX_LEFT: f64 = 0.4;
/// Largest share of the gap that a suspected mistake leaves.
const SUSPECTED: f64 = 0.6;
/// PSFs that are compared with each prediction.
const SAMPLE: usize = 16;

/// A mistake in the books of a set, and the set without it.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Bookkeeping {
    /// Identifier of the mistake.
    pub mistake: &'static str,
    /// The mistake as a sentence.
    pub words: String,
    /// The change that corrects it, as a sentence.
    pub remedy: String,
    /// Gap with the mistake, over a sample of the PSFs.
    pub gap_before: f64,
    /// Gap of the same PSFs without it.
    pub gap_after: f64,
    /// Verdict on the corrected set, to which all other figures belong.
    pub verdict: Verdict,
    /// The corrected set.
    #[serde(skip)]
    pub corrected: ObservationSet,
}

/// A mistake as it was found.
pub(super) enum Finding {
    /// It explains most of the gap.
    Sure(Bookkeeping),
    /// It explains a part of the gap, and effects may explain the rest.
    Suspected(Bookkeeping),
}

/// Looks for a mistake that explains the gap between `lens`, whose own gap is `own_gap`, and `set`, or a part of it.
///
/// # Errors
/// A set that cannot be compared with the lens.
pub(super) fn find(
    lens: &LensProfile,
    channels: &[PupilChannel],
    set: &ObservationSet,
    own_gap: f64,
) -> Result<Option<Finding>> {
    let sample = sample(set);
    // A few PSFs may cover too little of the field, where all of them do not.
    let Ok(before) = gap(lens, channels, &sample) else {
        return Ok(None);
    };
    if before < MIN_GAP.max(MIN_RATIO * own_gap) {
        return Ok(None);
    }
    let nothing = Hypothesis::nothing(channels.len());
    let tiles = placed_tiles(lens, channels, &sample)?;
    // Before encodings, which a black level beside a tone curve resembles.
    let mut all = estimates::of(&nothing, &tiles, &sample);
    all.extend(mistakes::of_frame_and_samples(&sample));
    if Predictor::new(lens)?.depends_on_depth() {
        all.extend(mistakes::of_distances(&sample));
    }
    // A change may lead out of the range of the lens, and is then none.
    let tried = all.into_iter().filter_map(|mistake| {
        let corrected = mistake.correct(&sample)?;
        Some((gap(lens, channels, &corrected).ok()?, mistake))
    });
    let tried: Vec<(f64, Mistake)> = tried.collect();
    let least = tried.iter().map(|(gap, _)| *gap);
    let least = least.fold(f64::INFINITY, f64::min).max(0.0);
    let best = tried.into_iter().filter(|(after, _)| {
        *after <= EQUAL * least + 1e-4 && *after <= MAX_LEFT.min(SUSPECTED * before)
    });
    let is_sure = |(after, mistake): &(f64, Mistake)| *after <= mistake.largest_share * before;
    let (mut sure, suspected): (Vec<_>, Vec<_>) = best.partition(is_sure);
    if sure.is_empty() {
        let gap_of = |set: &ObservationSet| gap(lens, channels, set).ok();
        sure.extend(crop::find(&sample, before, gap_of));
    }
    let found = |(after, mistake): (f64, Mistake)| {
        Some(Bookkeeping {
            corrected: mistake.correct(set)?,
            mistake: mistake.id,
            words: mistake.words,
            remedy: mistake.remedy,
            gap_before: before,
            gap_after: after,
            verdict: Verdict::NoGap,
        })
    };
    Ok(if sure.is_empty() {
        let first = suspected.into_iter().next();
        first.and_then(found).map(Finding::Suspected)
    } else {
        let first = sure.into_iter().next();
        first.and_then(found).map(Finding::Sure)
    })
}

/// Returns a set of some observations, spread over the order of `set` and over its distances.
fn sample(set: &ObservationSet) -> ObservationSet {
    let mut chosen = Vec::new();
    let distances = set.distances();
    let share = SAMPLE.div_ceil(distances.len().max(1)).max(4);
    for distance in distances {
        let own = set.observations.iter().filter(|o| o.distance == distance);
        let own: Vec<_> = own.collect();
        let stride = own.len().div_ceil(share).max(1);
        chosen.extend(own.into_iter().step_by(stride).cloned());
    }
    ObservationSet {
        observations: chosen,
        ..set.clone()
    }
}

/// Returns the tiles of `set`, each where the lens agrees best with it if its position is not known.
fn placed_tiles(
    lens: &LensProfile,
    channels: &[PupilChannel],
    set: &ObservationSet,
) -> Result<Vec<TileData>> {
    let mut tiles = TileSet::new(lens, channels, set, &[])?.tiles;
    jitter::place_by_pixels(&Hypothesis::nothing(channels.len()), &[], &mut tiles);
    Ok(tiles)
}

/// Returns the mean gap of `set`, less noise.
fn gap(lens: &LensProfile, channels: &[PupilChannel], set: &ObservationSet) -> Result<f64> {
    let tiles = placed_tiles(lens, channels, set)?;
    Ok(mean_gap(&Hypothesis::nothing(channels.len()), &tiles))
}
