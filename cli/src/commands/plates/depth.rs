//! Options about depth, and the depth of a plate.

use std::path::Path;

use clap::{Args, ValueEnum};
use seidel_core::{DepthConvention, DepthMeaning, DepthReading, Lens, ObjectDistance};

use super::depth_unit::DepthUnitArgs;
use super::{SettingsRecord, channel_parser, setting};
use crate::commands::{CommandError, parse_distance};
use seidel_image_io::depth_name::NamedDepth;
use seidel_image_io::error::FileError;
use seidel_image_io::image_channel::ChannelSpec;

/// Place of a frame in its run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FrameOrder {
    /// The first frame, whose depth pass is checked and whose colour space is reported.
    First,
    /// Any later frame, or the first one read once more.
    Later,
}

/// Options about depth.
#[derive(Debug, Args)]
#[command(next_help_heading = "Depth")]
pub(crate) struct DepthArgs {
    /// Depth pass, or a frame pattern; the plate's own Z if omitted
    #[arg(long, value_name = "FILE[:CHANNEL]", conflicts_with = "distance", value_parser = channel_parser())]
    pub(crate) depth: Option<ChannelSpec>,
    /// One object distance for the whole plate, metres or `inf`
    #[arg(long, value_name = "METRES", value_parser = parse_distance)]
    pub(super) distance: Option<ObjectDistance>,
    /// Meaning of the samples of the depth pass
    #[arg(long, value_enum, default_value_t = DepthKind::Distance)]
    depth_kind: DepthKind,
    #[command(flatten)]
    pub(super) unit: DepthUnitArgs,
    /// Nearest distance of a normalised depth pass, metres
    #[arg(long, value_name = "METRES")]
    near: Option<f64>,
    /// Farthest distance of a normalised depth pass, metres
    #[arg(long, value_name = "METRES")]
    far: Option<f64>,
    /// Focal length of the camera in widths of a plate pixel, for a depth pass whose distances are along the ray and not
    /// along the optical axis
    ///
    /// The focal length is half the width of the plate over the tangent of half the horizontal field of view.
    #[arg(long, value_name = "FOCAL_PX", conflicts_with = "distance")]
    along_ray: Option<f64>,
    /// Width over which the depth pass is averaged at edges, by a filter or by motion over the shutter, pixels of the plate:
    /// edges up to that wide are divided between their two sides
    ///
    /// The check of depth names the width. Depth of one sample a pixel needs no such repair and is nearer to the truth.
    #[arg(long, value_name = "PX", conflicts_with = "distance")]
    depth_filter: Option<f64>,
    /// Skip the check of the first depth pass for signs of another --depth-kind or --depth-unit
    #[arg(long)]
    pub(super) no_depth_check: bool,
}

/// The meaning of the samples of a depth pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum DepthKind {
    /// Distance along the optical axis
    Distance,
    /// One over the distance; 0 is infinity
    Inverse,
    /// 0 at --near, 1 at --far
    FarOne,
    /// 1 at --near, 0 at --far
    FarZero,
}

impl DepthArgs {
    /// Returns the meaning of the samples of depth passes.
    ///
    /// # Errors
    /// A normalised pass without its range.
    pub(super) fn meaning(&self) -> Result<DepthMeaning, CommandError> {
        let range = || match (self.near, self.far) {
            (Some(near_m), Some(far_m)) => Ok((near_m, far_m)),
            _ => Err(CommandError::Usage(
                "--depth-kind far-one and far-zero need --near and --far, in metres".to_owned(),
            )),
        };
        let metres_per_unit = self.unit.metres;
        let convention = match self.depth_kind {
            DepthKind::Distance => DepthConvention::Distance { metres_per_unit },
            DepthKind::Inverse => DepthConvention::Inverse { metres_per_unit },
            DepthKind::FarOne => {
                let (near_m, far_m) = range()?;
                DepthConvention::FarOne { near_m, far_m }
            }
            DepthKind::FarZero => {
                let (near_m, far_m) = range()?;
                DepthConvention::FarZero { near_m, far_m }
            }
        };
        Ok(DepthMeaning {
            convention,
            along_ray: self.along_ray,
            averaged_px: self.depth_filter.unwrap_or(0.0),
        })
    }

