//! Lenses measured at one distance: how defocus changes with distance is taken from the data of the camera.

use super::context::FitContext;
use super::defocus_starts;
use crate::fit::initial::InitialEstimate;
use seidel_optics::profile::PupilChannel;

/// Returns the defocus of a thin lens by the camera's data, if all tiles are of one known distance.
pub(super) fn law_of_camera(context: &FitContext) -> Option<InitialEstimate> {
    let is_known = |m: &crate::measure::MeasuredTile| m.distance.vergence_per_m().is_some();
    if context.vergences.len() != 1 || !context.measured.iter().all(is_known) {
        return None;
    }
    defocus_starts::of_camera(&context.sets[0])
}

/// Gives the defocus of `channel`, measured at `vergence`, the slope of `camera`.
pub(super) fn set_law(channel: &mut PupilChannel, camera: &InitialEstimate, vergence: f64) {
    let [_, slope] = camera.alpha;
    if let [constant] = &mut channel.alpha.coefficients[..] {
        *constant -= slope * vergence;
        channel.alpha.coefficients.push(slope);
        // Unknown.
        channel.alpha.sigma.push(0.0);
    }
}

/// Returns what is known of other distances, in words; `None` where several were measured.
pub(super) fn remark(context: &FitContext, law: Option<&InitialEstimate>) -> Option<String> {
    let distance = context.measured.first()?.distance;
    if context.vergences.len() != 1 || distance.vergence_per_m().is_none() {
        return None;
    }
    Some(if law.is_some() {
        format!(
            "all PSFs are at {distance}: at other distances, and with another focus, defocus is that of a thin lens with the focal length, f-number and focus distance of the set, and other aberrations stay. None of it was measured: add a set at a second and a third distance"
        )
    } else {
        format!(
            "all PSFs are at {distance}: the blur is the same at every other distance, and focus cannot change it. Give focal_length_mm, f_number, focus_distance_m and the pixel pitch in the manifest, or add a set at a second and a third distance"
        )
    })
}
