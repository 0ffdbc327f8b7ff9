//! Fits of lenses to observation sets.

use pyo3::prelude::*;
use seidel_core::{AxisChoice, FitSettings, ImagePoint, Model};

use crate::error::{Failure, Result, warn};
use crate::lens::Lens;
use crate::observations;
use crate::worker::CallOptions;

/// The options of `Lens.fit`, which documents them.
pub(crate) struct FitArgs<'a, 'py> {
    pub(crate) model: &'a str,
    pub(crate) axis: Option<&'a Bound<'py, PyAny>>,
    pub(crate) use_all: bool,
    pub(crate) law_only: bool,
    pub(crate) call: CallOptions<'a, 'py>,
}

impl FitArgs<'_, '_> {
    fn settings(&self) -> Result<FitSettings> {
        let model = match self.model {
            "auto" => Model::Auto,
            "reduced" => Model::Reduced,
            "extended" => Model::Extended,
            "moments" => Model::Moments,
            other => {
                return Err(Failure::argument(
                    "model",
                    format!("is {other:?}"),
                    "give \"auto\", \"reduced\", \"extended\" or \"moments\"",
                ));
            }
        };
        if model == Model::Moments && (self.use_all || self.law_only) {
            return Err(Failure::argument(
                "model",
                "is \"moments\", to which use_all and law_only do not apply",
                "leave them out, or choose another model",
            ));
        }
        Ok(FitSettings {
            model,
            axis: self.axis()?,
            use_all: self.use_all,
            law_only: self.law_only,
            ..FitSettings::default()
        })
    }

    fn axis(&self) -> Result<AxisChoice> {
        let Some(axis) = self.axis else {
            return Ok(AxisChoice::AsObserved);
        };
        if let Ok((x, y)) = axis.extract::<(f64, f64)>() {
            return Ok(AxisChoice::At(ImagePoint::new(x, y)));
        }
        if axis.extract::<String>().is_ok_and(|word| word == "free") {
            return Ok(AxisChoice::Free);
        }
        Err(Failure::argument(
            "axis",
            format!("is {}", axis.repr()?),
            "give (x, y) in frame pixels, \"free\", or None",
        ))
    }
}

/// Fits a lens to `observations`: a set or a path, or a sequence of them.
///
/// # Errors
/// Those of the core, and sets that cannot be read.
pub(crate) fn fit(observations: &Bound<'_, PyAny>, args: &FitArgs) -> Result<Lens> {
    let py = observations.py();
    let settings = args.settings()?;
    let named = observations::read_all(observations)?;
    let sources: Vec<String> = named.iter().map(|set| set.name.clone()).collect();
    let fit = args.call.run(py, move |progress| {
        let sets: Vec<_> = named.into_iter().map(|named| named.set).collect();
        Ok(seidel_core::fit(&sets, &settings, progress)?)
    })?;
    warn(py, fit.warnings())?;
    let mut profile = fit.into_lens();
    profile.provenance.sources = sources;
    Lens::of_profile(profile)
}
