//! Taking blur off plates: options that `remove` and `relens` share, the removal plane by plane, and what is said of it.

mod lens_check;

use clap::Args;
use seidel_core::plate::{Unblur, Unblurred, remove_bytes};
use seidel_core::remove::{Removed, Saturation};

use super::CommandError;
use super::plates::{Light, ReadPlate, Shared, Sight};
use lens_check::OnDoubt;
use seidel_image_io::error::FileError;
use seidel_image_io::plate::Plate;

pub(super) use lens_check::LensCheck;

/// From this many standard deviations of its noise on, a plate is not what its lens makes of any picture.
const MISFIT: f64 = 1.5;

/// Share of the first frame's work that is the check of the lens.
const CHECK_SHARE: f64 = 0.3;

/// Options about what the plate is known to be.
#[derive(Debug, Args)]
pub(super) struct RemovalArgs {
    /// Standard deviation of the plate's noise, in its linear units: one for all colours or one for each, such as
    /// 0.004,0.003,0.006; told from the plate if left out
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
    /// Refuses a number of noises that is not that of the plate's colours.
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

    /// The plate of frame `number` without the blur of its lens, what becomes of noise if `gain` is asked for, and what
    /// there is to say of it; the lens is set as `check` asks for. `progress` is told the share done.
    pub(super) fn found(
        &self,
        (shared, check): (&Shared, &LensCheck),
        (number, read): (Option<i64>, &mut ReadPlate),
        gain: bool,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Unblurred, CommandError> {
        let checking = |share| progress(CHECK_SHARE * share);
        let is_first = check.settle(self, shared, (number, read), &checking)?;
        let done = if is_first { CHECK_SHARE } else { 0.0 };
        let removing = |share| progress(done + (1.0 - done) * share);
        let found = Self::with_light(shared, read, |sight, light| {
            self.removed(sight, light, gain, &removing)
        })?;
        let said = self.told(read.plate.colour_names(), &found);
        read.said.extend(said);
        Ok(found)
    }

    /// Does `then` with the plate through its lens and the light that fell on the sensor.
    fn with_light<T>(
        shared: &Shared,
        read: &ReadPlate,
        then: impl FnOnce(&Sight, &Light) -> seidel_core::Result<T>,
    ) -> Result<T, CommandError> {
        let ReadPlate { setup, plate, .. } = read;
        let vergence = read.vergence.clone();
        shared.seen(setup, plate, vergence, |sight| {
            let mut light = read.light.with_planes(read.light.copied());
            light.undevelop(&setup.drawing.predictor, sight.weights);
            then(sight, &light).map_err(|e| FileError::from_core(plate.path(), e).into())
        })
    }

    fn unblur(&self) -> Unblur {
        Unblur {
            noise: self.noise.clone(),
            saturation: self.clip,
        }
    }

    /// `light` without the blur of `sight`; `progress` is told the share done.
    fn removed(
        &self,
        sight: &Sight,
        light: &Light,
        gain: bool,
        progress: &(dyn Fn(f64) + Sync),
    ) -> seidel_core::Result<Unblurred> {
        let unblur = self.unblur();
        unblur.removed(&sight.scene, (light, sight.weights), gain, &|share| {
            progress(share);
            true
        })
    }

    /// What there is to say of the colours, called `names`.
    fn told(&self, names: &[String], found: &Unblurred) -> Vec<String> {
        let each = |of: &dyn Fn(&Removed) -> Option<String>| {
            let told = names.iter().zip(found.colours());
            let told = told.filter_map(|(name, removed)| Some(format!("{name} {}", of(removed)?)));
            told.collect::<Vec<_>>().join(", ")
        };
        let source = match self.noise.is_empty() {
            true => "told from the plate",
            false => "as given",
        };
        let noise = each(&|removed| Some(format!("{:.3e}", removed.noise)));
        let mut said = vec![format!("noise, {source}: {noise}")];
        let clipped = each(&|removed| {
            let (level, count) = removed.clipped.filter(|(_, count)| *count > 0)?;
            Some(format!("{count} samples from {level:.4} up"))
        });
        if !clipped.is_empty() {
            said.push(format!("clipped: {clipped}"));
        }
        let misfit = each(&|removed| {
            let misfit = misfit(removed).filter(|misfit| *misfit > MISFIT)?;
            Some(format!("{misfit:.1}"))
        });
        if !misfit.is_empty() {
            said.push(format!(
                "the lens does not explain the plate: misfit, in times its noise, is {misfit}; check the profile, --amount, or the depth"
            ));
        }
        said
    }
}

/// How much more the lens leaves unexplained than there is noise, where there is any.
fn misfit(removed: &Removed) -> Option<f64> {
    (removed.noise > 0.0).then_some(removed.misfit)
}

/// Memory that a frame takes at most, bytes.
pub(super) fn work_bytes(read: &ReadPlate) -> u64 {
    let pixels = read.plate.width() as u64 * read.plate.height() as u64;
    // The file before and after.
    2 * read.plate.held_bytes() + remove_bytes(pixels, read.light.plane_count() as u64)
}
