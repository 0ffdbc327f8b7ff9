//! The conversion between two spaces as a look-up table.

use std::path::Path;

use seidel_colour::tables::{cube, cube_grid, linspace, spi1d};
use seidel_colour::{Config, PixelLayout, Processor};

use super::LutArgs;
use crate::Console;
use crate::commands::CommandError;
use seidel_image_io::atomic::check_target;
use seidel_image_io::error::FileError;
use seidel_image_io::lut::{LutFormat, write_lut};

/// Smallest and largest side of a .cube that other programs read.
const CUBE_SIDES: (usize, usize) = (2, 129);
/// Smallest and largest number of entries of an .spi1d: single precision distinguishes no more over a stop.
const SPI1D_ENTRIES: (usize, usize) = (2, 1 << 20);

/// Writes the table `output`.
pub(super) fn run(
    args: &LutArgs,
    config: &Config,
    output: &Path,
    console: &mut Console,
) -> Result<(), CommandError> {
    let Some(format) = LutFormat::from_path(output) else {
        let problem = "does not have the extension of a table";
        let remedy = "name it .cube or .spi1d, or give a picture IN to convert";
        return Err(FileError::new(output, "", problem, remedy).into());
    };
    check_target(output)?;
    let from = args.in_space.as_deref().unwrap_or_default();
    let processor = args.processor(config, from)?;
    let ((least, most), default) = match format {
        LutFormat::Cube => (CUBE_SIDES, 33),
        LutFormat::Spi1d => (SPI1D_ENTRIES, 4096),
    };
    let size = args.size.unwrap_or(default);
    if !(least..=most).contains(&size) {
        return Err(CommandError::Usage(format!(
            "--size is {size}; give {least} to {most} for such a table"
        )));
    }
    let text = match format {
        LutFormat::Cube => {
            let entries = convert(&processor, cube_grid(size, args.range), output)?;
            let title = format!("{} to {}", processor.from(), processor.to());
            cube(&title, size, args.range, &entries)
        }
        LutFormat::Spi1d => {
            let values = linspace(args.range, size);
            let greys = values.iter().map(|value| [*value; 3]).collect();
            let entries = convert(&processor, greys, output)?;
            check_separable(&processor, &values, &entries, output)?;
            spi1d(args.range, &entries)
        }
    };
    write_lut(output, &text)?;
    console.note(format!(
        "colour: `{}` to `{}`, by {}; values outside {} to {} are clipped by programs that read the table",
        processor.from(),
        processor.to(),
        config.name(),
        args.range.0,
        args.range.1
    ));
    Ok(())
}

/// Returns the converted colours.
///
/// # Errors
/// Colours without a finite value in the other space.
fn convert(
    processor: &Processor,
    mut colours: Vec<[f32; 3]>,
    output: &Path,
) -> Result<Vec<[f32; 3]>, CommandError> {
    let report = processor.convert_pixels(colours.as_flattened_mut(), PixelLayout::Rgb)?;
    if report.unrepresentable == 0 {
        return Ok(colours);
    }
    let problem = format!(
        "{} entries have no finite value in `{}`",
        report.unrepresentable,
        processor.to()
    );
    Err(FileError::new(output, "", problem, "give a smaller --range").into())
}

/// Largest relative change of a channel by the other channels for which a table per channel is accurate.
const CROSSTALK: f32 = 1e-4;

/// Rejects a conversion that mixes channels; `entries` are the converted greys of `values`.
fn check_separable(
    processor: &Processor,
    values: &[f32],
    entries: &[[f32; 3]],
    output: &Path,
) -> Result<(), CommandError> {
    let last = values.len() - 1;
    let indices = [0.0, 0.35, 0.7, 1.0].map(|share| (share * last as f32) as usize);
    for channel in 0..3 {
        let mut probes = Vec::new();
        for own in indices {
            for other in indices {
                let mut probe = [values[other]; 3];
                probe[channel] = values[own];
                probes.push((own, probe));
            }
        }
        let colours = probes.iter().map(|(_, probe)| *probe).collect();
        let converted = convert(processor, colours, output)?;
        for ((own, _), found) in probes.iter().zip(converted) {
            let want = entries[*own][channel];
            if (found[channel] - want).abs() > CROSSTALK * want.abs().max(0.01) {
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
