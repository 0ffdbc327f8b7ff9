//! Options about the lens that a shot states: the attributes of its plates, or a table beside them.

use std::path::{Path, PathBuf};

use clap::Args;

use seidel_image_io::lens_metadata::NamedAttribute;
use seidel_image_io::sequence::FramePattern;

/// Options about the lens that a shot states.
#[derive(Debug, Args)]
#[command(next_help_heading = "Focus")]
pub(crate) struct LensMetadataArgs {
    /// Focus and aperture that the plates state, or a table FILE
    ///
    /// Sets focus distance, f-number, focal length and film back: by `plate` from the EXR attributes of each frame. FILE is OpenTrackIO JSON, or a table by ARRI Meta Extract, RED REDline, or of Sony, Canon or Blackmagic cameras; or a frame
    /// pattern of OpenTrackIO samples. Its frames are matched with those of IN by time code, else by frame number. Options and
    /// --animate come before it, the lens profile after it. Distances in scene units need --depth-unit.
    #[arg(long = "lens-metadata", id = "lens_metadata", value_name = "plate|FILE", value_parser = parse_source)]
    pub(super) source: Option<LensSource>,
    /// Frame of IN that the first row of the table of --lens-metadata belongs to, if neither time code nor frame number says it
    #[arg(
        long = "lens-metadata-start",
        value_name = "FRAME",
        requires = "lens_metadata"
    )]
    pub(super) lens_metadata_start: Option<i64>,
    /// Attribute of the plates that states a quantity under a name of its own, for --lens-metadata plate
    ///
    /// Such as focus=com.studio.focus:mm. The quantities are focus, f-number, focal-length and film-back; the units m, cm, mm, in and ft, and T
    /// for a T-number. Without a unit a focus is in metres and a length in millimetres, unless the text names one. `seidel info` lists the
    /// attributes of a file. Can be given several times.
    #[arg(
        long = "lens-attribute",
        value_name = "QUANTITY=NAME[:UNIT]",
        requires = "lens_metadata"
    )]
    pub(super) lens_attribute: Vec<NamedAttribute>,
}

/// A source of settings of the lens.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum LensSource {
    /// The attributes of the plates.
    Plate,
    /// A table, or a frame pattern of them.
    Table(PathBuf),
}

fn parse_source(text: &str) -> Result<LensSource, String> {
    match text {
        "" => Err("give `plate`, or the path of a table".to_owned()),
        "plate" => Ok(LensSource::Plate),
        path => Ok(LensSource::Table(path.into())),
    }
}

impl LensMetadataArgs {
    /// Returns the table of lens settings, unless it is a frame pattern.
    pub(super) fn table(&self) -> Option<&Path> {
        match &self.source {
            Some(LensSource::Table(path))
                if path.is_file() || !FramePattern::parse(path).has_frame() =>
            {
                Some(path)
            }
            _ => None,
        }
    }
}
