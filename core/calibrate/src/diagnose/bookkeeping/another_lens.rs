//! The set of another lens.

use seidel_optics::observations::ObservationSet;
use seidel_optics::profile::LensProfile;

use super::super::{Capture, Diagnosis, Verdict};
use super::Bookkeeping;

/// Least gap of the set of another lens, and the least that effects leave of it: as much as no cause of a lens that is what it should be.
const MIN_GAP: f64 = 0.5;
const MIN_LEFT: f64 = 0.25;

/// Returns `diagnosis`, or that `set` is that of another lens, where neither a change of its books nor effects bring it near `lens`. Effects
/// that close a part are not added then: they imitate another lens.
pub(in super::super) fn or_another_lens(
    lens: &LensProfile,
    set: &ObservationSet,
    mut diagnosis: Diagnosis,
) -> Diagnosis {
    let gap = &mut diagnosis.gap;
    if gap.before < MIN_GAP || gap.after < MIN_LEFT {
        return diagnosis;
    }
    let found = Bookkeeping {
        mistake: "another_lens",
        words: format!(
            "this looks like the set of another lens: {}, neither a change of its books nor an effect brings it near this one{}",
            match gap.after < gap.before {
                true => format!("{:.0} % of the energy of a PSF remains", 100.0 * gap.after.min(1.0)),
                false => "nothing of the gap closes".to_owned(),
            },
            names(lens, set)
        ),
        remedy: "Compare the set with the lens that it was taken with, at the settings at which it was taken.".to_owned(),
        gap_before: gap.before,
        gap_after: gap.after.min(gap.before),
        can_be_corrected: false,
        verdict: Verdict::Unexplained,
        corrected: set.clone(),
    };
    gap.after = gap.before;
    (gap.closed, gap.closed_ci95) = (0.0, [0.0; 2]);
    for tile in &mut diagnosis.tiles {
        tile.after = tile.before;
    }
    Diagnosis {
        verdict: Verdict::Bookkeeping,
        bookkeeping: Some(found),
        added: Vec::new(),
        equivalents: Vec::new(),
        next_capture_id: Capture::None,
        next_capture: "none before it is certain that the set is of this lens".to_owned(),
        places_left: diagnosis.places.clone(),
        corrected: lens.clone(),
        ..diagnosis
    }
}

/// Returns the names of both lenses where both are stated, and whether they differ.
fn names(lens: &LensProfile, set: &ObservationSet) -> String {
    let stated = [&set.camera, &lens.camera].map(|camera| {
        let (model, serial) = (&camera.lens_model, &camera.lens_serial_number);
        let parts = [model.as_deref(), serial.as_deref()];
        parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
    });
    match stated {
        [set, lens] if set.is_empty() || lens.is_empty() => String::new(),
        [set, lens] if set == lens => format!(", though both state {lens}"),
        [set, lens] => format!("; the set states {set}, the lens {lens}"),
    }
}
