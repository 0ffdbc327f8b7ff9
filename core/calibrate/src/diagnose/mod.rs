//! Diagnosis of the gap between a lens and observations: the missing effect, and the gap after it is added.
//!
//! Mistakes in the books of the observations come first (`bookkeeping`).
//! Tiles are compared with the lens's predictions on their pixel grid (`tiles`, `prediction`). Every effect,
//! and two or three of them jointly, are fitted by Levenberg-Marquardt (`hypothesis`, `gap_problem`, `search`, `joint`) and scored
//! by cross-validation over field zones. The scores give posterior probabilities (`posterior`) and a verdict
//! (`verdict`). The selected effects are fitted to all tiles, and without each zone in turn for the reported
//! figures (`proof`). Every effect says in plain words what it means (`cause_words`) and what its fitted values amount to;
//! the next capture is chosen by the responses of the remaining causes (`capture`, `next_capture`). Effects that
//! the observed places cannot show are not tried (`coverage`).

mod bookkeeping;
mod capture;
mod cause_words;
mod centroid_start;
mod coverage;
mod diagnosis;
mod explainable;
mod gap_problem;
mod hypothesis;
mod jitter;
mod joint;
mod joint_search;
mod matched_filter;
mod model_share;
mod next_capture;
mod one_distance;
mod pair;
mod places;
mod posterior;
mod prediction;
mod proof;
mod registration;
mod search;
mod settings;
mod shape;
mod shift_basis;
mod subsample;
mod tile_noise;
mod tiles;
mod verdict;

pub use bookkeeping::{Bookkeeping, FoundMistake, MistakeInSet, mistakes_between};
pub use capture::Capture;
pub use cause_words::{CauseWords, cause_words};
pub use diagnosis::{
    Cause, Diagnosis, Example, Gap, Order, Pair, Place, Shape, Shares, TileGap, Verdict, Zone,
};
pub use model_share::{ModelShare, OwnGapSource};
pub use pair::{
    PairEstimate, PairGeometry, PairImage, PairSettings, PlacedPictures, Quantisation, StoredCurve,
    TileResponse, estimate_pair,
};
pub use settings::DiagnosisSettings;

use crate::reference_channel::reference_channel;
use bookkeeping::Books;
use coverage::Coverage;
use hypothesis::{Hypothesis, LensChannels};
use search::{Candidate, HypothesisSearch};
use seidel_optics::Progress;
use seidel_optics::effects::{self, Effect};
use seidel_optics::error::{Error, Result};
use seidel_optics::observations::ObservationSet;
use seidel_optics::profile::{LensDescription, LensProfile, PupilChannel};
use tiles::{TileData, TileSet};

/// Random error of ideal positions above which a remark reports it, px.
const MIN_REPORTED_JITTER_PX: f64 = 0.02;
/// Single effects refined on more tiles: at most this many, of those that leave at most this ratio of the gap that the best
/// leaves.
const REFINED_SINGLES: usize = 4;
const REFINED_RATIO: f64 = 4.0;
/// Detection limits that effects leave where mistakes are looked for beside them.
const LEFT_LIMITS: f64 = 1.5;
/// Largest number of mistakes beside effects that are diagnosed. The right one leaves at most this share of the gap that effects alone leave.
const MAX_BESIDE_EFFECTS: usize = 2;
const MISTAKE_LEAVES: f64 = 0.3;

