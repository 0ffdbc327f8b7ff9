//! How large and of what shape the lens draws points over the frame: an ellipse of twice the standard deviation each.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use seidel_c::SeidelRect;

use super::place::Place;
use crate::host::Result;
use crate::lens::points;

/// An ellipse, plate pixels: its middle, and the halves of two diameters that are square to each other before the
/// plate's pixels are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ellipse {
    pub(super) middle: (f64, f64),
    pub(super) axes: [(f64, f64); 2],
}

/// What grids depend on: the lens, and all that is set, in words.
type Key = (usize, String);

/// A grid, and what it was made for.
type Made = (Key, Arc<Vec<Ellipse>>);

/// Grids by instance, so that they are not made again with every drawing.
static KEPT: Mutex<BTreeMap<usize, Made>> = Mutex::new(BTreeMap::new());

/// The ellipses of an instance.
///
/// # Errors
/// What the library says.
pub(super) fn grid(instance: usize, place: &Place) -> Result<Arc<Vec<Ellipse>>> {
    let settings = place.setup.settings();
    let told = format!("{settings:?} {:?} {:?}", place.setup.scales(), place.format);
    let key = (place.lens.handle().addr(), told);
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((old, grid)) = kept.get(&instance)
        && *old == key
    {
        return Ok(Arc::clone(grid));
    }
    let made = Arc::new(ellipses(place)?);
    kept.insert(instance, (key, Arc::clone(&made)));
    Ok(made)
}

/// Grids of an instance that is gone.
pub(crate) fn forget(instance: usize) {
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    kept.remove(&instance);
}

fn ellipses(place: &Place) -> Result<Vec<Ellipse>> {
    let settings = place.setup.settings();
    let channel = place.lens.channel("G");
    let ellipse = |middle| {
        let at = (place.format, channel);
        let kernel = (place.lens).kernel(settings, at, middle, settings.distance)?;
        Ok(of_moments(middle, &kernel.weights, kernel.window))
    };
    points(place.format).map(ellipse).collect()
}

/// The ellipse with twice the standard deviation of a kernel along every direction.
fn of_moments(from: (f64, f64), weights: &[f32], window: SeidelRect) -> Ellipse {
    let columns = window.width.max(1) as usize;
    let at = |k: usize| {
        (
            f64::from(window.left) + (k % columns) as f64,
            f64::from(window.top) + (k / columns) as f64,
        )
    };
    let sum = |value: &dyn Fn((f64, f64)) -> f64| -> f64 {
        let all = weights.iter().enumerate();
        all.map(|(k, weight)| f64::from(*weight) * value(at(k)))
            .sum()
    };
    let total = sum(&|_| 1.0).max(1e-12);
    let mean = (sum(&|p| p.0) / total, sum(&|p| p.1) / total);
    let moment = |f: &dyn Fn(f64, f64) -> f64| sum(&|p| f(p.0 - mean.0, p.1 - mean.1)) / total;
    let (xx, yy) = (moment(&|x, _| x * x), moment(&|_, y| y * y));
    let xy = moment(&|x, y| x * y);
    // Diagonal form of the symmetric matrix of second moments.
    let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
    let spread = ((xx - yy) / 2.0).hypot(xy);
    let middle = (xx + yy) / 2.0;
    let half = |variance: f64| 2.0 * variance.max(0.0).sqrt();
    let (long, short) = (half(middle + spread), half(middle - spread));
    Ellipse {
        middle: (from.0 + mean.0, from.1 + mean.1),
        axes: [
            (long * angle.cos(), long * angle.sin()),
            (-short * angle.sin(), short * angle.cos()),
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ellipses_lie_as_kernels_do() {
        // Light along a falling diagonal, one pixel right of where it comes from.
        let mut weights = [0.0_f32; 9];
        for k in [0, 4, 8] {
            weights[k] = 1.0 / 3.0;
        }
        let window = SeidelRect {
            left: 0,
            top: -1,
            width: 3,
            height: 3,
        };
        let ellipse = of_moments((10.5, 20.5), &weights, window);
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-6, "{a} {b}");
        near(ellipse.middle.0, 11.5);
        near(ellipse.middle.1, 20.5);
        let (x, y) = ellipse.axes[0];
        near(x, y);
        near(x.hypot(y), 2.0 * (4.0_f64 / 3.0).sqrt());
        near(ellipse.axes[1].0.hypot(ellipse.axes[1].1), 0.0);
    }
}
