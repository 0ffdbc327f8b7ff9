//! The sim-to-real gap: where a lens and observations differ, which effect the lens lacks, and how far the
//! gap shrinks once it is added.
//!
//! Tiles are compared with the lens's own predictions on their pixel grid (`seen`, `picture`). Every
//! effect, and pairs of them, are fitted (`hypothesis`, `descent`, `search`) and scored on zones of the
//! field left out; what they leave gives the odds (`odds`). The best is fitted again to all tiles, and
//! without each zone in turn for the figures that are reported (`proof`).

mod captures;
mod ceiling;
mod descent;
mod diagnosis;
mod hypothesis;
mod jitter;
mod odds;
mod pair;
mod picture;
mod places;
mod proof;
mod search;
mod seen;
mod settings;
mod shape;
mod verdict;

pub use diagnosis::{
    Cause, Diagnosis, Example, Gap, Order, Pair, Place, Shape, TileGap, Value, Verdict,
};
pub use pair::{PairEstimate, PairSettings, Picture, estimate_pair};
pub use settings::{Progress, Settings};

use search::{Candidate, Ground};
use seen::SeenSet;
use seidel_optics::effects::{self, Effect};
use seidel_optics::error::{Error, Result};
use seidel_optics::observations::ObservationSet;
use seidel_optics::profile::{LensDescription, LensProfile, PupilChannel};

/// Scatter of ideal positions that is told, px.
const TOLD_PX: f64 = 0.02;
/// Singles that are searched with more tiles.
const REFINED: usize = 4;
/// Singles of which pairs are made, and pairs that are searched with more tiles.
const PAIRED: usize = 4;
const REFINED_PAIRS: usize = 3;

/// Diagnoses the gap between `lens` and `set`.
///
/// # Errors
/// A lens described by moments, another frame or channels than the lens's, unknown distances where the
/// lens depends on them, too few observations, an unknown effect, and a stop on request.
pub fn diagnose(
    lens: &LensProfile,
    set: &ObservationSet,
    settings: &Settings,
    progress: &Progress,
) -> Result<Diagnosis> {
    let channels = rays(lens)?;
    let library = library(settings)?;
    let mut seen = SeenSet::new(lens, channels, set)?;
    let reference = reference(lens, channels);
    let first = seen.tiles.clone();
    let ground = Ground::new(&first, channels.len(), reference);
    let (tried, left): (Vec<_>, Vec<_>) = library.into_iter().partition(|e| ground.can_try(*e));
    let steps = tried.len() as f64 + 4.0;
    let mut singles: Vec<Candidate> = Vec::new();
    for (done, effect) in tried.iter().enumerate() {
        progress.step(done as f64 / steps)?;
        singles.push(ground.single(*effect));
    }
    singles.sort_by(|a, b| a.after.total_cmp(&b.after));
    if let Some(best) = singles.first() {
        let jitter_px = jitter::take_off(best, &mut seen.tiles);
        if jitter_px > TOLD_PX {
            seen.remarks.push(format!(
                "ideal positions scatter by {jitter_px:.2} px at random: taken off"
            ));
        }
    }
    let ground = Ground::new(&seen.tiles, channels.len(), reference);
    let rest = singles.split_off(REFINED.min(singles.len()));
    let refined = singles.into_iter().map(|single| ground.refined(single));
    let rest = rest.into_iter().map(|single| ground.rescored(single));
    let mut singles: Vec<Candidate> = refined.chain(rest).collect();
    singles.sort_by(|a, b| a.after.total_cmp(&b.after));
    let stage = verdict::Stage::new(lens, &ground, &singles);
    let pairs = if settings.pairs && stage.wants_pairs() {
        pairs(&ground, &singles, |share| {
            progress.step((tried.len() as f64 + 3.0 * share) / steps)
        })?
    } else {
        Vec::new()
    };
    progress.step((steps - 1.0) / steps)?;
    let decided = stage.decide(&singles, &pairs);
    proof::diagnosis(proof::Found {
        lens,
        channels,
        set,
        seen: &seen,
        ground: &ground,
        stage: &stage,
        singles: &singles,
        pairs: &pairs,
        decided: &decided,
        left: &left,
    })
}

/// The pairs worth trying: each of the best singles with every other effect.
fn pairs(
    ground: &Ground,
    singles: &[Candidate],
    progress: impl Fn(f64) -> Result<()>,
) -> Result<Vec<Candidate>> {
    let mut found: Vec<Candidate> = Vec::new();
    let first = PAIRED.min(singles.len());
    for (i, one) in singles[..first].iter().enumerate() {
        progress(i as f64 / first as f64)?;
        let others: Vec<&Candidate> = singles.iter().skip(i + 1).collect();
        for other in ground.promising(one, &others) {
            found.push(ground.pair(one, other));
        }
    }
    found.sort_by(|a, b| a.after.total_cmp(&b.after));
    let rest = found.split_off(REFINED_PAIRS.min(found.len()));
    let refined = found.into_iter().map(|pair| ground.refined(pair));
    let mut found: Vec<Candidate> = refined.chain(rest).collect();
    found.sort_by(|a, b| a.after.total_cmp(&b.after));
    Ok(found)
}

fn rays(lens: &LensProfile) -> Result<&[PupilChannel]> {
    match &lens.description {
        LensDescription::Pupil(channels) => Ok(channels),
        LensDescription::Moments(_) => Err(Error::new(
            "kind",
            "is `moments`; a diagnosis needs a lens known ray by ray",
            "fit the lens with `--model reduced`",
        )),
    }
}

fn library(settings: &Settings) -> Result<Vec<&'static dyn Effect>> {
    if settings.library.is_empty() {
        return Ok(effects::ALL.to_vec());
    }
    settings
        .library
        .iter()
        .map(|id| effects::by_id(id))
        .collect()
}

/// The channel of middle wavelength; the middle one where wavelengths are not known.
fn reference(lens: &LensProfile, channels: &[PupilChannel]) -> usize {
    let known: Option<Vec<f64>> = channels
        .iter()
        .map(|c| lens.camera.wavelength_nm.get(&c.name).copied())
        .collect();
    let named = || channels.iter().position(|c| c.name == "G");
    known.map_or_else(
        || named().unwrap_or(channels.len() / 2),
        |waves| {
            let mut order: Vec<usize> = (0..waves.len()).collect();
            order.sort_by(|a, b| waves[*a].total_cmp(&waves[*b]));
            order[order.len() / 2]
        },
    )
}
