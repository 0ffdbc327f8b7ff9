//! `seidel demo --measure`: raw photographs of point lights, and the lens measured in them.

use std::ffi::OsString;
use std::fs;

use seidel_core::{Lens, ObjectDistance, Predictor};
use seidel_image_io::atomic::check_folder_content;
use seidel_image_io::error::FileError;
use seidel_image_io::formats::png::write_gray16;
use seidel_image_io::lens_profile;

use super::{DemoArgs, worst_size_error_px};
use crate::Console;
use crate::commands::{CommandError, measure};
use crate::demo::lens::lens as built_in_lens;
use crate::demo::photograph::{BLACK, MOSAIC, WHITE, photograph_of_lights};

/// The photographs, with their distances in metres: even in 1 / distance, and before the focus at 2 m, where the PSFs of this lens are
/// narrower than a pixel.
const PHOTOGRAPHS: [(&str, f64); 3] = [("near.png", 1.4), ("middle.png", 1.55), ("far.png", 1.75)];
/// Results of the measurement beside them.
const LIGHTS: &str = "lights";
const LENS: &str = "lens.json";

pub(super) fn run(args: &DemoArgs, console: &mut Console) -> Result<(), CommandError> {
    let folder = &args.folder;
    let names = PHOTOGRAPHS.map(|(name, _)| name);
    check_folder_content(folder, &[&names[..], &[LIGHTS, LENS]].concat())?;
    fs::create_dir_all(folder).map_err(|e| FileError::io(folder, "be created", &e))?;
    let truth = built_in_lens(args.width, args.width * 9 / 16)?;
    for (seed, (name, metres)) in (0..).zip(PHOTOGRAPHS) {
        let photograph = photograph_of_lights(&truth, metres, seed)?;
        let path = folder.join(name);
        write_gray16(&path, photograph.width, photograph.samples)?;
        console.print(format!(
            "{:<32} raw mosaic of point lights at {metres} m",
            path.display()
        ));
    }
    let arguments = measure_arguments(args);
    let shown: Vec<_> = arguments.iter().map(|a| a.to_string_lossy()).collect();
    console.print(format!("seidel measure {}", shown.join(" ")));
    measure::run_line(&arguments, console)?;
    let lens = Lens::new(lens_profile::read(&folder.join(LENS))?)?;
    let distances = PHOTOGRAPHS.map(|(_, metres)| ObjectDistance::metres(metres));
    let distances: Vec<ObjectDistance> = distances.into_iter().collect::<Result<_, _>>()?;
    let error = worst_size_error_px(&Predictor::new(&truth)?, lens.predictor(), &distances)?;
    console.print(format!(
        "Predicted PSF sizes are within {error:.2} px of the lens that took the photographs."
    ));
    Ok(())
}

/// Returns the measurement as a user gives it after `seidel measure`.
fn measure_arguments(args: &DemoArgs) -> Vec<OsString> {
    let folder = &args.folder;
    let distances = PHOTOGRAPHS.map(|(_, metres)| metres.to_string());
    let mut arguments = vec![OsString::from("lights")];
    arguments.extend(PHOTOGRAPHS.map(|(name, _)| folder.join(name).into()));
    for (name, value) in [
        ("--cfa", OsString::from(MOSAIC)),
        ("--black", BLACK.to_string().into()),
        ("--white", WHITE.to_string().into()),
        ("--distance", distances.join(",").into()),
        ("--out", folder.join(LIGHTS).into()),
        ("--fit", folder.join(LENS).into()),
    ] {
        arguments.extend([OsString::from(name), value]);
    }
    arguments
}
