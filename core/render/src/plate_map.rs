//! The position of a plate in the frame of a lens.

use seidel_optics::field::ImagePoint;

/// The position and scale of a plate in the lens's frame.
///
/// It applies to square pixels. For others wrap the lens in a [`NonSquarePixelLens`](crate::NonSquarePixelLens).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlateMap {
    /// Position of the plate's top-left outer corner in the lens's frame.
    pub origin: ImagePoint,
    /// Plate pixels per pixel of the lens's frame.
    pub scale: f64,
}

impl PlateMap {
    /// Returns the map of a plate that begins `columns` to the right and `rows` below this one; both may be negative.
    pub fn moved(&self, columns: f64, rows: f64) -> Self {
        Self {
            origin: ImagePoint::new(
                self.origin.x_px + columns / self.scale,
                self.origin.y_px + rows / self.scale,
            ),
            scale: self.scale,
        }
    }

    /// Returns the position (x, y) of the plate's first pixel in its cell of a grid that is fixed to the frame, with cells of `side` plate
    /// pixels. Four cells meet at `point` of the frame.
    pub(crate) fn place_in_cell_about(&self, point: ImagePoint, side: usize) -> [usize; 2] {
        [self.origin.x_px - point.x_px, self.origin.y_px - point.y_px]
            .map(|at| (at * self.scale).round().rem_euclid(side as f64) as usize)
    }

    /// Returns the position of the centre of plate pixel (`column`, `row`) in the lens's frame.
    pub fn frame_point(&self, column: usize, row: usize) -> ImagePoint {
        ImagePoint::new(
            self.origin.x_px + (column as f64 + 0.5) / self.scale,
            self.origin.y_px + (row as f64 + 0.5) / self.scale,
        )
    }
}
