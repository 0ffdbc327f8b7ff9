//! Margins around a plate.

use seidel_optics::Rectangle;

/// Pixels to add on each side of a plate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Margins {
    /// Columns on the left.
    pub left: usize,
    /// Rows at the top.
    pub top: usize,
    /// Columns on the right.
    pub right: usize,
    /// Rows at the bottom.
    pub bottom: usize,
}

impl Margins {
    /// Returns whether nothing is added.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// Columns on the left, rows at the top, columns on the right and rows at the bottom.
    pub(crate) fn sides(&self) -> [usize; 4] {
        [self.left, self.top, self.right, self.bottom]
    }

    /// Returns `window` with these margins around it.
    pub fn around(&self, window: Rectangle) -> Rectangle {
        Rectangle {
            x: window.x - self.left as i32,
            y: window.y - self.top as i32,
            width: window.width + self.left + self.right,
            height: window.height + self.top + self.bottom,
        }
    }

    /// Returns `samples`, row-major and `width` columns wide, with the margins around them: each pixel of a margin is
    /// `fill` of the nearest pixel of the plate.
    pub(crate) fn padded(
        &self,
        samples: &[f32],
        width: usize,
        fill: impl Fn(f32) -> f32,
    ) -> Vec<f32> {
        let height = samples.len() / width.max(1);
        let rows = height + self.top + self.bottom;
        let mut out = Vec::with_capacity((width + self.left + self.right) * rows);
        for row in 0..rows {
            let nearest = row.saturating_sub(self.top).min(height - 1);
            let line = &samples[nearest * width..][..width];
            out.extend(std::iter::repeat_n(fill(line[0]), self.left));
            if nearest + self.top == row {
                out.extend_from_slice(line);
            } else {
                out.extend(line.iter().map(|sample| fill(*sample)));
            }
            out.extend(std::iter::repeat_n(fill(line[width - 1]), self.right));
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn margins_surround_the_plate_and_its_samples() {
        let margins = Margins {
            left: 1,
            top: 0,
            right: 2,
            bottom: 1,
        };
        let padded = margins.padded(&[1.0, 2.0, 3.0, 4.0], 2, |v| -v);
        let wanted = [
            [-1.0, 1.0, 2.0, -2.0, -2.0],
            [-3.0, 3.0, 4.0, -4.0, -4.0],
            [-3.0, -3.0, -4.0, -4.0, -4.0],
        ];
        assert_eq!(padded, wanted.concat());
        let window = Rectangle {
            x: 5,
            y: 6,
            width: 2,
            height: 2,
        };
        let around = margins.around(window);
        assert_eq!((around.x, around.y), (4, 6));
        assert_eq!((around.width, around.height), (5, 3));
    }
}
