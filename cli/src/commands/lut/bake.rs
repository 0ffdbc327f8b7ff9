//! What turns one space into another, as a look-up table.

use std::path::Path;

use seidel_colour::tables::{cube, cube_grid, linspace, spi1d};
use seidel_colour::{Config, PixelLayout, Processor};

use super::LutArgs;
use crate::Console;
use crate::commands::CommandError;
use seidel_image_io::atomic::check_target;
use seidel_image_io::error::FileError;
use seidel_image_io::lut::{LutFormat, write_lut};

/// Sides of a .cube that programs read.
const CUBE_SIDES: (usize, usize) = (2, 129);
/// Entries of an .spi1d: no more than single precision tells apart over a stop.
const SPI1D_ENTRIES: (usize, usize) = (2, 1 << 20);

/// Writes the table `output`.
pub(super) fn run(
    args: &LutArgs,
    config: &Config,
    output: &Path,
    console: &mut Console,
) -> Result<(), CommandError> {
    let Some(kind) = LutFormat::from_path(output) else {
        let remedy = "name it .cube or .spi1d, or give a picture IN to convert";
        return Err(FileError::new(output, "", "is named like no table", remedy).into());
    };
    check_target(output)?;
    let from = args.in_space.as_deref().unwrap_or_default();
    let processor = args.processor(config, from)?;
    let (least, most) = match kind {
        LutFormat::Cube => CUBE_SIDES,
        LutFormat::Spi1d => SPI1D_ENTRIES,
    };
    let size = args.size.unwrap_or(match kind {
        LutFormat::Cube => 33,
        LutFormat::Spi1d => 4096,
    });
    if !(least..=most).contains(&size) {
        return Err(CommandError::Usage(format!(
            "--size is {size}; give {least} to {most} for such a table"
        )));
    }
    let text = match kind {
        LutFormat::Cube => {
            let entries = turned(&processor, cube_grid(size, args.range), output)?;
            let title = format!("{} to {}", processor.from(), processor.to());
            cube(&title, size, args.range, &entries)
        }
        LutFormat::Spi1d => {
            let grey = |value: f32| [value; 3];
            let values = linspace(args.range, size);
            let entries = turned(
                &processor,
                values.iter().map(|v| grey(*v)).collect(),
                output,
            )?;
            check_apart(&processor, (&values, &entries), output)?;
            spi1d(args.range, &entries)
        }
    };
    write_lut(output, &text)?;
    console.remark(format!(
        "colour: `{}` to `{}`, by {}; values outside {} to {} are clipped by programs that read the table",
        processor.from(),
        processor.to(),
        config.name(),
        args.range.0,
        args.range.1
    ));
    Ok(())
}

/// What becomes of colours.
fn turned(
    processor: &Processor,
    mut colours: Vec<[f32; 3]>,
    output: &Path,
) -> Result<Vec<[f32; 3]>, CommandError> {
    let report = processor.convert_pixels(colours.as_flattened_mut(), PixelLayout::Rgb)?;
    if report.unrepresentable == 0 {
        return Ok(colours);
    }
    let problem = format!(
        "{} entries have no finite number in `{}`",
        report.unrepresentable,
        processor.to()
    );
    Err(FileError::new(output, "", problem, "give a smaller --range").into())
}

/// How far a channel may follow another, of its own size, before a table of each alone would be wrong.
const APART: f32 = 1e-4;

/// Refuses spaces in which one channel depends on others.
fn check_apart(
    processor: &Processor,
    (values, entries): (&[f32], &[[f32; 3]]),
    output: &Path,
) -> Result<(), CommandError> {
    let last = values.len() - 1;
    let shares = [0.0, 0.35, 0.7, 1.0].map(|share| (share * last as f32) as usize);
    for channel in 0..3 {
        let mut probes = Vec::new();
        for own in shares {
            for other in shares {
                let mut probe = [values[other]; 3];
                probe[channel] = values[own];
                probes.push((own, probe));
            }
        }
        let colours = probes.iter().map(|(_, probe)| *probe).collect();
        let turned = turned(processor, colours, output)?;
        for ((own, _), found) in probes.iter().zip(turned) {
            let want = entries[*own][channel];
            if (found[channel] - want).abs() > APART * want.abs().max(0.01) {
                let problem = format!(
                    "holds each channel alone, but `{}` to `{}` mixes them",
                    processor.from(),
                    processor.to()
                );
                return Err(FileError::new(output, "", problem, "write a .cube").into());
            }
        }
    }
    Ok(())
}
