//! What commands on plates share: options about lens, depth and plate, frames read, lenses set, scenes to draw, and
//! runs over sequences.

mod adjust;
mod colour;
mod depth;
mod depth_doubts;
mod focus;
mod frame_lens;
mod frames;
mod memory;
mod plate;
mod queue;
mod reader;
mod run;
mod shares;

pub(crate) use adjust::share_of;
pub(crate) use colour::{ConfigArgs, space_of};
pub(crate) use depth::DepthArgs;
pub(crate) use frames::{Files, FrameFiles};
pub(crate) use plate::PlateArgs;
pub(crate) use queue::{Outcome, Stages};
pub(crate) use reader::{
    FrameId, LensArgs, LoadedPlate, PlateReader, ReaderOptions, default_rendering_record,
};
pub(crate) use run::{Run, RunArgs};

use clap::ValueEnum;
use seidel_core::Displacement;

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