/// Diagnoses the gap between `lens` and `set`. A mistake in the books of the set is looked for before effects, and effects after
/// it is corrected.
///
/// # Errors
/// A lens described by moments, another frame or channels than the lens's, unknown distances where the
/// lens depends on them, too few observations, an unknown effect, and a stop on request.
pub fn diagnose(
    lens: &LensProfile,
    set: &ObservationSet,
    settings: &DiagnosisSettings,
    progress: &Progress,
) -> Result<Diagnosis> {
    let channels = rays(lens)?;
    if let Some(found) = exchanged_sets(lens, channels, set, settings) {
        let settings = DiagnosisSettings {
            design: Some(set.clone()),
            ..settings.clone()
        };
        let model = ModelShare::of(lens, channels, settings.design.as_ref())?;
        return diagnose_corrected(lens, found, &settings, model, progress);
    }
    let model = ModelShare::of(lens, channels, settings.design.as_ref())?;
    // Tiles that this program estimated are placed and named by it.
    let books = match settings.responses.is_empty() {
        true => bookkeeping::find(lens, channels, set, model.own_gap)?,
        false => Books::default(),
    };
    let suspected = match books.found {
        Some(FoundMistake::Sure(found)) => {
            let mut diagnosis = diagnose_corrected(lens, *found, settings, model, progress)?;
            diagnosis.remarks.extend(books.remark);
            return Ok(diagnosis);
        }
        Some(FoundMistake::Suspected(found)) => Some(*found),
        None => None,
    };
    let half = |share: f64| progress(0.5 * share);
    let mut as_stated = diagnose_effects(lens, set, settings, model.clone(), &half)?;
    as_stated.remarks.extend(books.remark);
    if !settings.responses.is_empty() || !leaves_a_part(&as_stated) {
        return Ok(as_stated);
    }
    let mut candidates = bookkeeping::beside_effects(
        lens,
        channels,
        set,
        &as_stated.corrected,
        &library(settings)?,
        suspected,
    )?;
    candidates.truncate(MAX_BESIDE_EFFECTS);
    let count = candidates.len() as f64;
    for (index, candidate) in candidates.into_iter().enumerate() {
        let part = |share: f64| progress(0.5 + 0.5 * (index as f64 + share) / count);
        let of_corrected = diagnose_corrected(lens, candidate, settings, model.clone(), &part)?;
        if is_better(&of_corrected, &as_stated) {
            return Ok(of_corrected);
        }
    }
    Ok(bookkeeping::or_another_lens(lens, set, as_stated))
}

/// Returns whether the effects of `diagnosis` leave more than is not seen, so that a mistake may stand beside them.
fn leaves_a_part(diagnosis: &Diagnosis) -> bool {
    match diagnosis.verdict {
        Verdict::Unexplained => true,
        Verdict::Explained | Verdict::Ambiguous => {
            diagnosis.gap.after > LEFT_LIMITS * diagnosis.detection_limit
        }
        Verdict::NoGap | Verdict::ModelTooSimple | Verdict::Bookkeeping => false,
    }
}

/// Returns whether the set without a mistake is explained, and far better than `as_stated`.
fn is_better(of_corrected: &Diagnosis, as_stated: &Diagnosis) -> bool {
    let is_explained = matches!(
        of_corrected.verdict_on_effects(),
        Verdict::Explained | Verdict::Ambiguous | Verdict::NoGap
    );
    is_explained && of_corrected.gap.after < MISTAKE_LEAVES * as_stated.gap.after
}

/// Returns the mistake that `set` is the one that `lens` was fitted to, and not that of `settings`.
fn exchanged_sets(
    lens: &LensProfile,
    channels: &[PupilChannel],
    set: &ObservationSet,
    settings: &DiagnosisSettings,
) -> Option<Bookkeeping> {
    let design = settings.design.as_ref()?;
    // A lens that does not state its own gap has a small one.
    let own_gap = ModelShare::of(lens, channels, None).map_or(0.0, |model| model.own_gap);
    bookkeeping::exchanged::find(lens, channels, set, design, own_gap)
}

/// Diagnoses the effects that `lens` lacks against the set without the mistake `found`.
fn diagnose_corrected(
    lens: &LensProfile,
    found: Bookkeeping,
    settings: &DiagnosisSettings,
    model: ModelShare,
    progress: &Progress,
) -> Result<Diagnosis> {
    let of_corrected = diagnose_effects(lens, &found.corrected, settings, model, progress)?;
    Ok(Diagnosis {
        verdict: Verdict::Bookkeeping,
        bookkeeping: Some(Bookkeeping {
            verdict: of_corrected.verdict,
            ..found
        }),
        ..of_corrected
    })
}

