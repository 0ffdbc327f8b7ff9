//! Options about depth, and the depth of a plate.

use std::path::Path;

use clap::{Args, ValueEnum};
use seidel_core::render::{DepthConvention, DepthReading};
use seidel_core::{
    Depth, DepthMeaning, DepthPass, Error, Lens, LensSession, ObjectDistance, PlateGeometry,
    PreparedDepth,
};

use super::depth_doubts::depth_doubts;
use crate::commands::{CommandError, parse_distance};
use seidel_image_io::error::FileError;
use seidel_image_io::image_channel::{ChannelSpec, ImageChannel};
use seidel_image_io::plate::Plate;

/// Place of a frame in its run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FrameOrder {
    /// The first frame, whose depth pass is checked and whose colour space is reported.
    First,
    /// Any later frame, or the first one read once more.
    Later,
}

/// Options about depth.
#[derive(Debug, Args)]
pub(crate) struct DepthArgs {
    /// The depth pass; the plate's own Z channel if left out. May hold a frame pattern
    #[arg(long, value_name = "FILE[:CHANNEL]", conflicts_with = "distance")]
    depth: Option<String>,
    /// One object distance for the whole plate, in metres, or `inf`
    #[arg(long, value_name = "METRES", value_parser = parse_distance)]
    distance: Option<ObjectDistance>,
    /// What the numbers of the depth pass are
    #[arg(long, value_enum, default_value_t = DepthKind::Distance)]
    depth_kind: DepthKind,
    /// Unit of the depth pass: m, cm, mm, km, in, ft, or metres per unit; negative if it counts backwards
    #[arg(long, value_name = "UNIT", default_value = "m", value_parser = parse_unit, allow_hyphen_values = true)]
    depth_unit: f64,
    /// Nearest distance of a normalised depth pass, metres
    #[arg(long, value_name = "METRES")]
    near: Option<f64>,
    /// Farthest distance of a normalised depth pass, metres
    #[arg(long, value_name = "METRES")]
    far: Option<f64>,
    /// Distances of the depth pass are along the ray from the camera, not along its axis; the camera's
    /// focal length, in widths of a plate pixel: half the width over the tangent of half the field of view
    #[arg(long, value_name = "FOCAL_PX", conflicts_with = "distance")]
    along_ray: Option<f64>,
    /// Do not look at the first depth pass for signs that its numbers are other than --depth-kind and
    /// --depth-unit say
    #[arg(long)]
    no_depth_check: bool,
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

fn parse_unit(text: &str) -> Result<f64, String> {
    match text {
        "m" => Ok(1.0),
        "cm" => Ok(0.01),
        "mm" => Ok(0.001),
        "km" => Ok(1000.0),
        "in" => Ok(0.0254),
        "ft" => Ok(0.3048),
        number => number
            .parse::<f64>()
            .ok()
            .filter(|v| v.is_finite() && *v != 0.0)
            .ok_or_else(|| "give m, cm, mm, km, in, ft, or the metres in one unit".to_owned()),
    }
}

/// Where depth comes from, the options settled.
pub(crate) enum DepthSource {
    /// One distance everywhere.
    Constant(ObjectDistance),
    /// A depth pass: in a file of its own, or else in the plate.
    Pass {
        spec: Option<ChannelSpec>,
        meaning: DepthMeaning,
        checked: bool,
    },
}

impl DepthArgs {
    /// The meaning of the samples of depth passes.
    pub(crate) fn meaning(&self) -> Result<DepthMeaning, CommandError> {
        let range = || match (self.near, self.far) {
            (Some(near_m), Some(far_m)) => Ok((near_m, far_m)),
            _ => Err(CommandError::Usage(
                "--depth-kind far-one and far-zero need --near and --far, in metres".to_owned(),
            )),
        };
        let metres_per_unit = self.depth_unit;
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
        })
    }

    pub(crate) fn source(&self) -> Result<DepthSource, CommandError> {
        Ok(match self.distance {
            Some(distance) => DepthSource::Constant(distance),
            None => DepthSource::Pass {
                spec: self.depth.as_deref().map(ChannelSpec::parse),
                meaning: self.meaning()?,
                checked: !self.no_depth_check,
            },
        })
    }
}

impl DepthSource {
    /// The file of the depth pass as given, which may hold a frame pattern.
    pub(crate) fn file_pattern(&self) -> Option<&str> {
        match self {
            Self::Pass {
                spec: Some(spec), ..
            } => Some(&spec.file),
            _ => None,
        }
    }

