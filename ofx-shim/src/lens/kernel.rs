//! Kernels of a lens over the frame: the images of single points of light.

use std::sync::Arc;

use seidel_core::render::LocalKernel;
use seidel_core::{LensSession, ObjectDistance, PlateGeometry, Rectangle};

use crate::host::Result;
use crate::threads;

/// Columns of the grid of points that are drawn over a frame.
const COLUMNS: i32 = 7;
/// Rows of that grid.
const ROWS: i32 = 5;

/// Returns the points of a grid over the frame: centres of pixels, in pixels from the top left corner of `format`.
pub(crate) fn grid_points(format: Rectangle) -> impl Iterator<Item = (f64, f64)> {
    let centre = |index: i32, count: i32, size: usize| {
        ((f64::from(index) + 0.5) / f64::from(count) * size as f64).floor() + 0.5
    };
    (0..ROWS * COLUMNS).map(move |k| {
        (
            centre(k % COLUMNS, COLUMNS, format.width),
            centre(k / COLUMNS, ROWS, format.height),
        )
    })
}

/// A lens over a frame whose kernels are wanted.
pub(crate) struct KernelSource {
    pub(crate) session: Arc<LensSession>,
    /// Place of the frame; its data window is the display window.
    pub(crate) geometry: PlateGeometry,
}

impl KernelSource {
    /// Returns the index of the lens channel `name`, or else that of green, or else 0.
    pub(crate) fn channel_index(&self, name: &str) -> usize {
        let names = self.session.lens().predictor().channel_names();
        let find = |name: &str| names.iter().position(|one| one == name);
        find(name).or_else(|| find("G")).unwrap_or(0)
    }

    /// Returns the kernel of a lens channel at `at`, frame pixels from the top left corner, for an object `distance_m`
    /// metres away.
    ///
    /// # Errors
    /// Those of [`LensSession::kernel_at`].
    pub(crate) fn kernel(
        &self,
        channel: usize,
        at: (f64, f64),
        distance_m: f64,
    ) -> Result<LocalKernel> {
        let distance = if self.session.lens().predictor().depends_on_depth() {
            ObjectDistance::metres(distance_m)?
        } else {
            ObjectDistance::Unknown
        };
        let (session, geometry) = (Arc::clone(&self.session), self.geometry);
        threads::run_on_one(move || session.kernel_at(&geometry, channel, at, distance))
    }
}
