//! `seidel measure lights`: PSF tiles of point lights.

use clap::Args;
use image::RgbImage;
use seidel_core::{AxisChoice, LensProfile, ObservationSet};
use seidel_measure::{LightSet, LightSettings, Reason, TileSize, measure_lights};
use serde_json::{Map, Value, json};

use super::common::CommonArgs;
use super::fitted::PixelNoise;
use super::{by_option, fitted, left_out, light_size, output, photographs};
use crate::Console;
use crate::commands::CommandError;
use crate::pictures::measured_sheet::light_sheet;
use crate::report::measured::{MeasuredPage, Place, measured_page};

/// Options of `seidel measure lights`.
#[derive(Debug, Args)]
pub struct LightsArgs {
    #[command(flatten)]
    pub(super) common: CommonArgs,
    /// Width and height of the tiles in pixels, or `auto` for as wide as the lights need
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = parse_tile)]
    tile: TileSize,
    /// Least signal over noise of a light
    #[arg(long, value_name = "N", default_value_t = LightSettings::default().min_snr)]
    min_snr: f64,
    /// Diameter in pixels that the image of a light would have without blur: its variance is taken off the blur of the fitted lens
    #[arg(long, value_name = "PX", requires = "fit")]
    light_px: Option<f64>,
    /// Numbers of lights to leave out, as `left_out.json` and the files in `psf` name them
    #[arg(long, value_name = "N,M", value_delimiter = ',')]
    leave_out: Vec<usize>,
    /// Numbers of lights to keep in spite of the checks
    #[arg(long, value_name = "N,M", value_delimiter = ',')]
    keep: Vec<usize>,
    /// Measure photographs with faults that make the lens wrong, such as sharpening or motion
    #[arg(long)]
    force: bool,
}

/// Names the option of numbers at fault.
fn named(error: seidel_core::Error) -> CommandError {
    match error.place.as_str() {
        "keep" | "leave_out" => by_option(error),
        _ => error.into(),
    }
}

/// Adds the option that measures in spite of a fault.
fn refused(mut error: seidel_core::Error) -> CommandError {
    error
        .remedy
        .push_str(", or measure in spite of it with --force");
    error.into()
}

fn parse_tile(text: &str) -> Result<TileSize, String> {
    if text == "auto" {
        return Ok(TileSize::Auto);
    }
    let side = text
        .parse()
        .ok()
        .filter(|side| TileSize::RANGE.contains(side));
    side.map(TileSize::Pixels).ok_or_else(|| {
        let (least, most) = (TileSize::RANGE.start(), TileSize::RANGE.end());
        format!("give {least} to {most} pixels, or `auto`")
    })
}

pub(super) fn run(args: &LightsArgs, console: &mut Console) -> Result<(), CommandError> {
    let common = &args.common;
    common.check()?;
    if let Some(diameter) = args.light_px
        && !(0.0..=light_size::MAX_DIAMETER_PX).contains(&diameter)
    {
        return Err(CommandError::Usage(format!(
            "--light-px: give 0 to {} pixels",
            light_size::MAX_DIAMETER_PX
        )));
    }
    output::check_targets(common)?;
    let (photographs, calibration) =
        photographs::read_all(&common.photographs, &common.input, console)?;
    let settings = LightSettings {
        tile: args.tile,
        min_snr: args.min_snr,
        leave_out: args.leave_out.clone(),
        keep: args.keep.clone(),
        ..LightSettings::default()
    };
    let measured = measure_lights(photographs, &calibration, &settings).map_err(named)?;
    if let Some(refusal) = measured.refusal().filter(|_| !args.force) {
        return Err(refused(refusal.clone()));
    }
    let axis = match common.axis {
        Some(AxisChoice::At(axis)) => Some(axis),
        _ => None,
    };
    let mut set = measured.observations(axis)?;
    let mut left_out = left_out::entries(&measured.left_out, &measured.photographs);
    let appended = match &common.also {
        Some(path) => output::append(&mut set, &mut left_out, path),
        None => Ok(0),
    };
    let noise = PixelNoise::Photons {
        white: f64::from(measured.photographs[0].white),
    };
    let fitted = match (appended, &common.fit) {
        (Ok(added), Some(_)) => fitted::fit_lens(common, &mut set, added, noise, console).map(Some),
        (appended, _) => appended.map(|_| None),
    };
    // Whatever ends the run here, the lights that were measured are written.
    let (mut fit, failure) = match fitted {
        Ok(fit) => (fit, None),
        Err(error) => (None, Some(error)),
    };
    let light_size = match (&mut fit, args.light_px) {
        (Some(fit), Some(diameter)) => Some(light_size::take_off(fit.lens_mut(), diameter)),
        _ => None,
    };
    if let Some(fit) = &fit {
        set.frame = set.frame.with_axis(fit.lens().frame.axis())?;
        set.axis_stated = true;
    }
    let lens = fit.as_ref().map(|fit| fit.lens());
    let sheet = light_sheet(&measured);
    let page = page(&measured, &set, lens, &sheet);
    let written = output::Written {
        set: &set,
        left_out: &left_out,
        sheet: &sheet,
        page: &page,
        lens,
    };
    output::write(common, &written)?;
    if common.json {
        let report = report_json(&measured, &set, lens);
        console.print(format!("{report:#}"));
    } else {
        print_report(args, &measured, &set, console);
        if let Some(fit) = &fit {
            fitted::print_report(fit, console);
        }
    }
    for warning in measured.warnings.iter().chain(&light_size) {
        console.note(warning);
    }
    match failure {
        None => Ok(()),
        Some(error) => {
            let folder = common.out.display();
            console.note(format!(
                "no lens was fitted. {folder} holds the lights of the photographs: `seidel fit {folder}` fits them once the fault is corrected"
            ));
            Err(error)
        }
    }
}

