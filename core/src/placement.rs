//! The place of a plate in the frame of a lens.

use seidel_optics::error::{Error, Result};
use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
use seidel_render::{PlateExtent, PlateMap};

use crate::plate::{LensScale, PlateGeometry};

/// The frame of a lens, as plates are placed in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LensFrame {
    /// The full frame and its optical axis.
    pub frame: Frame,
    /// Factor by which the image is narrower than the scene: 1 for a spherical lens, 2 for a 2x anamorphic one.
    pub squeeze: f64,
    /// Pitch of the frame's pixels, micrometres, if known.
    pub pixel_pitch_um: Option<f64>,
}

/// The place of a plate in the frame of a lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlatePlacement {
    /// Map from plate pixels to the lens's frame; where pixels are not square, to that of
    /// [`NonSquarePixelLens`](seidel_render::NonSquarePixelLens).
    pub map: PlateMap,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Width of a pixel over its height in the scene.
    pub pixel_aspect: f64,
    /// Size and map of the plate before it was expanded.
    pub extent: PlateExtent,
    /// Width of a pixel over its height on the sensor; less than [`Self::pixel_aspect`] by the squeeze of the lens.
    pub sensor_aspect: f64,
}

impl PlatePlacement {
    /// Places a plate of `geometry` centre on centre with the frame of a lens.
    ///
    /// Plates of an anamorphic lens with square pixels are either desqueezed, or squeezed and not marked so.
    /// They count as squeezed if their shape is nearer to that of the frame than to that of the desqueezed frame.
    ///
    /// # Errors
    /// Those of [`PlateGeometry::check`], and a film back for a lens of unknown pixel pitch.
    pub fn new(lens: LensFrame, geometry: &PlateGeometry) -> Result<Self> {
        geometry.check()?;
        let LensFrame {
            frame,
            squeeze,
            pixel_pitch_um,
        } = lens;
        let PlateGeometry {
            display,
            data,
            lens_scale,
            ..
        } = *geometry;
        let sensor_aspect = sensor_aspect(frame, squeeze, geometry);
        let square_width = display.width as f64 * sensor_aspect;
        let scale = match lens_scale {
            LensScale::FrameWidth => square_width / f64::from(frame.width_px()),
            LensScale::PixelRatio(ratio) => ratio,
            LensScale::FilmBack(width_mm) => {
                let pitch_um = pixel_pitch_um.ok_or_else(pitch_unknown)?;
                square_width / width_mm * pitch_um * 1e-3
            }
        };
        let corner = |size: f64, display_start: i32, display_size: usize, data_start: i32| {
            let from_centre =
                f64::from(data_start) - f64::from(display_start) - display_size as f64 / 2.0;
            size / 2.0 + from_centre / scale
        };
        let width = f64::from(frame.width_px()) / sensor_aspect;
        let height = f64::from(frame.height_px());
        let map = PlateMap {
            origin: ImagePoint::new(
                corner(width, display.x, display.width, data.x),
                corner(height, display.y, display.height, data.y),
            ),
            scale,
        };
        let (width, height) = (data.width, data.height);
        Ok(Self {
            map,
            width,
            height,
            extent: PlateExtent { map, width, height },
            pixel_aspect: sensor_aspect * squeeze,
            sensor_aspect,
        })
    }

    /// Returns the diagonal of the display window of `geometry` over that of the frame of `lens`, on the sensor.
    pub(crate) fn diagonal_share(&self, lens: LensFrame, geometry: &PlateGeometry) -> f64 {
        let (width, height) = (
            geometry.display.width as f64,
            geometry.display.height as f64,
        );
        let frame = lens.frame;
        let of_frame = f64::from(frame.width_px()).hypot(f64::from(frame.height_px()));
        (width * self.sensor_aspect).hypot(height) / self.map.scale / of_frame
    }

    /// Returns where the optical axis of `frame`, moved by `offset_px` plate pixels, meets the plate, in plate pixels from
    /// the outer corner of its first pixel.
    pub fn axis(&self, frame: Frame, offset_px: (f64, f64)) -> ImagePoint {
        let axis = frame.image_point(FieldPoint::new(0.0, 0.0));
        let on_plate =
            |axis: f64, origin: f64, offset: f64| (axis - origin) * self.map.scale + offset;
        ImagePoint::new(
            on_plate(
                axis.x_px / self.sensor_aspect,
                self.map.origin.x_px,
                offset_px.0,
            ),
            on_plate(axis.y_px, self.map.origin.y_px, offset_px.1),
        )
    }
}

fn pitch_unknown() -> Error {
    Error::new(
        "pixel_pitch_um",
        "is not known, so a film back has no size in the frame of the lens",
        "put the pixel pitch into the lens profile, or give the lens scale instead of the film back",
    )
}

