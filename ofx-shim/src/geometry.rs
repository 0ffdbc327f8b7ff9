//! From the host's coordinates to the plate's.
//!
//! Parameters and regions are canonical: square pixels, full scale, y up. Pictures are in pixels, y up. Plates have
//! y down and (0, 0) at the top-left corner of the format, as `seidel apply` counts them.

use std::ffi::c_void;

use seidel_c::{SEIDEL_FLOAT, SEIDEL_HALF, SeidelImage, SeidelRect};

use crate::host::Image;
use crate::sys::{OfxRectD, OfxRectI};

/// How pixels of a render lie among canonical coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scale {
    /// Pixels per canonical unit along x.
    pub(crate) x: f64,
    /// The same along y.
    pub(crate) y: f64,
}

/// What of a frame is worked on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Field {
    /// All of it.
    Whole,
    /// Even rows, counted from the bottom.
    Lower,
    /// Odd rows.
    Upper,
}

/// How far from whole a coordinate may be and still be meant so.
const SLACK: f64 = 1e-4;

impl Scale {
    /// That of a render at `render` scale with pixels `aspect` times as wide as high.
    pub(crate) fn new(render: [f64; 2], aspect: f64) -> Self {
        let sane = |scale: f64| {
            if scale.is_finite() && scale > 0.0 {
                scale
            } else {
                1.0
            }
        };
        Self {
            x: sane(render[0]) / aspect,
            y: sane(render[1]),
        }
    }

    /// The pixels that a canonical rectangle touches.
    pub(crate) fn pixels_of(&self, rect: OfxRectD) -> OfxRectI {
        // Hosts have endless regions: no number beyond what a plate can have.
        let bound = |value: f64| value.clamp(-8e6, 8e6);
        OfxRectI {
            x1: bound((rect.x1 * self.x + SLACK).floor()) as i32,
            y1: bound((rect.y1 * self.y + SLACK).floor()) as i32,
            x2: bound((rect.x2 * self.x - SLACK).ceil()) as i32,
            y2: bound((rect.y2 * self.y - SLACK).ceil()) as i32,
        }
    }

    /// The scale by which a host counts regions, told by the `region` of an input whose picture has the pixels
    /// `bounds`: that of the render, as it ought to be; or none, where it says regions in pixels of the render, as MLT
    /// does for previews. `aspect` is that of the pixels.
    pub(crate) fn of_regions(self, region: OfxRectD, bounds: OfxRectI, aspect: f64) -> Self {
        let pixels = Self::new([1.0; 2], aspect);
        match self.pixels_of(region) != bounds && pixels.pixels_of(region) == bounds {
            true => pixels,
            false => self,
        }
    }
}

/// Whether a rectangle has no pixel.
pub(crate) fn is_empty(rect: OfxRectI) -> bool {
    rect.x2 <= rect.x1 || rect.y2 <= rect.y1
}

/// What lies in both.
pub(crate) fn meet(a: OfxRectI, b: OfxRectI) -> OfxRectI {
    OfxRectI {
        x1: a.x1.max(b.x1),
        y1: a.y1.max(b.y1),
        x2: a.x2.min(b.x2),
        y2: a.y2.min(b.y2),
    }
}

/// How pixels of a frame, or of a field of it, become those of a plate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Plane {
    /// Left edge of the format.
    left: i32,
    /// Top edge of the format: the first row beyond it.
    top: i32,
    field: Field,
}

impl Plane {
    /// That of a frame with this format.
    pub(crate) fn new(format: OfxRectI, field: Field) -> Self {
        Self {
            left: format.x1,
            top: row_in(format.y2, field),
            field,
        }
    }

    /// A rectangle as the plate has it; of a field, its rows alone.
    pub(crate) fn rect(&self, rect: OfxRectI) -> SeidelRect {
        let (y1, y2) = (row_in(rect.y1, self.field), row_in(rect.y2, self.field));
        SeidelRect {
            left: rect.x1 - self.left,
            top: self.top - y2,
            width: rect.x2 - rect.x1,
            height: y2 - y1,
        }
    }

    /// A picture as the plate has it: its rows from the top down, without a copy. `channels` of it from `first` on.
    /// Nothing where the field has no row in it.
    pub(crate) fn image(&self, image: &Image, first: u32, channels: u32) -> Option<SeidelImage> {
        let sample = if image.half {
            SEIDEL_HALF
        } else {
            SEIDEL_FLOAT
        };
        let bytes = if image.half { 2 } else { 4 };
        let data = image.data.cast::<u8>();
        self.view(
            (data.cast(), image.bounds),
            (image.row_bytes, image.pixel_bytes() as u32),
            (sample, bytes * first, channels),
        )
    }

    /// The same of samples at an address.
    pub(crate) fn view(
        &self,
        (data, bounds): (*mut c_void, OfxRectI),
        (row_bytes, pixel_bytes): (i64, u32),
        (sample, offset, channels): (u32, u32, u32),
    ) -> Option<SeidelImage> {
        let rect = self.rect(bounds);
        if rect.width <= 0 || rect.height <= 0 {
            return None;
        }
        let step = match self.field {
            Field::Whole => 1,
            Field::Lower | Field::Upper => 2,
        };
        // The topmost row of those that count, from the bottom of the picture.
        let top_row = i64::from(last_row(bounds.y2, self.field) - bounds.y1);
        let first = data.cast::<u8>();
        let first = first.wrapping_offset((top_row * row_bytes) as isize + offset as isize);
        Some(SeidelImage {
            size: size_of::<SeidelImage>() as u64,
            data: first.cast(),
            row_bytes: -step * row_bytes,
            pixel_bytes,
            channels,
            sample,
            reserved: 0,
            rect,
        })
    }
}

