//! Where a plate lies in the lens's frame.

use crate::{PlateExtent, PlateMap};
use seidel_optics::field::{FieldPoint, Frame, ImagePoint};

/// A rectangle of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rectangle {
    /// Its first column.
    pub x: i32,
    /// Its first row.
    pub y: i32,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

/// A plate in the frame of a lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placed {
    /// Where its pixels lie in the lens's frame, or where pixels are not square in that of
    /// [`NonSquarePixelLens`](crate::NonSquarePixelLens).
    pub map: PlateMap,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Width of a pixel over its height.
    pub pixel_aspect: f64,
}

impl Placed {
    /// The plate whose pixels are `data` of a picture that is `display`, centre on centre with `frame`: the display
    /// window as wide as the frame, pixel aspect included, or at `scale` plate pixels per pixel of the frame, counted
    /// along y.
    pub fn new(
        frame: Frame,
        (display, data): (Rectangle, Rectangle),
        scale: Option<f64>,
        pixel_aspect: f64,
    ) -> Self {
        let square_width = display.width as f64 * pixel_aspect;
        let scale = scale.unwrap_or(square_width / f64::from(frame.width_px()));
        let corner = |size: f64, display_start: i32, display_size: usize, data_start: i32| {
            let from_centre =
                f64::from(data_start) - f64::from(display_start) - display_size as f64 / 2.0;
            size / 2.0 + from_centre / scale
        };
        let width = f64::from(frame.width_px()) / pixel_aspect;
        let height = f64::from(frame.height_px());
        let map = PlateMap {
            origin: ImagePoint::new(
                corner(width, display.x, display.width, data.x),
                corner(height, display.y, display.height, data.y),
            ),
            scale,
        };
        Self {
            map,
            width: data.width,
            height: data.height,
            pixel_aspect,
        }
    }

    /// As far as the size of kernels goes.
    pub fn extent(&self) -> PlateExtent {
        PlateExtent {
            map: self.map,
            width: self.width,
            height: self.height,
        }
    }

    /// Where the optical axis of `frame`, moved by `offset` plate pixels, meets the plate: plate pixels from the outer
    /// corner of its first pixel.
    pub fn axis(&self, frame: Frame, offset: (f64, f64)) -> ImagePoint {
        let axis = frame.image_point(FieldPoint::new(0.0, 0.0));
        let on_plate =
            |axis: f64, origin: f64, offset: f64| (axis - origin) * self.map.scale + offset;
        ImagePoint::new(
            on_plate(
                axis.x_px / self.pixel_aspect,
                self.map.origin.x_px,
                offset.0,
            ),
            on_plate(axis.y_px, self.map.origin.y_px, offset.1),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overscan_and_wide_pixels_keep_the_axis_where_it_is_in_the_picture() {
        let frame = Frame::new(300, 200, None).expect("a frame");
        let window = |x, y, width, height| Rectangle {
            x,
            y,
            width,
            height,
        };
        let display = window(10, 20, 150, 100);
        let data = window(0, 5, 170, 130);
        let placed = Placed::new(frame, (display, data), None, 1.0);
        assert_eq!(placed.map.scale, 0.5);
        assert_eq!(placed.axis(frame, (0.0, 0.0)), ImagePoint::new(85.0, 65.0));
        let corner = placed.map.frame_point(10, 15);
        assert_eq!(corner, ImagePoint::new(1.0, 1.0));
        // Half as many columns of twice the width.
        let wide = Placed::new(
            frame,
            (window(0, 0, 75, 100), window(0, 0, 75, 100)),
            None,
            2.0,
        );
        assert_eq!(wide.map.scale, 0.5);
        assert_eq!(wide.axis(frame, (1.0, 0.0)), ImagePoint::new(38.5, 50.0));
        let scaled = Placed::new(frame, (display, display), Some(2.0), 1.0);
        assert_eq!(scaled.map.origin, ImagePoint::new(112.5, 75.0));
    }
}
