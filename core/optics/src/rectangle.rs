//! A rectangle of pixels.

use std::fmt;
use std::ops::Range;

/// A rectangle of pixels on an unbounded grid: x right, y down.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rectangle {
    /// First column; may be negative.
    pub x: i32,
    /// First row; may be negative.
    pub y: i32,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl fmt::Display for Rectangle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            x,
            y,
            width,
            height,
        } = self;
        write!(f, "{width}x{height} at ({x}, {y})")
    }
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
        // In 64 bits, since the windows of a damaged file may end beyond 32.
        let overlap = |a: i32, a_size: usize, b: i32, b_size: usize| {
            let end = (i64::from(a) + a_size as i64).min(i64::from(b) + b_size as i64);
            let first = a.max(b);
            let size = usize::try_from(end - i64::from(first)).ok()?;
            (size > 0).then_some((first, size))
        };
        let (x, width) = overlap(self.x, self.width, other.x, other.width)?;
        let (y, height) = overlap(self.y, self.height, other.y, other.height)?;
        Some(Self {
            x,
            y,
            width,
            height,
        })
    }

    /// Returns the rectangle with `columns` more on the left and right and `rows` more at the top and bottom.
    pub fn expanded(self, columns: usize, rows: usize) -> Self {
        let less = |at: i32, by: usize| at.saturating_sub(i32::try_from(by).unwrap_or(i32::MAX));
        Self {
            x: less(self.x, columns),
            y: less(self.y, rows),
            width: self.width + 2 * columns,
            height: self.height + 2 * rows,
        }
    }

    /// Returns the rectangle moved as the corner of `from` is to be moved to that of `to`.
    pub fn moved(self, from: Self, to: Self) -> Self {
        let moved = |at: i32, from: i32, to: i32| at.saturating_add(to.saturating_sub(from));
        Self {
            x: moved(self.x, from.x, to.x),
            y: moved(self.y, from.y, to.y),
            ..self
        }
    }

    /// Returns whether all pixels of `inner` are in this rectangle.
    pub fn encloses(self, inner: Self) -> bool {
        let within = |inner: i32, inner_size: usize, outer: i32, outer_size: usize| {
            let first = i64::from(inner) - i64::from(outer);
            first >= 0 && first as u64 + inner_size as u64 <= outer_size as u64
        };
        within(inner.x, inner.width, self.x, self.width)
            && within(inner.y, inner.height, self.y, self.height)
    }

    /// Returns the smallest rectangle that contains both.
    pub fn union(self, other: Self) -> Self {
        let span = |a: i32, a_size: usize, b: i32, b_size: usize| {
            let end = (i64::from(a) + a_size as i64).max(i64::from(b) + b_size as i64);
            (end - i64::from(a.min(b))) as usize
        };
        Self {
            x: self.x.min(other.x),
            y: self.y.min(other.y),
            width: span(self.x, self.width, other.x, other.width),
            height: span(self.y, self.height, other.y, other.height),
        }
    }
}
