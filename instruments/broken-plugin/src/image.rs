//! Images of the host, released when dropped.

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;

use crate::api::{Effect, PropertySet, string};
use crate::faults::Fault;

/// An image of floats or bytes.
pub(crate) struct Image<'a> {
    properties: PropertySet<'a>,
    data: usize,
    row_bytes: isize,
    /// x1, y1, x2, y2.
    pub(crate) bounds: [i32; 4],
    pub(crate) channels: usize,
    is_bytes: bool,
    fault: Fault,
    /// Number of releases; 1 without faults.
    releases: usize,
}

impl Drop for Image<'_> {
    fn drop(&mut self) {
        if let Some(release) = self.properties.suites.effect.clipReleaseImage {
            for _ in 0..self.releases {
                // SAFETY: the handle is that of the image.
                unsafe { release(self.properties.handle) };
            }
        }
    }
}

/// The reason why an image cannot be read.
pub(crate) enum ImageError {
    /// There is no image; it counts as black.
    Missing,
    /// The image has a format that the plugin does not support.
    Unsupported,
}

impl<'a> Image<'a> {
    /// Fetches an image.
    pub(crate) fn fetch(
        effect: Effect<'a>,
        clip: &std::ffi::CStr,
        time: f64,
        fault: Fault,
    ) -> Result<Self, ImageError> {
        let suites = effect.suites;
        let clip = effect.clip(clip).ok_or(ImageError::Missing)?;
        let get = suites.effect.clipGetImage.ok_or(ImageError::Unsupported)?;
        let mut handle = std::ptr::null_mut();
        // SAFETY: memory for a handle; the region is optional.
        let status = unsafe { get(clip.handle, time, std::ptr::null(), &raw mut handle) };
        if status != kOfxStatOK || handle.is_null() {
            return Err(ImageError::Missing);
        }
        let properties = PropertySet { suites, handle };
        let mut image = Image {
            properties,
            data: 0,
            row_bytes: 0,
            bounds: [0; 4],
            channels: 0,
            is_bytes: false,
            fault,
            releases: 1,
        };
        let Some(data) = properties.non_null(kOfxImagePropData) else {
            if fault == Fault::ReadsNullData {
                // SAFETY: none; this is the fault.
                unsafe { std::ptr::read_volatile(std::ptr::null::<f32>()) };
            }
            return Err(ImageError::Missing);
        };
        let kept = (fault == Fault::KeepsString)
            .then(|| properties.raw_string(kOfxImageEffectPropComponents, 0));
        let bounds = properties
            .ints::<4>(kOfxImagePropBounds)
            .ok_or(ImageError::Unsupported)?;
        let components = match kept {
            // SAFETY: the test host frees no string, but the contents are no longer valid; this is the fault.
            Some(kept) => kept.map(|text| unsafe { string(text) }),
            None => properties.string(kOfxImageEffectPropComponents),
        };
        let depth = properties.string(kOfxImageEffectPropPixelDepth);
        match depth.as_deref() {
            Some("OfxBitDepthByte") if fault.takes_bytes() => image.is_bytes = true,
            Some("OfxBitDepthFloat") if fault.takes_floats() => {}
            _ if fault == Fault::IgnoresBitDepth => {}
            _ => return Err(ImageError::Unsupported),
        }
        image.channels = match components.as_deref() {
            Some("OfxImageComponentAlpha") => 1,
            Some("OfxImageComponentRGB") => 3,
            Some("OfxImageComponentRGBA") => 4,
            _ => return Err(ImageError::Unsupported),
        };
        image.bounds = bounds;
        image.data = data as usize;
        let row_bytes = properties
            .int(kOfxImagePropRowBytes, 0)
            .ok_or(ImageError::Unsupported)?;
        image.row_bytes = row_bytes as isize;
        if fault == Fault::IgnoresNegativeRows && row_bytes < 0 {
            let rows = (bounds[3] - bounds[1] - 1).max(0) as isize;
            image.data = data as usize - (rows * -image.row_bytes) as usize;
            image.row_bytes = -image.row_bytes;
        }
        Ok(image)
    }

    fn sample_bytes(&self) -> usize {
        if self.is_bytes { 1 } else { 4 }
    }

    /// Sets how often it is released.
    pub(crate) fn with_release_fault(mut self, fault: Fault) -> Self {
        self.releases = match fault {
            Fault::UnreleasedImage => 0,
            Fault::DoubleRelease => 2,
            _ => 1,
        };
        self
    }

    fn pixel(&self, x: i32, y: i32) -> Option<*mut u8> {
        let [x1, y1, x2, y2] = self.bounds;
        if x < x1 || x >= x2 || y < y1 || y >= y2 {
            return None;
        }
        let row = (y - y1) as isize * self.row_bytes;
        let column = ((x - x1) as usize * self.channels * self.sample_bytes()) as isize;
        Some((self.data as isize + row + column) as *mut u8)
    }

    /// Returns whether it has the pixel.
    pub(crate) fn contains(&self, x: i32, y: i32) -> bool {
        self.pixel(x, y).is_some()
    }

    /// Returns a sample; 0 outside the bounds.
    pub(crate) fn get(&self, x: i32, y: i32, channel: usize) -> f32 {
        match self.pixel(x, y) {
            // SAFETY: inside the image, and the channel is one of its channels.
            Some(pixel) if self.is_bytes => f32::from(unsafe { pixel.add(channel).read() }) / 255.0,
            // SAFETY: as above.
            Some(pixel) => unsafe { pixel.cast::<f32>().add(channel).read_unaligned() },
            None => 0.0,
        }
    }

    /// Writes a sample, unless the pixel is outside the bounds.
    pub(crate) fn set(&self, x: i32, y: i32, channel: usize, value: f32) {
        let Some(pixel) = self.pixel(x, y) else {
            return;
        };
        if self.is_bytes {
            let step = match self.fault {
                Fault::CoarseBytes => 8.0,
                _ => 1.0,
            };
            let byte = ((value.clamp(0.0, 1.0) * 255.0 / step).round() * step) as u8;
            // SAFETY: as above; no two threads write the same row.
            unsafe { pixel.add(channel).write(byte) };
        } else {
            // SAFETY: as above.
            unsafe { pixel.cast::<f32>().add(channel).write_unaligned(value) };
        }
    }
}
