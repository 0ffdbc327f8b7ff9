//! Seidel's own transfer functions, gamuts and spaces, in double precision, as defined in `luts/curves.toml`.
//!
//! Images are converted by an engine and a config. The embedded config and its tables are generated from these curves
//! and tested against them.

mod gamut;
mod table;
mod transfer;

pub use gamut::{Adaptation, Gamut, Matrix};
pub use table::{Curve, CurveTable, SpaceDefinition};
pub use transfer::{CameraLog, TransferFunction};
