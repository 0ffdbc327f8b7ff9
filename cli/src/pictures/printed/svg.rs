//! A chart as SVG at its true size.

use std::fmt::Write;

use seidel_measure::printed::{Sheet, Tone};

use super::{black_runs, groups};
use crate::report::escape;

/// Height of the caption's letters, mm.
const CAPTION_MM: f64 = 2.2;

fn colour(tone: Tone) -> &'static str {
    match tone {
        Tone::Black => "#000",
        Tone::White => "#fff",
    }
}

/// Returns the file.
pub fn svg(sheet: &Sheet) -> String {
    let (width, height) = (sheet.medium.width_mm, sheet.medium.height_mm);
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}mm\" height=\"{height}mm\" \
         viewBox=\"0 0 {width} {height}\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"{}\"/>\n",
        colour(sheet.background)
    );
    let mut path = String::new();
    if let Some(placed) = &sheet.cells {
        for [left, top, w, h] in black_runs(placed) {
            // Writing to a string cannot fail.
            let _ = write!(path, "M{left:.4} {top:.4}h{w:.4}v{h:.4}h{:.4}z", -w);
        }
        text += &format!("<path shape-rendering=\"crispEdges\" d=\"{path}\"/>\n");
    }
    for group in groups(&sheet.shapes) {
        path.clear();
        for shape in group {
            for (k, [x, y]) in shape.corners.iter().enumerate() {
                let _ = write!(path, "{}{x:.4} {y:.4}", if k == 0 { 'M' } else { 'L' });
            }
            path.push('z');
        }
        text += &format!("<path fill=\"{}\" d=\"{path}\"/>\n", colour(group[0].tone));
    }
    if sheet.medium.margin_mm > 0.0 {
        let ink = match sheet.background {
            Tone::Black => Tone::White,
            Tone::White => Tone::Black,
        };
        text += &format!(
            "<text x=\"{}\" y=\"{}\" font-family=\"sans-serif\" font-size=\"{CAPTION_MM}\" fill=\"{}\">{}</text>\n",
            sheet.medium.margin_mm,
            height - CAPTION_MM,
            colour(ink),
            escape(&sheet.caption)
        );
    }
    text + "</svg>\n"
}
