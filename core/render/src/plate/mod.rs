//! Plates as renderers need them: what turns the samples, alpha and depth that a host or file has into the light
//! and vergences of a [`Scene`](crate::Scene), and what was rendered back into samples.
//!
//! The command and the C ABI both work by this, so that they cannot differ.

mod light;
mod meaning;
mod placed;
mod rendering;
mod sight;
mod unblurred;
mod vergences;
mod weights;
mod work;

pub use light::{Light, LightParts, Returned};
pub use meaning::DepthMeaning;
pub use placed::{Placed, Rectangle};
pub use rendering::Rendering;
pub use sight::{LensUse, Seen};
pub use unblurred::{Unblur, Unblurred};
pub use vergences::Vergences;
pub use weights::plate_weights;
pub use work::{apply_bytes, remove_bytes};
