//! Occlusion beside many pinholes: the panels of the depth-edge test, labelled.

use super::panels::{Panel, grid};
use super::programs::Programs;
use super::samples::{Crop, part_of_file};

/// Size of a tile of the test's picture, px.
const TILE: (u32, u32) = (192, 128);
/// The panels that the test draws, column by column.
const COLUMNS: [&str; 5] = [
    "plate",
    "many pinholes",
    "Seidel",
    "without occlusion",
    "twice the error",
];
/// The scenes, row by row, in the test's order.
const SCENES: [&str; 10] = [
    "near card blurred",
    "dark card blurred",
    "near card sharp",
    "three cards",
    "card on floor",
    "slanted plane",
    "wires blurred",
    "wires sharp",
    "light, sharp card",
    "light, blurred card",
];

pub(super) fn draw(programs: &Programs) -> Result<(), String> {
    let work = programs.work();
    programs.ignored_test("depth", "SEIDEL_DEPTH_PICTURES", work)?;
    let tiles = work.join("depth-edges.png");
    let mut panels = Vec::new();
    for (row, scene) in (0..).zip(SCENES) {
        for (column, title) in (0..).zip(COLUMNS) {
            let crop = Crop {
                left: column * TILE.0,
                top: row * TILE.1,
                width: TILE.0,
                height: TILE.1,
            };
            panels.push(Panel {
                label: if column == 0 { scene } else { title }.to_owned(),
                image: part_of_file(&tiles, crop)?,
            });
        }
    }
    let sheet = work.join("depth-edges-labelled.png");
    let drawn = grid(&panels, COLUMNS.len() as u32)?;
    drawn
        .save(&sheet)
        .map_err(|why| format!("{}: {why}", sheet.display()))?;
    programs.install(&sheet, "depth-edges.png")
}
