//! Pixel fit: a lens described by its pupil, fitted to the pixels of all tiles (`--model reduced`,
//! `extended`).
//!
//! 1. Initial estimates come from moments ([`super::initial`]) and are compared on few tiles (`context`).
//! 2. The best is refined over all tiles, distances and channels by Levenberg-Marquardt with a robust loss
//!    per tile (`pixel_problem`). Flux and centroid of each tile are eliminated (`tile_equations`).
//! 3. The degrees of the parameters in vergence are selected by cross-validation over distances, and residual
//!    corrections per distance by cross-validation over field zones (`vergence_law`).
//! 4. The extended model adds fifth-order aberrations and the `parts` that held-out zones ask for (`extended`).
//! 5. Standard errors come from the Fisher information or a sandwich estimator (`covariance`). About a fifth
//!    of the PSFs are held out, score the result (`score`) and say how well the model describes the lens
//!    (`adequacy`).

mod adequacy;
pub(super) mod bounds;
mod context;
mod covariance;
mod defocus_starts;
mod extended;
mod focus_side;
mod jacobian;
mod leading_part;
pub(super) mod lens_equations;
mod metric;
mod noise_weights;
mod outliers;
pub(super) mod parameters;
mod part_log;
mod part_trial;
pub(super) mod parts;
mod pixel_problem;
mod pupil_sign;
mod refit;
mod registered_centroids;
mod report;
mod score;
#[cfg(test)]
mod tests;
mod tile_equations;
mod tilt_search;
mod vergence_law;

pub use covariance::{Correlation, PoorlyDetermined};
pub use metric::Metric;
pub use parameters::{ModelStructure, PolynomialSpec, Quantity};
pub use part_log::PartTrial;
pub use refit::refit_pupil;
pub use report::{ChannelReport, PupilFit};

use super::{AxisChoice, axis, check_same_camera, holdout, plane};
use crate::diagnose::cause_words;
use crate::measure::{MeasuredTile, Rejection, measure};
use crate::score::TestImage;
use crate::stage::Stage;
use context::FitContext;
use extended::Extended;
use seidel_optics::Progress;
use seidel_optics::effects::{self, Effect};
use seidel_optics::error::{Error, Result};
use seidel_optics::field::FieldPoint;
use seidel_optics::moments::support::Support;
use seidel_optics::observations::ObservationSet;
use seidel_optics::profile::{LensProfile, Verdict};

/// Settings of [`fit_pupil`].
#[derive(Debug, Clone, Default)]
pub struct PupilSettings {
    /// The model to fit.
    pub model: PupilModel,
    /// Position of the optical axis.
    pub axis: AxisChoice,
    /// Pixels of a tile that take part.
    pub support: Support,
    /// Fits all PSFs and holds none out; the profile then has no held-out score.
    pub use_all: bool,
    /// Describes each parameter by a polynomial in vergence alone, without residual corrections at the
    /// measured distances.
    pub law_only: bool,
    /// Test image of the held-out score; [`TestImage::natural`] if `None`.
    pub test_image: Option<TestImage>,
    /// Seconds since a fixed moment; with it, [`PupilFit::parts_tried`] holds times.
    pub clock: Option<fn() -> f64>,
}

/// The model that [`fit_pupil`] fits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PupilModel {
    /// The five reduced numbers (third-order aberrations) and a symmetric blur.
    Reduced,
    /// Also fifth-order aberrations, and every part that improves held-out zones of the field: vignetting, blades, an
    /// uneven pupil, decentred elements, a tilted sensor, seventh order, two planes of symmetry.
    Extended,
    /// [`PupilModel::Extended`] where the held-out pixel gap of [`PupilModel::Reduced`] is above 0.001 and the
    /// extended model gains at least 1 dB on the held-out PSFs; [`PupilModel::Reduced`] otherwise.
    #[default]
    Auto,
}

/// Held-out pixel gap above which the reduced model is insufficient, and the gain in held-out forward-blur
/// SNR (dB) that the extended model must reach.
const MAX_REDUCED_GAP: f64 = 1e-3;
const MIN_GAIN_DB: f64 = 1.0;

