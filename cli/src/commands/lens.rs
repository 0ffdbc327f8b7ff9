//! `seidel lens`: the library of lenses, drawings of a lens, and the JSON schema of profiles.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use seidel_core::profile::LensDescription;
use seidel_core::{LensProfile, LibraryLens};
use seidel_optics::library::{self};
use seidel_optics::profile::{bare_distances, bare_sides, schema};

use super::CommandError;
use super::drawing::{Drawing, DrawingArgs};
use crate::Console;
use crate::pictures::sheet::{SheetOptions, below_each_other, lens_sheet};
use seidel_image_io::formats::png::write_rgb8;
use seidel_image_io::lens_profile;

/// The subcommands of `seidel lens`.
#[derive(Debug, Subcommand)]
pub enum LensCommand {
    /// List the lenses that come with the program, and the profiles in the folder that SEIDEL_LENSES names
    List(ListArgs),
    /// Describe lenses, or draw their PSFs over the frame, by channel and distance
    Show(ShowArgs),
    /// Write the profile of a lens of the library, or of the folder that SEIDEL_LENSES names, to pin it over a long show
    Export(ExportArgs),
    /// Print the JSON schema of lens profiles
    Schema,
}

/// Options of `seidel lens list`.
#[derive(Debug, Args)]
pub struct ListArgs {
    /// Print the sheets of all lenses as a JSON document
    #[arg(long)]
    json: bool,
}

/// Options of `seidel lens export`.
#[derive(Debug, Args)]
pub struct ExportArgs {
    /// Name of a lens, with or without library: before it
    name: PathBuf,
    /// Lens profile to write; printed if left out
    #[arg(short, long, value_name = "LENS.json")]
    output: Option<PathBuf>,
}

/// Options of `seidel lens show`.
#[derive(Debug, Args)]
pub struct ShowArgs {
    /// Lens profiles, or names of lenses of the library, with or without library: before them
    #[arg(required = true, value_name = "LENS")]
    lenses: Vec<PathBuf>,
    /// Picture to write (PNG), the sheets of several lenses below each other; the lenses are described in words if this is left out
    #[arg(short, long, value_name = "SHEET.png")]
    output: Option<PathBuf>,
    #[command(flatten)]
    drawing: DrawingArgs,
}

pub(super) fn run(command: &LensCommand, console: &mut Console) -> Result<(), CommandError> {
    match command {
        LensCommand::Schema => {
            console.print(schema());
            Ok(())
        }
        LensCommand::Export(args) => export(args, console),
        LensCommand::List(args) => list(args, console),
        LensCommand::Show(args) => show(args, console),
    }
}

fn list(args: &ListArgs, console: &mut Console) -> Result<(), CommandError> {
    let sheets: Vec<_> = (library::ALL.iter())
        .map(LibraryLens::sheet)
        .collect::<seidel_core::Result<_>>()?;
    if args.json {
        let text = serde_json::to_string_pretty(&sheets);
        console.print(text.expect("numbers and texts have a JSON form"));
        return Ok(());
    }
    console.print(format!(
        "{:<26} {:>7}  {:<12} {:>12}  LENS",
        "NAME", "FOCAL", "F-NUMBERS", "SENSOR"
    ));
    for sheet in sheets {
        let [open, closed] = sheet.f_number_range;
        console.print(format!(
            "{:<26} {:>4} mm  {:<12} {:>9} mm  {}",
            format!("{}{}", library::PREFIX, sheet.name),
            sheet.focal_length_mm,
            if open == closed {
                format!("f/{open}")
            } else {
                format!("f/{open} - f/{closed}")
            },
            format!("{}x{}", sheet.sensor.width_mm, sheet.sensor.height_mm),
            sheet.title
        ));
    }
    for name in lens_profile::own_names()? {
        let reference = format!("{}{name}", library::PREFIX);
        let state = match lens_profile::read(Path::new(&reference)) {
            Ok(_) => "own profile".to_owned(),
            Err(error) => format!("cannot be used: {error}"),
        };
        console.print(format!("{reference:<64} {state}"));
    }
    console.print("");
    console.print(
        "Use a name wherever a command takes a lens. `seidel lens show NAME` describes one.",
    );
    Ok(())
}