/// Looks for a mistake in the books of `set`, without a diagnosis. A lens described by moments has none.
///
/// # Errors
/// A set that cannot be compared with the lens.
pub fn find_mistake(lens: &LensProfile, set: &ObservationSet) -> Result<Option<FoundMistake>> {
    let LensDescription::Pupil(channels) = &lens.description else {
        return Ok(None);
    };
    // Unknown without the set that the lens was fitted to.
    let own_gap = ModelShare::of(lens, channels, None).map_or(0.0, |model| model.own_gap);
    Ok(bookkeeping::find(lens, channels, set, own_gap)?.found)
}

/// Diagnoses the effects that `lens` lacks, whose own gap is that of `model`.
fn diagnose_effects(
    lens: &LensProfile,
    set: &ObservationSet,
    settings: &DiagnosisSettings,
    mut model: ModelShare,
    progress: &Progress,
) -> Result<Diagnosis> {
    let channels = rays(lens)?;
    let library = library(settings)?;
    let mut tiles = TileSet::new(lens, channels, set, &settings.responses)?;
    let names = channels.iter().map(|c| c.name.as_str());
    let reference = reference_channel(&lens.camera, names);
    let nothing = Hypothesis::nothing(channels.len());
    jitter::place_by_pixels(&nothing, &[], &mut tiles.tiles);
    let first = tiles.tiles.clone();
    let of_lens = LensChannels::of(&first, channels.len(), reference);
    let search = HypothesisSearch::new(&first, &of_lens);
    let coverage = Coverage::of(&first);
    let (shown, mut left): (Vec<_>, Vec<_>) = library.into_iter().partition(|e| coverage.shows(*e));
    tiles.remarks.extend(coverage.remark(&left));
    let (carried, shown): (Vec<_>, Vec<_>) = shown
        .into_iter()
        .partition(|e| is_carried_once(channels, *e));
    if !carried.is_empty() {
        tiles.remarks.push(format!(
            "the lens has these effects, which cannot act twice, so they were not tried: {}",
            coverage::titles(&carried)
        ));
        left.extend(carried);
    }
    let (shown, at_other_distances): (Vec<_>, Vec<_>) =
        (shown.into_iter()).partition(|e| !search.starts(*e).is_empty());
    left.extend(at_other_distances);
    let (tried, in_one_channel): (Vec<_>, Vec<_>) =
        shown.into_iter().partition(|e| search.can_try(*e));
    if !in_one_channel.is_empty() {
        tiles.remarks.push(format!(
            "effects that one channel cannot show were not tried: {}",
            coverage::titles(&in_one_channel)
        ));
        left.extend(in_one_channel);
    }
    let steps = tried.len() as f64 + 4.0;
    let mut outlines = Vec::new();
    for (done, effect) in tried.iter().enumerate() {
        step(progress, 0.8 * done as f64 / steps)?;
        outlines.push(search.outline(*effect));
    }
    let drafts = search.drafts(outlines);
    let mut singles = search.singles(drafts);
    let mut jitter_px = 0.0;
    if let Some(best) = singles.first() {
        // Where most of the hypotheses that remain agree with the pixels, so that few tiles move with each.
        jitter::place_by_pixels(&best.hypothesis, &best.theta, &mut tiles.tiles);
        jitter_px = remove_scatter(&nothing, best, model.own_gap, &mut tiles.tiles);
        if jitter_px > MIN_REPORTED_JITTER_PX {
            tiles.remarks.push(format!(
                "ideal positions scatter by {jitter_px:.2} px at random: taken off"
            ));
        }
    }
    let search = HypothesisSearch::new(&tiles.tiles, &of_lens);
    let least = singles
        .first()
        .map_or(0.0, |best| best.after.max(posterior::MIN_GAP));
    let promising = singles.partition_point(|s| s.after <= REFINED_RATIO * least);
    let rest = singles.split_off(REFINED_SINGLES.min(promising));
    // The simpler of two that do as well is likelier, so it is compared at its best.
    let simpler: Vec<&str> = (singles.iter())
        .flat_map(|single| posterior::contained_in(single.hypothesis.ids()[0]))
        .collect();
    let (contained, rest): (Vec<_>, Vec<_>) =
        (rest.into_iter()).partition(|single| simpler.contains(&single.hypothesis.ids()[0]));
    singles.extend(contained);
    let refined = singles.into_iter().map(|single| search.refined(single));
    let rest = rest.into_iter().map(|single| {
        if jitter_px > 0.0 {
            search.rescored(single)
        } else {
            single
        }
    });
    let mut singles: Vec<Candidate> = refined.chain(rest).collect();
    one_distance::score_as_twins(&search, &mut singles);
    singles.sort_by(|a, b| a.after.total_cmp(&b.after));
    let statistics = verdict::GapStatistics::new(model.own_gap, &search, &singles);
    let joint = if settings.pairs && statistics.wants_pairs() {
        let acting = singles.iter().filter(|single| single.acts_as.is_none());
        let acting: Vec<Candidate> = acting.cloned().collect();
        joint::combinations(&search, &statistics, &acting, |share| {
            step(progress, (tried.len() as f64 + 3.0 * share) / steps)
        })?
    } else {
        Vec::new()
    };
    step(progress, (steps - 1.0) / steps)?;
    let decision = statistics.decide(&singles, &joint);
    if decision.verdict == Verdict::ModelTooSimple {
        model.find_freedom(lens, settings.design.as_ref().unwrap_or(set));
    }
    proof::diagnosis(proof::Findings {
        lens,
        channels,
        set,
        tiles: &tiles,
        search: &search,
        statistics: &statistics,
        singles: &singles,
        joint: &joint,
        decision: &decision,
        model,
        left: &left,
    })
}

