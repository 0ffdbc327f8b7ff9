//! Spatially varying lens blur applied to plates, and removed from them.
//!
//! # The model
//!
//! The blurred plate is
//!
//! ```text
//! O(x) = sum over source pixels x' of I(x') P_x'(x - x')
//! ```
//!
//! where I is scene-linear light and P_x' the point-spread function (PSF) of the *source* pixel x': it varies with
//! field position, channel and depth. Each PSF has unit sum, so the plate keeps its light.
//!
//! # Rendering
//!
//! A [`Scene`] names the lens ([`BlurField`]), the PSF model, the position of the plate in the lens's frame
//! ([`PlateMap`]) and the vergence of its pixels. A [`Renderer`] turns [`Plane`]s of samples into blurred ones:
//!
//! | renderer | method |
//! | --- | --- |
//! | [`Scatter`] | exact: scatters one kernel per source pixel |
//! | [`Gather`] | fast: tiles of an image pyramid, each gathered with a stencil that varies bilinearly |
//! | [`LayeredRenderer`] | occlusion: blurs depth layers with another renderer and composites them near over far |
//! | [`EdgeReplicatingRenderer`] | pads the plate with its edge pixels, or with black of their depth, and renders that |
//! | [`MirroringRenderer`] | mirrors the plate at its edges, but for its small lights |
//! | [`SpotRenderer`] | exact at chosen pixels only: a reference for the error of the others |
//!
//! [`Operator`] is the fast renderer as a linear operator with its adjoint. [`AdjustedLens`],
//! [`ClampedLens`] and [`NonSquarePixelLens`] wrap a lens; [`FocusRemap`] applies focus controls to vergences; [`DepthConvention`] and
//! [`DepthCheck`] read and check depth passes.
//!
//! [`remove`] is the inverse of rendering.
#![forbid(unsafe_code)]

mod adjusted_lens;
mod bloom;
mod chromatic_lens;
mod clamped_lens;
mod depth;
mod edge_replication;
mod gather;
mod mirroring;
mod non_square_pixel_lens;
mod occlusion;
mod plate_map;
pub mod remove;
mod renderer;
mod scatter;
mod scene;
mod spot_renderer;
mod statistics;

pub use adjusted_lens::{AdjustedLens, MAX_AMOUNT};
pub use bloom::Bloom;
pub use chromatic_lens::ChromaticLens;
pub use clamped_lens::ClampedLens;
pub use depth::{
    AveragedDepth, AveragedQuantity, CameraPerspective, DepthCheck, DepthConvention, DepthFinding,
    DepthPlace, DepthProblem, DepthReading, DividedLight, FocusControls, FocusRange, FocusRemap,
    LensDistances, MAX_MULTIPLIER, PlateExtent, Severity, focus_vergence,
};
pub use edge_replication::{EdgeReplicatingRenderer, LightBeyond};
pub use gather::{Gather, KernelStore, LayerContext, Operator, Quality};
pub use mirroring::MirroringRenderer;
pub use non_square_pixel_lens::{MAX_PIXEL_ASPECT, NonSquarePixelLens};
pub use occlusion::{
    Background, BlurMap, DepthSlice, FocusSide, HIDDEN_REACH_PX, Holdout, LayeredRenderer,
    Occlusion, OtherSides,
};
pub(crate) use occlusion::{DepthLayers, LayerSpacing, snapped};
pub use plate_map::PlateMap;
pub use renderer::Renderer;
pub(crate) use scatter::kernel_reach;
pub use scatter::{LocalKernel, LocalKernels, Scatter, exact_at_pixels};
pub(crate) use scene::cancelled;
pub use scene::{Displacement, Edges, Plane, RenderWindow, Scene, VergencePass};
pub use seidel_optics::{BlurField, DisplacedBlur, apply_tone};
pub use spot_renderer::{SpotRenderer, low_discrepancy_pixels, psnr_at};
pub use statistics::{LevelStatistics, RenderStatistics, Rendered};
