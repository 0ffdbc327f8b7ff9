//! Conversion of the host's coordinates to those of the plate.
//!
//! Parameters and regions are canonical: square pixels at full resolution, y up. Images are in pixels of the render, y up.
//! Plates have y down and (0, 0) at the top left corner of the format, as `seidel apply` has them.

use seidel_core::Rectangle;

use crate::sys::{OfxRectD, OfxRectI};

/// Pixels of a render per canonical unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scale {
    /// Along x.
    pub(crate) x: f64,
    /// Along y.
    pub(crate) y: f64,
}

/// The rows of a frame that are rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Field {
    /// All rows.
    Whole,
    /// Even rows, counted from the bottom.
    Lower,
    /// Odd rows.
    Upper,
}

/// Distance from a whole number, pixels, within which a coordinate is taken to be whole: far above rounding errors of
/// scaled regions, far below a pixel.
const ROUNDING_SLACK: f64 = 1e-4;

/// Largest coordinate of a region, pixels. Hosts have infinite regions; no plate is as large as this.
const MAX_COORDINATE: f64 = 8e6;

impl Scale {
    /// Creates the scale of a render at the host's scale `render`, with pixels `aspect` times as wide as high.
    pub(crate) fn new(render: [f64; 2], aspect: f64) -> Self {
        let valid_or_one = |scale: f64| {
            if scale.is_finite() && scale > 0.0 {
                scale
            } else {
                1.0
            }
        };
        Self {
            x: valid_or_one(render[0]) / aspect,
            y: valid_or_one(render[1]),
        }
    }

    /// Returns the pixels that a canonical rectangle touches.
    pub(crate) fn pixels_of(&self, rect: OfxRectD) -> OfxRectI {
        let pixel = |value: f64| value.clamp(-MAX_COORDINATE, MAX_COORDINATE) as i32;
        OfxRectI {
            x1: pixel((rect.x1 * self.x + ROUNDING_SLACK).floor()),
            y1: pixel((rect.y1 * self.y + ROUNDING_SLACK).floor()),
            x2: pixel((rect.x2 * self.x - ROUNDING_SLACK).ceil()),
            y2: pixel((rect.y2 * self.y - ROUNDING_SLACK).ceil()),
        }
    }

    /// Returns the scale in which the host gives regions, found from the `region` of an input whose image has the pixels
    /// `bounds` of this `aspect`. It is that of the render, as the standard says, or 1 in hosts that give regions in
    /// pixels of the render, as MLT does for previews.
    pub(crate) fn of_regions(self, region: OfxRectD, bounds: OfxRectI, aspect: f64) -> Self {
        let pixels = Self::new([1.0; 2], aspect);
        if self.pixels_of(region) != bounds && pixels.pixels_of(region) == bounds {
            pixels
        } else {
            self
        }
    }
}

/// Plate pixels per pixel at full resolution, for lengths and offsets that parameters give.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PlateScale {
    /// Along x.
    pub(crate) x: f64,
    /// Along y; half as many in a field, which has every other row.
    pub(crate) y: f64,
    /// Offset of the rows of a field from the middle of the two frame rows that each stands for, plate pixels down.
    pub(crate) row_offset: f64,
}

impl PlateScale {
    /// Full resolution, with square pixels.
    pub(crate) const FULL: Self = Self {
        x: 1.0,
        y: 1.0,
        row_offset: 0.0,
    };

    /// Creates the scale of the plate that `field` of a render at `scale` is.
    pub(crate) fn new(scale: Scale, field: Field) -> Self {
        let (y, row_offset) = match field {
            Field::Whole => (scale.y, 0.0),
            Field::Lower => (scale.y / 2.0, -0.25),
            Field::Upper => (scale.y / 2.0, 0.25),
        };
        Self {
            x: scale.x,
            y,
            row_offset,
        }
    }
}

/// Returns whether a rectangle has no pixel.
pub(crate) fn is_empty(rect: OfxRectI) -> bool {
    rect.x2 <= rect.x1 || rect.y2 <= rect.y1
}

/// Returns the pixels that lie in both rectangles.
pub(crate) fn intersection(a: OfxRectI, b: OfxRectI) -> OfxRectI {
    OfxRectI {
        x1: a.x1.max(b.x1),
        y1: a.y1.max(b.y1),
        x2: a.x2.min(b.x2),
        y2: a.y2.min(b.y2),
    }
}

/// Returns the smallest rectangle that contains both.
pub(crate) fn bounding_box(a: OfxRectI, b: OfxRectI) -> OfxRectI {
    OfxRectI {
        x1: a.x1.min(b.x1),
        y1: a.y1.min(b.y1),
        x2: a.x2.max(b.x2),
        y2: a.y2.max(b.y2),
    }
}

/// Map between pixels of a frame, or of a field of it, and those of the plate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PixelMap {
    /// Left edge of the format.
    left: i32,
    /// Number of rows of the field below the top edge of the format, counted from row 0.
    top: i32,
    field: Field,
}

impl PixelMap {
    /// Creates the map of a `field` of a frame with this `format`.
    pub(crate) fn new(format: OfxRectI, field: Field) -> Self {
        Self {
            left: format.x1,
            top: rows_below(format.y2, field),
            field,
        }
    }

