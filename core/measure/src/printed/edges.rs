//! A chart of slanted squares: four orientations of edges at every place.

use seidel_optics::error::Result;

use super::{Medium, Shape, Sheet, Tone, Viewing, square, too_small};

/// Turns of neighbouring squares, degrees. Each square has edges along two orientations; both together have four,
/// 45 degrees apart, and none is within 7 degrees of a row or column of the sensor.
const TURNS: [f64; 2] = [7.0, 52.0];
/// Side of a square over the diameter of the blur, and its least value in pixels of the photograph: the edge profile must
/// reach both of its levels, and its length averages the noise.
const SIDE_OVER_BLUR: f64 = 6.0;
const MIN_SIDE_PX: f64 = 40.0;
/// Blank distance between squares over the diameter of the blur, and its least value, px.
const GAP_OVER_BLUR: f64 = 4.0;
const MIN_GAP_PX: f64 = 16.0;

/// Designs a chart of slanted squares.
///
/// # Errors
/// A sheet without room for four squares.
pub fn edges(medium: Medium, viewing: &Viewing) -> Result<Sheet> {
    viewing.check()?;
    let px_mm = viewing.px_mm();
    let side_px = (SIDE_OVER_BLUR * viewing.blur_px).max(MIN_SIDE_PX);
    let gap_px = (GAP_OVER_BLUR * viewing.blur_px).max(MIN_GAP_PX);
    let side_mm = medium.rounded(side_px * px_mm);
    // A turned square is at most sqrt(2) times as wide.
    let step_mm = (side_px * 2_f64.sqrt() + gap_px) * px_mm;
    let [columns, rows] = medium.inner().map(|v| (v / step_mm) as usize);
    if columns < 2 || rows < 2 {
        return Err(too_small("2 x 2 squares", &medium));
    }
    let start = [(medium.width_mm, columns), (medium.height_mm, rows)]
        .map(|(length, count)| (length - (count - 1) as f64 * step_mm) / 2.0);
    let shapes = (0..columns * rows)
        .map(|index| {
            let (column, row) = (index % columns, index / columns);
            let centre = [
                start[0] + column as f64 * step_mm,
                start[1] + row as f64 * step_mm,
            ];
            Shape {
                corners: square(centre, side_mm, TURNS[(column + row) % 2]),
                tone: Tone::Black,
            }
        })
        .collect();
    let choices = vec![
        format!("one pixel of the photograph covers {px_mm:.3} mm of the chart"),
        format!(
            "squares of {side_mm:.1} mm, {:.0} px of the photograph: six times the blur and at least {MIN_SIDE_PX} px, so that edges reach black and white",
            side_mm / px_mm
        ),
        format!("{columns} x {rows} squares, {step_mm:.1} mm apart"),
        format!(
            "turned by {} and {} degrees in turn: four orientations of edges at every place, which third moments need",
            TURNS[0], TURNS[1]
        ),
    ];
    Ok(Sheet {
        medium,
        background: Tone::White,
        shapes,
        cells: None,
        caption: format!("seidel edge chart, {columns} x {rows} squares of {side_mm:.2} mm"),
        choices,
        warnings: Vec::new(),
    })
}
