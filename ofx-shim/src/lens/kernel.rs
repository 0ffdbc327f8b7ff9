//! Kernels of a lens over the frame: the images of single points of light.

use std::sync::Arc;

use seidel_core::{LensSession, LocalKernel, ObjectDistance, PlateGeometry, Rectangle};

use crate::host::{Effect, Result};
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

/// A kernel that is wanted.
pub(crate) struct KernelRequest {
    /// Index of the lens channel.
    pub(crate) channel: usize,
    /// Frame pixels from the top left corner.
    pub(crate) at: (f64, f64),
    pub(crate) distance_m: f64,
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
        let request = KernelRequest {
            channel,
            at,
            distance_m,
        };
        let (session, geometry) = (Arc::clone(&self.session), self.geometry);
        threads::run_on_one(move || draw(&session, &geometry, &request))
    }

    /// Returns the kernels that `requests` name, or `None` if the host of `effect` aborts.
    ///
    /// # Errors
    /// Those of [`LensSession::kernel_at`].
    pub(crate) fn kernels(
        &self,
        effect: &Effect,
        requests: Vec<KernelRequest>,
    ) -> Result<Option<Vec<LocalKernel>>> {
        let (session, geometry) = (Arc::clone(&self.session), self.geometry);
        threads::run(effect, move |progress| {
            let mut kernels = Vec::with_capacity(requests.len());
            for request in &requests {
                if !progress(kernels.len() as f64 / requests.len() as f64) {
                    return Err(seidel_core::Error::cancelled("PSF grid"));
                }
                kernels.push(draw(&session, &geometry, request)?);
            }
            Ok(kernels)
        })
    }
}

fn draw(
    session: &LensSession,
    geometry: &PlateGeometry,
    request: &KernelRequest,
) -> seidel_core::Result<LocalKernel> {
    let distance = if session.lens().predictor().depends_on_depth() {
        ObjectDistance::metres(request.distance_m)?
    } else {
        ObjectDistance::Unknown
    };
    session.kernel_at(geometry, request.channel, request.at, distance)
}
