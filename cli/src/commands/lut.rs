//! `seidel lut`: converts pictures between colour spaces, writes look-up tables, and lists the spaces of a config.

mod bake;
mod convert;
mod list;

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use seidel_colour::{Config, Processor};
use seidel_image_io::formats::{names_read, names_written};

use super::CommandError;
use super::plates::{ConfigArgs, RunArgs};
use crate::Console;
use crate::progress::ProgressArgs;

/// Options of `seidel lut`.
#[derive(Debug, Args)]
pub struct LutArgs {
    #[arg(value_name = "IN", requires = "output", help = format!(
        "Picture to convert: {}; or a frame pattern such as plate.%04d.exr; omit it to write a table", names_read()))]
    input: Option<PathBuf>,
    #[arg(short, long, value_name = "OUT", required_unless_present = "list", help = format!(
        "Picture to write ({}), or table (.cube or .spi1d), by its extension", names_written()))]
    output: Option<PathBuf>,
    /// List the config's spaces, roles, displays and views
    #[arg(long, conflicts_with_all = ["input", "output", "in_space", "out_space", "view"])]
    list: bool,
    #[command(flatten)]
    config: ConfigArgs,
    /// Colour space of the input: a name, alias or role of the config; for pictures also auto, for the space that the
    /// file's metadata or the config's file rules state
    #[arg(long, value_name = "SPACE", required_unless_present = "list")]
    in_space: Option<String>,
    /// Colour space of the output
    #[arg(long, value_name = "SPACE", required_unless_present_any = ["list", "view"])]
    out_space: Option<String>,
    /// Convert to the signal of a display for one of its views, instead of to a space
    #[arg(long, value_name = "DISPLAY/VIEW", conflicts_with = "out_space")]
    view: Option<String>,
    /// Number of entries of a table: per side of a .cube, 2 to 129, 33 if omitted; in all of an .spi1d, 2 to 1048576,
    /// 4096 if omitted
    #[arg(long, value_name = "N", conflicts_with = "input")]
    size: Option<usize>,
    /// Input values of a table's first and last entries
    #[arg(long, value_name = "LOW,HIGH", default_value = "0,1", allow_hyphen_values = true, value_parser = parse_range)]
    range: (f32, f32),
    /// EXR layer or part to convert; the root R, G, B (or Y) and A if omitted
    #[arg(long, requires = "input")]
    layer: Option<String>,
    /// Replace NaN and infinite samples by zero, with a warning, instead of stopping
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
    /// Returns the conversion from the space called `from` to the space or view of the options.
    fn processor(&self, config: &Config, from: &str) -> Result<Arc<Processor>, CommandError> {
        if let Some(view) = &self.view {
            // Names of views may contain slashes; those of displays hardly ever do.
            let (display, view) = view.split_once('/').unwrap_or((view, ""));
            return Ok(Arc::new(config.display_processor(from, display, view)?));
        }
        let to = self.out_space.as_deref().unwrap_or_default();
        Ok(config.processor(from, to)?)
    }
}

impl LutArgs {
    /// Returns the option about progress.
    pub(super) fn progress(&self) -> ProgressArgs {
        self.run.progress
    }
}

pub(super) fn run(
    args: &LutArgs,
    command_line: &[OsString],
    console: &mut Console,
) -> Result<(), CommandError> {
    let config = args.config.load()?;
    if let (Some(input), Some(output)) = (&args.input, &args.output) {
        return convert::run(args, &config, input, output, command_line, console);
    }
    if let Some(option) = args.run.plate_option() {
        return Err(CommandError::Usage(format!(
            "{option} applies to pictures only: give IN, or leave it out"
        )));
    }
    match &args.output {
        Some(output) => bake::run(args, &config, output, console),
        None => {
            list::run(&config, console);
            Ok(())
        }
    }
}