/// Returns the width of a plate pixel over its height on the sensor; see [`PlatePlacement::new`].
fn sensor_aspect(frame: Frame, squeeze: f64, geometry: &PlateGeometry) -> f64 {
    let PlateGeometry {
        display,
        pixel_aspect,
        ..
    } = *geometry;
    let shape = |width: f64, height: f64| (width / height).ln();
    let plate = shape(display.width as f64, display.height as f64);
    let squeezed = shape(f64::from(frame.width_px()), f64::from(frame.height_px()));
    let desqueezed = squeezed + squeeze.ln();
    if pixel_aspect == 1.0 && (plate - squeezed).abs() < (plate - desqueezed).abs() {
        1.0
    } else {
        pixel_aspect / squeeze
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_optics::Rectangle;

    fn geometry(display: Rectangle, data: Rectangle, pixel_aspect: f64) -> PlateGeometry {
        PlateGeometry {
            display,
            data,
            pixel_aspect,
            lens_scale: LensScale::FrameWidth,
        }
    }

    fn place(frame: Frame, squeeze: f64, geometry: &PlateGeometry) -> PlatePlacement {
        let lens = LensFrame {
            frame,
            squeeze,
            pixel_pitch_um: Some(50.0),
        };
        PlatePlacement::new(lens, geometry).expect("a place")
    }

    #[test]
    fn rectangles_intersect_where_they_share_pixels() {
        let window = |x, y, width, height| Rectangle {
            x,
            y,
            width,
            height,
        };
        let all = window(-2, 3, 10, 4);
        assert_eq!((all.columns(), all.rows()), (-2..8, 3..7));
        assert!(all.contains(7, 6) && !all.contains(8, 6));
        let part = all.intersection(&window(5, 0, 9, 5));
        assert_eq!(part, Some(window(5, 3, 3, 2)));
        assert_eq!(all.intersection(&window(8, 3, 2, 2)), None);
    }

    #[test]
    fn overscan_and_pixel_aspect_leave_the_axis_in_place() {
        let frame = Frame::new(300, 200, None).expect("a frame");
        let window = |x, y, width, height| Rectangle {
            x,
            y,
            width,
            height,
        };
        let display = window(10, 20, 150, 100);
        let data = window(0, 5, 170, 130);
        let placed = place(frame, 1.0, &geometry(display, data, 1.0));
        assert_eq!(placed.map.scale, 0.5);
        assert_eq!(placed.axis(frame, (0.0, 0.0)), ImagePoint::new(85.0, 65.0));
        let corner = placed.map.frame_point(10, 15);
        assert_eq!(corner, ImagePoint::new(1.0, 1.0));
        // Half as many columns of twice the width.
        let wide = place(
            frame,
            1.0,
            &geometry(window(0, 0, 75, 100), window(0, 0, 75, 100), 2.0),
        );
        assert_eq!(wide.map.scale, 0.5);
        assert_eq!(wide.axis(frame, (1.0, 0.0)), ImagePoint::new(38.5, 50.0));
        let scaled = PlateGeometry {
            lens_scale: LensScale::PixelRatio(2.0),
            ..geometry(display, display, 1.0)
        };
        let scaled = place(frame, 1.0, &scaled);
        assert_eq!(scaled.map.origin, ImagePoint::new(112.5, 75.0));
    }

    #[test]
    fn a_film_back_shows_its_width_of_the_frame() {
        // 300 px of 50 µm are 15 mm wide.
        let frame = Frame::new(300, 200, None).expect("a frame");
        let all = Rectangle {
            x: 0,
            y: 0,
            width: 150,
            height: 100,
        };
        let of_width = |width_mm, pixel_aspect| PlateGeometry {
            lens_scale: LensScale::FilmBack(width_mm),
            ..geometry(all, all, pixel_aspect)
        };
        let scale = |width_mm| place(frame, 1.0, &of_width(width_mm, 1.0)).map.scale;
        assert_eq!((scale(15.0), scale(7.5), scale(30.0)), (0.5, 1.0, 0.25));
        let shares = [7.5, 15.0, 30.0].map(|width_mm| {
            let geometry = of_width(width_mm, 1.0);
            let lens = LensFrame {
                frame,
                squeeze: 1.0,
                pixel_pitch_um: Some(50.0),
            };
            place(frame, 1.0, &geometry).diagonal_share(lens, &geometry)
        });
        assert!((shares[0] - 0.5).abs() < 1e-12 && (shares[2] - 2.0).abs() < 1e-12);
        let crop = place(frame, 1.0, &of_width(7.5, 1.0));
        assert_eq!(crop.map.origin, ImagePoint::new(75.0, 50.0));
        // A squeezed plate shows the same width of the sensor.
        let squeezed = place(frame, 2.0, &of_width(15.0, 2.0));
        assert_eq!((squeezed.sensor_aspect, squeezed.map.scale), (1.0, 0.5));
        let unknown = LensFrame {
            frame,
            squeeze: 1.0,
            pixel_pitch_um: None,
        };
        let error = PlatePlacement::new(unknown, &of_width(15.0, 1.0)).expect_err("no pitch");
        assert!(error.to_string().contains("pixel_pitch_um"), "{error}");
        for width_mm in [0.0, -36.0, f64::NAN, f64::INFINITY] {
            let error = of_width(width_mm, 1.0).check().expect_err("no width");
            assert!(error.to_string().contains("film_back_mm"), "{error}");
        }
    }

    #[test]
    fn anamorphic_plates_are_placed_squeezed_or_desqueezed() {
        let frame = Frame::new(240, 200, None).expect("a frame");
        let placed = |width, pixel_aspect| {
            let all = Rectangle {
                x: 0,
                y: 0,
                width,
                height: 200,
            };
            place(frame, 2.0, &geometry(all, all, pixel_aspect))
        };
        let squeezed = placed(240, 2.0);
        assert_eq!((squeezed.sensor_aspect, squeezed.map.scale), (1.0, 1.0));
        // Not marked, but of the shape of the sensor.
        assert_eq!(placed(240, 1.0), squeezed);
        let desqueezed = placed(480, 1.0);
        assert_eq!(
            (desqueezed.pixel_aspect, desqueezed.sensor_aspect),
            (1.0, 0.5)
        );
        assert_eq!(desqueezed.map.scale, 1.0);
        assert_eq!(
            desqueezed.axis(frame, (0.0, 0.0)),
            ImagePoint::new(240.0, 100.0)
        );
    }
}
