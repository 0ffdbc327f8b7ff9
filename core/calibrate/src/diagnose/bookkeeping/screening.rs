//! Mistakes beside strong effects: the gap that a mistake and the best single effect leave together, in a few iterations.

use rayon::prelude::*;
use seidel_optics::effects::Effect;
use seidel_optics::observations::ObservationSet;
use seidel_optics::profile::{LensProfile, PupilChannel};

use super::super::coverage::Coverage;
use super::super::hypothesis::LensChannels;
use super::super::is_carried_once;
use super::super::search::HypothesisSearch;
use super::mistakes::Mistake;
use super::placed_tiles;
use crate::reference_channel::reference_channel;

/// Mistakes that are tried with effects, those that leave least alone.
const TRIED: usize = 4;
/// Ratio of gaps up to which two mistakes change the tiles alike, as the symmetries of a symmetric lens do; one of them is tried.
const ALIKE: f64 = 1.02;
/// Largest ratio of the gap that the best effect leaves with the mistake to that without, below which the mistake is suspected.
const SUSPECTED: f64 = 0.5;

/// Returns the mistake beside which a single effect of `library` leaves least of `sample`, with the gap that it leaves alone; `None` where effects leave
/// nearly as little without. `tried` are all mistakes with the gaps that they leave, the likelier of equal ones first.
pub(super) fn best(
    lens: &LensProfile,
    channels: &[PupilChannel],
    sample: &ObservationSet,
    before: f64,
    library: &[&'static dyn Effect],
    mut tried: Vec<(f64, Mistake)>,
) -> Option<(f64, Mistake)> {
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    tried.dedup_by(|next, kept| next.0 <= ALIKE * kept.0.max(0.0) + 1e-4);
    tried.retain(|(after, _)| *after < before);
    tried.truncate(TRIED);
    let without = left_by_best_effect(lens, channels, sample, library)?;
    let with = tried.into_iter().filter_map(|(after, mistake)| {
        let corrected = mistake.correct(sample)?;
        let left = left_by_best_effect(lens, channels, &corrected, library)?;
        Some((left, after, mistake))
    });
    let (left, after, mistake) = with.min_by(|a, b| a.0.total_cmp(&b.0))?;
    (left < SUSPECTED * without).then_some((after, mistake))
}

/// Returns the gap that the best single effect of `library` leaves of `set` after a few iterations on a draft mesh.
fn left_by_best_effect(
    lens: &LensProfile,
    channels: &[PupilChannel],
    set: &ObservationSet,
    library: &[&'static dyn Effect],
) -> Option<f64> {
    let tiles = placed_tiles(lens, channels, set).ok()?;
    let names = channels.iter().map(|c| c.name.as_str());
    let reference = reference_channel(&lens.camera, names);
    let of_lens = LensChannels::of(&tiles, channels.len(), reference);
    let search = HypothesisSearch::new(&tiles, &of_lens);
    let coverage = Coverage::of(&tiles);
    let can_try = |effect: &&'static dyn Effect| {
        coverage.shows(*effect)
            && !is_carried_once(channels, *effect)
            && !search.starts(*effect).is_empty()
            && search.can_try(*effect)
    };
    let library: Vec<&'static dyn Effect> = library.iter().copied().filter(can_try).collect();
    let left = library
        .par_iter()
        .map(|effect| search.outlined_gap(*effect));
    let least = left.min_by(f64::total_cmp)?;
    Some(least.max(0.0))
}
