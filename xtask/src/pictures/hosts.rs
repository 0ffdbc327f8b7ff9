//! Outputs of the OpenFX node, rendered in the test host.

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
const PANELS: [(&str, &[&str]); 6] = [
    (
        "Output: Result, with the overlay",
        &["--set", "worldScale=metres", "--overlay"],
    ),
    (
        "Output: Focal Plane Setup: orange nearer, blue farther",
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
        "Output: CoC Map, blue 4 px, green 32, lime 64",
        &["--set", "worldScale=metres", "--set", "output=CoC Map"],
    ),
    (
        "Output: PSF Grid",
        &["--set", "worldScale=metres", "--set", "output=PSF Grid"],
    ),
    (
        "Output: Gap, black equal; reference at 2.3 m",
        &[
            "--feed",
            "Reference=reference.exr",
            "--set",
            "worldScale=metres",
            "--set",
            "output=Gap",
        ],
    ),
    (
        "Not an output: World Scale feet, depth in metres",
        &["--set", "worldScale=feet"],
    ),
];

/// Inputs and settings of all panels.
const COMMON: [&str; 10] = [
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
];

/// The photograph that the gap is measured to: the same lens, focused elsewhere.
const REFERENCE: [&str; 6] = [
    "--render",
    "reference.exr",
    "--set",
    "worldScale=metres",
    "--set",
    "focusDistance=2.3",
];

pub(super) fn draw(programs: &Programs) -> Result<(), String> {
    programs.demo()?;
    programs.host(&[&REFERENCE[..], &COMMON].concat())?;
    let focused = ["--half", "--set", "focusDistance=2"];
    let mut panels = Vec::new();
    for (index, (label, set)) in PANELS.iter().enumerate() {
        let file = format!("host-{index}.png");
        let arguments = [&["--render", &file], &focused[..], &COMMON, set].concat();
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
