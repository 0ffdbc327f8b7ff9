//! The observed set and that of the fit, exchanged.

use seidel_optics::observations::ObservationSet;
use seidel_optics::profile::{LensProfile, PupilChannel};

use super::super::Verdict;
use super::{Bookkeeping, MIN_GAP, MIN_RATIO, gap, sample};

/// Returns the mistake that `lens`, of own gap `own_gap` by its profile, was fitted to `set` and not to `design`; `None` where it was not, or
/// where one of them cannot be compared with the lens.
pub(in super::super) fn find(
    lens: &LensProfile,
    channels: &[PupilChannel],
    set: &ObservationSet,
    design: &ObservationSet,
    own_gap: f64,
) -> Option<Bookkeeping> {
    let limit = MIN_GAP.max(MIN_RATIO * own_gap);
    let [of_set, of_design] = [set, design].map(|set| gap(lens, channels, &sample(set)).ok());
    let (of_set, of_design) = (of_set?, of_design?);
    let are_exchanged = of_design > limit && of_set < limit / 2.0;
    are_exchanged.then(|| Bookkeeping {
        mistake: "exchanged_sets",
        words: "the sets are exchanged: the lens was fitted to the observed one".to_owned(),
        remedy:
            "Give the set that the lens was fitted to as the design, and the other one as observed."
                .to_owned(),
        gap_before: of_design,
        gap_after: of_set.max(0.0),
        can_be_corrected: true,
        verdict: Verdict::NoGap,
        corrected: design.clone(),
    })
}
