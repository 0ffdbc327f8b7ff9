//! Charts to print or to show on a screen: noise, slanted edges, a board, and lights.
//!
//! Sizes follow from the expected blur, so [`Viewing`] states how a chart is seen: one pixel of the photograph covers
//! [`Viewing::px_mm`] millimetres of the chart. Every design has a function that returns a [`Sheet`].

mod board;
mod coverage;
mod edges;
mod lights;
mod noise;

pub use board::board;
pub use coverage::PageCoverage;
pub use edges::edges;
pub use lights::lights;
pub use noise::noise;

use seidel_optics::error::{Error, Result};

/// The geometry in which the chart is photographed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Viewing {
    /// Distance from the camera to the chart, m.
    pub distance_m: f64,
    /// Focal length, mm.
    pub focal_mm: f64,
    /// Pixel pitch of the sensor, µm.
    pub pitch_um: f64,
    /// Diameter of the expected blur, pixels of the photograph.
    pub blur_px: f64,
}

impl Viewing {
    /// Returns the length on the chart that one pixel of the photograph covers, mm: pitch x (z - f) / f of a thin lens.
    pub fn px_mm(&self) -> f64 {
        let magnification = self.focal_mm / (1000.0 * self.distance_m - self.focal_mm);
        self.pitch_um / 1000.0 / magnification
    }

    /// Checks ranges.
    ///
    /// # Errors
    /// A value that is not positive, and a chart within the focal length.
    pub fn check(&self) -> Result<()> {
        let values = [
            ("distance_m", self.distance_m),
            ("focal_mm", self.focal_mm),
            ("pitch_um", self.pitch_um),
            ("blur_px", self.blur_px),
        ];
        for (name, value) in values {
            if !(value.is_finite() && value > 0.0) {
                return Err(Error::new(
                    name,
                    "is not positive",
                    "give a positive number",
                ));
            }
        }
        if 1000.0 * self.distance_m <= 2.0 * self.focal_mm {
            return Err(Error::new(
                "distance_m",
                "is closer than twice the focal length",
                "give the distance from the lens to the chart in metres",
            ));
        }
        Ok(())
    }
}

/// The medium of a chart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Medium {
    /// Width of the area to draw on, mm.
    pub width_mm: f64,
    /// Height, mm.
    pub height_mm: f64,
    /// Blank margin of paper, mm; zero for a screen.
    pub margin_mm: f64,
    /// Side of the pixels of a screen, mm, on which lengths are then rounded; `None` for paper.
    pub pixel_mm: Option<f64>,
}

impl Medium {
    /// Returns `length_mm` rounded to whole pixels of a screen, at least one.
    fn rounded(&self, length_mm: f64) -> f64 {
        match self.pixel_mm {
            Some(pixel) => (length_mm / pixel).round().max(1.0) * pixel,
            None => length_mm,
        }
    }

    /// Returns width and height within the margins, mm.
    fn inner(&self) -> [f64; 2] {
        [self.width_mm, self.height_mm].map(|v| v - 2.0 * self.margin_mm)
    }
}

/// The tone of a shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tone {
    /// Ink, or a dark screen.
    Black,
    /// Bare paper, or a bright screen.
    White,
}

/// A filled polygon.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// Corners, mm from the top-left corner of the sheet, y down.
    pub corners: Vec<[f64; 2]>,
    /// Tone of the inside.
    pub tone: Tone,
}

/// Square cells, each black or white.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cells {
    /// Cells along x.
    pub columns: usize,
    /// Cells along y.
    pub rows: usize,
    /// Whether a cell is white, row by row.
    pub white: Vec<bool>,
}

/// A cell pattern on a sheet.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedCells {
    /// The pattern.
    pub cells: Cells,
    /// Top-left corner, mm.
    pub origin_mm: [f64; 2],
    /// Side of a cell, mm.
    pub cell_mm: f64,
}

/// A chart as it is printed.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet {
    /// The medium it was designed for.
    pub medium: Medium,
    /// Tone beneath all shapes.
    pub background: Tone,
    /// Polygons, later ones on top.
    pub shapes: Vec<Shape>,
    /// A pattern of cells, for noise charts.
    pub cells: Option<PlacedCells>,
    /// One line about the chart, which paper shows at its lower edge.
    pub caption: String,
    /// The choices and their reasons, one sentence for each.
    pub choices: Vec<String>,
    /// Limits of this chart at this size.
    pub warnings: Vec<String>,
}

/// Returns the corners of a square of `side` about `centre`, turned by `degrees`.
fn square([x, y]: [f64; 2], side: f64, degrees: f64) -> Vec<[f64; 2]> {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let half = side / 2.0;
    [[-half, -half], [half, -half], [half, half], [-half, half]]
        .map(|[u, v]| [x + u * cos - v * sin, y + u * sin + v * cos])
        .to_vec()
}

fn too_small(what: &str, medium: &Medium) -> Error {
    Error::new(
        "sheet",
        format!(
            "of {:.0} x {:.0} mm has no room for {what}",
            medium.width_mm, medium.height_mm
        ),
        "give a larger sheet, a shorter distance or a smaller blur",
    )
}

#[cfg(test)]
mod tests;
