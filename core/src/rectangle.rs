//! A rectangle of pixels.

use std::ops::Range;

/// A rectangle of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rectangle {
    /// First column.
    pub x: i32,
    /// First row.
    pub y: i32,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl Rectangle {
    /// The x coordinates of its pixels.
    pub fn columns(&self) -> Range<i32> {
        self.x..self.x + self.width as i32
    }

    /// The y coordinates of its pixels.
    pub fn rows(&self) -> Range<i32> {
        self.y..self.y + self.height as i32
    }

    /// Number of pixels.
    pub fn pixel_count(&self) -> usize {
        self.width * self.height
    }

    /// Returns whether pixel (`x`, `y`) lies in the rectangle.
    pub fn contains(&self, x: i32, y: i32) -> bool {
        self.columns().contains(&x) && self.rows().contains(&y)
    }

    /// Returns the pixels that lie in both rectangles, or `None` if there are none.
    pub fn intersection(&self, other: &Self) -> Option<Self> {
        let overlap = |a: Range<i32>, b: Range<i32>| a.start.max(b.start)..a.end.min(b.end);
        let columns = overlap(self.columns(), other.columns());
        let rows = overlap(self.rows(), other.rows());
        (!columns.is_empty() && !rows.is_empty()).then(|| Self {
            x: columns.start,
            y: rows.start,
            width: columns.len(),
            height: rows.len(),
        })
    }
}