/// Removes the scatter of positions from `tiles`, and returns it, px: against the given lens where that leaves no more than a lens of this
/// `own_gap` leaves anyway, and against the `best` effect otherwise. An effect that is not there follows the scatter.
fn remove_scatter(
    nothing: &Hypothesis,
    best: &Candidate,
    own_gap: f64,
    tiles: &mut Vec<TileData>,
) -> f64 {
    let mut against_lens = tiles.clone();
    let scatter_px = jitter::remove(nothing, &[], &mut against_lens);
    if gap_problem::mean_gap(nothing, &against_lens) < verdict::own_limit(own_gap) {
        *tiles = against_lens;
        return scatter_px;
    }
    jitter::remove(&best.hypothesis, &best.theta, tiles)
}

fn rays(lens: &LensProfile) -> Result<&[PupilChannel]> {
    match &lens.description {
        LensDescription::Pupil(channels) => Ok(channels),
        LensDescription::Moments(_) => Err(Error::new(
            "kind",
            "is `moments`; a diagnosis needs a lens described by its pupil",
            "fit the lens with the reduced model",
        )
        .with_kind(seidel_optics::ErrorKind::Unsupported)),
    }
}

/// Returns whether a channel has `effect`, of which a lens has one at most.
fn is_carried_once(channels: &[PupilChannel], effect: &dyn Effect) -> bool {
    let mut own = channels
        .iter()
        .flat_map(|c| c.effects.iter().chain(&c.added));
    effect.description().is_unique && own.any(|carried| carried.effect.id() == effect.id())
}

fn library(settings: &DiagnosisSettings) -> Result<Vec<&'static dyn Effect>> {
    if settings.library.is_empty() {
        return Ok(effects::causes().collect());
    }
    settings
        .library
        .iter()
        .map(|id| effects::by_id(id))
        .collect()
}

/// Reports the completed share.
///
/// # Errors
/// Cancellation.
fn step(progress: &Progress, share: f64) -> Result<()> {
    if progress(share) {
        Ok(())
    } else {
        Err(Error::cancelled("diagnosis"))
    }
}
