//! Size and shape of the lens's PSFs over the frame: ellipses at twice the standard deviation.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use seidel_core::{LensSession, LocalKernel};

use super::lens_placement::LensPlacement;
use crate::host::Result;
use crate::lens::{KernelSource, grid_points};

/// An ellipse, in plate pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ellipse {
    pub(super) centre: (f64, f64),
    /// Half the principal axes.
    pub(super) axes: [(f64, f64); 2],
}

/// The last ellipses of each instance and the lens that they belong to, by the address of the instance's handle.
type Cache = BTreeMap<usize, (LensPlacement, Arc<Vec<Ellipse>>)>;

/// Makes redraws with unchanged settings cheap.
static CACHE: Mutex<Cache> = Mutex::new(BTreeMap::new());

fn cache() -> MutexGuard<'static, Cache> {
    // The map is consistent even if a thread panicked while it held the lock.
    CACHE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Returns the ellipses of an instance, at the points of a PSF grid.
///
/// # Errors
/// Those of [`KernelSource::kernel`].
pub(super) fn ellipses(instance: usize, placement: &LensPlacement) -> Result<Arc<Vec<Ellipse>>> {
    let mut cache = cache();
    if let Some((cached, ellipses)) = cache.get(&instance)
        && cached.has_same_lens(placement)
    {
        return Ok(Arc::clone(ellipses));
    }
    let ellipses = Arc::new(compute(placement)?);
    cache.insert(instance, (placement.clone(), Arc::clone(&ellipses)));
    Ok(ellipses)
}

/// Forgets the ellipses of an instance that is destroyed.
pub(crate) fn forget(instance: usize) {
    cache().remove(&instance);
}

fn compute(placement: &LensPlacement) -> Result<Vec<Ellipse>> {
    let lens = KernelSource {
        session: Arc::new(LensSession::new(&placement.lens, &placement.settings)?),
        geometry: placement.geometry,
    };
    let channel = lens.channel_index("G");
    let ellipse = |point| {
        let kernel = lens.kernel(channel, point, placement.distance_m)?;
        Ok(Ellipse::of_kernel(point, &kernel))
    };
    grid_points(placement.geometry.display)
        .map(ellipse)
        .collect()
}

impl Ellipse {
    /// Computes the ellipse at twice the standard deviation of a kernel in every direction, from its second moments.
    /// `source` is the point of light.
    fn of_kernel(source: (f64, f64), kernel: &LocalKernel) -> Self {
        let position = |k: usize| {
            (
                f64::from(kernel.left) + (k % kernel.width) as f64,
                f64::from(kernel.top) + (k / kernel.width) as f64,
            )
        };
        let sum = |value: &dyn Fn((f64, f64)) -> f64| -> f64 {
            let all = kernel.weights.iter().enumerate();
            all.map(|(k, weight)| f64::from(*weight) * value(position(k)))
                .sum()
        };
        let total = sum(&|_| 1.0).max(1e-12);
        let mean = (sum(&|p| p.0) / total, sum(&|p| p.1) / total);
        let moment = |f: &dyn Fn(f64, f64) -> f64| sum(&|p| f(p.0 - mean.0, p.1 - mean.1)) / total;
        let (xx, yy) = (moment(&|x, _| x * x), moment(&|_, y| y * y));
        let xy = moment(&|x, y| x * y);
        // Principal axes of the covariance matrix.
        let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
        let spread = ((xx - yy) / 2.0).hypot(xy);
        let middle = (xx + yy) / 2.0;
        let radius = |variance: f64| 2.0 * variance.max(0.0).sqrt();
        let (long, short) = (radius(middle + spread), radius(middle - spread));
        Self {
            centre: (source.0 + mean.0, source.1 + mean.1),
            axes: [
                (long * angle.cos(), long * angle.sin()),
                (-short * angle.sin(), short * angle.cos()),
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ellipses_have_the_direction_and_size_of_kernels() {
        // Light along a falling diagonal, centred one pixel to the right of its source.
        let mut weights = vec![0.0; 9];
        for k in [0, 4, 8] {
            weights[k] = 1.0 / 3.0;
        }
        let kernel = LocalKernel {
            left: 0,
            top: -1,
            width: 3,
            height: 3,
            weights,
        };
        let ellipse = Ellipse::of_kernel((10.5, 20.5), &kernel);
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-6, "{a} {b}");
        near(ellipse.centre.0, 11.5);
        near(ellipse.centre.1, 20.5);
        let (x, y) = ellipse.axes[0];
        near(x, y);
        near(x.hypot(y), 2.0 * (4.0_f64 / 3.0).sqrt());
        near(ellipse.axes[1].0.hypot(ellipse.axes[1].1), 0.0);
    }
}
