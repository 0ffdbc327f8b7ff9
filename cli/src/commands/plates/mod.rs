//! The options, the reader, the frame queue and the writer that all commands on plates share.

mod adjust;
mod animated;
mod args;
mod colour;
mod depth;
mod depth_check;
mod depth_unit;
mod finished_frame;
mod frame_lens;
mod frames;
mod look;
mod memory;
mod plate;
mod queue;
mod read_shot;
mod reader;
mod resume;
mod run;
mod shot_lens;
mod shot_metadata;
mod side_images;
mod side_inputs;
mod views;

pub(crate) use adjust::scaled_amount;
pub(crate) use args::PlateCommandArgs;
pub(crate) use colour::{AUTO, ChangeFilter, ConfigArgs, space_of, unrepresentable};
pub(crate) use finished_frame::{FinishedFrame, Map, SideFile};
pub(crate) use frames::{Files, FrameFiles};
pub(crate) use look::LookArgs;
pub(crate) use reader::{LensUse, LoadedPlate, PlateReader};
pub(crate) use run::{Run, RunArgs};
pub(crate) use shot_lens::LENS_METADATA;
pub(crate) use side_inputs::{SideInputs, channel_parser};
pub(crate) use views::ViewWork;

/// The settings of a frame by name, for provenance and residuals.
pub(crate) type SettingsRecord = Vec<(String, String)>;

/// Returns an entry of a [`SettingsRecord`].
pub(crate) fn setting(name: &str, value: impl ToString) -> (String, String) {
    (name.to_owned(), value.to_string())
}
