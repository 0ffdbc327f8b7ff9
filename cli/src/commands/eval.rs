//! `seidel eval`: evaluates a lens on an observation set with the tables and the figure of the paper.

mod report;

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use seidel_calibrate::diagnose::{FoundMistake, find_mistake};
use seidel_calibrate::eval::shapes;
use seidel_calibrate::score::TestImage;
use seidel_core::evaluation::SparseSettings;
use seidel_core::{EvalSettings, evaluate};

use super::choice::ChoiceArgs;
use super::picture::read_image;
use super::tile_moments::MomentArgs;
use super::{CommandError, short_name, write_text};
use crate::Console;
use crate::pictures::shapes::shapes_picture;
use crate::progress::ProgressArgs;
use seidel_image_io::atomic::check_target;
use seidel_image_io::error::FileError;
use seidel_image_io::formats::png::write_rgb8;
use seidel_image_io::lens_profile;
use seidel_image_io::observation_set::{self as manifest, ReadOptions};

/// Options of `seidel eval`.
#[derive(Debug, Args)]
pub struct EvalArgs {
    /// Lens profile, or library:NAME
    #[arg(long)]
    lens: PathBuf,
    /// Observation set to evaluate the lens on
    #[arg(value_name = "OBS")]
    observations: PathBuf,
    /// Test image for the forward-blur SNR, by its luminance; a synthetic one with natural statistics if omitted
    #[arg(long, value_name = "Z")]
    image: Option<PathBuf>,
    /// Channels to evaluate; all if omitted
    #[arg(long, value_delimiter = ',')]
    channel: Vec<String>,
    /// Also refit on small subsets of the PSFs (Figure 13 of the paper)
    #[arg(long)]
    sparse: bool,
    /// Draw Figure 13 (implies --sparse)
    #[arg(long, value_name = "PLOT.svg")]
    plot: Option<PathBuf>,
    /// Draw observed and predicted PSFs with their residuals: one channel, up to three distances, three
    /// field positions each
    #[arg(long, value_name = "SHAPES.png")]
    shapes: Option<PathBuf>,
    /// Number of random splits of Figure 13
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u16).range(2..))]
    splits: u16,
    #[command(flatten)]
    measure: MomentArgs,
    /// Format of the tables
    #[arg(long, value_enum, default_value_t = Form::Text)]
    form: Form,
    /// Print a JSON document instead of tables
    #[arg(long)]
    json: bool,
    // After the options without a heading, which would come under its own.
    #[command(flatten)]
    choice: ChoiceArgs,
    #[command(flatten)]
    pub(super) progress: ProgressArgs,
}

/// The format of printed tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Form {
    /// Aligned columns
    Text,
    /// Markdown
    Markdown,
}

pub(super) fn run(args: &EvalArgs, console: &mut Console) -> Result<(), CommandError> {
    for path in args.plot.iter().chain(&args.shapes) {
        check_target(path)?;
    }
    let lens = lens_profile::read(&args.lens)?;
    let mut set = manifest::read(&args.observations, ReadOptions::default())?.set;
    args.choice.restrict(std::slice::from_mut(&mut set))?;
    let image = match &args.image {
        Some(path) => read_image(path)?,
        None => TestImage::natural(),
    };
    let sparse = (args.sparse || args.plot.is_some()).then(|| SparseSettings {
        splits: usize::from(args.splits),
        weighting: args.measure.weighting(),
        ..SparseSettings::default()
    });
    let settings = EvalSettings {
        channels: args.channel.clone(),
        support: args.measure.support(),
        sparse,
        ..EvalSettings::default()
    };
    let in_set = |e| FileError::from_core(&args.observations, e);
    let bar = console.progress_bar("evaluating");
    let evaluation = evaluate(&lens, &set, &image, &settings, &|share| bar.show(share));
    drop(bar);
    let evaluation = evaluation.map_err(in_set)?;
    if let Some(path) = &args.plot {
        let svg = report::plot(&evaluation)?;
        write_text(path, &svg)?;
    }
    if let Some(path) = &args.shapes {
        let rows = shapes(&lens, &set, &image, &settings).map_err(in_set)?;
        let picture = shapes_picture(&short_name(&args.observations), &rows)?;
        write_rgb8(path, &picture)?;
    }
    if args.json {
        console.print(report::json(&evaluation));
    } else {
        console.print(report::tables(&evaluation, args.form));
    }
    for remark in &evaluation.remarks {
        console.note(remark);
    }
    let found = find_mistake(&lens, &set).map_err(in_set)?;
    if let Some(found) = found.and_then(FoundMistake::sure) {
        console.note(super::mistake_note(&found));
    }
    if !args.json {
        for path in args.plot.iter().chain(&args.shapes) {
            console.print(format!("wrote {}", path.display()));
        }
    }
    Ok(())
}
