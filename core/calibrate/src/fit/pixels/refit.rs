//! A second fit of a model that a fit has selected: to all tiles, or with other weights.

use super::context::FitContext;
use super::report::PupilFit;
use super::{PupilSettings, check_squeeze, finish};
use crate::fit::{check_same_camera, group_tiles};
use crate::measure::measure;
use crate::stage::Stage;
use seidel_optics::Progress;
use seidel_optics::error::Result;
use seidel_optics::observations::ObservationSet;

/// Fits the model of `first`, with its parts and its optical axis, to all PSFs of `sets`, starting from its parameters.
///
/// The selection of the model, which takes most of the time of [`fit_pupil`](super::fit_pupil), is not repeated.
/// [`PupilSettings::model`] and [`PupilSettings::axis`] have no effect, and no PSF is held out.
///
/// # Errors
/// Sets that differ in frame or channels from each other, and cancellation by `progress`.
pub fn refit_pupil(
    sets: &[ObservationSet],
    first: &PupilFit,
    settings: &PupilSettings,
    progress: &Progress,
) -> Result<PupilFit> {
    let stage = Stage::whole(progress, "fit");
    stage.reach(0.0)?;
    let frame = check_same_camera(sets)?
        .frame
        .with_axis(first.lens.frame.axis())?;
    let settings = PupilSettings {
        use_all: true,
        ..settings.clone()
    };
    let mut rejected = Vec::new();
    let measured = measure(sets, settings.support, &mut rejected);
    group_tiles(sets, &measured)?;
    let held_out = vec![false; measured.len()];
    let context = FitContext::new(sets, &settings, frame, &measured, held_out);
    let found = &first.fitted;
    let layout = found.layout.with_known_axis();
    let theta = layout.transfer(&found.layout, &found.theta);
    let fit = context.refine(&layout, theta, found.metric);
    let refitted = finish(&context, fit, &rejected, stage.part(0.5, 1.0))?;
    check_squeeze(sets, &refitted.lens)?;
    stage.reach(1.0)?;
    Ok(refitted)
}
