//! Renderers: spatially varying lens blur applied to plates, and removed from them.
//!
//! A [`Scene`] says through which lens, at which depth and where in the frame a plate is seen; a [`Renderer`]
//! turns [`Plane`]s of scene-linear samples into blurred ones. [`Scatter`] is the exact reference, [`Gather`] the fast
//! renderer; [`Layered`] adds occlusion to either. [`remove`] is the inverse, [`plate`] places files' and hosts'
//! pixels into scenes.
//!
//! The blurred plate is O(x) = sum over source pixels x' of I(x') P_x'(x - x'): the PSF is that of the *source*
//! pixel. Each source spreads its light with a unit-sum kernel, so energy is kept.
#![forbid(unsafe_code)]

mod adjusted;
mod depth;
mod extended;
mod gather;
mod methods;
mod non_square;
mod occlusion;
pub mod plate;
mod plate_map;
pub mod remove;
mod scatter;
mod scene;
mod spots;

pub use adjusted::{Adjusted, MOST_AMOUNT};
pub use depth::{
    DepthCheck, DepthConvention, DepthProblem, DepthReading, Finding, FocusControls, FocusRange,
    LensReach, MOST_MULTIPLIER, PlateExtent, Severity, View, focus_vergence,
};
pub use extended::Extended;
pub use gather::{Gather, Operator, Quality};
pub use methods::{LevelMethods, Methods, Noted};
pub use non_square::{MOST_PIXEL_ASPECT, NonSquare};
pub(crate) use occlusion::Ladder;
pub use occlusion::{HIDDEN_REACH_PX, Holdout, Layered, Occlusion};
pub use plate_map::PlateMap;
pub use scatter::{LocalKernel, LocalKernels, Scatter, at_pixels};
pub(crate) use scatter::{reach, reach_of_pass};
pub(crate) use scene::cancelled;
pub use scene::{Displacement, Edges, Plane, Renderer, Scene, VergencePass, Window};
pub use seidel_optics::{BlurField, DisplacedBlur, apply_tone};
pub use spots::{Spots, psnr_at, spread_pixels};
