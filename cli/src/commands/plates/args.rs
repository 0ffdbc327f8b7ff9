//! The options that all commands on plates share.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use seidel_core::Displacement;

use super::RunArgs;
use super::depth::DepthArgs;
use super::frame_lens::LensArgs;
use super::plate::PlateArgs;

/// The options that all commands on plates share.
#[derive(Debug, Args)]
pub(crate) struct PlateCommandArgs {
    /// Plate to read: OpenEXR, PNG, TIFF, DPX, Radiance HDR or JPEG; or a frame pattern such as plate.%04d.exr
    #[arg(value_name = "IN")]
    pub(crate) input: PathBuf,
    #[command(flatten)]
    pub(crate) depth: DepthArgs,
    #[command(flatten)]
    pub(crate) lens: LensArgs,
    /// Displacement of light by the lens
    #[arg(long, value_enum, help_heading = "Look", default_value_t = Geometry::Lateral)]
    pub(crate) geometry: Geometry,
    #[command(flatten)]
    pub(crate) plate: PlateArgs,
    /// Plate to write: EXR, PNG, TIFF, DPX or HDR by its extension; or a frame pattern
    ///
    /// In the format of IN, everything else in the file is kept. In another format: EXR gets scene-linear, premultiplied
    /// colour, as half for 8-bit, 10-bit and half-float samples, as float for others. PNG gets the 8 bits of IN, or 16.
    /// TIFF gets the 8 or 16 bits of IN, or float. DPX gets 10 bits, or the 12 or 16 of IN, or 16 with alpha or without
    /// colour. HDR gets shared exponents. Integers are sRGB-encoded unless --encoding says otherwise. Warnings name
    /// everything that OUT cannot store.
    #[arg(short, long, help_heading = "Output", value_name = "OUT")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

/// Displacement of light by the lens.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum Geometry {
    /// Blur alone
    None,
    /// Lateral colour: channels are displaced against each other, the plate is not distorted
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
