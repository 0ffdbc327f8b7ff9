//! The removal that `remove` and `relens` share: options, the check of the lens, and warnings.

mod lens_check;

use clap::Args;
use seidel_core::render::remove::Removed;
use seidel_core::{NoiseGain, RemovalSettings, RemovedPlate, Saturation, remove_bytes};

use super::CommandError;
use super::plates::{LoadedPlate, PlateReader};
use lens_check::{Checked, OnDoubt};
use seidel_image_io::error::FileError;
use seidel_image_io::plate::Plate;

pub(super) use lens_check::LensCheck;

/// Misfit above which a warning says that the lens does not explain the plate, in standard deviations of the noise.
const MISFIT: f64 = 1.5;

/// Share of the first frame's work that the check of the lens takes.
const CHECK_SHARE: f64 = 0.3;

/// Options about noise and clipping of the plate.
#[derive(Debug, Args)]
pub(super) struct RemovalArgs {
    /// Standard deviation of the plate's noise, in its linear units: one for all colours or one for each, such as
    /// 0.004,0.003,0.006; estimated from the plate if left out
    #[arg(long, value_name = "S", value_delimiter = ',', value_parser = parse_noise, allow_hyphen_values = true)]
    noise: Vec<f64>,
    /// Where the plate is clipped: samples of LEVEL and more, and what they land on, keep their blur; auto tells the
    /// level from the plate, none takes all samples as they are
    #[arg(long, value_name = "LEVEL|auto|none", default_value = "auto", value_parser = parse_clip, allow_hyphen_values = true)]
    clip: Saturation,
    /// The plate's first frame is asked whether it shows as much blur as the lens has; where it does not:
    #[arg(long, value_enum, value_name = "DO", default_value_t = OnDoubt::Adjust)]
    lens_check: OnDoubt,
}

fn parse_noise(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok();
    number
        .filter(|v| v.is_finite() && *v >= 0.0)
        .ok_or_else(|| "give a standard deviation of zero or more, such as 0.004".to_owned())
}

fn parse_clip(text: &str) -> Result<Saturation, String> {
    match text {
        "auto" => Ok(Saturation::Told),
        "none" => Ok(Saturation::Never),
        level => (level.parse::<f64>().ok())
            .filter(|v| v.is_finite())
            .map(Saturation::From)
            .ok_or_else(|| "give the level at which samples are clipped, auto, or none".to_owned()),
    }
}

impl RemovalArgs {
    /// Rejects a number of noise levels that is neither one nor that of the plate's colours.
    pub(super) fn check(&self, plate: &Plate) -> Result<(), CommandError> {
        let names = plate.colour_names();
        if self.noise.len() <= 1 || self.noise.len() == names.len() {
            return Ok(());
        }
        Err(FileError::new(
            plate.path(),
            "--noise",
            format!("has {} values", self.noise.len()),
            format!("give one for all, or one each for {}", names.join(", ")),
        )
        .into())
    }

    /// The settings of a removal.
    pub(super) fn settings(&self) -> RemovalSettings {
        RemovalSettings {
            noise: self.noise.clone(),
            saturation: self.clip,
            ..RemovalSettings::default()
        }
    }

    /// Removes the blur of the lens from the plate of frame `number`, after `check` has set the lens. Adds warnings to the
    /// plate.
    pub(super) fn remove(
        &self,
        reader: &PlateReader,
        check: &LensCheck,
        number: Option<i64>,
        loaded: &mut LoadedPlate,
        noise_gain: NoiseGain,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<RemovedPlate, CommandError> {
        let checking = |share| progress(CHECK_SHARE * share);
        let checked = check.settle(self.lens_check, reader, number, loaded, &checking)?;
        let done = match checked {
            Checked::Here => CHECK_SHARE,
            Checked::Before => 0.0,
        };
        let removing = |share| {
            progress(done + (1.0 - done) * share);
            true
        };
        let removed = loaded.prepared.remove(noise_gain, &removing);
        let removed = removed.map_err(|e| loaded.in_file(e))?;
        let warnings = self.warnings(loaded.plate.colour_names(), &removed);
        loaded.warnings.extend(warnings);
        Ok(removed)
    }

    /// Noise, clipping and misfit of the colours called `names`, in words.
    fn warnings(&self, names: &[String], removed: &RemovedPlate) -> Vec<String> {
        let each = |describe: &dyn Fn(&Removed) -> Option<String>| {
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
        let noise = each(&|removed| Some(format!("{:.3e}", removed.noise)));
        let mut warnings = vec![format!("noise, {source}: {noise}")];
        let clipped = each(&|removed| {
            let (level, count) = removed.clipped.filter(|(_, count)| *count > 0)?;
            Some(format!("{count} samples from {level:.4} up"))
        });
        if !clipped.is_empty() {
            warnings.push(format!("clipped: {clipped}"));
        }
        let misfit = each(&|removed| {
            let misfit = misfit(removed).filter(|misfit| *misfit > MISFIT)?;
            Some(format!("{misfit:.1}"))
        });
        if !misfit.is_empty() {
            warnings.push(format!(
                "the lens does not explain the plate: misfit, in times its noise, is {misfit}; check the profile, --amount, or the depth"
            ));
        }
        warnings
    }
}

/// The misfit, where there is noise to compare it with.
fn misfit(removed: &Removed) -> Option<f64> {
    (removed.noise > 0.0).then_some(removed.misfit)
}

/// Most memory that a frame takes, bytes.
pub(super) fn work_bytes(loaded: &LoadedPlate) -> u64 {
    let pixels = loaded.plate.width() as u64 * loaded.plate.height() as u64;
    // The file before and after.
    2 * loaded.plate.memory_bytes() + remove_bytes(pixels, loaded.prepared.planes().len() as u64)
}
