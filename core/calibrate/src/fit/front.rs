//! One function for all lens models.

use super::{
    AxisChoice, MomentsFit, MomentsSettings, PupilFit, PupilModel, PupilSettings, Weighting,
    fit_moments, fit_pupil, refit_pupil,
};
use crate::measure::Rejection;
use crate::score::TestImage;
use seidel_optics::Progress;
use seidel_optics::error::Result;
use seidel_optics::moments::support::Support;
use seidel_optics::observations::ObservationSet;
use seidel_optics::profile::LensProfile;

/// The lens model to fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Model {
    /// S1..S10 per channel and object distance, the model of the paper: [`fit_moments`].
    Moments,
    /// Third-order aberrations and a symmetric blur: [`PupilModel::Reduced`].
    Reduced,
    /// Also fifth-order aberrations, and the parts that held-out zones ask for: [`PupilModel::Extended`].
    Extended,
    /// The extended model where held-out PSFs show that it is needed, or else the reduced one:
    /// [`PupilModel::Auto`].
    #[default]
    Auto,
}

/// Settings of [`fit`].
#[derive(Debug, Clone, Default)]
pub struct FitSettings {
    /// The lens model.
    pub model: Model,
    /// Position of the optical axis.
    pub axis: AxisChoice,
    /// Pixels of a tile that take part.
    pub support: Support,
    /// Weights of the residuals of moments; used by [`Model::Moments`] only.
    pub weighting: Weighting,
    /// Fits all PSFs and holds none out; ignored by [`Model::Moments`], which never holds any out.
    pub use_all: bool,
    /// Omits residual corrections at the measured distances; ignored by [`Model::Moments`].
    pub law_only: bool,
    /// Test image of the held-out score; [`TestImage::natural`] if `None`. Ignored by [`Model::Moments`].
    pub test_image: Option<TestImage>,
    /// Seconds since a fixed moment; with it, [`PupilFit::parts_tried`] holds times. Ignored by [`Model::Moments`].
    pub clock: Option<fn() -> f64>,
}

/// A fitted lens with its report.
#[derive(Debug, Clone)]
pub enum Fit {
    /// Result of [`Model::Moments`].
    Moments(MomentsFit),
    /// Result of the other models.
    Pupil(PupilFit),
}

impl Fit {
    /// Returns the fitted profile.
    pub fn lens(&self) -> &LensProfile {
        match self {
            Self::Moments(fit) => &fit.lens,
            Self::Pupil(fit) => &fit.lens,
        }
    }

    /// Returns the fitted profile, for instance to record the sources in its provenance.
    pub fn lens_mut(&mut self) -> &mut LensProfile {
        match self {
            Self::Moments(fit) => &mut fit.lens,
            Self::Pupil(fit) => &mut fit.lens,
        }
    }

    /// Returns the fitted profile without the report.
    pub fn into_lens(self) -> LensProfile {
        match self {
            Self::Moments(fit) => fit.lens,
            Self::Pupil(fit) => fit.lens,
        }
    }

    /// Returns the limits of the result, one sentence for each.
    pub fn warnings(&self) -> &[String] {
        match self {
            Self::Moments(fit) => &fit.warnings,
            Self::Pupil(fit) => &fit.warnings,
        }
    }

    /// Returns the limits of the result, to add one or take one back.
    pub fn warnings_mut(&mut self) -> &mut Vec<String> {
        match self {
            Self::Moments(fit) => &mut fit.warnings,
            Self::Pupil(fit) => &mut fit.warnings,
        }
    }

    /// Returns the tiles excluded from the fit, with reasons.
    pub fn rejected(&self) -> &[Rejection] {
        match self {
            Self::Moments(fit) => &fit.rejected,
            Self::Pupil(fit) => &fit.rejected,
        }
    }
}

impl FitSettings {
    /// Returns the settings of a fit of `model`.
    fn pupil(&self, model: PupilModel) -> PupilSettings {
        PupilSettings {
            model,
            axis: self.axis,
            support: self.support,
            use_all: self.use_all,
            law_only: self.law_only,
            test_image: self.test_image.clone(),
            clock: self.clock,
        }
    }
}

/// Fits a lens to one or more observation sets of one camera. The page of the crate `seidel_core` has an example.
///
/// # Errors
/// As [`fit_moments`] for [`Model::Moments`], and as [`fit_pupil`] for the other models.
pub fn fit(sets: &[ObservationSet], settings: &FitSettings, progress: &Progress) -> Result<Fit> {
    let model = match settings.model {
        Model::Moments => {
            let settings = MomentsSettings {
                weighting: settings.weighting,
                axis: settings.axis,
                support: settings.support,
            };
            return fit_moments(sets, &settings, progress).map(Fit::Moments);
        }
        Model::Reduced => PupilModel::Reduced,
        Model::Extended => PupilModel::Extended,
        Model::Auto => PupilModel::Auto,
    };
    fit_pupil(sets, &settings.pupil(model), progress).map(Fit::Pupil)
}

/// Fits the model of `first`, with its parts and its optical axis, to all PSFs of `sets`, starting from its parameters.
///
/// For sets whose weights changed, or whose held-out PSFs shall take part at last: the model is not selected again.
///
/// # Errors
/// As [`fit`].
pub fn refit(
    sets: &[ObservationSet],
    first: &Fit,
    settings: &FitSettings,
    progress: &Progress,
) -> Result<Fit> {
    match first {
        Fit::Moments(_) => {
            let settings = FitSettings {
                model: Model::Moments,
                axis: AxisChoice::At(first.lens().frame.axis()),
                ..settings.clone()
            };
            fit(sets, &settings, progress)
        }
        Fit::Pupil(first) => {
            let settings = settings.pupil(PupilModel::Auto);
            refit_pupil(sets, first, &settings, progress).map(Fit::Pupil)
        }
    }
}
