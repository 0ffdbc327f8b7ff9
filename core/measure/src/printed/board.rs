//! A slanted checkerboard.

use seidel_optics::error::Result;

use super::{Medium, Shape, Sheet, Tone, Viewing, square, too_small};

/// Turn of the board, degrees: its edges cross rows and columns of the sensor slowly, as edge profiles need.
const TURN: f64 = 7.0;
/// Side of a square over the diameter of the blur, and its least value in pixels of the photograph.
const SIDE_OVER_BLUR: f64 = 6.0;
const MIN_SIDE_PX: f64 = 32.0;

/// Designs a slanted checkerboard.
///
/// # Errors
/// A sheet without room for eight squares.
pub fn board(medium: Medium, viewing: &Viewing) -> Result<Sheet> {
    viewing.check()?;
    let px_mm = viewing.px_mm();
    let side_px = (SIDE_OVER_BLUR * viewing.blur_px).max(MIN_SIDE_PX);
    let side_mm = medium.rounded(side_px * px_mm);
    let [width, height] = medium.inner();
    let (sin, cos) = TURN.to_radians().sin_cos();
    let reach = ((width.hypot(height) / side_mm) / 2.0).ceil() as i32 + 1;
    let mut shapes = Vec::new();
    for row in -reach..=reach {
        for column in (-reach..=reach).filter(|c| (c + row).rem_euclid(2) == 0) {
            let (u, v) = (f64::from(column) * side_mm, f64::from(row) * side_mm);
            let centre = [
                medium.width_mm / 2.0 + u * cos - v * sin,
                medium.height_mm / 2.0 + u * sin + v * cos,
            ];
            let corners = square(centre, side_mm, TURN);
            let inside = |[x, y]: &[f64; 2]| {
                (x - medium.width_mm / 2.0).abs() <= width / 2.0
                    && (y - medium.height_mm / 2.0).abs() <= height / 2.0
            };
            if corners.iter().all(inside) {
                shapes.push(Shape {
                    corners,
                    tone: Tone::Black,
                });
            }
        }
    }
    if shapes.len() < 8 {
        return Err(too_small("eight squares of a board", &medium));
    }
    let choices = vec![
        format!("one pixel of the photograph covers {px_mm:.3} mm of the chart"),
        format!(
            "squares of {side_mm:.1} mm, {:.0} px of the photograph: six times the blur and at least {MIN_SIDE_PX} px, so that edges reach black and white",
            side_mm / px_mm
        ),
        format!(
            "turned by {TURN} degrees: two orientations of edges, enough for the lens as a whole; print `edges` for four at every place"
        ),
    ];
    Ok(Sheet {
        medium,
        background: Tone::White,
        caption: format!("seidel board, squares of {side_mm:.2} mm"),
        shapes,
        cells: None,
        choices,
        warnings: Vec::new(),
    })
}
