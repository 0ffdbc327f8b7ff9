//! Frame pixels, and the field coordinates in which the lens model is polynomial.

use crate::error::{Error, Result};

/// A position in frame pixels: x right, y down, (0, 0) at the outer corner of the top-left pixel.
///
/// The centre of the pixel in column c and row r is (c + 0.5, r + 0.5).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImagePoint {
    /// Pixels to the right of the frame's left edge.
    pub x_px: f64,
    /// Pixels below the frame's top edge.
    pub y_px: f64,
}

impl ImagePoint {
    /// Creates the point (`x_px`, `y_px`).
    pub const fn new(x_px: f64, y_px: f64) -> Self {
        Self { x_px, y_px }
    }
}

/// A field position: offset from the optical axis in half frame widths, x right and y down.
///
/// This is the X-frame of the model: the point where the unaberrated chief ray meets the sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldPoint {
    /// Half frame widths to the right of the optical axis.
    pub x: f64,
    /// Half frame widths below the optical axis.
    pub y: f64,
}

impl FieldPoint {
    /// Creates the field point (`x`, `y`), in half frame widths from the axis.
    pub const fn new(x: f64, y: f64) -> Self {
        Self { x, y }
    }

    /// Returns the distance h from the axis, in half frame widths.
    pub fn radius(self) -> f64 {
        self.x.hypot(self.y)
    }

    /// Returns the meridional (radial) direction; on the axis, where any is valid, the x direction.
    pub fn meridian(self) -> Meridian {
        let h = self.radius();
        if h > 0.0 {
            Meridian {
                cos: self.x / h,
                sin: self.y / h,
            }
        } else {
            Meridian { cos: 1.0, sin: 0.0 }
        }
    }
}

/// The direction of the meridional plane in the image: the unit vector (cos, sin) away from the axis.
///
/// An image offset (i, j) has the radial part r = cos i + sin j and the sagittal part t = -sin i + cos j.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Meridian {
    /// Component along image x.
    pub cos: f64,
    /// Component along image y.
    pub sin: f64,
}

impl Meridian {
    /// The meridian along image x.
    pub const X: Self = Self { cos: 1.0, sin: 0.0 };

    /// Returns the inverse rotation, from meridional offsets back to image offsets.
    #[must_use]
    pub fn inverse(self) -> Self {
        Self {
            cos: self.cos,
            sin: -self.sin,
        }
    }
}

/// The full frame of a camera: its size in pixels and the position of the optical axis.
///
/// ```
/// use seidel_optics::field::{Frame, ImagePoint};
///
/// let frame = Frame::new(1920, 1080, None)?; // axis at the centre
/// let corner = frame.field_point(ImagePoint::new(0.0, 0.0));
/// assert_eq!((corner.x, corner.y), (-1.0, -0.5625)); // in half frame widths
/// # Ok::<(), seidel_optics::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    width_px: u32,
    height_px: u32,
    axis: ImagePoint,
}

impl Frame {
    /// Creates a frame of `width_px` x `height_px` with its optical axis at `axis`, or at the centre if `None`.
    ///
    /// # Errors
    /// Rejects a zero size, and an axis that is not finite or lies more than one frame size outside.
    pub fn new(width_px: u32, height_px: u32, axis: Option<ImagePoint>) -> Result<Self> {
        if width_px == 0 || height_px == 0 {
            return Err(Error::new(
                "image_size",
                format!("is {width_px} x {height_px}"),
                "give the width and height of the full frame in pixels, both at least 1",
            ));
        }
        let (w, h) = (f64::from(width_px), f64::from(height_px));
        let axis = axis.unwrap_or(ImagePoint::new(w / 2.0, h / 2.0));
        let near = |v: f64, size: f64| v.is_finite() && v > -size && v < 2.0 * size;
        if !near(axis.x_px, w) || !near(axis.y_px, h) {
            return Err(Error::new(
                "optical_axis",
                format!("is ({}, {})", axis.x_px, axis.y_px),
                format!(
                    "give it in pixels of the {width_px} x {height_px} frame, or leave it out for the centre"
                ),
            ));
        }
        Ok(Self {
            width_px,
            height_px,
            axis,
        })
    }

