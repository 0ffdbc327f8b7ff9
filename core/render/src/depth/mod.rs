//! Depth passes: what their numbers mean, a check of that, and the range in focus.

mod check;
mod convention;
mod focus_range;

pub use check::{DepthCheck, DepthProblem, Finding, LensReach, Severity, View};
pub use convention::{DepthConvention, DepthReading};
pub use focus_range::{FocusControls, FocusRange, MOST_MULTIPLIER, PlateExtent, focus_vergence};
