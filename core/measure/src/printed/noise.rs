//! A noise chart: independent black and white cells, with a finder mark in each corner.

use seidel_optics::error::Result;
use seidel_optics::numeric::SplitMix64;

use super::{Cells, Medium, PlacedCells, Sheet, Tone, Viewing, too_small};

/// Side of a cell over the diameter of the blur, and its least value in pixels of the photograph. Smaller cells average out
/// in the blur, larger ones leave high frequencies without light.
const CELL_OVER_BLUR: f64 = 0.25;
const MIN_CELL_PX: f64 = 1.8;
/// Least width of a mark's rings over the diameter of the blur, and in pixels of the photograph.
const RING_OVER_BLUR: f64 = 0.8;
const MIN_RING_PX: f64 = 5.0;
/// Modules of a mark, and of the blank frame around it.
const MARK_MODULES: usize = 7;
const QUIET_MODULES: usize = 1;
/// Smallest cell that office printers draw cleanly, mm: five dots of 600 dpi.
const MIN_PRINTED_MM: f64 = 0.2;
/// Least number of cells along the shorter side.
const MIN_CELLS: usize = 60;

/// Designs a noise chart.
///
/// # Errors
/// A sheet without room for it.
pub fn noise(medium: Medium, viewing: &Viewing, seed: u64) -> Result<Sheet> {
    viewing.check()?;
    let px_mm = viewing.px_mm();
    let wanted_px = (CELL_OVER_BLUR * viewing.blur_px).max(MIN_CELL_PX);
    let cell_mm = medium.rounded(wanted_px * px_mm);
    let cell_px = cell_mm / px_mm;
    let ring_px = (RING_OVER_BLUR * viewing.blur_px).max(MIN_RING_PX);
    let module = (ring_px / cell_px).ceil() as usize;
    let border = 2 * module;
    let [columns, rows] = medium.inner().map(|v| (v / cell_mm) as usize);
    let corner = (MARK_MODULES + 2 * QUIET_MODULES) * module;
    if columns.min(rows) < MIN_CELLS + 2 * border || columns.min(rows) < 3 * corner {
        return Err(too_small("a noise chart", &medium));
    }
    let cells = draw(columns, rows, module, border, seed);
    let origin_mm = [
        (medium.width_mm - columns as f64 * cell_mm) / 2.0,
        (medium.height_mm - rows as f64 * cell_mm) / 2.0,
    ];
    let mut warnings = Vec::new();
    if medium.pixel_mm.is_none() && cell_mm < MIN_PRINTED_MM {
        warnings.push(format!(
            "cells of {cell_mm:.2} mm are too fine for office printers; photograph from farther away with a larger chart"
        ));
    }
    let choices = vec![
        format!("one pixel of the photograph covers {px_mm:.3} mm of the chart"),
        format!(
            "cells of {cell_mm:.3} mm, {cell_px:.1} px of the photograph: a quarter of the blur and at least {MIN_CELL_PX} px, so that all frequencies of the blur have light"
        ),
        format!("{columns} x {rows} cells"),
        format!(
            "corner marks of {:.1} mm, whose rings are {:.1} px wide and stay visible through the blur",
            (MARK_MODULES * module) as f64 * cell_mm,
            module as f64 * cell_px
        ),
    ];
    Ok(Sheet {
        medium,
        background: Tone::White,
        shapes: Vec::new(),
        caption: format!(
            "seidel noise chart, {columns} x {rows} cells of {cell_mm:.3} mm, seed {seed}"
        ),
        cells: Some(PlacedCells {
            cells,
            origin_mm,
            cell_mm,
        }),
        choices,
        warnings,
    })
}

/// Draws noise within a white border of `border` cells, and marks of modules of `module` cells in its corners.
fn draw(columns: usize, rows: usize, module: usize, border: usize, seed: u64) -> Cells {
    let mut random = SplitMix64::new(seed);
    let mut white: Vec<bool> = (0..columns * rows).map(|_| random.unit() < 0.5).collect();
    for (index, white) in white.iter_mut().enumerate() {
        let (x, y) = (index % columns, index / columns);
        // Distances from the nearer borders: all four corners are alike.
        let (x, y) = (x.min(columns - 1 - x), y.min(rows - 1 - y));
        if x < border || y < border {
            *white = true;
            continue;
        }
        let (x, y) = ((x - border) / module, (y - border) / module);
        if x.max(y) < MARK_MODULES + QUIET_MODULES {
            *white = !is_mark(x, y);
        }
    }
    Cells {
        columns,
        rows,
        white,
    }
}

/// Returns whether module (`x`, `y`) of a mark is black: concentric squares with widths 1 : 1 : 3 : 1 : 1 along any line
/// through the centre.
fn is_mark(x: usize, y: usize) -> bool {
    let middle = MARK_MODULES / 2;
    let ring = x.abs_diff(middle).max(y.abs_diff(middle));
    ring == middle || ring < 2
}
