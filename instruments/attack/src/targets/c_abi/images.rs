//! Images between guard pages: any access beyond their samples ends the process.

use std::ffi::c_void;
use std::ptr::null_mut;

use half::f16;
use seidel_c::{SEIDEL_FLOAT, SEIDEL_HALF, SeidelImage, SeidelRect};

use crate::rng::Rng;

/// Byte of padding between samples, which no call may change.
const PADDING: u8 = 0xa5;

/// Bytes between two inaccessible pages, at the end or the beginning of the room between them.
pub(super) struct GuardedImage {
    mapping: *mut c_void,
    mapped: usize,
    data: *mut u8,
    length: usize,
    layout: Layout,
}

/// The shape of an image.
#[derive(Clone, Copy)]
pub(super) struct Layout {
    pub(super) rect: SeidelRect,
    pub(super) channels: usize,
    pub(super) is_half: bool,
    /// Bytes from pixel to pixel and from row to row.
    pub(super) pixel: usize,
    pub(super) row: usize,
    /// Whether rows are stored from the bottom up.
    pub(super) is_bottom_up: bool,
    /// Whether the image ends at a guard page, rather than begins at one.
    pub(super) is_at_end: bool,
}

impl Layout {
    /// Picks a shape for a rectangle of reasonable size.
    pub(super) fn random(rect: SeidelRect, channels: usize, rng: &mut Rng) -> Self {
        let is_half = rng.once_in(3);
        let sample = if is_half { 2 } else { 4 };
        let pixel = channels * sample + *rng.pick(&[0, 0, 1, 4]);
        let row = pixel * rect.width as usize + *rng.pick(&[0, 0, 3, 16]);
        Self {
            rect,
            channels,
            is_half,
            pixel,
            row,
            is_bottom_up: rng.once_in(4),
            is_at_end: rng.once_in(2),
        }
    }

    fn sample_bytes(&self) -> usize {
        if self.is_half { 2 } else { 4 }
    }

    /// Bytes from the first to the last sample.
    fn length(&self) -> usize {
        let (width, height) = (self.rect.width as usize, self.rect.height as usize);
        (height - 1) * self.row + (width - 1) * self.pixel + self.channels * self.sample_bytes()
    }

    /// Offsets of all samples.
    fn offsets(&self) -> impl Iterator<Item = usize> {
        let layout = *self;
        let rows = 0..layout.rect.height as usize;
        rows.flat_map(move |y| {
            (0..layout.rect.width as usize).flat_map(move |x| {
                let start = y * layout.row + x * layout.pixel;
                (0..layout.channels).map(move |k| start + k * layout.sample_bytes())
            })
        })
    }
}

impl GuardedImage {
    /// Maps an image and fills its samples.
    pub(super) fn new(layout: Layout, mut fill: impl FnMut(usize) -> f32) -> Self {
        // SAFETY: asks for a number only.
        let page = unsafe { libc::sysconf(libc::_SC_PAGESIZE) } as usize;
        let length = layout.length();
        let room = length.div_ceil(page) * page;
        let mapped = room + 2 * page;
        let flags = libc::MAP_PRIVATE | libc::MAP_ANONYMOUS;
        // SAFETY: a new mapping, of which the inner pages become accessible.
        let mapping = unsafe { libc::mmap(null_mut(), mapped, libc::PROT_NONE, flags, -1, 0) };
        assert_ne!(mapping, libc::MAP_FAILED, "the attack gets no memory");
        // SAFETY: within the mapping.
        let inner = unsafe { mapping.cast::<u8>().add(page) };
        // SAFETY: the inner pages of the mapping.
        let changed =
            unsafe { libc::mprotect(inner.cast(), room, libc::PROT_READ | libc::PROT_WRITE) };
        assert_eq!(changed, 0, "the attack cannot make its pages accessible");
        let offset = if layout.is_at_end { room - length } else { 0 };
        // SAFETY: within the inner pages.
        let data = unsafe { inner.add(offset) };
        let mut image = Self {
            mapping,
            mapped,
            data,
            length,
            layout,
        };
        image.bytes_mut().fill(PADDING);
        for (k, at) in layout.offsets().enumerate() {
            let value = fill(k);
            let bytes = image.bytes_mut();
            if layout.is_half {
                bytes[at..at + 2].copy_from_slice(&f16::from_f32(value).to_ne_bytes());
            } else {
                bytes[at..at + 4].copy_from_slice(&value.to_ne_bytes());
            }
        }
        image
    }

    fn bytes(&self) -> &[u8] {
        // SAFETY: accessible for as long as the mapping exists, and initialised by the system.
        unsafe { std::slice::from_raw_parts(self.data, self.length) }
    }

    fn bytes_mut(&mut self) -> &mut [u8] {
        // SAFETY: as above, and borrowed for writing.
        unsafe { std::slice::from_raw_parts_mut(self.data, self.length) }
    }

    /// Returns the description of the image for a call.
    pub(super) fn describe(&self) -> SeidelImage {
        let layout = &self.layout;
        let top = if layout.is_bottom_up {
            (layout.rect.height as usize - 1) * layout.row
        } else {
            0
        };
        let row = layout.row as i64;
        SeidelImage {
            size: size_of::<SeidelImage>() as u64,
            // SAFETY: within the image.
            data: unsafe { self.data.add(top) }.cast(),
            row_bytes: if layout.is_bottom_up { -row } else { row },
            pixel_bytes: layout.pixel as u32,
            channels: layout.channels as u32,
            sample: if layout.is_half {
                SEIDEL_HALF
            } else {
                SEIDEL_FLOAT
            },
            reserved: 0,
            rect: layout.rect,
        }
    }

    /// Returns whether all samples are finite.
    pub(super) fn is_finite(&self) -> bool {
        let bytes = self.bytes();
        self.layout.offsets().all(|at| {
            if self.layout.is_half {
                f16::from_ne_bytes([bytes[at], bytes[at + 1]]).is_finite()
            } else {
                let sample = [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
                f32::from_ne_bytes(sample).is_finite()
            }
        })
    }

    /// Returns whether all bytes between samples are as they were.
    pub(super) fn has_padding(&self) -> bool {
        let mut is_sample = vec![false; self.length];
        let size = self.layout.sample_bytes();
        for at in self.layout.offsets() {
            is_sample[at..at + size].fill(true);
        }
        let pairs = self.bytes().iter().zip(is_sample);
        pairs
            .filter(|(_, is_sample)| !is_sample)
            .all(|(&byte, _)| byte == PADDING)
    }
}

impl Drop for GuardedImage {
    fn drop(&mut self) {
        // SAFETY: the mapping is its own, and no reference to it remains.
        unsafe { libc::munmap(self.mapping, self.mapped) };
    }
}
