//! What commands on plates share: options about lens, depth and plate, frames read, lenses set, scenes to draw, and
//! runs over sequences.

mod adjust;
mod colour;
mod depth;
mod depth_check;
mod focus;
mod frames;
mod memory;
mod plate;
mod queue;
mod run;
mod setup;
mod shared;
mod shares;

pub(crate) use adjust::share_of;
pub(crate) use colour::{ConfigArgs, space_of};
pub(crate) use depth::DepthArgs;
pub(crate) use depth_check::PlateView;
pub(crate) use frames::{Files, FrameFiles};
pub(crate) use plate::{Light, PlateArgs};
pub(crate) use queue::{Outcome, Stages};
pub(crate) use run::{Run, RunArgs};
pub(crate) use seidel_core::plate::{DepthMeaning, Rendering, Vergences};
pub(crate) use shared::{LensArgs, ReadPlate, Shared, Sight};

use clap::ValueEnum;
use seidel_core::render::Displacement;

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
