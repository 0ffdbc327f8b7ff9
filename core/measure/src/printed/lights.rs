//! A chart of lights: white dots on black, to be shown on a screen or lit from behind.

use seidel_optics::error::Result;
use seidel_optics::numeric::SplitMix64;

use super::{Medium, Shape, Sheet, Tone, Viewing, too_small};
use crate::capture_plan::largest_light_px;

/// Distance between lights over the diameter of the blur, and its least value, px. Nearer lights count as double.
const STEP_OVER_BLUR: f64 = 5.0;
const MIN_STEP_PX: f64 = 24.0;
/// Random displacement of a light along each axis over the distance between lights: without it all lights could lie alike
/// on the pixels.
const JITTER: f64 = 0.15;
/// Smallest dot that printers draw, mm.
const MIN_PRINTED_MM: f64 = 0.1;
/// Corners of the polygon that stands for a circle.
const CORNERS: u32 = 24;

/// Designs a chart of lights.
///
/// # Errors
/// A sheet without room for 2 x 2 lights.
pub fn lights(medium: Medium, viewing: &Viewing, seed: u64) -> Result<Sheet> {
    viewing.check()?;
    let px_mm = viewing.px_mm();
    let largest_mm = largest_light_px(viewing.blur_px) * px_mm;
    let diameter_mm = medium
        .rounded(largest_mm)
        .max(if medium.pixel_mm.is_none() {
            MIN_PRINTED_MM
        } else {
            0.0
        });
    let step_mm = (STEP_OVER_BLUR * viewing.blur_px).max(MIN_STEP_PX) * px_mm;
    let [columns, rows] = medium.inner().map(|v| (v / step_mm) as usize);
    if columns < 2 || rows < 2 {
        return Err(too_small("2 x 2 lights", &medium));
    }
    let start = [(medium.width_mm, columns), (medium.height_mm, rows)]
        .map(|(length, count)| (length - (count - 1) as f64 * step_mm) / 2.0);
    let mut random = SplitMix64::new(seed);
    let mut shapes = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let mut at = |start: f64, index: usize| {
                let jitter = JITTER * (2.0 * random.unit() - 1.0);
                start + (index as f64 + jitter) * step_mm
            };
            let centre = [at(start[0], column), at(start[1], row)];
            shapes.push(dot(centre, diameter_mm, medium));
        }
    }
    let mut warnings = Vec::new();
    if diameter_mm > 1.3 * largest_mm {
        warnings.push(format!(
            "dots of {diameter_mm:.2} mm are the smallest of this medium and widen the blur; {largest_mm:.2} mm or less would not. Photograph from farther away"
        ));
    }
    if medium.pixel_mm.is_none() {
        warnings.push(
            "light this sheet from behind: print it on film, or punch the dots into black foil as pinholes"
                .to_owned(),
        );
    }
    let choices = vec![
        format!("one pixel of the photograph covers {px_mm:.3} mm of the chart"),
        format!(
            "dots of {diameter_mm:.2} mm, {:.2} px of the photograph",
            diameter_mm / px_mm
        ),
        format!(
            "{columns} x {rows} dots, {step_mm:.1} mm apart: five times the blur and at least {MIN_STEP_PX} px"
        ),
    ];
    Ok(Sheet {
        medium,
        background: Tone::Black,
        shapes,
        cells: None,
        caption: format!(
            "seidel lights, {columns} x {rows} dots of {diameter_mm:.2} mm, seed {seed}"
        ),
        choices,
        warnings,
    })
}

/// Returns a dot about `centre`: a circle on paper, whole pixels on a screen.
fn dot([x, y]: [f64; 2], diameter: f64, medium: Medium) -> Shape {
    let corners = match medium.pixel_mm {
        Some(pixel) => {
            let [left, top] = [x, y].map(|v| ((v - diameter / 2.0) / pixel).round() * pixel);
            vec![
                [left, top],
                [left + diameter, top],
                [left + diameter, top + diameter],
                [left, top + diameter],
            ]
        }
        None => (0..CORNERS)
            .map(|k| {
                let angle = std::f64::consts::TAU * f64::from(k) / f64::from(CORNERS);
                let (sin, cos) = angle.sin_cos();
                [x + diameter / 2.0 * cos, y + diameter / 2.0 * sin]
            })
            .collect(),
    };
    Shape {
        corners,
        tone: Tone::White,
    }
}
