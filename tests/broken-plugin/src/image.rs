//! Images of the host, given back when they go.

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;

use crate::api::{Effect, Set};
use crate::faults::Fault;

/// An image with its pixels.
pub(crate) struct Image<'a> {
    set: Set<'a>,
    data: usize,
    row_bytes: isize,
    /// x1, y1, x2, y2.
    pub(crate) bounds: [i32; 4],
    pub(crate) channels: usize,
    releases: usize,
}

impl Drop for Image<'_> {
    fn drop(&mut self) {
        if let Some(release) = self.set.suites.effect.clipReleaseImage {
            for _ in 0..self.releases {
                // SAFETY: the handle came with the image.
                unsafe { release(self.set.handle) };
            }
        }
    }
}

/// Why there is no image.
pub(crate) enum Missing {
    /// There is none: as if it were black.
    Empty,
    /// There is one that cannot be used.
    Unusable,
}

impl<'a> Image<'a> {
    pub(crate) fn of(
        effect: Effect<'a>,
        clip: &std::ffi::CStr,
        time: f64,
        fault: Fault,
    ) -> Result<Self, Missing> {
        let suites = effect.suites;
        let (clip, _) = effect.clip(clip).ok_or(Missing::Empty)?;
        let get = suites.effect.clipGetImage.ok_or(Missing::Unusable)?;
        let mut handle = std::ptr::null_mut();
        // SAFETY: room for a handle, no region.
        let got = unsafe { get(clip, time, std::ptr::null(), &raw mut handle) };
        if got != kOfxStatOK || handle.is_null() {
            return Err(Missing::Empty);
        }
        let set = Set { suites, handle };
        let mut image = Image {
            set,
            data: 0,
            row_bytes: 0,
            bounds: [0; 4],
            channels: 0,
            releases: 1,
        };
        let data = set
            .pointer(kOfxImagePropData)
            .unwrap_or(std::ptr::null_mut());
        if fault == Fault::NullData && data.is_null() {
            // SAFETY: it is not: this is the fault.
            unsafe { std::ptr::read_volatile(data.cast::<f32>()) };
        }
        if data.is_null() {
            return Err(Missing::Empty);
        }
        let kept =
            (fault == Fault::KeepsString).then(|| set.raw_text(kOfxImageEffectPropComponents));
        let bounds = set
            .ints::<4>(kOfxImagePropBounds)
            .ok_or(Missing::Unusable)?;
        let components = match kept {
            // SAFETY: the host keeps the bytes, but not what is in them: this is the fault.
            Some(kept) => kept.map(|at| unsafe { crate::api::text_at(at) }),
            None => set.text(kOfxImageEffectPropComponents),
        };
        let depth = set.text(kOfxImageEffectPropPixelDepth);
        let float = depth.is_some_and(|depth| depth == "OfxBitDepthFloat");
        if !float && fault != Fault::TakesAnySamples {
            return Err(Missing::Unusable);
        }
        image.channels = match components.as_deref() {
            Some("OfxImageComponentAlpha") => 1,
            Some("OfxImageComponentRGB") => 3,
            Some("OfxImageComponentRGBA") => 4,
            _ => return Err(Missing::Unusable),
        };
        image.bounds = bounds;
        image.data = data as usize;
        let row_bytes = set.int(kOfxImagePropRowBytes, 0).ok_or(Missing::Unusable)?;
        image.row_bytes = row_bytes as isize;
        if fault == Fault::NegativeRows && row_bytes < 0 {
            let rows = (bounds[3] - bounds[1] - 1).max(0) as isize;
            image.data = data as usize - (rows * -image.row_bytes) as usize;
            image.row_bytes = -image.row_bytes;
        }
        Ok(image)
    }

    /// What becomes of it in the end, for images of Source.
    pub(crate) fn with_fault(mut self, fault: Fault) -> Self {
        self.releases = match fault {
            Fault::UnreleasedImage => 0,
            Fault::DoubleRelease => 2,
            _ => 1,
        };
        self
    }

    fn at(&self, x: i32, y: i32) -> Option<*mut f32> {
        let [x1, y1, x2, y2] = self.bounds;
        if x < x1 || x >= x2 || y < y1 || y >= y2 {
            return None;
        }
        let row = (y - y1) as isize * self.row_bytes;
        let column = ((x - x1) as usize * self.channels * 4) as isize;
        Some((self.data as isize + row + column) as *mut f32)
    }

    /// Whether the pixel is there.
    pub(crate) fn has(&self, x: i32, y: i32) -> bool {
        self.at(x, y).is_some()
    }

    /// A sample, 0 outside.
    pub(crate) fn get(&self, x: i32, y: i32, channel: usize) -> f32 {
        match self.at(x, y) {
            // SAFETY: inside the image, of which the channel is one.
            Some(at) => unsafe { at.add(channel).read_unaligned() },
            None => 0.0,
        }
    }

    /// Writes a sample, if the pixel is there.
    pub(crate) fn put(&self, x: i32, y: i32, channel: usize, value: f32) {
        if let Some(at) = self.at(x, y) {
            // SAFETY: as above; no two threads write the same row.
            unsafe { at.add(channel).write_unaligned(value) };
        }
    }
}
