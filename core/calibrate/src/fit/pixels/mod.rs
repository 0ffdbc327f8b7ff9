//! A whole lens from the pixels of all its tiles: `--model reduced` and `--model extended`.
//!
//! Starts come from moments ([`super::starts`]); each is tried on a few tiles, and the best is refined
//! on all of them over all distances and channels at once (`descent`). How freely each number may
//! change with vergence is decided by distances left out, and what the law leaves at the measured
//! ones is kept where zones of the field left out say so (`law`). Effects are added one by one
//! (`extend`). A fifth of the PSFs takes no part in any of this and says how good it is (`score`).

mod change;
mod descent;
mod errors;
mod extend;
mod job;
mod law;
mod layout;
mod metric;
mod report;
mod score;
#[cfg(test)]
mod tests;
mod tile;

pub use errors::{Correlation, Unclear};
pub use layout::{Freedom, Quantity, Structure};
pub use metric::Metric;
pub use report::{ChannelReport, PupilFit};

use super::{AxisChoice, axis, displacement, holdout, one_camera, plane};
use crate::measure::{MeasuredTile, Rejection, measure};
use crate::score::TestImage;
use job::Job;
use seidel_optics::error::{Error, Result};
use seidel_optics::field::FieldPoint;
use seidel_optics::moments::support::Support;
use seidel_optics::observations::ObservationSet;

/// How to fit the pixels of a lens.
#[derive(Debug, Clone, Default)]
pub struct PupilSettings {
    /// Whether effects are added.
    pub extension: Extension,
    /// Where the optical axis is.
    pub axis: AxisChoice,
    /// Which pixels of a tile take part.
    pub support: Support,
    /// Whether all PSFs take part, and none is kept aside.
    pub use_all: bool,
    /// Whether the lens is the same law over all distances, without what it leaves at each.
    pub law_only: bool,
    /// The picture through which kept-aside PSFs are compared; one with natural statistics if none.
    pub picture: Option<TestImage>,
}

/// Whether a fit adds effects, fifth-order aberrations and vignetting, to the reduced numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Extension {
    /// It does not.
    #[default]
    Never,
    /// Where PSFs kept aside show that third order falls short, and that effects mend it.
    WhereNeeded,
    /// It does.
    Always,
}

/// Mean gap of PSFs kept aside from which on third order falls short, and the forward-blur signal to
/// noise that effects must gain to be kept, dB.
const FALLS_SHORT: f64 = 1e-3;
const GAINS_DB: f64 = 1.0;

/// Fits a lens ray by ray to one or more observation sets of one camera.
///
/// # Errors
/// Sets of different frames or channels, known and unknown distances mixed, and channels with too few
/// usable tiles to start from.
pub fn fit_pupil(sets: &[ObservationSet], settings: &PupilSettings) -> Result<PupilFit> {
    let first = one_camera(sets)?;
    let mut frame = match settings.axis {
        AxisChoice::At(axis) => first.frame.with_axis(axis)?,
        AxisChoice::AsObserved | AxisChoice::Free => first.frame,
    };
    let mut rejected = Vec::new();
    let measured = measure(sets, settings.support, &mut rejected);
    // Also says which distances are mixed, and which channels have no tile.
    let groups = super::grouped(sets, &measured)?;
    if settings.axis == AxisChoice::Free {
        let found = axis::find_axis(
            &frame,
            &super::groups_of_tiles(&groups),
            plane::Weighting::Weighted,
        )?;
        frame = frame.with_axis(found.axis)?;
    }
    let aside = kept_aside(sets, &measured, &frame, settings);
    let mut job = Job::new(sets, settings, frame, &measured, aside);
    let mut fit = job.begin()?;
    fit = law::choose(&job, fit, &law::REDUCED)?;
    if settings.extension == Extension::Always {
        fit = extend::extend(&job, fit)?;
    }
    if settings.axis == AxisChoice::Free {
        fit = job.free_axis(fit);
        job.settle_axis(&mut fit)?;
    }
    let reduced = finish(&job, fit.clone(), &rejected)?;
    let short = |f: &PupilFit| {
        (f.lens.held_out.as_ref())
            .filter(|h| h.pixel_gap > FALLS_SHORT)
            .cloned()
    };
    let Some(before) = short(&reduced).filter(|_| settings.extension == Extension::WhereNeeded)
    else {
        return Ok(reduced);
    };
    let mut extended = finish(&job, extend::extend(&job, fit)?, &rejected)?;
    let gained = extended
        .lens
        .held_out
        .as_ref()
        .map_or(0.0, |h| h.snr_db - before.snr_db);
    if gained < GAINS_DB {
        return Ok(reduced);
    }
    extended.remarks.push(format!(
        "third order falls short of these PSFs (gap {:.4}): fifth order and vignetting were added, which gain {gained:.1} dB on PSFs kept aside",
        before.pixel_gap
    ));
    Ok(extended)
}

/// The lens with errors, what its law leaves, and its score.
fn finish(job: &Job, fit: job::Fitted, rejected: &[Rejection]) -> Result<PupilFit> {
    let errors = errors::Errors::of(job, &fit);
    let remainders = if job.settings.law_only {
        Vec::new()
    } else {
        law::remainders(job, &fit)
    };
    report::assemble(job, fit, &errors, &remainders, rejected.to_vec())
}

/// Which measured tiles take no part in the fit.
fn kept_aside(
    sets: &[ObservationSet],
    measured: &[MeasuredTile],
    frame: &seidel_optics::field::Frame,
    settings: &PupilSettings,
) -> Vec<bool> {
    if settings.use_all {
        return vec![false; measured.len()];
    }
    let places: Vec<FieldPoint> = measured
        .iter()
        .map(|tile| {
            let observation = &sets[tile.set].observations[tile.observation];
            frame.field_point(observation.ideal.unwrap_or(observation.centre))
        })
        .collect();
    holdout::held_out(frame, &places)
}

/// The error of a channel that no lens could be started for.
fn no_start(channel: &str) -> Error {
    Error::new(
        format!("channel {channel}"),
        "has too few tiles, or tiles too alike, to start a fit from",
        "give PSFs at a dozen places or more, from the axis to the corners",
    )
}
