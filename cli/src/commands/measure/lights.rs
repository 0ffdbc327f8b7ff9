//! `seidel measure lights`: PSF tiles of point lights.

use std::path::Path;

use clap::Args;
use seidel_core::calibrate::fit::AxisChoice;
use seidel_core::observations::ObservationSet;
use seidel_core::profile::LensProfile;
use seidel_image_io::atomic::{check_target, write_folder_atomically};
use seidel_image_io::json::write_json;
use seidel_image_io::observation_set::{self as manifest, ReadOptions};
use seidel_image_io::png::write_rgb8;
use seidel_image_io::{FileError, lens_profile};
use seidel_measure::{LightSet, LightSettings, Reason, TileSize, measure_lights};
use serde_json::{Map, Value, json};

use super::common::CommonArgs;
use super::{fitted, left_out, photographs};
use crate::Console;
use crate::commands::CommandError;
use crate::pictures::light_sheet::light_sheet;

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
    for target in [&common.fit, &common.sheet].into_iter().flatten() {
        check_target(target)?;
    }
    let (photographs, calibration) = photographs::read_all(common, console)?;
    let settings = LightSettings {
        tile: args.tile,
        min_snr: args.min_snr,
        ..LightSettings::default()
    };
    let measured = measure_lights(photographs, &calibration, &settings)?;
    let axis = match common.axis {
        Some(AxisChoice::At(axis)) => Some(axis),
        _ => None,
    };
    let mut set = measured.observations(axis)?;
    let mut left_out = left_out::entries(&measured.left_out, &measured.photographs);
    if let Some(path) = &common.also {
        append(&mut set, &mut left_out, path)?;
    }
    let fit = match &common.fit {
        Some(_) => {
            let white = f64::from(measured.photographs[0].white);
            Some(fitted::fit_lens(common, &mut set, white, console)?)
        }
        None => None,
    };
    if let Some(fit) = &fit {
        set.frame = set.frame.with_axis(fit.lens().frame.axis())?;
        set.axis_stated = true;
    }
    let lens = fit.as_ref().map(|fit| fit.lens());
    write(common, &set, &left_out, &measured, lens)?;
    if common.json {
        let report = report_json(&measured, &set, lens);
        console.print(format!("{report:#}"));
    } else {
        print_report(args, &measured, &set, console);
        if let Some(fit) = &fit {
            fitted::print_report(fit, console);
        }
    }
    for warning in &measured.warnings {
        console.note(warning);
    }
    Ok(())
}

/// Adds the observations and the left-out lights of the set at `path`, before those of `set`.
fn append(
    set: &mut ObservationSet,
    left_out: &mut Vec<Value>,
    path: &Path,
) -> Result<(), CommandError> {
    let mut other = manifest::read(path, ReadOptions::default())?.set;
    set.check_frame(other.frame)
        .map_err(|error| FileError::from_core(path, error))?;
    if (other.mosaic, &other.channels) != (set.mosaic, &set.channels) {
        let of = |s: &ObservationSet| {
            let mosaic = s.mosaic.map_or("none".to_owned(), |m| m.to_string());
            format!("{} of mosaic {mosaic}", s.channels.join(", "))
        };
        return Err(CommandError::File(FileError::new(
            path,
            "channels, mosaic",
            format!("are {}, those of the photographs {}", of(&other), of(set)),
            "append to a set of the same camera",
        )));
    }
    other.observations.append(&mut set.observations);
    for (index, observation) in other.observations.iter_mut().enumerate() {
        observation.file = format!("psf/{index:04}.tif");
    }
    if set.axis_stated {
        (other.frame, other.axis_stated) = (set.frame, true);
    }
    *set = other;
    let folder = if path.is_dir() {
        path
    } else {
        path.parent().unwrap_or(path)
    };
    let mut all = left_out::of_set(folder)?;
    all.append(left_out);
    *left_out = all;
    Ok(())
}

/// Writes the folder whole or not at all, then the files beside it.
fn write(
    args: &CommonArgs,
    set: &ObservationSet,
    left_out: &[Value],
    measured: &LightSet,
    lens: Option<&LensProfile>,
) -> Result<(), CommandError> {
    let faults = set.faults();
    if !faults.is_empty() {
        return Err(CommandError::File(FileError::many(&args.out, faults)));
    }
    let sheet = light_sheet(measured);
    write_folder_atomically(&args.out, |folder| {
        manifest::write_into(set, folder)?;
        write_json(&folder.join(left_out::FILE), &left_out)?;
        write_rgb8(&folder.join("sheet.png"), &sheet)?;
        match lens {
            Some(lens) => lens_profile::write(&folder.join("lens.json"), lens),
            None => Ok(()),
        }
    })?;
    if let (Some(path), Some(lens)) = (&args.fit, lens) {
        lens_profile::write(path, lens)?;
    }
    if let Some(path) = &args.sheet {
        write_rgb8(path, &sheet)?;
    }
    Ok(())
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
