//! The blur of the demo's plate by depth, as `seidel apply --show` draws it.

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

pub(super) fn draw(programs: &Programs) -> Result<(), String> {
    programs.demo()?;
    let work = programs.work();
    let view = "--ocio seidel --in-space lin_rec709 --view sRGB/Plain";
    let mut panels = Vec::new();
    for (option, label) in [
        ("", "blurred: focus 2.5 m, f/2"),
        ("--show coc", "--show coc: blue 1 px, green 4, orange 16"),
        ("--show focus", "--show focus: green in focus, red in front"),
        ("--show slices", "--show slices: one colour each"),
    ] {
        let file = work.join("show.png");
        programs.seidel(&format!(
            "apply --lens demo/lens.json demo/plate.exr -o show.exr --focus-distance 2.5 --f-number 2 {option}"
        ))?;
        programs.seidel(&format!("lut show.exr -o show.png {view}"))?;
        let image = part_of_file(&file, PLATE)?;
        let (width, height) = (PLATE.width / REDUCTION, PLATE.height / REDUCTION);
        panels.push(Panel {
            label: label.to_owned(),
            image: resize(&image, width, height, FilterType::Triangle),
        });
    }
    let sheet = work.join("show-sheet.png");
    let drawn = grid(&panels, 2)?;
    drawn
        .save(&sheet)
        .map_err(|why| format!("{}: {why}", sheet.display()))?;
    programs.install(&sheet, "show.png")
}
