//! Depth passes: conventions, a plausibility check, and focus controls.

mod averaged;
mod check;
mod convention;
mod focus_plane;
mod focus_range;

pub use averaged::{AveragedDepth, AveragedQuantity, DividedLight};
pub(crate) use check::distance_span;
pub use check::{
    CameraPerspective, DepthCheck, DepthFinding, DepthPlace, DepthProblem, LensDistances, Severity,
};
pub use convention::{DepthConvention, DepthReading};
pub(crate) use focus_plane::FocusPlane;
pub use focus_range::{
    FocusControls, FocusRange, FocusRemap, MAX_MULTIPLIER, PlateExtent, focus_vergence,
};
