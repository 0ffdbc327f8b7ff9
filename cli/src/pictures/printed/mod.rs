//! Charts as files: PDF and SVG to print, PNG for screens and for `measure chart`.

mod pdf;
mod raster;
mod svg;

use std::path::Path;

use seidel_measure::printed::{PlacedCells, Shape, Tone};

pub use pdf::pdf;
pub use raster::picture;
pub use svg::svg;

/// A file format of charts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PrintFormat {
    /// Vectors on a page.
    Pdf,
    /// Vectors.
    Svg,
    /// Pixels.
    Png,
}

impl PrintFormat {
    /// Returns the format that the extension of `path` names.
    pub fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "pdf" => Some(Self::Pdf),
            "svg" => Some(Self::Svg),
            "png" => Some(Self::Png),
            _ => None,
        }
    }
}

/// Returns the rectangles that draw the black cells: runs along rows, so that files stay small.
fn black_runs(placed: &PlacedCells) -> Vec<[f64; 4]> {
    let (cells, side) = (&placed.cells, placed.cell_mm);
    let mut runs = Vec::new();
    for (row, line) in cells.white.chunks(cells.columns).enumerate() {
        let mut start = 0;
        for run in line.chunk_by(|a, b| a == b) {
            if !run[0] {
                let left = placed.origin_mm[0] + start as f64 * side;
                let top = placed.origin_mm[1] + row as f64 * side;
                runs.push([left, top, run.len() as f64 * side, side]);
            }
            start += run.len();
        }
    }
    runs
}

/// Returns the share of light of a tone.
fn level(tone: Tone) -> f32 {
    match tone {
        Tone::Black => 0.0,
        Tone::White => 1.0,
    }
}

/// Returns the shapes that share a tone, in drawing order.
fn groups(shapes: &[Shape]) -> impl Iterator<Item = &[Shape]> {
    shapes.chunk_by(|a, b| a.tone == b.tone)
}

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_measure::printed::{Medium, Viewing, edges, noise};

    const A5: Medium = Medium {
        width_mm: 210.0,
        height_mm: 148.0,
        margin_mm: 8.0,
        pixel_mm: None,
    };
    const VIEWING: Viewing = Viewing {
        distance_m: 1.0,
        focal_mm: 50.0,
        pitch_um: 4.0,
        blur_px: 6.0,
    };

    #[test]
    fn a_noise_chart_has_the_same_cells_in_every_format() {
        let sheet = noise(A5, &VIEWING, 3).expect("room");
        let placed = sheet.cells.as_ref().expect("cells");
        let picture = picture(&sheet);
        let scale = picture.width() as usize / placed.cells.columns;
        assert_eq!(picture.width() as usize, scale * placed.cells.columns);
        for (index, white) in placed.cells.white.iter().enumerate() {
            let (x, y) = (index % placed.cells.columns, index / placed.cells.columns);
            let pixel = picture.get_pixel((x * scale) as u32, ((y + 1) * scale - 1) as u32);
            assert_eq!(pixel.0[0] > 127, *white);
        }
        let black = placed.cells.white.iter().filter(|w| !**w).count() as f64;
        let area: f64 = black_runs(placed).iter().map(|r| r[2] * r[3]).sum();
        let cells = area / placed.cell_mm.powi(2);
        assert!((cells / black - 1.0).abs() < 1e-9, "{cells} {black}");
        let text = svg(&sheet);
        assert_eq!(text.matches('M').count(), black_runs(placed).len());
        let file = pdf(&sheet);
        assert!(file.starts_with(b"%PDF-") && file.ends_with(b"%%EOF"));
        let rectangles = file.windows(4).filter(|w| w == b" re\n").count();
        assert!(rectangles >= black_runs(placed).len(), "{rectangles}");
    }

    #[test]
    fn edges_are_antialiased_at_the_resolution_of_the_picture() {
        let sheet = edges(A5, &VIEWING).expect("room");
        let picture = picture(&sheet);
        let mean = picture.pixels().map(|p| f64::from(p.0[0])).sum::<f64>()
            / f64::from(picture.width() * picture.height())
            / 255.0;
        let side = |s: &Shape| {
            let [a, b] = [s.corners[0], s.corners[1]];
            (a[0] - b[0]).hypot(a[1] - b[1])
        };
        let area: f64 = sheet.shapes.iter().map(|s| side(s).powi(2)).sum();
        let want = 1.0 - area / (210.0 * 148.0);
        assert!((mean - want).abs() < 1e-3, "{mean} {want}");
        assert!(picture.pixels().any(|p| (40..215).contains(&p.0[0])));
    }
}
