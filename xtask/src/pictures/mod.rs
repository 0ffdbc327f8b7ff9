//! The pictures of the documentation, made from what the programs write, with a label on every panel.

mod depth_edges;
mod evaluation;
mod hosts;
mod looks;
mod noise;
mod panels;
mod programs;
mod remove;
mod samples;
mod show;

pub(crate) use programs::finished;

use std::path::Path;

use programs::Programs;

pub(crate) const USAGE: &str = "cargo xtask pictures [--programs FOLDER] [NAME...]";

/// Draws one picture, or a group of them, into `docs/`.
type Draw = fn(&Programs) -> Result<(), String>;

/// The pictures by the names that the command line takes.
const PICTURES: [(&str, Draw); 14] = [
    ("before-after", |p| demo_file(p, "before-after.png")),
    ("sheet", |p| demo_file(p, "sheet.png")),
    ("lenses", |p| demo_file(p, "lenses.png")),
    ("colour", colour),
    ("hosts", hosts::draw),
    ("looks", looks::draw),
    ("named-looks", looks::draw_named),
    ("tilt", looks::draw_tilted),
    ("library", looks::draw_library),
    ("remove", remove::draw),
    ("depth-edges", depth_edges::draw),
    ("show", show::draw),
    ("shot", show::draw_shot),
    ("evaluation", evaluation::draw),
];

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
            name if PICTURES.iter().any(|(known, _)| *known == name) => names.push(argument),
            other => {
                let known: Vec<&str> = PICTURES.iter().map(|(name, _)| *name).collect();
                let known = known.join(", ");
                return Err(format!("{other} is not one of {known}; usage: {USAGE}"));
            }
        }
    }
    let programs = Programs::new(root, folder.map(Into::into))?;
    let mut drawn = Vec::new();
    for (name, draw) in PICTURES {
        if names.is_empty() || names.iter().any(|wanted| wanted == name) {
            draw(&programs).map_err(|why| format!("{name}: {why}"))?;
            drawn.push(name);
        }
    }
    Ok(format!("drawn: {}", drawn.join(", ")))
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
