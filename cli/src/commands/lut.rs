//! `seidel lut`: pictures from one colour space to another, the same as a look-up table, and what spaces there are.

mod bake;
mod convert;
mod list;

use std::ffi::OsString;
use std::path::Path;
use std::sync::Arc;

use clap::Args;
use seidel_colour::{Config, Processor};

use super::CommandError;
use super::plates::{ConfigArgs, RunArgs};
use crate::Console;

/// Options of `seidel lut`.
#[derive(Debug, Args)]
pub struct LutArgs {
    /// The picture to convert: OpenEXR, PNG, TIFF, DPX, Radiance HDR or JPEG; may hold a frame pattern such as
    /// plate.%04d.exr; none to write a table
    #[arg(value_name = "IN", requires = "output")]
    input: Option<String>,
    /// Where to write: the picture, EXR, PNG, TIFF, DPX or HDR by its extension, or a table, .cube or .spi1d
    #[arg(short, long, value_name = "OUT", required_unless_present = "list")]
    output: Option<String>,
    /// List the config's spaces, roles, displays and views
    #[arg(long, conflicts_with_all = ["input", "output", "in_space", "out_space", "view"])]
    list: bool,
    #[command(flatten)]
    config: ConfigArgs,
    /// Colour space to come from, by name, alias or role; of a picture auto for what its file says, else the config's
    /// file rules
    #[arg(long, value_name = "SPACE", required_unless_present = "list")]
    in_space: Option<String>,
    /// Colour space to go to
    #[arg(long, value_name = "SPACE", required_unless_present_any = ["list", "view"])]
    out_space: Option<String>,
    /// Go to what a display is sent for one of its views, instead of a space
    #[arg(long, value_name = "DISPLAY/VIEW", conflicts_with = "out_space")]
    view: Option<String>,
    /// Entries of a table: those of a side of a .cube, 33 if left out, or all of an .spi1d, 4096
    #[arg(long, value_name = "N", conflicts_with = "input")]
    size: Option<usize>,
    /// Values of a table's first and last entries
    #[arg(long, value_name = "LOW,HIGH", default_value = "0,1", allow_hyphen_values = true, value_parser = parse_range)]
    range: (f32, f32),
    /// EXR layer or part to convert; the root R, G, B (or Y) and A if left out
    #[arg(long, requires = "input")]
    layer: Option<String>,
    /// Replace NaN and infinite samples by zero, and say how many, instead of stopping
    #[arg(long, requires = "input")]
    scrub: bool,
    #[command(flatten)]
    run: RunArgs,
}

fn parse_range(text: &str) -> Result<(f32, f32), String> {
    let numbers: Vec<Option<f32>> = text.split(',').map(|t| t.trim().parse().ok()).collect();
    match numbers.as_slice() {
        [Some(low), Some(high)] if low < high && low.is_finite() && high.is_finite() => {
            Ok((*low, *high))
        }
        _ => Err("give two numbers, the smaller first, such as -0.125,1.125".to_owned()),
    }
}

impl LutArgs {
    /// What goes from the space called `from` to where the options say.
    fn processor(&self, config: &Config, from: &str) -> Result<Arc<Processor>, CommandError> {
        if let Some(view) = &self.view {
            // Views may have slashes in their names, displays hardly.
            let (display, view) = view.split_once('/').unwrap_or((view, ""));
            return Ok(Arc::new(config.display_processor(from, display, view)?));
        }
        let to = self.out_space.as_deref().unwrap_or_default();
        Ok(config.processor(from, to)?)
    }
}

pub(super) fn run(
    args: &LutArgs,
    words: &[OsString],
    console: &mut Console,
) -> Result<(), CommandError> {
    let config = args.config.load()?;
    if let (Some(input), Some(output)) = (&args.input, &args.output) {
        return convert::run(args, &config, (input, output), words, console);
    }
    if args.run.has_frames() {
        let words = "--frames are those of a picture IN, which was not given";
        return Err(CommandError::Usage(words.to_owned()));
    }
    match &args.output {
        Some(output) => bake::run(args, &config, Path::new(output), console),
        None => {
            list::run(&config, console);
            Ok(())
        }
    }
}