/// Returns the name of a lens as commands on files take it: that of a lens of the library gets its prefix if there is no file
/// of that name.
fn with_prefix(lens: &Path) -> PathBuf {
    let name = lens.to_str().unwrap_or_default();
    let is_own = || lens_profile::own_names().is_ok_and(|own| own.iter().any(|one| one == name));
    if !lens.exists() && (LibraryLens::by_name(name).is_ok() || is_own()) {
        return PathBuf::from(format!("{}{name}", library::PREFIX));
    }
    lens.to_path_buf()
}

fn export(args: &ExportArgs, console: &mut Console) -> Result<(), CommandError> {
    let profile = lens_profile::read(&with_prefix(&args.name))?;
    let Some(output) = &args.output else {
        console.print(profile.to_json());
        return Ok(());
    };
    lens_profile::write(output, &profile)?;
    console.print(format!("wrote {}", output.display()));
    Ok(())
}

/// Returns a lens profile in words, in the order of the sheets of the library.
fn words(path: &Path, lens: &LensProfile) -> String {
    let camera = &lens.camera;
    let known = |value: Option<f64>, form: &dyn Fn(f64) -> String| {
        value.map_or_else(|| "not known".to_owned(), form)
    };
    let (kind, channels) = match &lens.description {
        LensDescription::Moments(channels) => {
            let names = channels.iter().map(|channel| channel.name.as_str());
            ("fitted by moments", names.collect::<Vec<_>>())
        }
        LensDescription::Pupil(channels) => {
            let names = channels.iter().map(|channel| channel.name.as_str());
            ("drawn ray by ray", names.collect())
        }
    };
    let effects: BTreeSet<&str> = (lens.pupil_channels().iter())
        .flat_map(|channel| &channel.effects)
        .map(|effect| effect.effect.description().title)
        .collect();
    let effects: Vec<_> = effects.into_iter().collect();
    let (width, height) = (lens.frame.width_px(), lens.frame.height_px());
    let pitch = known(lens.pixel_pitch_um, &|um| {
        let mm = |px: u32| f64::from(px) * um / 1e3;
        format!("{:.2} x {:.2} mm", mm(width), mm(height))
    });
    let mut lines = vec![
        format!("{}: a lens {kind}", path.display()),
        camera.lens_model.clone().unwrap_or_default(),
        String::new(),
        format!(
            "  focal length  {}",
            known(camera.focal_length_mm, &|mm| format!("{mm} mm"))
        ),
        format!(
            "  f-number      {}",
            known(camera.f_number, &|n| format!("f/{n}"))
        ),
        format!("  focus         {}", camera.focus_distance),
        format!("  sensor        {pitch}, {width} x {height} px"),
        format!("  channels      {}", channels.join(", ")),
    ];
    lines.extend((camera.squeeze).map(|squeeze| format!("  squeeze       {squeeze}x")));
    if !effects.is_empty() {
        lines.push(format!("  effects       {}", effects.join(", ")));
    }
    let provenance = &lens.provenance;
    lines.push(format!(
        "  made by       {} {}",
        provenance.program, provenance.settings
    ));
    if !provenance.sources.is_empty() {
        lines.push(format!("  measured in   {}", provenance.sources.join(", ")));
    }
    let tiles = &provenance.tiles;
    if !tiles.is_empty() {
        let counted = tiles
            .iter()
            .map(|at| format!("{} at {}", at.tiles, at.distance()));
        lines.push(format!(
            "  tiles         {}",
            counted.collect::<Vec<_>>().join(", ")
        ));
    }
    lines.extend(coverage_words(lens).map(|words| format!("\n{words}")));
    lines.extend(lens.plane_of_focus().map(|plane| format!("\n{plane}")));
    lines.extend(lens.adequacy().map(|adequacy| format!("\n{adequacy}")));
    lines.join("\n").replacen("\n\n\n", "\n\n", 1)
}

