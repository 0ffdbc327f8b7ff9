//! Blur removal for `remove` and `relens`: options, the check of the lens, and warnings.

mod kept_blur;
mod lens_check;

use clap::Args;
use seidel_core::{NoiseGain, RemovalSettings, RemovedPlate, Saturation, SharpPlane, remove_bytes};

use super::plates::{FrameFiles, LoadedPlate, PlateReader, Run};
use super::{CommandError, knobs};
use lens_check::{LensCheck, OnMismatch};

pub(super) use lens_check::Task;

/// Misfit above which a warning says that the lens does not explain the plate, in standard deviations of the noise.
const LARGEST_MISFIT: f64 = 1.5;

/// Share of a frame's progress taken by the removal. The rest is a render of the result.
const REMOVAL_SHARE: f64 = 0.9;

/// Share of the removal's progress taken by the check of the lens, in the frame where it runs.
const CHECK_SHARE: f64 = 0.3;

/// Options about noise and clipping of the plate.
#[derive(Debug, Args)]
#[command(next_help_heading = "Noise and clipping")]
pub(super) struct RemovalArgs {
    /// Standard deviation of the plate's noise, in linear units of the plate; estimated if omitted
    ///
    /// One value for all colours, or one for each, such as 0.004,0.003,0.006.
    #[arg(long, value_name = "S", value_delimiter = ',', value_parser = parse_noise, allow_hyphen_values = true)]
    noise: Vec<f64>,
    /// Level from which samples are clipped: they and the pixels that their light reaches keep their blur
    ///
    /// auto estimates the level from the plate; none treats no sample as clipped.
    #[arg(long, value_name = "LEVEL|auto|none", default_value = "auto", value_parser = parse_clip, allow_hyphen_values = true)]
    clip: Saturation,
    /// Action if the first frame does not show as much blur as the lens has
    #[arg(long, value_enum, value_name = "ACTION", default_value_t = OnMismatch::Adjust)]
    lens_check: OnMismatch,
}

fn parse_noise(text: &str) -> Result<f64, String> {
    knobs::parse("noise", text)
}

fn parse_clip(text: &str) -> Result<Saturation, String> {
    match text {
        "auto" => Ok(Saturation::Auto),
        "none" => Ok(Saturation::Never),
        level => (level.parse::<f64>().ok())
            .filter(|v| v.is_finite())
            .map(Saturation::Level)
            .ok_or_else(|| "give the level at which samples are clipped, auto, or none".to_owned()),
    }
}

/// The removal of blur from the frames of a run.
pub(super) struct Removal<'a> {
    args: &'a RemovalArgs,
    /// Reader of the plates, with the lens that they were taken with.
    pub(super) reader: &'a PlateReader<'a>,
    run: &'a Run,
    check: LensCheck,
}

impl RemovalArgs {
    /// Returns the settings of a removal.
    pub(super) fn settings(&self) -> RemovalSettings {
        RemovalSettings {
            noise: self.noise.clone(),
            saturation: self.clip,
            ..RemovalSettings::default()
        }
    }

    /// Returns notes on noise, clipped samples, kept blur and misfit of the colours called `names`.
    fn warnings(&self, names: &[String], removed: &RemovedPlate) -> Vec<String> {
        let by_colour = |describe: &dyn Fn(&SharpPlane) -> Option<String>| {
            let colours = names.iter().zip(removed.colours());
            let described = colours
                .filter_map(|(name, removed)| Some(format!("{name} {}", describe(removed)?)));
            described.collect::<Vec<_>>().join(", ")
        };
        let source = if self.noise.is_empty() {
            "estimated from the plate"
        } else {
            "as given"
        };
        let noise = by_colour(&|removed| Some(format!("{:.3e}", removed.noise)));
        let mut warnings = vec![format!("noise, {source}: {noise}")];
        let clipped = by_colour(&|removed| {
            let clipping = removed.clipping.filter(|clipping| clipping.count > 0)?;
            let (level, count) = (clipping.level, clipping.count);
            Some(format!("{count} samples from {level:.4} up"))
        });
        if !clipped.is_empty() {
            warnings.push(format!("clipped: {clipped}"));
        }
        warnings.extend(kept_blur::note(removed));
        let misfit = by_colour(&|removed| {
            // Without noise there is nothing to compare the misfit with.
            let is_large = removed.noise > 0.0 && removed.misfit > LARGEST_MISFIT;
            is_large.then(|| format!("{:.1}", removed.misfit))
        });
        if !misfit.is_empty() {
            warnings.push(format!(
                "the lens does not explain the plate: misfit, in times its noise, is {misfit}; check the profile, --amount, or the depth"
            ));
        }
        warnings
    }
}

impl<'a> Removal<'a> {
    /// Creates the removal for the frames of `run`, as a part of `task`.
    pub(super) fn new(
        args: &'a RemovalArgs,
        reader: &'a PlateReader<'a>,
        run: &'a Run,
        task: Task,
    ) -> Self {
        Self {
            args,
            reader,
            run,
            check: LensCheck::new(args.lens_check, run.frames().len(), task),
        }
    }

    /// Returns the files of the frame at `index`.
    pub(super) fn frame(&self, index: usize) -> &FrameFiles {
        &self.run.frames()[index]
    }

    /// Reads a view of the plate of the frame at `index`, with all images beside it.
    pub(super) fn read(&self, index: usize, view: usize) -> Result<LoadedPlate, CommandError> {
        let frame = self.frame(index);
        let mut loaded = self.reader.read(frame, index, view)?;
        self.reader.add_side_images(&frame.read, &mut loaded)?;
        Ok(loaded)
    }

    /// Returns an upper bound of the memory that a frame takes, bytes.
    pub(super) fn memory_bytes(&self, loaded: &LoadedPlate) -> u64 {
        let pixels = loaded.plate.width() as u64 * loaded.plate.height() as u64;
        let planes = loaded.prepared.planes().len() as u64;
        // The file before and after.
        2 * loaded.plate.memory_bytes() + remove_bytes(pixels, planes)
    }

    /// Removes the blur of the lens from the plate of the frame at `index`, after the check of the lens. Adds warnings to
    /// the plate.
    pub(super) fn remove(
        &self,
        index: usize,
        loaded: &mut LoadedPlate,
        noise_gain: NoiseGain,
    ) -> Result<RemovedPlate, CommandError> {
        let progress = |share| self.run.show_progress(index, REMOVAL_SHARE * share);
        let done = if self.check.is_due() {
            CHECK_SHARE
        } else {
            0.0
        };
        let number = self.frame(index).number;
        (self.check).set_lens(self.reader, number, loaded, &|share| progress(done * share))?;
        let removed = (loaded.prepared)
            .remove(noise_gain, &|share| progress(done + (1.0 - done) * share))
            .map_err(|e| loaded.in_file(e))?;
        let warnings = self.args.warnings(loaded.plate.colour_names(), &removed);
        loaded.warnings.extend(warnings);
        Ok(removed)
    }

    /// Shows the progress of a removal of colour fringes.
    pub(super) fn show_match_progress(&self, index: usize, share: f64) -> bool {
        self.run.show_progress(index, share)
    }

    /// Shows the progress of a render of the result.
    pub(super) fn show_render_progress(&self, index: usize, share: f64) -> bool {
        let done = REMOVAL_SHARE + (1.0 - REMOVAL_SHARE) * share;
        self.run.show_progress(index, done)
    }
}
