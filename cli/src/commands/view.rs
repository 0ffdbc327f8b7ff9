//! `seidel view`: a page on which one looks at a lens, a set or a diagnosis in the browser.

use std::path::{Path, PathBuf};

use clap::Args;
use seidel_core::LibraryLens;
use seidel_optics::predict::predict_set;

use super::drawing::{Drawing, DrawingArgs};
use super::{CommandError, short_name, write_text};
use crate::Console;
use crate::view::{LensSubject, SetSubject, lens_page, report_page, set_page};
use seidel_image_io::error::FileError;
use seidel_image_io::formats::detect;
use seidel_image_io::json::{TEXT_LIMIT_BYTES, read_json, read_text};
use seidel_image_io::lens_profile;
use seidel_image_io::observation_set::{self as manifest, ReadOptions};

/// Options of `seidel view`.
#[derive(Debug, Args)]
pub struct ViewArgs {
    /// Lens profile or library:NAME, observation set, or report.json of `seidel diagnose`
    #[arg(value_name = "LENS|SET|REPORT")]
    subject: PathBuf,
    /// Page to write (HTML): one file, which needs no network
    #[arg(short, long, value_name = "PAGE.html")]
    output: PathBuf,
    /// With an observation set: lens profile or library:NAME whose PSFs stand beside the measured ones
    #[arg(long)]
    lens: Option<PathBuf>,
    #[command(flatten)]
    drawing: DrawingArgs,
}

/// The subject of a page.
enum Subject {
    Lens,
    Set,
    Report,
}

pub(super) fn run(args: &ViewArgs, console: &mut Console) -> Result<(), CommandError> {
    let subject = subject(&args.subject)?;
    if args.lens.is_some() && !matches!(subject, Subject::Set) {
        return Err(CommandError::Usage(
            "--lens stands beside the PSFs of an observation set; give the lens alone to see it"
                .to_owned(),
        ));
    }
    check_output(args)?;
    let page = match subject {
        Subject::Lens => lens(args, console)?,
        Subject::Set => set(args, console)?,
        Subject::Report => {
            let text = read_text(&args.subject, TEXT_LIMIT_BYTES)?;
            report_page(&text).map_err(|e| FileError::from_core(&args.subject, e))?
        }
    };
    write_text(&args.output, &page)?;
    console.print(format!(
        "wrote {} ({:.1} MB); open it in a browser",
        args.output.display(),
        page.len() as f64 / 1e6
    ));
    Ok(())
}

/// Returns the kind of `path`, by its content.
fn subject(path: &Path) -> Result<Subject, CommandError> {
    if path.is_dir()
        || path
            .file_name()
            .is_some_and(|name| name == manifest::MANIFEST)
    {
        return Ok(Subject::Set);
    }
    let is_text = lens_profile::of_library(path)?.is_none() && detect(path).is_err();
    if is_text {
        let json: serde_json::Value = read_json(path)?;
        match json["format"].as_str() {
            Some("gap-report") => return Ok(Subject::Report),
            Some("psf-observations") => return Ok(Subject::Set),
            _ => {}
        }
    }
    // A lens, or a file that the reader of lenses names as what it is.
    Ok(Subject::Lens)
}

/// # Errors
/// An output that is no page, or that would replace an input.
fn check_output(args: &ViewArgs) -> Result<(), CommandError> {
    let output = &args.output;
    let extension = output
        .extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_ascii_lowercase();
    if !["html", "htm"].contains(&extension.as_str()) {
        return Err(FileError::new(
            output,
            "",
            "is not the name of a page",
            "give a name that ends in .html",
        )
        .into());
    }
    let target = output.canonicalize();
    let inputs = [Some(&args.subject), args.lens.as_ref()];
    let same = |path: &&PathBuf| {
        target
            .as_ref()
            .is_ok_and(|t| path.canonicalize().is_ok_and(|p| p == *t))
    };
    if inputs.into_iter().flatten().any(|path| same(&path)) {
        return Err(FileError::new(
            output,
            "",
            "is read by this command and would be overwritten",
            "give the output another name",
        )
        .into());
    }
    Ok(())
}

fn lens(args: &ViewArgs, console: &mut Console) -> Result<String, CommandError> {
    let Drawing { lens, model } = args.drawing.open(&args.subject, console)?;
    let of_library = lens_profile::of_library(&args.subject)?;
    let sheet = of_library.map(LibraryLens::sheet).transpose()?;
    let name = match &sheet {
        Some(sheet) => format!("{}: {}", sheet.name, sheet.title),
        None => short_name(&args.subject),
    };
    let page = lens_page(&LensSubject {
        name: &name,
        lens: &lens,
        model,
        smallest_aperture: sheet.map(|sheet| sheet.f_number_range[1]),
    });
    Ok(page.map_err(|e| FileError::from_core(&args.subject, e))?)
}

fn set(args: &ViewArgs, console: &mut Console) -> Result<String, CommandError> {
    let set = manifest::read(&args.subject, ReadOptions::default())?.set;
    let name = short_name(&args.subject);
    let Some(path) = &args.lens else {
        return Ok(set_page(&SetSubject {
            name: &name,
            set: &set,
            predicted: None,
        }));
    };
    let drawing = args.drawing.open(path, console)?;
    let predicted = predict_set(drawing.lens.predictor(), &set, drawing.model)
        .map_err(|e| FileError::from_core(&args.subject, e))?;
    let lens = short_name(path);
    Ok(set_page(&SetSubject {
        name: &name,
        set: &set,
        predicted: Some((&lens, &predicted)),
    }))
}
