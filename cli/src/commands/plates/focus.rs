//! Options about the range in focus, in the terms of depth-of-field tools.

use clap::Args;
use seidel_core::{FocusControls, ObjectDistance};

/// Options about the range in focus and the growth of blur outside it.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Focus")]
pub(crate) struct FocusArgs {
    /// Depth of the range in focus, metres: half of it lies before the focus plane
    ///
    /// Everything in the range is as sharp as on the focus plane. Beyond it, depth is measured from the nearer end.
    #[arg(long, value_name = "METRES", default_value_t = 0.0)]
    pub(crate) depth_of_field: f64,
    /// Factor on the distance from focus before the focus plane, in vergence: blur grows as many times as fast, 0 keeps
    /// all of it in focus
    #[arg(long, value_name = "F", default_value_t = 1.0)]
    pub(crate) front_multiplier: f64,
    /// Factor on the distance from focus behind the focus plane, as --front-multiplier
    #[arg(long, value_name = "F", default_value_t = 1.0)]
    pub(crate) back_multiplier: f64,
    /// Radius of the largest kernel in the frame, plate pixels; no limit if omitted
    ///
    /// The radius is that of a uniform disc, or two standard deviations of any other kernel. A larger kernel is replaced
    /// by that of the distance at which it has this radius.
    #[arg(long, value_name = "PX")]
    pub(crate) maximum_size: Option<f64>,
}

impl FocusArgs {
    /// Returns the focus controls; `focus` is the value of `--focus-distance`.
    pub(super) fn controls(&self, focus: Option<ObjectDistance>) -> FocusControls {
        FocusControls {
            focus_per_m: focus.and_then(ObjectDistance::vergence_per_m),
            depth_of_field_m: self.depth_of_field,
            front: self.front_multiplier,
            back: self.back_multiplier,
            maximum_px: self.maximum_size,
        }
    }
}
