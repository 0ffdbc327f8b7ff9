//! Images in the caller's memory: any order of rows, any padding between pixels and rows, any alignment.

use std::ffi::c_void;

use half::f16;

use crate::pointers::{Versioned, read_optional, read_versioned};
use crate::status::{Failure, Result, SeidelStatus};

/// 16-bit samples: IEEE 754 half precision.
pub const SEIDEL_HALF: u32 = 1;
/// 32-bit samples: IEEE 754 single precision.
pub const SEIDEL_FLOAT: u32 = 2;

/// Most columns or rows of a rectangle, and largest magnitude of its position: sums of them fit in an `i32`.
const MAX_SIDE: i32 = 1 << 24;

/// A rectangle of plate pixels: x grows to the right, y downwards. In arguments, width and height must be at least 1
/// and no member above 16777216 in magnitude.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct SeidelRect {
    /// First column.
    pub left: i32,
    /// First row.
    pub top: i32,
    /// Number of columns.
    pub width: i32,
    /// Number of rows.
    pub height: i32,
}

impl SeidelRect {
    pub(crate) const EMPTY: Self = Self {
        left: 0,
        top: 0,
        width: 0,
        height: 0,
    };

    /// Checks that the rectangle, the argument `name`, is not empty and its members are in range.
    pub(crate) fn check(&self, name: &str) -> Result<()> {
        let is_side = |first: i32, size: i32| {
            (1..=MAX_SIDE).contains(&size) && (-MAX_SIDE..=MAX_SIDE).contains(&first)
        };
        if is_side(self.left, self.width) && is_side(self.top, self.height) {
            return Ok(());
        }
        Err(Failure::argument(
            name,
            format!(
                "is {} x {} at ({}, {})",
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

    /// Returns the rectangle with `x` more columns and `y` more rows on each side.
    pub(crate) fn grown(&self, x: i32, y: i32) -> Self {
        Self {
            left: self.left - x,
            top: self.top - y,
            width: self.width + 2 * x,
            height: self.height + 2 * y,
        }
    }

    /// Returns the intersection of two rectangles, which may be empty.
    pub(crate) fn intersection(&self, other: Self) -> Self {
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

/// An image in the caller's memory, which the library reads or writes in place. It may have any alignment and any
/// padding between pixels and rows; the library touches its samples only.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct SeidelImage {
    /// sizeof(SeidelImage).
    pub size: u64,
    /// First sample of the pixel at (rect.left, rect.top), the top-left one.
    pub data: *mut c_void,
    /// Bytes from a pixel to the pixel below it; negative if rows are stored from the bottom up.
    pub row_bytes: i64,
    /// Bytes from a pixel to the pixel on its right; 0 if pixels are packed. With `data` it selects some channels of
    /// many.
    pub pixel_bytes: u32,
    /// Samples per pixel, 1 to 4. Of a plate: 1 is Y; 2 are Y, A; 3 are R, G, B; 4 are R, G, B, A.
    pub channels: u32,
    /// SEIDEL_HALF or SEIDEL_FLOAT.
    pub sample: u32,
    /// Unused; set it to 0.
    pub reserved: u32,
    /// The pixels of the plate that the image holds.
    pub rect: SeidelRect,
}

// SAFETY: `repr(C)`, begins with its size, and holds numbers and a raw pointer.
unsafe impl Versioned for SeidelImage {
    const MIN_SIZE: usize = size_of::<Self>();

    fn defaults() -> Self {
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

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum SampleFormat {
    Half,
    Float,
}

impl SampleFormat {
    fn bytes(self) -> usize {
        match self {
            Self::Half => 2,
            Self::Float => 4,
        }
    }
}

/// An image of the caller whose layout was checked.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ImageView {
    data: *mut u8,
    row_bytes: isize,
    pixel_bytes: isize,
    format: SampleFormat,
    pub(crate) channels: usize,
    pub(crate) rect: SeidelRect,
}

impl ImageView {
    /// Checks the image at `image`, the argument `name`.
    ///
    /// # Safety
    /// `image` must be NULL or an image whose samples can be read, or written if it is an output, until the call
    /// ends.
    pub(crate) unsafe fn new(image: *const SeidelImage, name: &str) -> Result<Self> {
        // SAFETY: as the caller guarantees.
        let image = unsafe { read_versioned(image, name)? };
        Self::check(&image, name)
    }

    /// Checks the image at `image` like [`ImageView::new`], or returns `None` if it is NULL.
    ///
    /// # Safety
    /// That of [`ImageView::new`].
    pub(crate) unsafe fn optional(image: *const SeidelImage, name: &str) -> Result<Option<Self>> {
        // SAFETY: as the caller guarantees.
        let image = unsafe { read_optional(image, name)? };
        image.map(|image| Self::check(&image, name)).transpose()
    }

    fn check(image: &SeidelImage, name: &str) -> Result<Self> {
        let refuse = |field: &str, problem: String, remedy: &str| {
            Err(Failure::argument(
                &format!("{name}.{field}"),
                problem,
                remedy,
            ))
        };
        if image.data.is_null() {
            return refuse("data", "is NULL".into(), "give a pointer to its samples");
        }
        image.rect.check(&format!("{name}.rect"))?;
        if !(1..=4).contains(&image.channels) {
            let problem = format!("is {}", image.channels);
            return refuse("channels", problem, "give 1 to 4");
        }
        let format = match image.sample {
            SEIDEL_HALF => SampleFormat::Half,
            SEIDEL_FLOAT => SampleFormat::Float,
            other => {
                let remedy = "give SEIDEL_HALF or SEIDEL_FLOAT";
                return refuse("sample", format!("is {other}"), remedy);
            }
        };
        let packed = i64::from(image.channels) * format.bytes() as i64;
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
        let distance = image.row_bytes.checked_abs();
        if height > 1 && distance.is_none_or(|bytes| bytes < row) {
            let problem = format!("is {}, but a row has {row} bytes", image.row_bytes);
            let remedy = "give the bytes from a row to the one below it, negative if rows are stored from the bottom up";
            return refuse("row_bytes", problem, remedy);
        }
        let span = image.row_bytes.checked_mul(height - 1);
        let span = span.and_then(|bytes| bytes.checked_abs()?.checked_add(row));
        if span.is_none_or(|bytes| isize::try_from(bytes).is_err()) {
            let problem = format!("is {}", image.row_bytes);
            let remedy = "give a number with which the image fits in memory";
            return refuse("row_bytes", problem, remedy);
        }
        Ok(Self {
            data: image.data.cast(),
            row_bytes: image.row_bytes as isize,
            pixel_bytes: pixel_bytes as isize,
            format,
            channels: image.channels as usize,
            rect: image.rect,
        })
    }

    /// Returns the address of a sample, by column and row from the top-left pixel of the image.
    fn address(&self, column: usize, row: usize, channel: usize) -> *mut u8 {
        let offset = row as isize * self.row_bytes
            + column as isize * self.pixel_bytes
            + (channel * self.format.bytes()) as isize;
        self.data.wrapping_offset(offset)
    }

    fn get(&self, column: usize, row: usize, channel: usize) -> f32 {
        let at = self.address(column, row, channel);
        match self.format {
            SampleFormat::Half => {
                // SAFETY: in the image, whose memory its creator guarantees; alignment is not assumed.
                let bits = unsafe { at.cast::<u16>().read_unaligned() };
                f16::from_bits(bits).to_f32()
            }
            SampleFormat::Float => {
                // SAFETY: as above.
                unsafe { at.cast::<f32>().read_unaligned() }
            }
        }
    }

    fn set(&self, column: usize, row: usize, channel: usize, value: f32) {
        let at = self.address(column, row, channel);
        match self.format {
            SampleFormat::Half => {
                let bits = f16::from_f32(value).to_bits();
                // SAFETY: in the image, which its creator guarantees to be writable; alignment is not assumed.
                unsafe { at.cast::<u16>().write_unaligned(bits) };
            }
            SampleFormat::Float => {
                // SAFETY: as above.
                unsafe { at.cast::<f32>().write_unaligned(value) };
            }
        }
    }

    /// Checks that the image can hold the samples of a plane over `rect`, row-major, as far as the image has its pixels.
    ///
    /// # Errors
    /// A finite sample beyond the range of half floats, which would become infinite.
    pub(crate) fn check_range(
        &self,
        channel: usize,
        rect: SeidelRect,
        plane: &[f32],
    ) -> Result<()> {
        if self.format == SampleFormat::Float {
            return Ok(());
        }
        let shared = self.rect.intersection(rect);
        if shared.width == 0 {
            return Ok(());
        }
        for row in shared.top..shared.top + shared.height {
            let line = (row - rect.top) as usize * rect.columns();
            let line = &plane[line + (shared.left - rect.left) as usize..][..shared.columns()];
            let is_beyond = |v: &f32| v.is_finite() && !f16::from_f32(*v).is_finite();
            if let Some(at) = line.iter().position(is_beyond) {
                let (value, column) = (line[at], shared.left + at as i32);
                return Err(Failure::argument(
                    "output",
                    format!(
                        "channel {channel}: the result at column {column}, row {row} is {value}, beyond the largest half float"
                    ),
                    "give an image of SEIDEL_FLOAT",
                ));
            }
        }
        Ok(())
    }

    /// Reads one channel over `rect`, row-major; zero where the image has no pixel.
    pub(crate) fn read(&self, channel: usize, rect: SeidelRect) -> Result<Vec<f32>> {
        let mut out = zeros(rect.pixels())?;
        let shared = self.rect.intersection(rect);
        if shared.width == 0 {
            return Ok(out);
        }
        for row in shared.top..shared.top + shared.height {
            let line = (row - rect.top) as usize * rect.columns();
            let line = &mut out[line + (shared.left - rect.left) as usize..][..shared.columns()];
            let own_row = (row - self.rect.top) as usize;
            for (k, out) in line.iter_mut().enumerate() {
                let column = (shared.left - self.rect.left) as usize + k;
                *out = self.get(column, own_row, channel);
            }
        }
        Ok(out)
    }

    /// Reads one channel over `rect`, row-major; the nearest pixel where the image has none.
    pub(crate) fn read_clamped(&self, channel: usize, rect: SeidelRect) -> Result<Vec<f32>> {
        let mut out = zeros(rect.pixels())?;
        let nearest = |at: i32, first: i32, size: i32| (at - first).clamp(0, size - 1) as usize;
        for (k, out) in out.iter_mut().enumerate() {
            let (x, y) = ((k % rect.columns()) as i32, (k / rect.columns()) as i32);
            let column = nearest(rect.left + x, self.rect.left, self.rect.width);
            let row = nearest(rect.top + y, self.rect.top, self.rect.height);
            *out = self.get(column, row, channel);
        }
        Ok(out)
    }

    /// Writes every pixel of one channel from `samples` over `rect`; zero outside `rect`.
    pub(crate) fn write(&self, channel: usize, rect: SeidelRect, samples: &[f32]) {
        for row in 0..self.rect.height {
            for column in 0..self.rect.width {
                let x = self.rect.left + column - rect.left;
                let y = self.rect.top + row - rect.top;
                let is_inside = (0..rect.width).contains(&x) && (0..rect.height).contains(&y);
                let value = if is_inside {
                    samples[y as usize * rect.columns() + x as usize]
                } else {
                    0.0
                };
                self.set(column as usize, row as usize, channel, value);
            }
        }
    }
}

/// Returns `count` zeros.
///
/// # Errors
/// SEIDEL_STATUS_MEMORY if they cannot be allocated.
fn zeros(count: usize) -> Result<Vec<f32>> {
    let mut out = Vec::new();
    out.try_reserve_exact(count).map_err(|_| {
        Failure::new(
            SeidelStatus::Memory,
            format!("plate: no memory for {count} samples; render smaller parts"),
        )
    })?;
    out.resize(count, 0.0);
    Ok(out)
}