/// Returns the sides of the frame and the distances that the fit had no tile of, one sentence for each; none where the profile does
/// not hold its tiles.
fn coverage_words(lens: &LensProfile) -> impl Iterator<Item = String> {
    let tiles = &lens.provenance.tiles;
    let sides = bare_sides(tiles, &lens.frame).map(|sides| {
        format!(
            "No tile lies near these sides of the frame: {sides}. The blur there is extrapolated."
        )
    });
    let distances = bare_distances(tiles).join(", ");
    let distances = (!distances.is_empty()).then(|| format!("No tile lies {distances}."));
    sides.into_iter().chain(distances)
}

fn show(args: &ShowArgs, console: &mut Console) -> Result<(), CommandError> {
    let lenses: Vec<_> = args.lenses.iter().map(|lens| with_prefix(lens)).collect();
    let Some(output) = &args.output else {
        let descriptions = lenses.iter().map(|lens| description(lens));
        let descriptions = descriptions.collect::<Result<Vec<_>, _>>()?;
        console.print(descriptions.join("\n\n"));
        return Ok(());
    };
    let (mut sheets, mut remarks) = (Vec::new(), Vec::new());
    for path in &lenses {
        let of_library = lens_profile::of_library(path)?;
        let Drawing { lens, model } = args.drawing.open(path, console)?;
        let options = SheetOptions {
            title: of_library
                .map(LibraryLens::sheet)
                .transpose()?
                .map(|sheet| sheet.title),
            ..SheetOptions::default()
        };
        sheets.push(lens_sheet(lens.profile(), model, &options)?);
        remarks.extend(coverage_words(lens.profile()));
        remarks.push(match lens.profile().adequacy() {
            Some(adequacy) => adequacy.to_string(),
            None if of_library.is_some() => continue,
            None => "the profile does not say how well its model describes the lens".to_owned(),
        });
    }
    write_rgb8(output, &below_each_other(&sheets))?;
    console.print(format!("wrote {}", output.display()));
    for remark in remarks {
        console.print(remark);
    }
    Ok(())
}

/// Returns a lens in words: the sheet of a lens of the library, or what the profile at `path` says.
fn description(path: &Path) -> Result<String, CommandError> {
    Ok(match lens_profile::of_library(path)? {
        Some(lens) => lens.sheet()?.to_string().trim_end().to_owned(),
        None => words(path, &lens_profile::read(path)?),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_optics::profile::TileCoverage;

    #[test]
    fn sides_and_distances_without_tiles_are_sentences() {
        let mut lens = crate::demo::lens::lens(600, 400).expect("a frame");
        let all = |lens: &LensProfile| coverage_words(lens).collect::<Vec<_>>();
        assert!(all(&lens).is_empty());
        let half = TileCoverage {
            vergence_per_m: Some(0.5),
            tiles: 9,
            x_px: [20.0, 310.0],
            y_px: [20.0, 380.0],
        };
        lens.provenance.tiles = vec![half.clone()];
        let sides = "No tile lies near these sides of the frame: right (beyond x = 310 of 600 px)";
        assert_eq!(
            all(&lens),
            [
                format!("{sides}. The blur there is extrapolated."),
                "No tile lies at a distance other than 2 m.".to_owned()
            ]
        );
        let mut whole = half.clone();
        whole.vergence_per_m = Some(0.0);
        whole.x_px[1] = 590.0;
        lens.provenance.tiles = vec![whole, half];
        assert_eq!(
            all(&lens),
            [
                format!("{sides} at 2 m. The blur there is extrapolated."),
                "No tile lies nearer than 2 m.".to_owned()
            ]
        );
    }
}