/// Ends of the stages of [`Stages`] but the last, as shares of the fit's progress, by model.
const REDUCED_STAGES: [f64; 4] = [0.6, 0.8, 1.0, 1.0];
const EXTENDED_STAGES: [f64; 4] = [0.25, 0.35, 0.35, 0.95];
const AUTO_STAGES: [f64; 4] = [0.25, 0.35, 0.4, 0.95];

/// Fits a lens described by its pupil to one or more observation sets of one camera.
///
/// # Errors
/// Sets that differ in frame, channels or axis; known and unknown distances mixed; channels with too few
/// usable tiles for an initial estimate; cancellation by `progress`.
pub fn fit_pupil(
    sets: &[ObservationSet],
    settings: &PupilSettings,
    progress: &Progress,
) -> Result<PupilFit> {
    let whole = Stage::whole(progress, "fit");
    let fit = fit_in_stages(sets, settings, Stages::of(whole, settings.model))?;
    whole.reach(1.0)?;
    Ok(fit)
}

/// The stages of a fit, by their share of its time on sets of about a hundred PSFs in three channels.
struct Stages<'a> {
    reduced: Stage<'a>,
    reduced_law: Stage<'a>,
    reduced_scored: Stage<'a>,
    extended: Stage<'a>,
    extended_scored: Stage<'a>,
}

impl<'a> Stages<'a> {
    fn of(whole: Stage<'a>, model: PupilModel) -> Self {
        let ends = match model {
            PupilModel::Reduced => REDUCED_STAGES,
            PupilModel::Extended => EXTENDED_STAGES,
            PupilModel::Auto => AUTO_STAGES,
        };
        let [a, b, c, d] = ends;
        Self {
            reduced: whole.part(0.0, a),
            reduced_law: whole.part(a, b),
            reduced_scored: whole.part(b, c),
            extended: whole.part(c, d),
            extended_scored: whole.part(d, 1.0),
        }
    }
}

fn fit_in_stages(
    sets: &[ObservationSet],
    settings: &PupilSettings,
    stages: Stages,
) -> Result<PupilFit> {
    stages.reduced.reach(0.0)?;
    let first = check_same_camera(sets)?;
    let mut frame = match settings.axis {
        AxisChoice::At(axis) => first.frame.with_axis(axis)?,
        AxisChoice::AsObserved | AxisChoice::Free => first.frame,
    };
    let mut rejected = Vec::new();
    let measured = measure(sets, settings.support, &mut rejected);
    super::check_channels(sets, &measured, &rejected)?;
    // Also reports mixed distances.
    let groups = super::group_tiles(sets, &measured)?;
    if settings.axis == AxisChoice::Free {
        let found = axis::find_axis(
            &frame,
            &super::group_slices(&groups),
            plane::Weighting::Weighted,
        )?;
        frame = frame.with_axis(found.axis)?;
    }
    let held_out = held_out_tiles(sets, &measured, &frame, settings);
    let mut context = FitContext::new(sets, settings, frame, &measured, held_out);
    let (by_moments, estimates) = context.fit_reduced(stages.reduced)?;
    let mut fit = focus_side::settled(&context, by_moments.clone());
    fit = vergence_law::choose(
        &context,
        fit,
        &vergence_law::REDUCED_LAWS,
        vergence_law::Refit::Full,
        stages.reduced_law,
    )?;
    let mut held_back = Vec::new();
    let mut tried = Vec::new();
    if settings.model == PupilModel::Extended {
        Extended {
            fit,
            held_back,
            tried,
        } = extended::extend(&context, fit, &estimates, stages.extended)?;
    }
    if settings.axis == AxisChoice::Free {
        fit = context.free_axis(fit);
        context.move_frame_to_axis(&mut fit)?;
    }
    let scored = if settings.model == PupilModel::Extended {
        stages.extended_scored
    } else {
        stages.reduced_scored
    };
    let mut reduced = finish(&context, fit.clone(), &rejected, scored)?;
    reduced
        .warnings
        .extend(focus_side::remark(&context, &by_moments, &fit));
    reduced.warnings.extend(held_back);
    reduced.parts_tried = tried;
    let short = |f: &PupilFit| {
        (f.lens.held_out.as_ref())
            .filter(|h| h.pixel_gap > MAX_REDUCED_GAP)
            .cloned()
    };
    let Some(before) = short(&reduced).filter(|_| settings.model == PupilModel::Auto) else {
        check_squeeze(sets, &reduced.lens)?;
        return Ok(reduced);
    };
    let Extended {
        mut fit,
        held_back,
        tried,
    } = extended::extend(&context, fit, &estimates, stages.extended)?;
    if settings.axis == AxisChoice::Free {
        // The parts may have moved it, or begun from estimates without it.
        fit = context.free_axis(fit);
        context.move_frame_to_axis(&mut fit)?;
    }
    let side = focus_side::remark(&context, &by_moments, &fit);
    let mut extended = finish(&context, fit, &rejected, stages.extended_scored)?;
    let gained = extended
        .lens
        .held_out
        .as_ref()
        .map_or(0.0, |h| h.snr_db - before.snr_db);
    if gained < MIN_GAIN_DB {
        check_squeeze(sets, &reduced.lens)?;
        reduced.parts_tried = tried;
        return Ok(reduced);
    }
    check_squeeze(sets, &extended.lens)?;
    extended.warnings.push(format!(
        "the reduced model leaves a held-out pixel gap of {:.4}: {} were added, which raise the held-out forward-blur SNR by {gained:.1} dB",
        before.pixel_gap,
        effect_names(&extended.lens)
            .into_iter()
            .map(named)
            .collect::<Vec<_>>()
            .join(", ")
    ));
    extended.warnings.extend(side);
    extended.warnings.extend(held_back);
    extended.parts_tried = tried;
    Ok(extended)
}

