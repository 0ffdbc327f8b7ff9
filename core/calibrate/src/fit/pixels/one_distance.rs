//! Lenses measured at one distance.

use super::context::FitContext;

/// Returns what is known of other distances, in words; `None` where several were measured, or where the distance is unknown.
pub(super) fn remark(context: &FitContext) -> Option<String> {
    let distance = context.measured.first()?.distance;
    if context.vergences.len() != 1 || distance.vergence_per_m().is_none() {
        return None;
    }
    Some(format!(
        "all PSFs are at {distance}: the blur is the same at every other distance, and focus cannot change it. Add a set at a second and a third distance"
    ))
}
