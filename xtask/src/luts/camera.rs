//! One-dimensional tables of the cameras' curves, code to linear: for programs without OpenColorIO.

use seidel_colour::curves::Table;
use seidel_colour::tables::{evenly, spi1d_of_one};

/// Codes from below black to above white, which footage has.
const RANGE: (f32, f32) = (-0.125, 1.125);

const ENTRIES: usize = 4096;

/// Each table with its path in the room.
pub(super) fn files(table: &Table) -> Result<Vec<(String, String)>, String> {
    let mut files = Vec::new();
    for space in &table.spaces {
        let curve = table.curve(space).map_err(|e| e.to_string())?;
        if let (Some(name), Some(curve)) = (&space.table, curve) {
            let codes = evenly(RANGE, ENTRIES);
            let linear = |code: &f32| curve.form.linear(f64::from(*code)) as f32;
            let entries: Vec<f32> = codes.iter().map(linear).collect();
            files.push((
                format!("camera/{name}.spi1d"),
                spi1d_of_one(RANGE, &entries),
            ));
        }
    }
    Ok(files)
}
