//! Options about occlusion and holdouts.

use std::path::Path;

use clap::builder::NonEmptyStringValueParser;
use clap::{Args, ValueEnum};
use seidel_core::{
    DepthMeaning, DepthPass, HoldoutMatte, OcclusionSettings, PlateGeometry, PreparedHoldout,
};

use crate::commands::CommandError;
use crate::commands::plates::LoadedPlate;
use seidel_image_io::error::FileError;
use seidel_image_io::image_channel::{ChannelSpec, ImageChannel};

/// Options about occlusion.
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
    #[arg(long, value_name = "FILE[:CHANNEL]", value_parser = NonEmptyStringValueParser::new())]
    holdout: Option<String>,
    /// Depth pass of the holdout, with the meaning of the plate's: only light from behind the object is held out
    #[arg(long, value_name = "FILE[:CHANNEL]", requires = "holdout", value_parser = NonEmptyStringValueParser::new())]
    holdout_depth: Option<String>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Switch {
    /// Near surfaces hide far ones
    On,
    /// Light leaks across depth edges; the sum of light is kept
    Off,
}

/// The files of a holdout: paths or frame patterns.
pub(super) struct HoldoutSource {
    pub(super) matte: Option<ChannelSpec>,
    pub(super) depth: Option<ChannelSpec>,
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
        ] {
            if is_used {
                record.push_str(name);
            }
        }
        record
    }

    /// Returns the files of the holdout.
    ///
    /// # Errors
    /// Options about occlusion while it is off.
    pub(super) fn holdout(&self) -> Result<HoldoutSource, CommandError> {
        let options = [
            (self.no_fill_foreground, "--no-fill-foreground"),
            (self.no_blur_inside, "--no-blur-inside"),
            (self.holdout.is_some(), "--holdout"),
        ];
        let used = options.iter().find(|(is_used, _)| *is_used);
        if let Some((_, option)) = used
            && !self.is_on()
        {
            return Err(CommandError::Usage(format!(
                "{option} needs occlusion: leave out --occlusion off"
            )));
        }
        let spec = |text: &Option<String>| text.as_deref().map(ChannelSpec::parse);
        Ok(HoldoutSource {
            matte: spec(&self.holdout),
            depth: spec(&self.holdout_depth),
        })
    }

    /// Returns the occlusion settings of the renderer.
    pub(super) fn settings(&self) -> Option<OcclusionSettings> {
        self.is_on().then_some(OcclusionSettings {
            fill_foreground: !self.no_fill_foreground,
            blur_inside: !self.no_blur_inside,
        })
    }
}

/// Returns the channel that a file is named with, if any.
fn channel(spec: Option<&ChannelSpec>) -> Option<&str> {
    spec.and_then(|spec| spec.channel.as_deref())
}

impl HoldoutSource {
    /// Returns the paths or frame patterns of matte and depth, in this order, as far as they are used.
    pub(super) fn file_patterns(&self) -> impl Iterator<Item = &str> {
        let specs = [&self.matte, &self.depth].into_iter().flatten();
        specs.map(|spec| spec.file.as_str())
    }

    /// Reads the holdout of the plate `loaded`, which lies at `geometry`: the file `matte` and, if any, the depth pass with
    /// its meaning. Adds warnings to the plate.
    pub(super) fn read(
        &self,
        loaded: &mut LoadedPlate,
        geometry: &PlateGeometry,
        matte: &Path,
        depth: Option<(&Path, DepthMeaning)>,
    ) -> Result<PreparedHoldout, CommandError> {
        let windows = loaded.plate.windows();
        let image = ImageChannel::read_matte(matte, channel(self.matte.as_ref()))?;
        let fitted = image.fit_to(windows)?;
        loaded.warnings.extend(fitted.warning);
        let mut holdout = HoldoutMatte {
            samples: fitted.samples,
            depth: None,
        };
        let place = format!("channel {}", image.channel);
        (holdout.check(geometry.data.width))
            .map_err(|e| FileError::from_core(matte, e.within(&place)))?;
        if let Some((file, meaning)) = depth {
            let pass = ImageChannel::read_depth(file, channel(self.depth.as_ref()))?;
            let fitted = pass.fit_to(windows)?;
            loaded.warnings.extend(fitted.warning);
            holdout.depth = Some(DepthPass {
                samples: fitted.samples,
                meaning,
            });
        }
        let file = depth.map_or(matte, |(file, _)| file);
        let prepared = PreparedHoldout::new(&loaded.lens.session, geometry, holdout);
        Ok(prepared.map_err(|e| FileError::from_core(file, e))?)
    }
}