/// Squeeze up to which a lens counts as spherical.
const MAX_SPHERICAL_SQUEEZE: f64 = 1.05;

/// Rejects a camera with a squeeze if the model describes the lens without two planes of symmetry.
fn check_squeeze(sets: &[ObservationSet], lens: &LensProfile) -> Result<()> {
    let anamorphic = effect_names(lens).contains(&effects::DoublePlane.id());
    let proven = (lens.adequacy()).is_some_and(|a| a.verdict() == Verdict::Describes);
    for (index, set) in sets.iter().enumerate() {
        let squeezed = |squeeze: &f64| squeeze.max(1.0 / squeeze) > MAX_SPHERICAL_SQUEEZE;
        let Some(squeeze) = set.camera.squeeze.filter(squeezed) else {
            continue;
        };
        if proven && !anamorphic {
            return Err(Error::new(
                format!("observation set {} camera.squeeze", index + 1),
                format!(
                    "is {squeeze}, but the PSFs are those of a spherical lens: a rotationally symmetric model describes them"
                ),
                "correct the squeeze in the manifest, or leave it out",
            ));
        }
    }
    Ok(())
}

/// Returns the plain name of an effect with its identifier.
fn named(id: &str) -> String {
    format!("{} ({id})", cause_words(id).title)
}

/// Returns the identifiers of the effects of `lens`.
fn effect_names(lens: &LensProfile) -> Vec<&'static str> {
    let first = lens.pupil_channels().first();
    first.map_or_else(Vec::new, |channel| {
        channel.effects.iter().map(|e| e.effect.id()).collect()
    })
}

/// Completes a fit with standard errors, residual corrections and the held-out score.
fn finish(
    context: &FitContext,
    fit: context::FittedLens,
    rejected: &[Rejection],
    stage: Stage,
) -> Result<PupilFit> {
    stage.reach(0.0)?;
    let errors = covariance::CovarianceEstimate::of(context, &fit);
    let remainders = if context.settings.law_only {
        Vec::new()
    } else {
        vergence_law::remainders(context, &fit, stage.part(0.1, 0.9))?
    };
    stage.reach(0.9)?;
    report::assemble(context, fit, &errors, &remainders, rejected.to_vec())
}

/// Returns which measured tiles are held out.
fn held_out_tiles(
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
    holdout::held_out_mask(frame, &places)
}

/// Returns the error of a channel without an initial estimate.
fn no_initial_estimate(channel: &str) -> Error {
    Error::new(
        format!("channel {channel}"),
        "has too few tiles, or tiles too alike, to start a fit from",
        "give PSFs at a dozen places or more, from the axis to the corners",
    )
    .with_kind(seidel_optics::ErrorKind::InsufficientData)
}
