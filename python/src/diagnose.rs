//! Diagnosis of the gap between a lens and measured PSFs.

use pyo3::prelude::*;
use seidel_core::DiagnosisSettings;

use crate::error::{Failure, Result};
use crate::lens::Lens;
use crate::observations::{self, ObservationSet};
use crate::worker::CallOptions;

/// The result of `diagnose`.
#[pyclass(frozen, module = "seidel")]
pub(crate) struct Diagnosis {
    verdict: &'static str,
    added: Vec<&'static str>,
    report: String,
    corrected: Py<Lens>,
    estimated: Option<Py<ObservationSet>>,
}

impl Diagnosis {
    /// The result of the core, and the PSFs if they were estimated.
    pub(crate) fn new(
        py: Python<'_>,
        diagnosis: seidel_core::Diagnosis,
        estimated: Option<Py<ObservationSet>>,
    ) -> Result<Self> {
        let report = serde_json::to_string(&diagnosis).map_err(|error| {
            Failure::argument(
                "report",
                format!("cannot be written ({error})"),
                "report this",
            )
        })?;
        Ok(Self {
            verdict: diagnosis.verdict.id(),
            report,
            corrected: Py::new(py, Lens::of_profile(diagnosis.corrected)?)?,
            added: diagnosis.added,
            estimated,
        })
    }
}

#[pymethods]
impl Diagnosis {
    /// Verdict: `"no_gap"`, `"explained"`, `"ambiguous"`, `"unexplained"`, `"model_too_simple"` or `"bookkeeping"`.
    #[getter]
    fn verdict(&self) -> &'static str {
        self.verdict
    }

    /// Identifiers of the effects that were added to the lens, the stronger first.
    #[getter]
    fn added(&self) -> Vec<&'static str> {
        self.added.clone()
    }

    /// The lens with these effects.
    #[getter]
    fn corrected(&self, py: Python<'_>) -> Py<Lens> {
        self.corrected.clone_ref(py)
    }

    /// The PSFs that `diagnose_pictures` estimated, an `ObservationSet`; `None` for `diagnose`.
    #[getter]
    fn estimated(&self, py: Python<'_>) -> Option<Py<ObservationSet>> {
        self.estimated.as_ref().map(|set| set.clone_ref(py))
    }

    /// The whole report as a dictionary: gap, causes with their probabilities and amounts, places, shares, remarks. The keys
    /// are those of `report.json` of the command, whose schema `seidel diagnose --schema` prints.
    #[getter]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("json")?.getattr("loads")?.call1((&self.report,))
    }

    fn __repr__(&self) -> String {
        format!(
            "<seidel.Diagnosis {}: {}>",
            self.verdict,
            self.added.join(", ")
        )
    }
}

/// Adds the function to `module`.
pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(diagnose, module)?)
}

/// Finds the effects that `lens` lacks against measured PSFs, their probabilities, and how far adding them closes the gap.
///
/// - `lens`: a lens of the kind `"pupil"`.
/// - `observations`: an `ObservationSet`, or the path of one, of the frame and channels of the lens.
/// - `only`: identifiers of the effects to try; all if `None`.
/// - `pairs`: also try pairs of effects.
/// - `design`: the set that the lens was fitted to; needed for a lens fitted with `use_all`.
/// - `threads`: most threads; 0 for one each core.
/// - `progress`: as for `apply`.
///
/// It takes minutes for a hundred PSFs in three channels. Raises `InvalidInput`, `Unsupported` for a lens fitted in moments,
/// `InsufficientData` and `Cancelled`.
#[pyfunction]
#[pyo3(signature = (lens, observations, *, only=None, pairs=true, design=None, threads=0, progress=None))]
fn diagnose(
    lens: &Bound<'_, Lens>,
    observations: &Bound<'_, PyAny>,
    only: Option<Vec<String>>,
    pairs: bool,
    design: Option<&Bound<'_, PyAny>>,
    threads: u32,
    progress: Option<&Bound<'_, PyAny>>,
) -> Result<Diagnosis> {
    let py = lens.py();
    let set = observations::read(observations)?.set;
    let design = design.map(observations::read).transpose()?;
    let settings = DiagnosisSettings {
        library: only.unwrap_or_default(),
        pairs,
        design: design.map(|named| named.set),
        ..DiagnosisSettings::default()
    };
    let options = CallOptions { threads, progress };
    let lens = lens.get().core();
    let diagnosis = options.run(py, move |progress| {
        Ok(seidel_core::diagnose(&lens, &set, &settings, progress)?)
    })?;
    Diagnosis::new(py, diagnosis, None)
}