    /// Returns the plate pixels of a rectangle of the frame: of a field, its own rows.
    pub(crate) fn rectangle(&self, rect: OfxRectI) -> Rectangle {
        let bottom = rows_below(rect.y1, self.field);
        let top = rows_below(rect.y2, self.field);
        Rectangle {
            x: rect.x1 - self.left,
            y: self.top - top,
            width: (rect.x2 - rect.x1).max(0) as usize,
            height: (top - bottom).max(0) as usize,
        }
    }

    /// Returns the frame pixel of plate pixel (`x`, `y`).
    pub(crate) fn frame_pixel(&self, x: i32, y: i32) -> (i32, i32) {
        let row = self.top - 1 - y;
        let frame_row = match self.field {
            Field::Whole => row,
            Field::Lower => 2 * row,
            Field::Upper => 2 * row + 1,
        };
        (x + self.left, frame_row)
    }
}

/// Returns the number of rows of `field` below row `y` of the frame, counted from row 0.
fn rows_below(y: i32, field: Field) -> i32 {
    match field {
        Field::Whole => y,
        Field::Lower => (y + 1).div_euclid(2),
        Field::Upper => y.div_euclid(2),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rect(x1: i32, y1: i32, x2: i32, y2: i32) -> OfxRectI {
        OfxRectI { x1, y1, x2, y2 }
    }

    #[test]
    fn proxies_and_wide_pixels_follow_scale_and_aspect() {
        let scale = Scale::new([0.5, 0.5], 2.0);
        assert_eq!((scale.x, scale.y), (0.25, 0.5));
        let all = OfxRectD {
            x1: 0.0,
            y1: -10.0,
            x2: 1001.0,
            y2: 540.0,
        };
        assert_eq!(scale.pixels_of(all), rect(0, -5, 251, 270));
        // Invalid scales count as 1, and infinite regions have an end.
        assert_eq!(Scale::new([0.0, f64::NAN], 1.0).x, 1.0);
        let infinite = OfxRectD {
            x1: -1e300,
            y1: f64::NEG_INFINITY,
            x2: f64::INFINITY,
            y2: 1e300,
        };
        assert_eq!(
            scale.pixels_of(infinite),
            rect(-8_000_000, -8_000_000, 8_000_000, 8_000_000)
        );
    }

    #[test]
    fn regions_in_pixels_of_a_proxy_are_recognised_by_the_image() {
        let half = Scale::new([0.5, 0.5], 2.0);
        let region = |x2, y2| OfxRectD {
            x2,
            y2,
            ..OfxRectD::default()
        };
        let image = rect(0, 0, 100, 80);
        // Canonical, as the standard says, and of a part of the image.
        assert_eq!(half.of_regions(region(400.0, 160.0), image, 2.0), half);
        let part = rect(10, 0, 40, 80);
        assert_eq!(half.of_regions(region(400.0, 160.0), part, 2.0), half);
        // In pixels of the render, with the aspect alone.
        let pixels = half.of_regions(region(200.0, 80.0), image, 2.0);
        assert_eq!((pixels.x, pixels.y), (0.5, 1.0));
    }

    #[test]
    fn plate_rows_run_down_from_the_top_of_the_format() {
        let map = PixelMap::new(rect(10, 0, 110, 50), Field::Whole);
        let part = map.rectangle(rect(10, 40, 20, 52));
        let expected = Rectangle {
            x: 0,
            y: -2,
            width: 10,
            height: 12,
        };
        assert_eq!(part, expected);
        assert_eq!(map.frame_pixel(0, -2), (10, 51));
        assert_eq!(map.frame_pixel(9, 9), (19, 40));
    }

    #[test]
    fn fields_take_every_other_row_from_the_top_down() {
        let rows = |field, bounds: OfxRectI| {
            let map = PixelMap::new(rect(0, 0, 4, 9), field);
            let rows = map.rectangle(bounds).rows();
            rows.map(|y| map.frame_pixel(0, y).1).collect::<Vec<_>>()
        };
        let bounds = rect(0, 3, 4, 9);
        assert_eq!(rows(Field::Whole, bounds), [8, 7, 6, 5, 4, 3]);
        assert_eq!(rows(Field::Lower, bounds), [8, 6, 4]);
        assert_eq!(rows(Field::Upper, bounds), [7, 5, 3]);
        assert!(rows(Field::Upper, rect(0, 2, 4, 3)).is_empty());
    }

    #[test]
    fn fields_share_the_rows_of_a_frame() {
        for (y1, y2) in [(0, 10), (-3, 4), (1, 2), (-7, -2)] {
            let frame = rect(0, y1, 1, y2);
            let mut rows = Vec::new();
            for field in [Field::Lower, Field::Upper] {
                let map = PixelMap::new(frame, field);
                let own = map.rectangle(frame).rows();
                rows.extend(own.map(|y| map.frame_pixel(0, y).1));
            }
            rows.sort_unstable();
            assert_eq!(rows, (y1..y2).collect::<Vec<_>>());
        }
    }
}
