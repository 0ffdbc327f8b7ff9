//! Options about the range in focus, in the terms of depth-of-field tools.

use clap::Args;
use seidel_core::{FocusControls, ObjectDistance};

/// Options about the range in focus and the growth of blur outside it.
#[derive(Debug, Clone, Args)]
pub(crate) struct FocusArgs {
    /// Range about the focus plane, in metres, half of it before the plane, in which everything is as sharp
    /// as on it; beyond, depth is measured from the nearer end of the range
    #[arg(
        long,
        value_name = "METRES",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub(crate) depth_of_field: f64,
    /// How many times as far from focus, in vergence, everything before the focus plane is: blur grows as
    /// many times as fast; 0 keeps it in focus
    #[arg(
        long,
        value_name = "F",
        default_value_t = 1.0,
        allow_negative_numbers = true
    )]
    pub(crate) front_multiplier: f64,
    /// The same behind the focus plane
    #[arg(
        long,
        value_name = "F",
        default_value_t = 1.0,
        allow_negative_numbers = true
    )]
    pub(crate) back_multiplier: f64,
    /// Largest kernel in the frame: its radius in plate pixels if it is an even disc, two standard
    /// deviations of any other; what would be larger is drawn at the distance where it has this size
    #[arg(long, value_name = "PX", allow_negative_numbers = true)]
    pub(crate) maximum_size: Option<f64>,
}

impl FocusArgs {
    /// The focus controls; `focus` is the focus distance that the user set, if any.
    pub(crate) fn controls(&self, focus: Option<ObjectDistance>) -> FocusControls {
        FocusControls {
            focus_per_m: focus.and_then(ObjectDistance::vergence_per_m),
            depth_of_field_m: self.depth_of_field,
            front: self.front_multiplier,
            back: self.back_multiplier,
            maximum_px: self.maximum_size,
        }
    }
}
