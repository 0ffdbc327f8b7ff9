//! What commands on plates share: options about lens, depth and plate, frames read, lenses set, scenes to draw, and
//! runs over sequences.

mod adjust;
mod depth;
mod depth_check;
mod focus;
mod memory;
mod plate;
mod queue;
mod rendering;
mod run;
mod setup;
mod shared;

pub(crate) use adjust::share_of;
pub(crate) use depth::{DepthArgs, DepthMeaning};
pub(crate) use depth_check::PlateView;
pub(crate) use plate::{Light, PlateArgs};
pub(crate) use queue::{Outcome, Stages};
pub(crate) use rendering::Rendering;
pub(crate) use run::{Files, FrameFiles, RunArgs, Shares};
pub(crate) use shared::{LensArgs, ReadPlate, Shared, Sight};

use clap::ValueEnum;
use seidel_core::render::{Displacement, VergencePass};

/// Displacement of light by the lens.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum Geometry {
    /// Blur alone
    None,
    /// Lateral colour: channels shifted against each other, the plate undistorted
    Lateral,
    /// Distortion and lateral colour
    Full,
}

impl From<Geometry> for Displacement {
    fn from(geometry: Geometry) -> Self {
        match geometry {
            Geometry::None => Self::None,
            Geometry::Lateral => Self::Lateral,
            Geometry::Full => Self::Full,
        }
    }
}

/// Object vergence of a plate's pixels, 1/m.
#[derive(Clone)]
pub(crate) enum Vergences {
    Constant(f64),
    PerPixel(Vec<f32>),
}

impl Vergences {
    pub(crate) fn pass(&self) -> VergencePass<'_> {
        match self {
            Self::Constant(v) => VergencePass::Constant(*v),
            Self::PerPixel(pass) => VergencePass::PerPixel(pass),
        }
    }
}
