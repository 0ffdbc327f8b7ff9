//! A picture from one space to another.

use std::path::Path;

use seidel_colour::{Alphas, Config};

use super::LutArgs;
use crate::Console;
use crate::commands::CommandError;
use crate::commands::plates::space_of;
use crate::files::error::FileError;
use crate::files::flat_plate::Encoding;
use crate::files::plate::{Plate, PlateOptions};

/// What asks for the space that a file is in to be told by the file.
const AUTO: &str = "auto";

/// Converts the picture `input`.
pub(super) fn run(
    args: &LutArgs,
    config: &Config,
    (input, output): (&Path, &Path),
    console: &mut Console,
) -> Result<(), CommandError> {
    let options = PlateOptions {
        layer: args.layer.clone(),
        encoding: Some(Encoding::Linear),
        colour_managed: true,
        ..PlateOptions::default()
    };
    let mut plate = Plate::open(input, &options)?;
    let asked = args.in_space.as_deref().unwrap_or(AUTO);
    let (from, by) = match asked {
        AUTO => space_of(config, &plate)?,
        name => (config.space(name)?, "--in-space".to_owned()),
    };
    let processor = args.processor(config, &from.name)?;
    console.remark(format!(
        "colour: `{}` ({by}) to `{}`, by {}",
        from.name,
        processor.to(),
        config.name()
    ));
    let bad = plate.non_finite();
    if let (Some(first), false) = (bad.first(), args.scrub) {
        let remedy = "mend the picture, or give --scrub to replace such samples by zero";
        return Err(FileError::new(input, "", first.to_string(), remedy).into());
    }
    for bad in &bad {
        console.remark(format!("{bad}; replaced by zero"));
    }
    let mut colours = plate.colour();
    // Also where nothing is converted.
    for sample in colours.iter_mut().flatten().filter(|v| !v.is_finite()) {
        *sample = 0.0;
    }
    let alpha = plate.alpha();
    let alphas = match &alpha {
        Some(alpha) if plate.is_premultiplied() => Alphas::Shared(alpha),
        _ => Alphas::Straight,
    };
    let report = processor.planes(&mut colours, alphas)?;
    if report.unheld > 0 {
        let problem = format!(
            "{} samples have no finite number in `{}`",
            report.unheld,
            processor.to()
        );
        if !args.scrub {
            let remedy = "check --in-space, or give --scrub to replace such samples by zero";
            return Err(FileError::new(input, "colour", problem, remedy).into());
        }
        console.remark(format!("{problem}; replaced by zero"));
    }
    plate.set_colour(&colours)?;
    if processor.from() != processor.to() {
        plate.set_colour_space(processor.to());
    }
    for said in plate.write(output)? {
        console.remark(said);
    }
    Ok(())
}