/// How many rows of a field lie below row `y` of the frame, counted from row 0.
fn row_in(y: i32, field: Field) -> i32 {
    match field {
        Field::Whole => y,
        // Rows 0, 2, 4...: those below y.
        Field::Lower => (y + 1).div_euclid(2),
        // Rows 1, 3, 5...
        Field::Upper => y.div_euclid(2),
    }
}

/// The last row of a field below row `end` of the frame.
fn last_row(end: i32, field: Field) -> i32 {
    match field {
        Field::Whole => end - 1,
        Field::Lower => 2 * (row_in(end, field) - 1),
        Field::Upper => 2 * (row_in(end, field) - 1) + 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rect(x1: i32, y1: i32, x2: i32, y2: i32) -> OfxRectI {
        OfxRectI { x1, y1, x2, y2 }
    }

    #[test]
    fn proxies_and_wide_pixels_go_by_scale_and_aspect() {
        let scale = Scale::new([0.5, 0.5], 2.0);
        assert_eq!((scale.x, scale.y), (0.25, 0.5));
        let all = OfxRectD {
            x1: 0.0,
            y1: -10.0,
            x2: 1001.0,
            y2: 540.0,
        };
        assert_eq!(scale.pixels_of(all), rect(0, -5, 251, 270));
        // Bad scales count as none; endless regions have an end.
        assert_eq!(Scale::new([0.0, f64::NAN], 1.0).x, 1.0);
        let endless = OfxRectD {
            x1: -1e300,
            y1: f64::NEG_INFINITY,
            x2: f64::INFINITY,
            y2: 1e300,
        };
        assert_eq!(
            scale.pixels_of(endless),
            rect(-8_000_000, -8_000_000, 8_000_000, 8_000_000)
        );
    }

    #[test]
    fn regions_in_pixels_of_a_proxy_are_told_by_the_picture() {
        let half = Scale::new([0.5, 0.5], 2.0);
        let region = |x2, y2| OfxRectD {
            x2,
            y2,
            ..OfxRectD::default()
        };
        let picture = rect(0, 0, 100, 80);
        // Canonical, as it ought to be, and for a part of the picture.
        assert_eq!(half.of_regions(region(400.0, 160.0), picture, 2.0), half);
        let part = rect(10, 0, 40, 80);
        assert_eq!(half.of_regions(region(400.0, 160.0), part, 2.0), half);
        // In pixels of the render, with the aspect alone.
        let pixels = half.of_regions(region(200.0, 80.0), picture, 2.0);
        assert_eq!((pixels.x, pixels.y), (0.5, 1.0));
    }

    #[test]
    fn rows_run_down_from_the_top_of_the_format() {
        let plane = Plane::new(rect(10, 0, 110, 50), Field::Whole);
        let part = plane.rect(rect(10, 40, 20, 52));
        assert_eq!(
            (part.left, part.top, part.width, part.height),
            (0, -2, 10, 12)
        );
    }

    #[test]
    fn views_begin_at_the_top_row_whatever_the_order_of_rows() {
        let mut samples = [0.0_f32; 4 * 6];
        for (index, sample) in samples.iter_mut().enumerate() {
            *sample = (index / 4) as f32;
        }
        let bounds = rect(0, 3, 4, 9);
        let data: *mut c_void = samples.as_mut_ptr().cast();
        let first = |field, data, row_bytes| {
            let plane = Plane::new(rect(0, 0, 4, 9), field);
            let view = plane.view((data, bounds), (row_bytes, 4), (SEIDEL_FLOAT, 0, 1));
            let view = view.expect("rows");
            // SAFETY: within the samples.
            let value = unsafe { view.data.cast::<f32>().read() };
            (value, view.row_bytes, view.rect.top, view.rect.height)
        };
        assert_eq!(first(Field::Whole, data, 16), (5.0, -16, 0, 6));
        // Frame rows 3 to 8: lower are 4, 6, 8, upper 3, 5, 7.
        assert_eq!(first(Field::Lower, data, 16), (5.0, -32, 0, 3));
        assert_eq!(first(Field::Upper, data, 16), (4.0, -32, 0, 3));
        // The same from the top down: the bottom row comes last in memory.
        let bottom = samples[20..].as_mut_ptr().cast();
        assert_eq!(first(Field::Whole, bottom, -16), (0.0, 16, 0, 6));
        let plane = Plane::new(rect(0, 0, 4, 9), Field::Upper);
        let none = plane.view((data, rect(0, 2, 4, 3)), (16, 4), (SEIDEL_FLOAT, 0, 1));
        assert!(none.is_none());
    }

    #[test]
    fn fields_share_the_rows_of_a_frame() {
        for (y1, y2) in [(0, 10), (-3, 4), (1, 2), (-7, -2)] {
            let of = |field| row_in(y2, field) - row_in(y1, field);
            assert_eq!(of(Field::Lower) + of(Field::Upper), y2 - y1);
            for field in [Field::Lower, Field::Upper] {
                let last = last_row(y2, field);
                assert!(last < y2 && last >= y2 - 2);
                assert_eq!(last.rem_euclid(2), i32::from(field == Field::Upper));
            }
        }
    }
}