/// Returns the number of lights left out for every reason that occurs.
fn reasons(measured: &LightSet) -> Vec<(Reason, usize)> {
    let count = |why: Reason| measured.left_out.iter().filter(|l| l.why == why).count();
    let all = Reason::ALL.map(|why| (why, count(why)));
    all.into_iter().filter(|(_, count)| *count > 0).collect()
}

/// Returns the noise of a dark pixel in electrons, if the gain is known.
fn dark_noise(set: &ObservationSet) -> Option<f64> {
    let observation = set.observations.last()?;
    let reference = set.channels.iter().position(|name| name == "G");
    let sigma = observation.noise_sigma[reference.unwrap_or(0)]?;
    Some(sigma / observation.gain?)
}

/// Returns the counts per electron of the photographs.
fn gain(set: &ObservationSet) -> Option<f64> {
    set.observations.last()?.gain
}

/// Returns the report as a web page.
fn page(
    measured: &LightSet,
    set: &ObservationSet,
    lens: Option<&LensProfile>,
    sheet: &RgbImage,
) -> String {
    let mut noise = Vec::new();
    if let Some(gain) = gain(set) {
        noise.push(format!("{gain:.3} counts per electron"));
    }
    if let Some(electrons) = dark_noise(set) {
        noise.push(format!("{electrons:.1} electrons of noise in a dark pixel"));
    }
    for (name, sigma) in set.channels.iter().zip(typical_sigma(set)) {
        noise.push(format!("{name}: {sigma:.2} counts in a dark pixel"));
    }
    let hot: usize = measured.hot_pixels.iter().sum();
    noise.push(format!("{hot} defective pixels"));
    measured_page(&MeasuredPage {
        kind: "lights",
        photographs: &measured.photographs,
        distances: set.observations.iter().map(|o| o.distance).collect(),
        kept: (measured.lights.iter())
            .map(|light| Place {
                photograph: light.photograph,
                at: light.place(),
            })
            .collect(),
        left_out: &measured.left_out,
        sheet,
        noise,
        lens,
        warnings: &measured.warnings,
    })
}

/// Returns the median noise of a dark pixel by channel, counts.
fn typical_sigma(set: &ObservationSet) -> Vec<f64> {
    let of = |channel: usize| {
        let sigmas = set
            .observations
            .iter()
            .filter_map(|o| o.noise_sigma[channel]);
        let mut sigmas: Vec<f64> = sigmas.collect();
        sigmas.sort_by(f64::total_cmp);
        sigmas.get(sigmas.len() / 2).copied().unwrap_or(0.0)
    };
    (0..set.channels.len()).map(of).collect()
}

fn report_json(measured: &LightSet, set: &ObservationSet, lens: Option<&LensProfile>) -> Value {
    let by_reason: Map<String, Value> = (reasons(measured).into_iter())
        .map(|(why, count)| (why.name().to_owned(), json!(count)))
        .collect();
    json!({
        "photographs": measured.photographs.iter().map(|p| &p.name).collect::<Vec<_>>(),
        "mosaic": set.mosaic.map(|m| m.to_string()),
        "kept": measured.lights.len(),
        "observations": set.observations.len(),
        "left_out": by_reason,
        "hot_pixels": measured.hot_pixels,
        "tile_px": measured.tile_px,
        "gain": gain(set),
        "dark_noise_electrons": dark_noise(set),
        "response": set.channels.iter().zip(&measured.response)
            .map(|(name, r)| (name.clone(), json!(r))).collect::<Map<_, _>>(),
        "lens": lens.map(fitted::report_json),
        "warnings": measured.warnings,
    })
}

fn print_report(
    args: &LightsArgs,
    measured: &LightSet,
    set: &ObservationSet,
    console: &mut Console,
) {
    let kept = measured.lights.len();
    let left_out = measured.left_out.len();
    console.print(format!(
        "kept {kept} of {} lights, tiles of {} px",
        kept + left_out,
        measured.tile_px
    ));
    for (why, count) in reasons(measured) {
        console.print(format!("left out {count}: {why}"));
    }
    if let Some(gain) = gain(set) {
        let noise = dark_noise(set).unwrap_or(0.0);
        console.print(format!(
            "gain {gain:.3} counts per electron, dark noise {noise:.1} electrons"
        ));
    }
    console.print(format!(
        "wrote {} ({} observations)",
        args.common.out.display(),
        set.observations.len()
    ));
}
