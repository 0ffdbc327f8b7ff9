//! Options about occlusion and holdouts.

use std::path::Path;

use clap::{Args, ValueEnum};
use seidel_core::{
    DepthMeaning, DepthPass, HoldoutMatte, LensSession, OcclusionSettings, PlateGeometry,
    PreparedHoldout,
};

use crate::commands::CommandError;
use seidel_image_io::error::FileError;
use seidel_image_io::image_channel::{ChannelSpec, ImageChannel};
use seidel_image_io::plate::Plate;

/// Options about occlusion.
#[derive(Debug, Args)]
pub(super) struct OcclusionArgs {
    /// Whether near things hide far ones where depth varies. Without it light of either side leaks over
    /// the other, and the sum of light is kept
    #[arg(long, value_enum, default_value_t = Switch::On)]
    occlusion: Switch,
    /// Leave what a blurred foreground uncovers to the foreground's own light, instead of filling it with
    /// what can be seen beside it
    #[arg(long)]
    no_fill_foreground: bool,
    /// Blur foregrounds outwards only: nothing shows through within their outline, which stays hard
    #[arg(long)]
    no_blur_inside: bool,
    /// Matte of something that will be in front: kept back sharp to the pixel; its A, its only channel or
    /// the one named. May hold a frame pattern
    #[arg(long, value_name = "FILE[:CHANNEL]")]
    holdout: Option<String>,
    /// Depth pass of the holdout, read as the plate's is: only what lies behind is kept back
    #[arg(long, value_name = "FILE[:CHANNEL]", requires = "holdout")]
    holdout_depth: Option<String>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Switch {
    /// Near hides far
    On,
    /// Every pixel's light is blurred as if alone
    Off,
}

/// The files of a holdout as given, which may hold frame patterns.
pub(super) struct HoldoutSource {
    pub(super) matte: Option<ChannelSpec>,
    pub(super) depth: Option<ChannelSpec>,
}

impl OcclusionArgs {
    /// Whether near surfaces occlude far ones.
    fn is_on(&self) -> bool {
        self.occlusion == Switch::On
    }

    /// The settings as one line.
    pub(super) fn record(&self) -> String {
        let mut record = if self.is_on() { "on" } else { "off" }.to_owned();
        for (is_so, word) in [
            (self.no_fill_foreground, ", no-fill-foreground"),
            (self.no_blur_inside, ", no-blur-inside"),
            (self.holdout.is_some(), ", holdout"),
        ] {
            record.push_str(if is_so { word } else { "" });
        }
        record
    }

    pub(super) fn source(&self) -> Result<HoldoutSource, CommandError> {
        let asks = [
            (self.no_fill_foreground, "--no-fill-foreground"),
            (self.no_blur_inside, "--no-blur-inside"),
            (self.holdout.is_some(), "--holdout"),
        ];
        if let Some((_, option)) = asks.iter().find(|(asked, _)| *asked && !self.is_on()) {
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

    /// The occlusion settings of the renderer.
    pub(super) fn settings(&self) -> Option<OcclusionSettings> {
        self.is_on().then_some(OcclusionSettings {
            fill_foreground: !self.no_fill_foreground,
            blur_inside: !self.no_blur_inside,
        })
    }
}

impl HoldoutSource {
    /// Matte and depth as given, in this order, as far as there are any.
    pub(super) fn file_patterns(&self) -> impl Iterator<Item = &str> {
        let specs = [&self.matte, &self.depth].into_iter().flatten();
        specs.map(|spec| spec.file.as_str())
    }

    /// Reads the holdout of `plate`, which lies at `geometry`, from the files of its frame. Adds to `warnings`.
    pub(super) fn read(
        &self,
        plate: &Plate,
        (geometry, meaning): (PlateGeometry, DepthMeaning),
        session: &LensSession,
        matte: Option<&Path>,
        depth: Option<&Path>,
        warnings: &mut Vec<String>,
    ) -> Result<Option<PreparedHoldout>, CommandError> {
        let Some(file) = matte else {
            return Ok(None);
        };
        let channel = |spec: &Option<ChannelSpec>| spec.as_ref().and_then(|s| s.channel.clone());
        let matte = ImageChannel::read_matte(file, channel(&self.matte).as_deref())?;
        let fitted = matte.fit_to(plate.windows())?;
        warnings.extend(fitted.warning);
        let mut holdout = HoldoutMatte {
            samples: fitted.samples,
            depth: None,
        };
        let place = format!("channel {}", matte.channel);
        (holdout.check(geometry.data.width))
            .map_err(|e| FileError::from_core(file, e.within(&place)))?;
        if let Some(file) = depth {
            let pass = ImageChannel::read_depth(file, channel(&self.depth).as_deref())?;
            let fitted = pass.fit_to(plate.windows())?;
            warnings.extend(fitted.warning);
            holdout.depth = Some(DepthPass {
                samples: fitted.samples,
                meaning,
            });
        }
        let at_fault = depth.unwrap_or(file);
        let prepared = PreparedHoldout::new(session, &geometry, holdout);
        Ok(Some(
            prepared.map_err(|e| FileError::from_core(at_fault, e))?,
        ))
    }
}