    /// The settings by name; files by their last component, so that they may be moved.
    pub(super) fn record(&self) -> Vec<(String, String)> {
        let named = |name: &str, value: String| (name.to_owned(), value);
        let (spec, meaning) = match self {
            Self::Constant(distance) => return vec![named("distance", distance.to_string())],
            Self::Pass { spec, meaning, .. } => (spec, meaning),
        };
        let depth = spec.as_ref().map_or_else(
            || "the plate's own".to_owned(),
            |spec| {
                let file = Path::new(&spec.file).file_name().unwrap_or_default();
                let channel = spec.channel.as_deref().unwrap_or_default();
                format!("{} {channel}", file.to_string_lossy())
            },
        );
        let along_ray = meaning.along_ray;
        vec![
            named("depth", depth),
            named("depth-kind and unit", format!("{:?}", meaning.convention)),
            named(
                "along-ray",
                along_ray.map_or_else(|| "no".to_owned(), |focal| focal.to_string()),
            ),
        ]
    }

    /// Rejects a depth pass that the lens cannot follow.
    pub(crate) fn check_lens(&self, lens: &Lens, file: &Path) -> Result<(), CommandError> {
        if lens.predictor().depends_on_depth() || self.file_pattern().is_none() {
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

    /// Reads the depth of `plate`, from `file` where the pass has one of its own, for the lens of `session`. Adds to
    /// `warnings`; the first pass of a run is checked for signs of another convention.
    pub(crate) fn read(
        &self,
        plate: &Plate,
        geometry: &PlateGeometry,
        file: Option<&Path>,
        session: &LensSession,
        order: FrameOrder,
        warnings: &mut Vec<String>,
    ) -> Result<PreparedDepth, CommandError> {
        let prepare = |depth| PreparedDepth::new(session, geometry, depth);
        let (spec, meaning, checked) = match self {
            Self::Constant(distance) => return Ok(prepare(Depth::Distance(*distance))?),
            Self::Pass {
                spec,
                meaning,
                checked,
            } => (spec, meaning, *checked),
        };
        if !session.lens().predictor().depends_on_depth() {
            return Ok(prepare(Depth::Distance(ObjectDistance::Unknown))?);
        }
        let channel = spec.as_ref().and_then(|s| s.channel.as_deref());
        let pass = match file {
            Some(file) => ImageChannel::read_depth(file, channel)?,
            None => plate.depth(None).map_err(|e| {
                FileError::new(
                    plate.path(),
                    "depth",
                    format!("has no depth of its own ({e})"),
                    "the lens's blur depends on depth: give --depth FILE or --distance METRES",
                )
            })?,
        };
        let fitted = pass.fit_to(plate.windows())?;
        warnings.extend(fitted.warning);
        let in_pass = |e: Error| {
            FileError::from_core(&pass.file, e.within(&format!("channel {}", pass.channel)))
        };
        let depth = prepare(Depth::Pass(DepthPass {
            samples: fitted.samples,
            meaning: *meaning,
        }));
        let depth = depth.map_err(in_pass)?;
        if let Some(reading) = depth.reading() {
            describe(&pass, reading, warnings);
        }
        if order == FrameOrder::First && checked {
            let doubts = doubts_of(&depth, plate, session, geometry, *meaning).map_err(in_pass)?;
            let name = format!("depth {}:{}", pass.file.display(), pass.channel);
            warnings.extend(doubts.iter().map(|doubt| format!("{name} {doubt}")));
        }
        Ok(depth)
    }
}

/// Signs that the pass of `depth` means something else than `meaning` says.
fn doubts_of(
    depth: &PreparedDepth,
    plate: &Plate,
    session: &LensSession,
    geometry: &PlateGeometry,
    meaning: DepthMeaning,
) -> seidel_core::Result<Vec<String>> {
    let (Some(reading), Some(pass)) = (depth.reading(), depth.pass()) else {
        return Ok(Vec::new());
    };
    depth_doubts(
        session,
        &session.place(geometry)?,
        plate,
        &pass.samples,
        &reading.vergence,
        meaning.convention,
    )
}

fn describe(pass: &ImageChannel, reading: &DepthReading, warnings: &mut Vec<String>) {
    let name = format!("depth {}:{}", pass.file.display(), pass.channel);
    match reading.range_m {
        Some((near, far)) => warnings.push(format!("{name} spans {near:.4} m to {far:.4} m")),
        None => warnings.push(format!("{name} is at infinity everywhere")),
    }
    for (count, what) in [
        (reading.infinite, "pixels at infinity"),
        (
            reading.empty,
            "empty pixels (zero or negative depth), taken to be at infinity",
        ),
        (
            reading.outside,
            "pixels outside 0..1, taken to be at the near or far end",
        ),
    ] {
        if count > 0 {
            warnings.push(format!("{name} has {count} {what}"));
        }
    }
}
