//! The folder of a measured set, and the files beside it.

use std::path::Path;

use image::RgbImage;
use seidel_core::{LensProfile, ObservationSet};
use seidel_image_io::atomic::{Output, check_target, write_atomically, write_folder_atomically};
use seidel_image_io::formats::png::write_rgb8;
use seidel_image_io::json::write_json;
use seidel_image_io::observation_set::{self as manifest, ReadOptions};
use seidel_image_io::{FileError, lens_profile};
use serde_json::Value;

use super::common::CommonArgs;
use super::left_out;
use crate::commands::CommandError;

/// The files of a measurement.
pub(super) struct Written<'a> {
    pub(super) set: &'a ObservationSet,
    pub(super) left_out: &'a [Value],
    pub(super) sheet: &'a RgbImage,
    pub(super) page: &'a str,
    pub(super) lens: Option<&'a LensProfile>,
}

/// Checks that the files of the options can be written.
pub(super) fn check_targets(args: &CommonArgs) -> Result<(), CommandError> {
    for target in [&args.fit, &args.sheet, &args.report].into_iter().flatten() {
        check_target(target)?;
    }
    Ok(())
}

/// Writes the folder whole or not at all, then the files beside it.
pub(super) fn write(args: &CommonArgs, written: &Written<'_>) -> Result<(), CommandError> {
    let mut set = written.set.clone();
    args.put_camera(&mut set)?;
    let faults = set.faults();
    if !faults.is_empty() {
        return Err(CommandError::File(FileError::many(&args.out, faults)));
    }
    write_folder_atomically(&args.out, |folder| {
        manifest::write_into(&set, folder)?;
        write_json(&folder.join(left_out::FILE), &written.left_out)?;
        write_rgb8(&folder.join("sheet.png"), written.sheet)?;
        write_page(&folder.join("report.html"), written.page)?;
        match written.lens {
            Some(lens) => lens_profile::write(&folder.join("lens.json"), lens),
            None => Ok(()),
        }
    })?;
    if let (Some(path), Some(lens)) = (&args.fit, written.lens) {
        lens_profile::write(path, lens)?;
    }
    if let Some(path) = &args.sheet {
        write_rgb8(path, written.sheet)?;
    }
    if let Some(path) = &args.report {
        write_page(path, written.page)?;
    }
    Ok(())
}

/// Writes a page whole or not at all.
pub(super) fn write_page(path: &Path, page: &str) -> Result<(), FileError> {
    write_atomically(path, |out: &mut Output<'_>| {
        std::io::Write::write_all(out, page.as_bytes())
    })
}

/// Returns the name of the tile of a number, and the number of a tile of such a name.
fn file(number: usize) -> String {
    format!("psf/{number:04}.tif")
}

fn number(name: &str) -> Option<usize> {
    let number = name
        .strip_prefix("psf/")?
        .strip_suffix(".tif")?
        .parse()
        .ok()?;
    (file(number) == name).then_some(number)
}

/// Adds the observations and the left-out places of the set at `path`, before those of `set`.
pub(super) fn append(
    set: &mut ObservationSet,
    left_out: &mut Vec<Value>,
    path: &Path,
) -> Result<usize, CommandError> {
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
    // Files keep their numbers where they have any; those of the photographs go on after them.
    let numbers: Option<Vec<usize>> = other.observations.iter().map(|o| number(&o.file)).collect();
    let first = match numbers {
        Some(numbers) => numbers.into_iter().max().map_or(0, |largest| largest + 1),
        None => {
            for (index, observation) in other.observations.iter_mut().enumerate() {
                observation.file = file(index);
            }
            other.observations.len()
        }
    };
    for (index, observation) in set.observations.iter_mut().enumerate() {
        observation.file = file(first + number(&observation.file).unwrap_or(index));
    }
    let added = other.observations.len();
    other.observations.append(&mut set.observations);
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
    Ok(added)
}
