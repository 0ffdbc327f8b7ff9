//! Where a plate lies in the frame of a lens.

use seidel_optics::field::ImagePoint;

/// Where the pixels of a plate lie in the lens's frame. Plates whose pixels are not square are seen through a
/// [`NonSquarePixelLens`] lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlateMap {
    /// Lens-frame position of the plate's top-left outer corner.
    pub origin: ImagePoint,
    /// Plate pixels that make up one lens-frame pixel.
    pub scale: f64,
}

impl PlateMap {
    /// The map of a plate that begins (`columns`, `rows`) pixels further on, or before where these are negative.
    pub fn moved(&self, columns: f64, rows: f64) -> Self {
        Self {
            origin: ImagePoint::new(
                self.origin.x_px + columns / self.scale,
                self.origin.y_px + rows / self.scale,
            ),
            scale: self.scale,
        }
    }

    /// Lens-frame position of the centre of plate pixel (`column`, `row`).
    pub fn frame_point(&self, column: usize, row: usize) -> ImagePoint {
        ImagePoint::new(
            self.origin.x_px + (column as f64 + 0.5) / self.scale,
            self.origin.y_px + (row as f64 + 0.5) / self.scale,
        )
    }
}
