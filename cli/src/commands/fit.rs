//! `seidel fit`: fits a lens profile to observation sets.

mod moments;
mod pupil;

use std::path::PathBuf;
use std::sync::LazyLock;
use std::time::Instant;

use clap::{Args, ValueEnum};
use seidel_calibrate::diagnose::{MistakeInSet, mistakes_between};
use seidel_calibrate::fit;
use seidel_calibrate::measure::Rejection;
use seidel_core::{AxisChoice, Fit, FitSettings, LensProfile, ObservationSet};
use serde_json::{Value, json};

use super::choice::ChoiceArgs;
use super::picture::read_image;
use super::tile_moments::MomentArgs;
use super::{CommandError, parse_point, short_name};
use crate::Console;
use crate::progress::ProgressArgs;
use seidel_image_io::atomic::check_target;
use seidel_image_io::lens_profile;
use seidel_image_io::observation_set::{self as manifest, ReadOptions};

/// Options of `seidel fit`.
#[derive(Debug, Args)]
pub struct FitArgs {
    /// Observation sets of one camera, folders with a manifest.json: one or more, for further object distances or points
    #[arg(required = true, value_name = "OBS")]
    observations: Vec<PathBuf>,
    /// Lens profile to write
    #[arg(short, long, value_name = "LENS")]
    output: PathBuf,
    /// Lens model; if omitted `reduced`, or `extended` where held-out PSFs show that third order is not enough
    #[arg(long, value_enum)]
    model: Option<Model>,
    /// Position of the optical axis: X,Y in frame pixels, or `free` to estimate it; from the set if omitted
    #[arg(long, value_name = "free|X,Y", value_parser = parse_axis)]
    axis: Option<AxisChoice>,
    #[command(flatten)]
    measure: MomentArgs,
    /// Fit all PSFs and hold none out to score the lens (reduced, extended)
    #[arg(long)]
    use_all: bool,
    /// Describe the lens by smooth functions of distance alone, without their residuals at the measured distances
    /// (reduced, extended)
    #[arg(long)]
    law_only: bool,
    /// Test image on which held-out PSFs are scored, by its luminance; a synthetic one with natural statistics if omitted
    /// (reduced, extended)
    #[arg(long, value_name = "Z")]
    image: Option<PathBuf>,
    /// Leave out bad observations, with a note on each, instead of stopping
    #[arg(long)]
    skip_bad: bool,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
    // After the options without a heading, which would come under its own.
    #[command(flatten)]
    choice: ChoiceArgs,
    #[command(flatten)]
    pub(super) progress: ProgressArgs,
}

/// A lens model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Model {
    /// Third-order aberrations, defocus and a symmetric blur, fitted to the tiles' pixels over all
    /// distances at once
    Reduced,
    /// The same with fifth-order aberrations, and whatever held-out zones of the field ask for: seventh order, vignetting,
    /// blades, an uneven pupil, decentred elements, two planes of symmetry (anamorphic lenses)
    Extended,
    /// S1..S10 per channel and object distance: the paper's model
    Moments,
}

/// Parses an optical axis: `X,Y` or `free`.
pub(super) fn parse_axis(text: &str) -> Result<AxisChoice, String> {
    if text == "free" {
        return Ok(AxisChoice::Free);
    }
    parse_point(text)
        .map(AxisChoice::At)
        .map_err(|problem| format!("{problem}, or `free`"))
}

pub(super) fn run(args: &FitArgs, console: &mut Console) -> Result<(), CommandError> {
    args.check()?;
    check_target(&args.output)?;
    let (mut sets, skipped) = args.read_sets()?;
    for line in &skipped {
        console.note(format!("left out {line}"));
    }
    args.choice.restrict(&mut sets)?;
    let settings = args.settings()?;
    let bar = console.progress_bar("fitting");
    let fitted = fit::fit(&sets, &settings, &|share| bar.show(share));
    drop(bar);
    let mut fit = fitted.map_err(|e| e.within(&args.set_names()))?;
    args.write(fit.lens_mut())?;
    match &fit {
        Fit::Moments(fit) if args.json => console.print(moments::report_json(fit, &skipped)),
        Fit::Moments(fit) => moments::report_text(fit, args, console),
        Fit::Pupil(fit) if args.json => console.print(pupil::report_json(fit, &skipped)),
        Fit::Pupil(fit) => pupil::report_text(fit, args, console),
    }
    for warning in fit.warnings() {
        console.note(warning);
    }
    for MistakeInSet { set, found } in mistakes_between(&sets, fit.lens()) {
        let text = super::mistake_note(&found);
        console.note(format!("{}: {text}", args.observations[set].display()));
    }
    Ok(())
}

