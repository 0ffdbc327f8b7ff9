//! Three-dimensional tables from cameras to a display: to look at plates in programs without OpenColorIO.

use seidel_colour::curves::{CurveTable, TransferFunction};
use seidel_colour::tables::{cube, cube_grid};

/// Entries a side. Enough to look, and small enough to keep.
const SIZE: usize = 17;

/// Cameras that there is a table of, each with what its file is called.
const CAMERAS: [(&str, &str); 2] = [
    ("ARRI LogC4", "arri-logc4-to-srgb"),
    ("S-Log3 S-Gamut3.Cine", "sony-slog3-cine-to-srgb"),
];

/// What they are made for.
const DISPLAY: &str = "sRGB - Texture";

/// Each table with its path in the room.
pub(super) fn files(table: &CurveTable) -> Result<Vec<(String, String)>, String> {
    let mut files = Vec::new();
    for (camera, file) in CAMERAS {
        let (curve, matrix, display) = way(table, camera)?;
        let shown = |colour: &[f32; 3]| {
            let light = colour.map(|code| curve.decode(f64::from(code)));
            matrix.map(|row| {
                let sum: f64 = row.iter().zip(light).map(|(m, v)| m * v).sum();
                display.encode(sum).clamp(0.0, 1.0) as f32
            })
        };
        let range = (0.0, 1.0);
        let entries: Vec<[f32; 3]> = cube_grid(SIZE, range).iter().map(shown).collect();
        let title = format!("{camera} to {DISPLAY}, clipped");
        files.push((
            format!("cube/{file}.cube"),
            cube(&title, SIZE, range, &entries),
        ));
    }
    Ok(files)
}

/// From codes of `camera` to those of the display.
fn way(
    table: &CurveTable,
    camera: &str,
) -> Result<(TransferFunction, [[f64; 3]; 3], TransferFunction), String> {
    let find = |name: &str| {
        let space = table.space(name);
        let space = space.ok_or_else(|| format!("curves.toml: lacks the space {name}"))?;
        let curve = table.curve(space).map_err(|e| e.to_string())?;
        let curve = curve.ok_or_else(|| format!("curves.toml: {name} has no curve"))?;
        let gamut = table.gamut(space).map_err(|e| e.to_string())?;
        Ok::<_, String>((curve.transfer, gamut))
    };
    let (curve, gamut) = find(camera)?;
    let (shown, display) = find(DISPLAY)?;
    // Both whites are D65, so none is adapted.
    Ok((curve, gamut.matrix_to(display), shown))
}
