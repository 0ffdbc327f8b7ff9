//! `seidel info`: describes image files and their provenance.

use std::path::PathBuf;

use clap::Args;

use super::CommandError;
use crate::Console;
use seidel_image_io::description::Description;

/// Options of `seidel info`.
#[derive(Debug, Args)]
pub struct InfoArgs {
    /// Image files
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Print JSON: a list with one entry per file
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &InfoArgs, console: &mut Console) -> Result<(), CommandError> {
    let described = args.files.iter().map(|file| Description::read(file));
    let described = described.collect::<Result<Vec<_>, _>>()?;
    if args.json {
        let json = serde_json::to_string_pretty(&described);
        console.print(json.unwrap_or_default());
        return Ok(());
    }
    for line in described.iter().flat_map(Description::lines) {
        console.print(line);
    }
    Ok(())
}
