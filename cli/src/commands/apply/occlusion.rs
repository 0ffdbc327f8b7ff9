//! Options about near things that hide far ones, and about what will be in front.

use std::path::Path;

use clap::{Args, ValueEnum};
use seidel_core::Result;
use seidel_core::render::{Holdout, Occlusion};

use crate::commands::CommandError;
use crate::commands::plates::{DepthMeaning, PlateView, Vergences};
use seidel_image_io::depth::{DepthPass, DepthSpec};
use seidel_image_io::error::FileError;
use seidel_image_io::matte::Matte;
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

/// The holdout's files as given, which may hold frame patterns.
pub(super) struct HoldoutSource {
    pub(super) matte: Option<DepthSpec>,
    pub(super) depth: Option<DepthSpec>,
}

/// A frame's holdout in memory.
pub(super) struct HoldoutPixels {
    matte: Vec<f32>,
    vergence: Option<Vergences>,
}

impl HoldoutPixels {
    /// The same with `change` made to its vergences, such as that made to those of the plate.
    pub(super) fn changed(self, change: impl Fn(Vergences) -> Result<Vergences>) -> Result<Self> {
        Ok(Self {
            vergence: self.vergence.map(change).transpose()?,
            ..self
        })
    }
}

impl OcclusionArgs {
    /// Whether light of near and far is kept apart.
    pub(super) fn is_on(&self) -> bool {
        self.occlusion == Switch::On
    }

    /// The settings in a word or two.
    pub(super) fn told(&self) -> String {
        let mut told = if self.is_on() { "on" } else { "off" }.to_owned();
        for (is_so, word) in [
            (self.no_fill_foreground, ", no-fill-foreground"),
            (self.no_blur_inside, ", no-blur-inside"),
            (self.holdout.is_some(), ", holdout"),
        ] {
            told.push_str(if is_so { word } else { "" });
        }
        told
    }

    pub(super) fn source(&self) -> std::result::Result<HoldoutSource, CommandError> {
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
        let spec = |text: &Option<String>| text.as_deref().map(DepthSpec::parse);
        Ok(HoldoutSource {
            matte: spec(&self.holdout),
            depth: spec(&self.holdout_depth),
        })
    }

    /// What the renderer is told.
    pub(super) fn settings<'a>(&self, holdout: Option<&'a HoldoutPixels>) -> Occlusion<'a> {
        Occlusion {
            fill_foreground: !self.no_fill_foreground,
            blur_inside: !self.no_blur_inside,
            holdout: holdout.map(|pixels| Holdout {
                matte: &pixels.matte,
                vergence: pixels.vergence.as_ref().map(Vergences::pass),
            }),
        }
    }
}

impl HoldoutSource {
    /// Matte and depth as given, in this order, as far as there are any.
    pub(super) fn file_patterns(&self) -> impl Iterator<Item = &str> {
        let specs = [&self.matte, &self.depth].into_iter().flatten();
        specs.map(|spec| spec.file.as_str())
    }

    /// The holdout of a frame, from the files of that frame.
    pub(super) fn read(
        &self,
        plate: &Plate,
        (matte, depth): (Option<&Path>, Option<&Path>),
        meaning: DepthMeaning,
        view: &PlateView,
        said: &mut Vec<String>,
    ) -> std::result::Result<Option<HoldoutPixels>, CommandError> {
        let Some(file) = matte else {
            return Ok(None);
        };
        let window = plate.data_window();
        let channel = |spec: &Option<DepthSpec>| spec.as_ref().and_then(|s| s.channel.clone());
        let matte = Matte::open(file, channel(&self.matte).as_deref())?;
        let (samples, remark) = matte.over(plate.windows())?;
        said.extend(remark);
        if let Some(at) = samples.iter().position(|v| !(0.0..=1.0).contains(v)) {
            return Err(FileError::new(
                file,
                format!("channel {}", matte.channel),
                format!(
                    "pixel ({}, {}) is {}",
                    at % window.width,
                    at / window.width,
                    samples[at]
                ),
                "give a matte of values from 0 to 1",
            )
            .into());
        }
        let vergence = depth
            .map(|file| -> std::result::Result<_, CommandError> {
                let pass = DepthPass::open(file, channel(&self.depth).as_deref())?;
                let (samples, remark) = pass.over(plate.windows())?;
                said.extend(remark);
                let reading = meaning.read(&samples, window.width, view.axis_and_aspect());
                let reading = reading.map_err(|e| FileError::from_core(file, e))?;
                Ok(Vergences::PerPixel(reading.vergence))
            })
            .transpose()?;
        Ok(Some(HoldoutPixels {
            matte: samples,
            vergence,
        }))
    }
}
