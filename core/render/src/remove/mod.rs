//! Deconvolution: the removal of a lens's blur from plates.
//!
//! For a plate b with noise of standard deviation s, the sharp image x minimises
//!
//! ```text
//! |W^(1/2) (A x - b)|² / (2 s²) + l sum |D x|
//! ```
//!
//! A is the lens as a linear operator (`lens_operator`), W weighs samples (`noise_model`), D is the gradient in four
//! directions (`gradient`) and l the regularisation weight. This is total-variation deconvolution. It is solved by ADMM
//! (`admm`). In the end a Wiener filter corrects texture (`texture`), and a prior of patches takes the place of total
//! variation (`plug_and_play`). Docs: `docs/background/remove.md`.
//!
//! | part | estimated from |
//! | --- | --- |
//! | s (`noise_estimate`) | frequencies that the lens blocks |
//! | l (`admm`) | the noise and the mean gradient of the estimate |
//! | the light beyond the plate's edges (`canvas`) | the part of it that is blurred into the plate |
//!
//! Frequencies that the lens attenuates below the noise cannot be recovered: there the regularisation determines the
//! image. Clipped samples (`saturation`), highlights and the pixels that get their light keep their blur.

mod admm;
mod block_matching;
mod canvas;
mod change_map;
mod collaborative_filter;
mod colour_match;
mod deconvolver;
mod depth_layer;
mod depth_split;
mod detailed_tiles;
mod gradient;
mod hidden_surface;
mod highlights;
mod hole_filling;
mod kept_blur;
mod layer_cut;
mod lens_check;
mod lens_operator;
mod light_candidates;
mod light_equations;
mod light_fit;
mod light_kernels;
mod light_lattice;
mod light_sources;
mod local_mean;
mod noise_estimate;
mod noise_gain;
mod noise_model;
mod normal_deviate;
mod overlapping_tiles;
mod plug_and_play;
mod problem;
mod quadratic;
mod saturation;
mod schedule;
mod separation;
mod spectrum_check;
#[cfg(test)]
mod test_scenes;
#[cfg(test)]
mod tests;
mod texture;
mod tile_fft;
mod tile_spectrum;
mod transfer_functions;
mod vectors;
mod winsorised;

pub use canvas::Canvas;
pub use change_map::change_map;
pub use colour_match::{match_blur, reference_colour};
pub use deconvolver::{Clipping, Deconvolver, Lights, SharpPlane, find_lights};
pub use depth_split::{DepthSplit, SplitPlane};
pub use kept_blur::{KeptBlur, KeptBlurReason};
pub use lens_check::estimate_blur_share;
pub use saturation::Saturation;
pub use separation::PlaneLights;

use highlights::Highlights;

/// Returns the least of `samples`, or 0 if none is negative.
fn darkest_sample(samples: &[f32]) -> f32 {
    samples.iter().fold(0.0, |least, v| least.min(*v))
}

/// Rises linearly from 0 at the first of `bounds` to 1 at the second; these may be in descending order.
fn ramp(value: f32, bounds: [f32; 2]) -> f32 {
    let [from, to] = bounds;
    ((value - from) / (to - from)).clamp(0.0, 1.0)
}
