//! Sampling grids and unit-sum kernels.

use super::{KernelBounds, LocalBlur, PsfModel};

/// A grid of pixels on which a PSF is sampled, placed relative to its centroid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampleGrid {
    /// Offset of the first pixel's centre from the centroid along x, px.
    pub first_x_px: f64,
    /// Offset of the first pixel's centre from the centroid along y, px.
    pub first_y_px: f64,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl SampleGrid {
    /// Returns the pixels of a `width` x `height` tile whose PSF has its centroid at tile coordinates
    /// (`centroid_x`, `centroid_y`).
    pub fn for_tile(width: usize, height: usize, centroid_x: f64, centroid_y: f64) -> Self {
        Self {
            first_x_px: 0.5 - centroid_x,
            first_y_px: 0.5 - centroid_y,
            width,
            height,
        }
    }

    /// Number of pixels.
    pub fn len(&self) -> usize {
        self.width * self.height
    }

    /// Returns whether the grid has no pixel.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The pixels of a kernel.
#[derive(Debug, Clone, Copy)]
pub(super) struct KernelGrid {
    /// First column relative to the source pixel.
    pub(super) left: i32,
    /// First row relative to the source pixel.
    pub(super) top: i32,
    /// The same pixels relative to the centroid.
    pub(super) samples: SampleGrid,
}

impl KernelGrid {
    /// Returns the pixels within `bounds` of a centroid `shift_px` from the centre of the source pixel: at least the
    /// pixel nearest to the centroid.
    pub(super) fn new(bounds: &KernelBounds, shift_px: (f64, f64)) -> Self {
        let (x, y) = shift_px;
        let left = (x - bounds.left_px).ceil().min(x.round());
        let right = (x + bounds.right_px).floor().max(x.round());
        let top = (y - bounds.up_px).ceil().min(y.round());
        let bottom = (y + bounds.down_px).floor().max(y.round());
        Self {
            left: left as i32,
            top: top as i32,
            samples: SampleGrid {
                first_x_px: left - x,
                first_y_px: top - y,
                width: (right - left) as usize + 1,
                height: (bottom - top) as usize + 1,
            },
        }
    }

    /// Returns the pixels within `reach` columns and rows of the source pixel, at least one; `None` if these are all.
    pub(super) fn cropped(&self, reach: [i32; 2]) -> Option<Self> {
        let near = |first: i32, count: usize, reach: i32| {
            let last = first + count as i32 - 1;
            let start = (-reach).clamp(first, last);
            start..reach.clamp(start, last) + 1
        };
        let columns = near(self.left, self.samples.width, reach[0]);
        let rows = near(self.top, self.samples.height, reach[1]);
        let part = Self {
            left: columns.start,
            top: rows.start,
            samples: SampleGrid {
                first_x_px: self.samples.first_x_px + f64::from(columns.start - self.left),
                first_y_px: self.samples.first_y_px + f64::from(rows.start - self.top),
                width: columns.len(),
                height: rows.len(),
            },
        };
        (part.samples.len() < self.samples.len()).then_some(part)
    }
}

/// A kernel: unit-sum weights around a source pixel. A reusable buffer that [`draw_kernel`] fills.
#[derive(Debug, Clone, Default)]
pub struct Kernel {
    /// Column of the first weight relative to the source pixel.
    pub left: i32,
    /// Row of the first weight relative to the source pixel.
    pub top: i32,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The weights, row-major; they sum to one.
    pub weights: Vec<f32>,
}

/// Draws the PSF of `blur` into `kernel`, sampled at pixel centres and scaled to unit sum.
///
/// The centroid lies `shift_px` (x, y) from the centre of the source pixel. The kernel covers
/// [`PsfModel::kernel_bounds`]. A PSF that no pixel centre samples becomes the single pixel nearest to its centroid.
pub fn draw_kernel<M: PsfModel + ?Sized>(
    model: &M,
    blur: &LocalBlur,
    shift_px: (f64, f64),
    kernel: &mut Kernel,
) {
    let grid = KernelGrid::new(&model.kernel_bounds(blur), shift_px);
    (kernel.left, kernel.top) = (grid.left, grid.top);
    let window = grid.samples;
    (kernel.width, kernel.height) = (window.width, window.height);
    kernel.weights.resize(window.len(), 0.0);
    model.sample_f32(blur, &window, &mut kernel.weights);
    let sum: f64 = kernel.weights.iter().map(|&w| f64::from(w)).sum();
    if sum > 0.0 && sum.is_finite() {
        let scale = (1.0 / sum) as f32;
        kernel.weights.iter_mut().for_each(|w| *w *= scale);
    } else {
        // The PSF falls between the pixel centres.
        kernel.left = shift_px.0.round() as i32;
        kernel.top = shift_px.1.round() as i32;
        (kernel.width, kernel.height) = (1, 1);
        kernel.weights.clear();
        kernel.weights.push(1.0);
    }
}
