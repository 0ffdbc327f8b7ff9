//! Pictures in the caller's memory: any order of rows, any room between pixels and rows, at any address.

use std::ffi::c_void;

use half::f16;

use crate::pointers::{Sized64, maybe_sized, sized};
use crate::status::{Failure, Result};

/// Samples of 16 bits: IEEE 754 half.
pub const SEIDEL_HALF: u32 = 1;
/// Samples of 32 bits: IEEE 754 single.
pub const SEIDEL_FLOAT: u32 = 2;

/// Most columns or rows.
const MOST_SIDE: i32 = 1 << 24;

/// A rectangle of a plate's pixels: x to the right, y down.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct SeidelRect {
    /// Its first column.
    pub left: i32,
    /// Its first row.
    pub top: i32,
    /// Columns.
    pub width: i32,
    /// Rows.
    pub height: i32,
}

impl SeidelRect {
    pub(crate) const EMPTY: Self = Self {
        left: 0,
        top: 0,
        width: 0,
        height: 0,
    };

    /// Refuses one that is empty or too large to count in.
    pub(crate) fn check(&self, name: &str) -> Result<()> {
        let side = |first: i32, size: i32| {
            (1..=MOST_SIDE).contains(&size) && (-MOST_SIDE..=MOST_SIDE).contains(&first)
        };
        if side(self.left, self.width) && side(self.top, self.height) {
            return Ok(());
        }
        Err(Failure::argument(
            name,
            format!(
                "is {} x {} from ({}, {})",
                self.width, self.height, self.left, self.top
            ),
            "give at least one pixel, and no number above 16777216",
        ))
    }

    pub(crate) fn contains(&self, inner: Self) -> bool {
        inner.left >= self.left
            && inner.top >= self.top
            && inner.left + inner.width <= self.left + self.width
            && inner.top + inner.height <= self.top + self.height
    }

    /// The same with `x` more columns and `y` more rows on either side.
    pub(crate) fn grown(&self, x: i32, y: i32) -> Self {
        Self {
            left: self.left - x,
            top: self.top - y,
            width: self.width + 2 * x,
            height: self.height + 2 * y,
        }
    }

    /// What lies in both; empty where nothing does.
    pub(crate) fn meet(&self, other: Self) -> Self {
        let span = |a: i32, a_size: i32, b: i32, b_size: i32| {
            let first = a.max(b);
            (first, ((a + a_size).min(b + b_size) - first).max(0))
        };
        let (left, width) = span(self.left, self.width, other.left, other.width);
        let (top, height) = span(self.top, self.height, other.top, other.height);
        Self {
            left,
            top,
            width,
            height,
        }
    }

    pub(crate) fn columns(&self) -> usize {
        self.width as usize
    }

    pub(crate) fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }
}

/// A picture in the caller's memory, read or written in place. It may lie at any address, with any room between pixels and
/// rows; nothing but its samples is touched.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct SeidelImage {
    /// sizeof(SeidelImage).
    pub size: u64,
    /// The first sample of the pixel at (rect.left, rect.top).
    pub data: *mut c_void,
    /// Bytes from a pixel to the one below it; negative where rows are stored from the bottom up.
    pub row_bytes: i64,
    /// Bytes from a pixel to the one on its right; 0 where nothing lies between them. With it and `data` one channel of
    /// many can be given alone.
    pub pixel_bytes: u32,
    /// Samples of a pixel that count, 1 to 4. Of plates: 1 is Y, 2 are Y and A, 3 are R, G and B, 4 are R, G, B and A.
    pub channels: u32,
    /// SEIDEL_HALF or SEIDEL_FLOAT.
    pub sample: u32,
    /// Leave it 0.
    pub reserved: u32,
    /// Which pixels of the plate it holds.
    pub rect: SeidelRect,
}

// SAFETY: `repr(C)`, begins with its size, and holds numbers and a raw pointer.
unsafe impl Sized64 for SeidelImage {
    const LEAST: usize = size_of::<Self>();

    fn neutral() -> Self {
        Self {
            size: size_of::<Self>() as u64,
            data: std::ptr::null_mut(),
            row_bytes: 0,
            pixel_bytes: 0,
            channels: 0,
            sample: 0,
            reserved: 0,
            rect: SeidelRect::EMPTY,
        }
    }
}

/// A picture whose numbers were found to be sound.
#[derive(Debug, Clone, Copy)]
pub(crate) struct View {
    data: *mut u8,
    row_bytes: isize,
    pixel_bytes: isize,
    half: bool,
    pub(crate) channels: usize,
    pub(crate) rect: SeidelRect,
}

impl View {
    /// The picture at `image`.
    ///
    /// # Safety
    /// `image` must be NULL or a picture whose samples can be read, or written if it is an output, until the call ends.
    pub(crate) unsafe fn new(image: *const SeidelImage, name: &str) -> Result<Self> {
        // SAFETY: as the caller vouches.
        let image = unsafe { sized(image, name)? };
        Self::of(&image, name)
    }

    /// The same, nothing where `image` is NULL.
    ///
    /// # Safety
    /// That of [`View::new`].
    pub(crate) unsafe fn maybe(image: *const SeidelImage, name: &str) -> Result<Option<Self>> {
        // SAFETY: as the caller vouches.
        let image = unsafe { maybe_sized(image, name)? };
        image.map(|image| Self::of(&image, name)).transpose()
    }

