//! `seidel info`: describes image files and their provenance, and tables of lens settings.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use super::CommandError;
use crate::Console;
use seidel_image_io::description::Description;
use seidel_image_io::error::FileError;
use seidel_image_io::lens_metadata::{FrameRecord, Sidecar, is_table, lines, range_lines};
use seidel_image_io::sequence::FramePattern;

/// Options of `seidel info`.
#[derive(Debug, Args)]
pub struct InfoArgs {
    /// Image files, frame patterns such as plate.%04d.exr, or tables of lens settings
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Print JSON: a list with one entry per file
    #[arg(long)]
    json: bool,
}

/// The description of a file.
#[derive(Serialize)]
#[serde(untagged)]
enum Described {
    Image(Description),
    Table {
        file: String,
        format: String,
        frames: Vec<FrameRecord>,
    },
}

impl Described {
    fn read(path: &Path) -> Result<Self, FileError> {
        if !is_table(path) {
            return Description::read(path).map(Self::Image);
        }
        let table = Sidecar::open(path)?;
        Ok(Self::Table {
            file: path.display().to_string(),
            format: table.dialect().to_owned(),
            frames: table.records().to_vec(),
        })
    }

    fn lines(&self) -> Vec<String> {
        match self {
            Self::Image(description) => description.lines(),
            Self::Table {
                file,
                format,
                frames,
            } => table_lines(file, format, frames),
        }
    }
}

fn table_lines(file: &str, format: &str, frames: &[FrameRecord]) -> Vec<String> {
    let mut all = vec![format!("{file}: lens settings by {format}")];
    let codes: Vec<_> = frames.iter().filter_map(|frame| frame.time_code).collect();
    let codes = match &codes[..] {
        [first, .., last] => format!(", time code {first} to {last}"),
        [only] => format!(", time code {only}"),
        [] => String::new(),
    };
    all.push(format!("  frames: {}{codes}", frames.len()));
    let first = frames.iter().take(1).flat_map(lines);
    all.extend(first.map(|(name, value)| format!("  {name}: {value}")));
    if frames.len() > 1 {
        all.extend(range_lines(frames).iter().map(|line| format!("  {line}")));
    }
    all
}

/// Returns the files that exist for a frame pattern, by number; the path itself if it is none.
fn files_of(path: &Path) -> Vec<PathBuf> {
    let pattern = FramePattern::parse(path);
    if !pattern.has_frame() || path.exists() {
        return vec![path.to_owned()];
    }
    let files = pattern.existing();
    match files.is_empty() {
        // Reading it gives the error.
        true => vec![path.to_owned()],
        false => files,
    }
}

pub(super) fn run(args: &InfoArgs, console: &mut Console) -> Result<(), CommandError> {
    let files: Vec<PathBuf> = args.files.iter().flat_map(|file| files_of(file)).collect();
    let is_sequence = files.len() > args.files.len();
    let described = files.iter().map(|file| Described::read(file));
    let described = described.collect::<Result<Vec<_>, _>>()?;
    if args.json {
        let json = serde_json::to_string_pretty(&described);
        console.print(json.unwrap_or_default());
        return Ok(());
    }
    // Of a sequence that one pattern names, the first frame stands for all.
    let shown = if is_sequence && args.files.len() == 1 {
        1
    } else {
        described.len()
    };
    for line in described.iter().take(shown).flat_map(Described::lines) {
        console.print(line);
    }
    let plates = described.iter().filter_map(|described| match described {
        Described::Image(description) => Some(description.lens.clone()),
        Described::Table { .. } => None,
    });
    let plates: Vec<FrameRecord> = plates.collect();
    let ranges = range_lines(&plates);
    if plates.len() > 1 && !ranges.is_empty() {
        console.print(format!("lens over {} files:", plates.len()));
        for line in ranges {
            console.print(format!("  {line}"));
        }
    }
    Ok(())
}
