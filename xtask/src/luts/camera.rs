//! One-dimensional tables from camera codes to linear values, for programs without OpenColorIO.

use seidel_colour::curves::CurveTable;
use seidel_colour::tables::{linspace, spi1d};

/// First and last code of a table. Footage has codes below black and above white.
const RANGE: (f32, f32) = (-0.125, 1.125);

const ENTRIES: usize = 4096;

/// Path in `luts/` and text of each table.
pub(super) fn files(table: &CurveTable) -> Result<Vec<(String, String)>, String> {
    let mut files = Vec::new();
    for space in &table.spaces {
        let curve = table.curve(space).map_err(|e| e.to_string())?;
        if let (Some(name), Some(curve)) = (&space.table, curve) {
            let codes = linspace(RANGE, ENTRIES);
            let linear = |code: &f32| [curve.transfer.decode(f64::from(*code)) as f32];
            let entries: Vec<[f32; 1]> = codes.iter().map(linear).collect();
            files.push((format!("camera/{name}.spi1d"), spi1d(RANGE, &entries)));
        }
    }
    Ok(files)
}