    fn of(image: &SeidelImage, name: &str) -> Result<Self> {
        let refuse = |what: &str, problem: String, remedy: &str| {
            Err(Failure::argument(
                &format!("{name}.{what}"),
                problem,
                remedy,
            ))
        };
        if image.data.is_null() {
            return refuse("data", "is NULL".into(), "give its samples");
        }
        image.rect.check(&format!("{name}.rect"))?;
        if !(1..=4).contains(&image.channels) {
            let problem = format!("is {}", image.channels);
            return refuse("channels", problem, "give 1 to 4");
        }
        let half = match image.sample {
            SEIDEL_HALF => true,
            SEIDEL_FLOAT => false,
            other => {
                let remedy = "give SEIDEL_HALF or SEIDEL_FLOAT";
                return refuse("sample", format!("is {other}"), remedy);
            }
        };
        let packed = i64::from(image.channels) * if half { 2 } else { 4 };
        let pixel_bytes = match image.pixel_bytes {
            0 => packed,
            bytes => i64::from(bytes),
        };
        if pixel_bytes < packed {
            let remedy = format!("give 0, or at least {packed}");
            return refuse("pixel_bytes", format!("is {pixel_bytes}"), &remedy);
        }
        let (width, height) = (i64::from(image.rect.width), i64::from(image.rect.height));
        let row = (width - 1) * pixel_bytes + packed;
        if height > 1
            && image
                .row_bytes
                .checked_abs()
                .is_none_or(|bytes| bytes < row)
        {
            let problem = format!("is {}, a row takes {row}", image.row_bytes);
            return refuse(
                "row_bytes",
                problem,
                "give what lies between rows, or its negative",
            );
        }
        let span = image.row_bytes.checked_mul(height - 1);
        let span = span.and_then(|bytes| bytes.checked_abs()?.checked_add(row));
        if span.is_none_or(|bytes| isize::try_from(bytes).is_err()) {
            let problem = format!("is {}", image.row_bytes);
            return refuse("row_bytes", problem, "the picture does not fit in memory");
        }
        Ok(Self {
            data: image.data.cast(),
            row_bytes: image.row_bytes as isize,
            pixel_bytes: pixel_bytes as isize,
            half,
            channels: image.channels as usize,
            rect: image.rect,
        })
    }

    /// The address of a sample of the picture.
    fn at(&self, (column, row): (usize, usize), channel: usize) -> *mut u8 {
        let bytes = if self.half { 2 } else { 4 };
        let offset = row as isize * self.row_bytes
            + column as isize * self.pixel_bytes
            + (channel * bytes) as isize;
        self.data.wrapping_offset(offset)
    }

    fn get(&self, place: (usize, usize), channel: usize) -> f32 {
        let at = self.at(place, channel);
        if self.half {
            // SAFETY: within the picture, which its maker vouched for; at any address.
            f16::from_bits(unsafe { at.cast::<u16>().read_unaligned() }).to_f32()
        } else {
            // SAFETY: as above.
            unsafe { at.cast::<f32>().read_unaligned() }
        }
    }

    fn put(&self, place: (usize, usize), channel: usize, value: f32) {
        let at = self.at(place, channel);
        if self.half {
            let bits = f16::from_f32(value).to_bits();
            // SAFETY: within the picture, which its maker vouched for as an output; at any address.
            unsafe { at.cast::<u16>().write_unaligned(bits) };
        } else {
            // SAFETY: as above.
            unsafe { at.cast::<f32>().write_unaligned(value) };
        }
    }

    /// One channel over `rect`, row-major: zero where the picture has no pixel.
    pub(crate) fn read(&self, channel: usize, rect: SeidelRect) -> Result<Vec<f32>> {
        let mut out = zeros(rect.pixels())?;
        let shared = self.rect.meet(rect);
        for row in shared.top..shared.top + shared.height {
            let line = (row - rect.top) as usize * rect.columns();
            let line = &mut out[line + (shared.left - rect.left) as usize..][..shared.columns()];
            let from = (row - self.rect.top) as usize;
            for (k, out) in line.iter_mut().enumerate() {
                let column = (shared.left - self.rect.left) as usize + k;
                *out = self.get((column, from), channel);
            }
        }
        Ok(out)
    }

    /// The same, the nearest pixel where the picture has none.
    pub(crate) fn read_held(&self, channel: usize, rect: SeidelRect) -> Result<Vec<f32>> {
        let mut out = zeros(rect.pixels())?;
        let nearest = |at: i32, first: i32, size: i32| (at - first).clamp(0, size - 1) as usize;
        for (k, out) in out.iter_mut().enumerate() {
            let (x, y) = ((k % rect.columns()) as i32, (k / rect.columns()) as i32);
            let column = nearest(rect.left + x, self.rect.left, self.rect.width);
            let row = nearest(rect.top + y, self.rect.top, self.rect.height);
            *out = self.get((column, row), channel);
        }
        Ok(out)
    }

    /// Writes all pixels of one channel from samples of `rect`, zero where that has none.
    pub(crate) fn write(&self, channel: usize, rect: SeidelRect, samples: &[f32]) {
        for row in 0..self.rect.height {
            for column in 0..self.rect.width {
                let (x, y) = (
                    self.rect.left + column - rect.left,
                    self.rect.top + row - rect.top,
                );
                let inside = (0..rect.width).contains(&x) && (0..rect.height).contains(&y);
                let value = match inside {
                    true => samples[y as usize * rect.columns() + x as usize],
                    false => 0.0,
                };
                self.put((column as usize, row as usize), channel, value);
            }
        }
    }
}

/// As many zeros, or a refusal where there is no room for them.
pub(crate) fn zeros(count: usize) -> Result<Vec<f32>> {
    let mut out = Vec::new();
    out.try_reserve_exact(count).map_err(|_| {
        Failure::new(
            crate::SeidelStatus::Memory,
            format!("plate: no memory for {count} samples; render smaller parts"),
        )
    })?;
    out.resize(count, 0.0);
    Ok(out)
}
