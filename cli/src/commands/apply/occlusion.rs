//! Options about occlusion, holdouts and backgrounds.

use std::path::PathBuf;

use clap::builder::NonEmptyStringValueParser;
use clap::{Args, ValueEnum};
use seidel_core::OcclusionSettings;

use crate::commands::CommandError;
use crate::commands::plates::{SideInputs, channel_parser};
use seidel_image_io::image_channel::ChannelSpec;

/// Options about occlusion, and about what lies before and behind the plate.
#[derive(Debug, Args)]
#[command(next_help_heading = "Depth")]
pub(super) struct OcclusionArgs {
    /// Occlusion of far surfaces by near ones where depth varies
    #[arg(long, value_enum, default_value_t = Switch::On)]
    occlusion: Switch,
    /// Fill the pixels that a blurred foreground uncovers with the foreground's own light, instead of the background
    /// visible beside it
    #[arg(long)]
    no_fill_foreground: bool,
    /// Blur foregrounds outwards only: nothing shows through inside their outline, which stays hard
    #[arg(long)]
    no_blur_inside: bool,
    /// Matte of an object that will be merged in front later, or a frame pattern; its A, its only channel, or CHANNEL
    ///
    /// The light of the plate is held out where the matte covers it, sharp to the pixel.
    #[arg(long, value_name = "FILE[:CHANNEL]", value_parser = channel_parser())]
    holdout: Option<ChannelSpec>,
    /// Depth pass of the holdout, with the meaning of the plate's: only light from behind the object is held out
    #[arg(long, value_name = "FILE[:CHANNEL]", requires = "holdout", value_parser = channel_parser())]
    holdout_depth: Option<ChannelSpec>,
    /// The plate without its foreground (a clean plate), or a frame pattern: shown where the blur of the foreground uncovers
    /// it, instead of an estimate
    ///
    /// Its depth is its own Z channel or --background-depth, with the meaning of the plate's.
    #[arg(long, value_name = "FILE", conflicts_with = "no_fill_foreground", value_parser = NonEmptyStringValueParser::new())]
    background: Option<String>,
    /// Depth pass of the background, or a frame pattern
    #[arg(long, value_name = "FILE[:CHANNEL]", requires = "background", value_parser = channel_parser())]
    background_depth: Option<ChannelSpec>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Switch {
    /// Near surfaces hide far ones
    On,
    /// Light leaks across depth edges; the sum of light is kept
    Off,
}

impl OcclusionArgs {
    fn is_on(&self) -> bool {
        self.occlusion == Switch::On
    }

    /// Returns the settings as one line.
    pub(super) fn record(&self) -> String {
        let mut record = if self.is_on() { "on" } else { "off" }.to_owned();
        for (is_used, name) in [
            (self.no_fill_foreground, ", no-fill-foreground"),
            (self.no_blur_inside, ", no-blur-inside"),
            (self.holdout.is_some(), ", holdout"),
            (self.background.is_some(), ", background"),
        ] {
            if is_used {
                record.push_str(name);
            }
        }
        record
    }

    /// Rejects options about occlusion while it is off.
    pub(super) fn check(&self) -> Result<(), CommandError> {
        let options = [
            (self.no_fill_foreground, "--no-fill-foreground"),
            (self.no_blur_inside, "--no-blur-inside"),
            (self.holdout.is_some(), "--holdout"),
            (self.background.is_some(), "--background"),
        ];
        let used = options.iter().find(|(is_used, _)| *is_used);
        if let Some((_, option)) = used
            && !self.is_on()
        {
            return Err(CommandError::Usage(format!(
                "{option} needs occlusion: leave out --occlusion off"
            )));
        }
        Ok(())
    }

    /// Returns the files of holdout and background.
    pub(super) fn side_inputs(&self) -> SideInputs {
        SideInputs {
            holdout: self.holdout.clone(),
            holdout_depth: self.holdout_depth.clone(),
            background: self.background.as_ref().map(PathBuf::from),
            background_depth: self.background_depth.clone(),
            ..SideInputs::default()
        }
    }

    /// Returns the occlusion settings of the renderer.
    pub(super) fn settings(&self) -> Option<OcclusionSettings> {
        self.is_on().then_some(OcclusionSettings {
            fill_foreground: !self.no_fill_foreground,
            blur_inside: !self.no_blur_inside,
        })
    }
}
