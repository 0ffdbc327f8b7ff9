//! Pictures of clips, given back when they are let go.

use std::ffi::c_void;

use super::{Failure, Host, Props, Result};
use crate::sys::clip::{
    ALPHA, COMPONENTS, DEPTH_FLOAT, DEPTH_HALF, IMAGE_BOUNDS, IMAGE_DATA, IMAGE_ROW_BYTES,
    PIXEL_ASPECT, PIXEL_DEPTH, PREMULTIPLICATION, RGB, RGBA, UNPREMULTIPLIED,
};
use crate::sys::plugin::STATUS_ERR_IMAGE_FORMAT;
use crate::sys::{Handle, OfxRectI};

/// A picture of the host's.
pub(crate) struct Image<'h> {
    host: &'h Host,
    handle: Handle,
    /// First sample of the pixel at the bottom left of the bounds.
    pub(crate) data: *mut c_void,
    pub(crate) bounds: OfxRectI,
    /// Bytes from a row to the one above it.
    pub(crate) row_bytes: i64,
    /// 1, 3 or 4.
    pub(crate) channels: u32,
    /// Samples of 16 bits.
    pub(crate) half: bool,
    /// Where the host says it.
    pub(crate) pixel_aspect: Option<f64>,
    /// Whether the host says that colour is not multiplied by alpha.
    pub(crate) unpremultiplied: bool,
}

impl Drop for Image<'_> {
    fn drop(&mut self) {
        if let Some(release) = self.host.suites.effect.release_image {
            // SAFETY: the handle came of the host and is given back once.
            unsafe { release(self.handle) };
        }
    }
}

impl<'h> Image<'h> {
    /// The picture behind `handle`; nothing where it has no samples.
    pub(super) fn of(host: &'h Host, handle: Handle) -> Result<Option<Self>> {
        // From here on it is given back whatever comes.
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
        let props = Props::of(&host.suites.property, handle);
        let (Some(data), Some([x1, y1, x2, y2])) =
            (props.pointer(IMAGE_DATA), props.ints(IMAGE_BOUNDS))
        else {
            return Ok(None);
        };
        if x2 <= x1 || y2 <= y1 {
            return Ok(None);
        }
        let components = props.string(COMPONENTS, 0).unwrap_or_default();
        image.channels = match components.as_bytes() {
            name if name == RGBA.to_bytes() => 4,
            name if name == RGB.to_bytes() => 3,
            name if name == ALPHA.to_bytes() => 1,
            _ => return Err(other("channels", &components, "RGBA, RGB or Alpha")),
        };
        let depth = props.string(PIXEL_DEPTH, 0).unwrap_or_default();
        image.half = match depth.as_bytes() {
            name if name == DEPTH_FLOAT.to_bytes() => false,
            name if name == DEPTH_HALF.to_bytes() => true,
            _ => return Err(other("samples", &depth, "Float or Half")),
        };
        image.data = data;
        image.bounds = OfxRectI { x1, y1, x2, y2 };
        let packed = i64::from(x2 - x1) * image.pixel_bytes();
        let row_bytes = props.int(IMAGE_ROW_BYTES, 0).map(i64::from);
        image.row_bytes = row_bytes.filter(|bytes| *bytes != 0).unwrap_or(packed);
        let aspect = props.double(PIXEL_ASPECT, 0);
        image.pixel_aspect = aspect.filter(|aspect| aspect.is_finite() && *aspect > 0.0);
        image.unpremultiplied = props.is(PREMULTIPLICATION, UNPREMULTIPLIED);
        Ok(Some(image))
    }

    /// Bytes of a pixel.
    pub(crate) fn pixel_bytes(&self) -> i64 {
        i64::from(self.channels) * if self.half { 2 } else { 4 }
    }
}

fn other(what: &str, given: &str, wanted: &str) -> Failure {
    Failure::new(
        STATUS_ERR_IMAGE_FORMAT,
        format!(
            "The host handed in a picture whose {what} are `{given}`; Seidel works on {wanted}. Convert the picture first."
        ),
    )
}