    /// Width of the full frame, pixels.
    pub fn width_px(&self) -> u32 {
        self.width_px
    }

    /// Height of the full frame, pixels.
    pub fn height_px(&self) -> u32 {
        self.height_px
    }

    /// Position of the optical axis, frame pixels.
    pub fn axis(&self) -> ImagePoint {
        self.axis
    }

    /// Returns the same frame with its axis at `axis`.
    ///
    /// # Errors
    /// As [`Frame::new`].
    pub fn with_axis(&self, axis: ImagePoint) -> Result<Self> {
        Self::new(self.width_px, self.height_px, Some(axis))
    }

    /// Returns the same frame with its axis at `axis`, which a fit found.
    ///
    /// # Errors
    /// An axis that is not finite or lies more than one frame size outside; the remedy is to state it.
    pub fn with_estimated_axis(&self, axis: ImagePoint) -> Result<Self> {
        self.with_axis(axis).map_err(|_| {
            Error::new(
                "optical_axis",
                format!(
                    "is estimated at ({:.1}, {:.1}), far outside of the {} x {} frame",
                    axis.x_px, axis.y_px, self.width_px, self.height_px
                ),
                "state it, such as the centre of the frame: these PSFs do not show it",
            )
        })
    }

    /// Half the frame's width in pixels: the unit of field coordinates.
    pub fn half_width_px(&self) -> f64 {
        f64::from(self.width_px) / 2.0
    }

    /// Converts frame pixels to field coordinates.
    pub fn field_point(&self, at: ImagePoint) -> FieldPoint {
        let unit = self.half_width_px();
        FieldPoint::new(
            (at.x_px - self.axis.x_px) / unit,
            (at.y_px - self.axis.y_px) / unit,
        )
    }

    /// Converts field coordinates to frame pixels.
    pub fn image_point(&self, at: FieldPoint) -> ImagePoint {
        let unit = self.half_width_px();
        ImagePoint::new(self.axis.x_px + at.x * unit, self.axis.y_px + at.y * unit)
    }

    /// Returns the field radius of the corner farthest from the axis, half frame widths.
    pub fn corner_radius(&self) -> f64 {
        let (w, h) = (f64::from(self.width_px), f64::from(self.height_px));
        [(0.0, 0.0), (w, 0.0), (0.0, h), (w, h)]
            .into_iter()
            .map(|(x, y)| self.field_point(ImagePoint::new(x, y)).radius())
            .fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn field_and_image_points_are_inverse() {
        let frame = Frame::new(3000, 2000, Some(ImagePoint::new(1490.0, 1010.0))).expect("valid");
        let at = ImagePoint::new(12.5, 1987.25);
        let back = frame.image_point(frame.field_point(at));
        assert!((back.x_px - at.x_px).abs() < 1e-9 && (back.y_px - at.y_px).abs() < 1e-9);
        assert_eq!(frame.field_point(frame.axis()), FieldPoint::new(0.0, 0.0));
        assert_eq!(frame.field_point(frame.axis()).meridian(), Meridian::X);
    }

    #[test]
    fn invalid_frames_are_rejected() {
        assert!(Frame::new(0, 10, None).is_err());
        assert!(Frame::new(10, 10, Some(ImagePoint::new(f64::NAN, 1.0))).is_err());
        assert!(Frame::new(10, 10, Some(ImagePoint::new(500.0, 1.0))).is_err());
        // A user cannot leave out what the fit estimated.
        let frame = Frame::new(10, 10, None).expect("valid");
        let error = frame.with_estimated_axis(ImagePoint::new(500.0, 1.0));
        let error = error.expect_err("far outside").to_string();
        assert!(
            error.contains("estimated") && !error.contains("leave it out"),
            "{error}"
        );
    }
}
