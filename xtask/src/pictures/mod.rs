//! The pictures of the documentation, made from what the programs write, with a label on every panel.

mod depth_edges;
mod evaluation;
mod hosts;
mod looks;
mod noise;
mod panels;
mod performance;
mod programs;
mod remove;
mod samples;
mod show;
mod sources;

pub(crate) use programs::finished;

use std::path::Path;

use programs::Programs;

use crate::workspace::Tree;

pub(crate) const USAGE: &str = "cargo xtask pictures [--programs FOLDER] [NAME...]";

/// Draws a picture into `docs/`.
type Draw = fn(&Programs) -> Result<(), String>;

/// A picture of the documentation, or a group of them.
struct Picture {
    /// The name that the command line takes.
    name: &'static str,
    draw: Draw,
    /// Beginnings of the paths of the code that decides on its looks.
    sources: &'static [&'static str],
}

/// The code that draws PSF sheets, and the demo.
const SHEETS: [&str; 4] = [
    "cli/src/pictures/canvas",
    "cli/src/pictures/psf_panel",
    "cli/src/pictures/sheet",
    "cli/src/demo/",
];

/// The code that draws plates side by side, and the demo.
const COMPARISONS: [&str; 3] = [
    "cli/src/pictures/canvas",
    "cli/src/pictures/comparison",
    "cli/src/demo/",
];

static PICTURES: [Picture; 15] = [
    picture(
        "before-after",
        |p| demo_file(p, "before-after.png"),
        &COMPARISONS,
    ),
    picture("sheet", |p| demo_file(p, "sheet.png"), &SHEETS),
    picture("lenses", |p| demo_file(p, "lenses.png"), &COMPARISONS),
    picture("colour", colour, &["tests/seidel/colour_picture"]),
    picture(
        "hosts",
        hosts::draw,
        &["xtask/src/pictures/hosts", "ofx-shim/src/rendering/"],
    ),
    picture("looks", looks::draw, &["xtask/src/pictures/looks"]),
    picture(
        "named-looks",
        looks::draw_named,
        &["xtask/src/pictures/looks", "core/src/knobs/preset"],
    ),
    picture("tilt", looks::draw_tilted, &["xtask/src/pictures/looks"]),
    picture(
        "library",
        looks::draw_library,
        &["xtask/src/pictures/looks", "core/optics/src/library/"],
    ),
    picture("remove", remove::draw, &["xtask/src/pictures/remove"]),
    picture(
        "depth-edges",
        depth_edges::draw,
        &["xtask/src/pictures/depth_edges", "tests/seidel/depth.rs"],
    ),
    picture(
        "show",
        show::draw,
        &[
            "xtask/src/pictures/show",
            "cli/src/commands/apply/show",
            "core/src/coc_scale",
        ],
    ),
    picture("shot", show::draw_shot, &["xtask/src/pictures/show"]),
    picture(
        "evaluation",
        evaluation::draw,
        &[
            "xtask/src/pictures/evaluation",
            "cli/src/pictures/canvas",
            "cli/src/pictures/shapes",
            "cli/src/pictures/plot",
        ],
    ),
    picture(
        "performance",
        performance::draw,
        &["xtask/src/pictures/performance"],
    ),
];

const fn picture(name: &'static str, draw: Draw, sources: &'static [&'static str]) -> Picture {
    Picture {
        name,
        draw,
        sources,
    }
}

/// Draws the pictures named in `arguments`, all of them if none is named. Returns a report.
pub(crate) fn run(root: &Path, arguments: impl Iterator<Item = String>) -> Result<String, String> {
    let mut folder = None;
    let mut names = Vec::new();
    let mut arguments = arguments;
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--programs" => {
                let value = arguments.next();
                folder = Some(
                    value.ok_or_else(|| format!("--programs needs a folder; usage: {USAGE}"))?,
                );
            }
            name if PICTURES.iter().any(|known| known.name == name) => names.push(argument),
            other => {
                let known: Vec<&str> = PICTURES.iter().map(|known| known.name).collect();
                let known = known.join(", ");
                return Err(format!("{other} is not one of {known}; usage: {USAGE}"));
            }
        }
    }
    let programs = Programs::new(root, folder.map(Into::into))?;
    let mut drawn = Vec::new();
    for picture in &PICTURES {
        let name = picture.name;
        if names.is_empty() || names.iter().any(|wanted| wanted == name) {
            (picture.draw)(&programs).map_err(|why| format!("{name}: {why}"))?;
            sources::note_drawn(root, name, picture.sources)?;
            drawn.push(name);
        }
    }
    Ok(format!("drawn: {}", drawn.join(", ")))
}

/// Reports the pictures whose sources changed after they were drawn.
pub(crate) fn check(tree: &Tree, problems: &mut Vec<String>) {
    let stale = PICTURES
        .iter()
        .filter_map(|picture| sources::stale(tree, picture.name, picture.sources));
    problems.extend(stale);
}

/// Installs a picture that the demo itself writes.
fn demo_file(programs: &Programs, file: &str) -> Result<(), String> {
    let demo = programs.demo()?;
    programs.install(&demo.join(file), file)
}

/// Draws a blurred log plate, read in its own colour space and read as linear.
fn colour(programs: &Programs) -> Result<(), String> {
    let drawn = programs.work().join("colour.png");
    programs.ignored_test("colour_picture", "SEIDEL_COLOUR_PICTURE", &drawn)?;
    programs.install(&drawn, "colour.png")
}
