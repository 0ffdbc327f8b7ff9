//! Images of clips, released when they are dropped.

use std::ffi::c_void;

use super::{Failure, Host, Result};
use crate::sys::clip::{
    ALPHA, COMPONENTS, DEPTH_FLOAT, DEPTH_HALF, IMAGE_BOUNDS, IMAGE_DATA, IMAGE_ROW_BYTES,
    PIXEL_ASPECT, PIXEL_DEPTH, PREMULTIPLICATION, RGB, RGBA, UNPREMULTIPLIED,
};
use crate::sys::plugin::STATUS_ERR_IMAGE_FORMAT;
use crate::sys::{Handle, OfxRectI};

/// An image in the host's memory.
pub(crate) struct Image<'h> {
    host: &'h Host,
    handle: Handle,
    /// Address of the bottom left pixel of the bounds.
    pub(super) data: *mut c_void,
    pub(crate) bounds: OfxRectI,
    /// Bytes from a row to the row above it.
    pub(super) row_bytes: i64,
    /// Number of channels: 1, 3 or 4.
    pub(crate) channels: u32,
    /// Whether samples are 16-bit instead of 32-bit floats.
    pub(super) half: bool,
    /// Width of a pixel over its height, if the host reports it.
    pub(crate) pixel_aspect: Option<f64>,
    /// Whether the host reports colour that is not multiplied by alpha.
    pub(crate) unpremultiplied: bool,
}

impl Drop for Image<'_> {
    fn drop(&mut self) {
        if let Some(release) = self.host.suites.effect.release_image {
            // SAFETY: the host's handle, released once.
            unsafe { release(self.handle) };
        }
    }
}

impl<'h> Image<'h> {
    /// Takes over the image of a handle; `None` if it has no samples.
    ///
    /// # Errors
    /// A sample type or components that the plugin does not support.
    pub(super) fn new(host: &'h Host, handle: Handle) -> Result<Option<Self>> {
        // Dropping this releases the image on every return.
        let mut image = Self {
            host,
            handle,
            data: std::ptr::null_mut(),
            bounds: OfxRectI::default(),
            row_bytes: 0,
            channels: 0,
            half: false,
            pixel_aspect: None,
            unpremultiplied: false,
        };
        let properties = host.property_set(handle);
        let (Some(data), Some([x1, y1, x2, y2])) = (
            properties.pointer(IMAGE_DATA),
            properties.ints(IMAGE_BOUNDS),
        ) else {
            return Ok(None);
        };
        if x2 <= x1 || y2 <= y1 {
            return Ok(None);
        }
        let components = properties.string(COMPONENTS, 0).unwrap_or_default();
        image.channels = match components.as_bytes() {
            name if name == RGBA.to_bytes() => 4,
            name if name == RGB.to_bytes() => 3,
            name if name == ALPHA.to_bytes() => 1,
            _ => {
                return Err(unsupported(
                    "components",
                    &components,
                    "RGBA, RGB and Alpha",
                ));
            }
        };
        let depth = properties.string(PIXEL_DEPTH, 0).unwrap_or_default();
        image.half = match depth.as_bytes() {
            name if name == DEPTH_FLOAT.to_bytes() => false,
            name if name == DEPTH_HALF.to_bytes() => true,
            _ => return Err(unsupported("sample type", &depth, "Float and Half")),
        };
        image.data = data;
        image.bounds = OfxRectI { x1, y1, x2, y2 };
        let packed = i64::from(x2 - x1) * image.pixel_bytes();
        let row_bytes = properties.int(IMAGE_ROW_BYTES, 0).map(i64::from);
        image.row_bytes = row_bytes.filter(|bytes| *bytes != 0).unwrap_or(packed);
        if host.is_mlt() && image.row_bytes > 0 {
            (image.data, image.row_bytes) = from_last_row(data, image.row_bytes, y2 - y1);
        }
        let aspect = properties.double(PIXEL_ASPECT, 0);
        image.pixel_aspect = aspect.filter(|aspect| aspect.is_finite() && *aspect > 0.0);
        image.unpremultiplied = properties.equals(PREMULTIPLICATION, UNPREMULTIPLIED);
        Ok(Some(image))
    }

    /// Returns the number of bytes per pixel.
    pub(super) fn pixel_bytes(&self) -> i64 {
        i64::from(self.channels) * if self.half { 2 } else { 4 }
    }
}

/// Returns the address of the last of `rows` rows in memory, and the bytes from it to the row before: MLT keeps rows from the top,
/// but with its property `mlt_origin` it calls the first of them the bottom one.
fn from_last_row(first: *mut c_void, row_bytes: i64, rows: i32) -> (*mut c_void, i64) {
    let to_last = i64::from(rows - 1) * row_bytes;
    (first.wrapping_byte_offset(to_last as isize), -row_bytes)
}

fn unsupported(property: &str, value: &str, supported: &str) -> Failure {
    Failure::new(
        STATUS_ERR_IMAGE_FORMAT,
        format!(
            "The host passed an image with {property} `{value}`. Seidel supports {supported}: convert the image first."
        ),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_from_the_top_begin_with_the_last() {
        let mut rows = [[1_u16; 4], [2; 4], [3; 4]];
        let row_bytes = size_of_val(&rows[0]) as i64;
        let (bottom, up) = from_last_row(rows.as_mut_ptr().cast(), row_bytes, 3);
        assert_eq!(bottom.cast(), rows[2].as_mut_ptr());
        assert_eq!(
            bottom.wrapping_byte_offset(2 * up as isize),
            rows.as_mut_ptr().cast()
        );
    }
}