    /// Returns the settings by name, of depth passes with the given `meaning`. Files are named by their last component, so that
    /// they may be moved.
    pub(super) fn record(&self, meaning: DepthMeaning) -> SettingsRecord {
        if let Some(distance) = self.distance {
            return vec![setting("distance", distance)];
        }
        let depth = self.depth.as_ref().map_or_else(
            || "the plate's own".to_owned(),
            |spec| {
                let file = spec.file.file_name().unwrap_or_default();
                let channel = spec.channel.as_deref().unwrap_or_default();
                format!("{} {channel}", file.to_string_lossy())
            },
        );
        let along_ray = meaning.along_ray;
        let along_ray = along_ray.map_or_else(|| "no".to_owned(), |focal| focal.to_string());
        vec![
            setting("depth", depth),
            setting("depth-kind and unit", convention_words(meaning.convention)),
            setting("along-ray", along_ray),
            setting("depth-filter", meaning.averaged_px),
        ]
    }

    /// Rejects a depth pass for a `lens`, read from `file`, that was fitted at one distance.
    pub(super) fn check_lens(&self, lens: &Lens, file: &Path) -> Result<(), CommandError> {
        if lens.predictor().depends_on_depth() || self.depth.is_none() {
            return Ok(());
        }
        Err(FileError::new(
            file,
            "planes",
            "the lens was fitted at one object distance, so it cannot follow a depth pass",
            "fit it to sets at three or more distances, or leave out --depth",
        )
        .into())
    }
}

/// Returns a convention in the words of the options.
fn convention_words(convention: DepthConvention) -> String {
    match convention {
        DepthConvention::Distance { metres_per_unit } => {
            format!("distance, {metres_per_unit} m a unit")
        }
        DepthConvention::Inverse { metres_per_unit } => {
            format!("inverse, {metres_per_unit} m a unit")
        }
        DepthConvention::FarOne { near_m, far_m } => {
            format!("far-one, near {near_m} m, far {far_m} m")
        }
        DepthConvention::FarZero { near_m, far_m } => {
            format!("far-zero, near {near_m} m, far {far_m} m")
        }
    }
}

/// Returns a note if the name of a channel contradicts the `meaning` of its samples; it continues the name of the pass.
pub(super) fn name_note(channel: &str, meaning: DepthMeaning) -> Option<String> {
    let is_normalised = matches!(
        meaning.convention,
        DepthConvention::FarOne { .. } | DepthConvention::FarZero { .. }
    );
    let (what, remedy) = match NamedDepth::of(channel)? {
        NamedDepth::AlongRay if meaning.along_ray.is_none() => (
            "runs along the ray from the camera",
            "give --along-ray F, the focal length of the camera in pixels",
        ),
        NamedDepth::Filtered => (
            "is filtered, which puts objects between surfaces",
            "take an unfiltered pass",
        ),
        NamedDepth::Normalised if !is_normalised => (
            "is a share of a range",
            "give --depth-kind far-one or far-zero with --near and --far",
        ),
        NamedDepth::AlongRay | NamedDepth::Normalised => return None,
    };
    Some(format!("{what}, by its name: {remedy}"))
}

/// Returns notes on the range of a depth pass, of the first frame alone, and on its unusual pixels; each continues the name of
/// the pass.
pub(super) fn describe(reading: &DepthReading, order: FrameOrder) -> Vec<String> {
    let range = match reading.range_m {
        Some((near, far)) => format!("spans {near:.4} m to {far:.4} m"),
        None => "is at infinity everywhere".to_owned(),
    };
    let range = Some(range).filter(|_| order == FrameOrder::First);
    let counts = [
        (reading.infinite, "pixels at infinity"),
        (
            reading.empty,
            "empty pixels (zero or negative depth), taken to be at infinity",
        ),
        (
            reading.outside,
            "pixels outside 0..1, taken to be at the near or far end",
        ),
    ];
    let counts = counts.into_iter().filter(|(count, _)| *count > 0);
    let counts = counts.map(|(count, pixels)| format!("has {count} {pixels}"));
    range.into_iter().chain(counts).collect()
}
