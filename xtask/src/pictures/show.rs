//! The demo's plate through a lens: its blur as `seidel apply --show` draws it, and the shot of the guide.

use image::imageops::{FilterType, resize};

use super::panels::{Panel, grid};
use super::programs::Programs;
use super::samples::{Crop, part_of_file};

/// The demo's plate, px, and the share of it that a panel has.
const PLATE: Crop = Crop {
    left: 0,
    top: 0,
    width: 960,
    height: 540,
};
const REDUCTION: u32 = 2;

/// Draws the blur of the plate, and what `--show` draws for it.
pub(super) fn draw(programs: &Programs) -> Result<(), String> {
    let lens = "--lens demo/lens.json --focus-distance 2.5 --f-number 2";
    let panels = [
        ("", "blurred: focus 2.5 m, f/2"),
        (
            "--show coc",
            "--show coc: 1 px violet, 4 px blue, 32 px green",
        ),
        (
            "--show focus",
            "--show focus: grey in focus, orange in front, blue behind",
        ),
        (
            "--show slices",
            "--show slices: a colour for each depth slice",
        ),
    ];
    sheet(programs, lens, &panels, "show.png")
}

/// Draws the ends of the rack focus of the guide, and both uses of its mask.
pub(super) fn draw_shot(programs: &Programs) -> Result<(), String> {
    programs.demo()?;
    let lens = "--lens library:modern-50 --f-number 1.4";
    programs.seidel(&format!(
        "apply {lens} demo/plate.exr -o mask.exr --show focus-matte --focus-distance inf --focus-tolerance 8"
    ))?;
    let panels = [
        ("--focus-distance 1.164", "frame 1001: focus on the pole"),
        ("--focus-distance 2.034", "frame 1024: focus on the slate"),
        (
            "--focus-distance 20 --mask mask.exr:R",
            "--mask: the halo of the pole stays",
        ),
        (
            "--focus-distance 20 --mask mask.exr:R --mask-scales blur",
            "--mask-scales blur: no halo",
        ),
    ];
    sheet(programs, lens, &panels, "shot.png")
}

/// Draws a panel of the plate for each option and label of `panels`, at half the size.
fn sheet(
    programs: &Programs,
    lens: &str,
    panels: &[(&str, &str)],
    file: &str,
) -> Result<(), String> {
    programs.demo()?;
    let work = programs.work();
    let view = "--ocio seidel --in-space lin_rec709 --view sRGB/Plain";
    let mut drawn = Vec::new();
    for (option, label) in panels {
        programs.seidel(&format!("apply {lens} demo/plate.exr -o show.exr {option}"))?;
        programs.seidel(&format!("lut show.exr -o show.png {view}"))?;
        let image = part_of_file(&work.join("show.png"), PLATE)?;
        let (width, height) = (PLATE.width / REDUCTION, PLATE.height / REDUCTION);
        drawn.push(Panel {
            label: (*label).to_owned(),
            image: resize(&image, width, height, FilterType::Triangle),
        });
    }
    let sheet = work.join("show-sheet.png");
    let drawn = grid(&drawn, 2)?;
    drawn
        .save(&sheet)
        .map_err(|why| format!("{}: {why}", sheet.display()))?;
    programs.install(&sheet, file)
}
