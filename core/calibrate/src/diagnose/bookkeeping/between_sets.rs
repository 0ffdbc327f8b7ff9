//! Sets that are fitted together, of which one may hold a mistake in its books.

use seidel_optics::no_progress;
use seidel_optics::observations::ObservationSet;
use seidel_optics::profile::{LensProfile, MAX_EXCESS_DESCRIBED};

use super::super::find_mistake;
use super::{Bookkeeping, FoundMistake};
use crate::fit::{PupilModel, PupilSettings, fit_pupil};

/// A mistake in one of several sets.
#[derive(Debug, Clone)]
pub struct MistakeInSet {
    /// Index of the set.
    pub set: usize,
    /// The mistake, against a lens fitted to the set with the most distances.
    pub found: Bookkeeping,
}

/// Looks for mistakes in the books of `sets`, to which `lens` was fitted together. Where the lens describes them there are none.
/// Otherwise a lens is fitted to one set, that with the most distances, and compared with the others.
pub fn mistakes_between(sets: &[ObservationSet], lens: &LensProfile) -> Vec<MistakeInSet> {
    let adequacy = (lens.held_out.as_ref()).and_then(|held_out| held_out.adequacy.as_ref());
    if sets.len() < 2 || adequacy.is_none_or(|a| a.excess_gap <= MAX_EXCESS_DESCRIBED) {
        return Vec::new();
    }
    let settings = PupilSettings {
        model: PupilModel::Reduced,
        ..PupilSettings::default()
    };
    let rank = |set: &ObservationSet| (set.distances().len(), set.observations.len());
    let Some(reference) = (0..sets.len()).max_by_key(|k| rank(&sets[*k])) else {
        return Vec::new();
    };
    let own = std::slice::from_ref(&sets[reference]);
    let Ok(fit) = fit_pupil(own, &settings, &no_progress) else {
        return Vec::new();
    };
    let others = (sets.iter().enumerate()).filter(|(index, _)| *index != reference);
    let found = others.filter_map(|(set, observed)| {
        let found = find_mistake(&fit.lens, observed).ok()?;
        let found = found.and_then(FoundMistake::sure)?;
        Some(MistakeInSet { set, found })
    });
    found.collect()
}