/// Returns the seconds since its first call.
fn seconds_of_run() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed().as_secs_f64()
}

impl FitArgs {
    /// Returns the paths of all sets, for errors.
    fn set_names(&self) -> String {
        let names = self.observations.iter();
        let names: Vec<_> = names.map(|path| path.display().to_string()).collect();
        names.join(", ")
    }

    /// Returns the settings of the fit. Reads the test image if one is given.
    fn settings(&self) -> Result<FitSettings, CommandError> {
        Ok(FitSettings {
            model: match self.model {
                None => fit::Model::Auto,
                Some(Model::Moments) => fit::Model::Moments,
                Some(Model::Reduced) => fit::Model::Reduced,
                Some(Model::Extended) => fit::Model::Extended,
            },
            axis: self.axis.unwrap_or_default(),
            support: self.measure.support(),
            weighting: self.measure.weighting(),
            use_all: self.use_all,
            law_only: self.law_only,
            test_image: self.image.as_deref().map(read_image).transpose()?,
            clock: Some(seconds_of_run),
        })
    }

    /// Rejects options that do not apply to the selected model.
    fn check(&self) -> Result<(), CommandError> {
        let moments = self.model == Some(Model::Moments);
        if self.measure.unweighted && !moments {
            return Err(CommandError::Usage(
                "--unweighted applies to moments only; add --model moments or leave it out"
                    .to_owned(),
            ));
        }
        let pupil_options = [
            ("--use-all", self.use_all),
            ("--law-only", self.law_only),
            ("--image", self.image.is_some()),
        ];
        match pupil_options.iter().find(|(_, given)| *given) {
            Some((name, _)) if moments => Err(CommandError::Usage(format!(
                "{name} does not apply to --model moments; leave it out or use --model reduced or extended"
            ))),
            _ => Ok(()),
        }
    }

    /// Reads the sets; also returns the observations left out.
    fn read_sets(&self) -> Result<(Vec<ObservationSet>, Vec<String>), CommandError> {
        let options = ReadOptions {
            skip_bad: self.skip_bad,
        };
        let (mut sets, mut skipped) = (Vec::new(), Vec::new());
        for path in &self.observations {
            let read = manifest::read(path, options)?;
            for fault in read.skipped.iter().flat_map(|d| &d.faults) {
                skipped.push(format!("{}: {fault}", path.display()));
            }
            sets.push(read.set);
        }
        Ok((sets, skipped))
    }

    /// Writes the lens with its provenance.
    fn write(&self, lens: &mut LensProfile) -> Result<(), CommandError> {
        lens.provenance.sources = self.observations.iter().map(|p| short_name(p)).collect();
        lens.provenance.settings += &self.choice.describe();
        Ok(lens_profile::write(&self.output, lens)?)
    }
}

/// Prints the rejected tiles.
fn print_rejected(rejected: &[Rejection], args: &FitArgs, console: &mut Console) {
    for r in rejected {
        console.print(format!(
            "rejected {} observation {} ({}) channel {}: {}",
            args.observations[r.set].display(),
            r.observation,
            r.file,
            r.channel,
            r.reason
        ));
    }
}

/// Returns the rejected tiles as JSON.
fn rejected_json(rejected: &[Rejection]) -> Vec<Value> {
    let one = |r: &Rejection| {
        json!({
            "set": r.set, "observation": r.observation, "file": r.file,
            "channel": r.channel, "reason": r.reason,
        })
    };
    rejected.iter().map(one).collect()
}
