//! Four outputs of the OpenFX node, rendered in the test host.

use super::panels::{Panel, grid};
use super::programs::Programs;
use super::samples::{Crop, part_of_file};

/// Size of the demo's plate at half resolution, px.
const HALF: Crop = Crop {
    left: 0,
    top: 0,
    width: 480,
    height: 270,
};

/// Label of each panel, and what it sets besides [`COMMON`].
const PANELS: [(&str, &[&str]); 4] = [
    (
        "Output: Result, with the overlay",
        &["--set", "worldScale=metres", "--overlay"],
    ),
    (
        "Output: Focal Plane Setup",
        &[
            "--set",
            "worldScale=metres",
            "--set",
            "output=Focal Plane Setup",
            "--set",
            "dof=0.3",
        ],
    ),
    (
        "Output: PSF Grid",
        &["--set", "worldScale=metres", "--set", "output=PSF Grid"],
    ),
    (
        "World Scale feet, depth in metres",
        &["--set", "worldScale=feet"],
    ),
];

/// Inputs and settings of all panels.
const COMMON: [&str; 13] = [
    "--half",
    "--feed",
    "Source=demo/plate.exr",
    "--feed",
    "Depth=demo/plate.exr:Z",
    "--set",
    "lens=Fast 50 mm f/0.95",
    "--set",
    "math=depth",
    "--set",
    "focus=Focus Distance",
    "--set",
    "focusDistance=2",
];

pub(super) fn draw(programs: &Programs) -> Result<(), String> {
    programs.demo()?;
    let mut panels = Vec::new();
    for (index, (label, set)) in PANELS.iter().enumerate() {
        let file = format!("host-{index}.png");
        let arguments = [&["--render", &file], &COMMON[..], set].concat();
        programs.host(&arguments)?;
        panels.push(Panel {
            label: (*label).to_owned(),
            image: part_of_file(&programs.work().join(&file), HALF)?,
        });
    }
    let sheet = programs.work().join("hosts.png");
    let drawn = grid(&panels, 2)?;
    drawn
        .save(&sheet)
        .map_err(|why| format!("{}: {why}", sheet.display()))?;
    programs.install(&sheet, "hosts.png")
}
