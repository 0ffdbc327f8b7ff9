//! Three-dimensional tables from a camera to a display, for viewing plates in programs without OpenColorIO.

use seidel_colour::curves::{CurveTable, Matrix, TransferFunction};
use seidel_colour::tables::{cube, cube_grid};

/// Entries along each side: accurate enough for viewing, and small enough for the repository.
const SIZE: usize = 17;

/// Camera spaces with a table, and the name of its file.
const CAMERAS: [(&str, &str); 2] = [
    ("ARRI LogC4", "arri-logc4-to-srgb"),
    ("S-Log3 S-Gamut3.Cine", "sony-slog3-cine-to-srgb"),
];

/// The display of all tables.
const DISPLAY: &str = "sRGB - Texture";

/// Path in `luts/` and text of each table.
pub(super) fn files(table: &CurveTable) -> Result<Vec<(String, String)>, String> {
    let mut files = Vec::new();
    for (camera, file) in CAMERAS {
        let transform = Transform::new(table, camera)?;
        let range = (0.0, 1.0);
        let grid = cube_grid(SIZE, range);
        let entries: Vec<[f32; 3]> = grid.iter().map(|codes| transform.apply(codes)).collect();
        let title = format!("{camera} to {DISPLAY}, clipped");
        files.push((
            format!("cube/{file}.cube"),
            cube(&title, SIZE, range, &entries),
        ));
    }
    Ok(files)
}

/// The transform from a camera's codes to those of the display.
struct Transform {
    camera: TransferFunction,
    matrix: Matrix,
    display: TransferFunction,
}

impl Transform {
    fn new(table: &CurveTable, camera: &str) -> Result<Self, String> {
        let find = |name: &str| {
            let space = table.space(name);
            let space = space.ok_or_else(|| format!("curves.toml: lacks the space {name}"))?;
            let curve = table.curve(space).map_err(|e| e.to_string())?;
            let curve = curve.ok_or_else(|| format!("curves.toml: {name} has no curve"))?;
            let gamut = table.gamut(space).map_err(|e| e.to_string())?;
            Ok::<_, String>((curve.transfer, gamut))
        };
        let (camera, camera_gamut) = find(camera)?;
        let (display, display_gamut) = find(DISPLAY)?;
        // No chromatic adaptation: both white points are D65.
        let matrix = camera_gamut.matrix_to(display_gamut);
        Ok(Self {
            camera,
            matrix,
            display,
        })
    }

    fn apply(&self, codes: &[f32; 3]) -> [f32; 3] {
        let light = codes.map(|code| self.camera.decode(f64::from(code)));
        self.matrix.map(|row| {
            let sum: f64 = row.iter().zip(light).map(|(m, v)| m * v).sum();
            self.display.encode(sum).clamp(0.0, 1.0) as f32
        })
    }
}
