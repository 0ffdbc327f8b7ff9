//! The compiled part of the Python package `seidel`: lenses, and blur applied, removed, replaced, measured and
//! diagnosed on NumPy arrays.
//!
//! It only converts: arrays to plates, settings to those of the core, errors to exceptions. All computation is that of
//! `seidel-core`, on threads of `seidel-threads`, while the calling thread releases the GIL and answers signals.
#![forbid(unsafe_code)]

mod apply;
mod array;
mod depth;
mod diagnose;
mod diagnose_pictures;
mod error;
mod fit;
mod focus;
mod lens;
mod lens_settings;
mod look;
mod match_colours;
mod measure;
mod observations;
mod photographs;
mod plate;
mod relens;
mod removal;
mod remove;
mod settings;
mod worker;

use pyo3::prelude::*;

/// The compiled part of the package `seidel`, which exports all of it.
#[pymodule(name = "_seidel")]
fn seidel(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<lens::Lens>()?;
    module.add_class::<observations::ObservationSet>()?;
    module.add_class::<diagnose::Diagnosis>()?;
    apply::register(module)?;
    focus::register(module)?;
    remove::register(module)?;
    removal::register(module)?;
    relens::register(module)?;
    match_colours::register(module)?;
    lens_settings::register(module)?;
    measure::register(module)?;
    diagnose::register(module)?;
    diagnose_pictures::register(module)
}
