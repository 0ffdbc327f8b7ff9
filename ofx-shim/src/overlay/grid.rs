//! How large and of what shape the lens draws points over the frame: an ellipse of twice the standard deviation each.

use std::collections::BTreeMap;
use std::ptr::{null, null_mut};
use std::sync::{Arc, Mutex, PoisonError};

use seidel_c::{SeidelKernel, SeidelPlate, SeidelRect, SeidelStatus, seidel_kernel};

use super::place::Place;
use crate::ffi;
use crate::host::Result;

/// Columns and rows of the grid.
const COLUMNS: i32 = 7;
const ROWS: i32 = 5;

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
    let channel = place.lens.info.channels.iter().position(|name| name == "G");
    let channel = channel.unwrap_or(0) as u32;
    let mut out = Vec::new();
    for row in 0..ROWS {
        for column in 0..COLUMNS {
            let at = |k: i32, count: i32, size: i32| {
                (f64::from(k) + 0.5) / f64::from(count) * f64::from(size)
            };
            let middle = (
                at(column, COLUMNS, place.format.width).floor() + 0.5,
                at(row, ROWS, place.format.height).floor() + 0.5,
            );
            let (weights, window) = kernel(place, channel, middle)?;
            out.push(of_moments(middle, &weights, window));
        }
    }
    Ok(out)
}

/// The weights of a kernel, and where they lie about the pixel that light comes from.
fn kernel(place: &Place, channel: u32, (x, y): (f64, f64)) -> Result<(Vec<f32>, SeidelRect)> {
    let plate = SeidelPlate {
        size: size_of::<SeidelPlate>() as u64,
        format: place.format,
        extent: place.format,
        source: null(),
        depth: null(),
        matte: null(),
        matte_depth: null(),
        alphas: null(),
    };
    let settings = place.setup.settings();
    let distance = match place.lens.info.knows_depth {
        true => settings.distance,
        false => f64::NAN,
    };
    let mut kernel = SeidelKernel {
        size: size_of::<SeidelKernel>() as u64,
        weights: null_mut(),
        capacity: 0,
        left: 0,
        top: 0,
        width: 0,
        height: 0,
    };
    let handle = place.lens.handle();
    let ask = |kernel: &mut SeidelKernel| {
        // SAFETY: everything is held until the call ends; the weights are as many as is said.
        unsafe { seidel_kernel(handle, settings, &plate, channel, x, y, distance, kernel) }
    };
    let mut status = ask(&mut kernel);
    let mut weights = Vec::new();
    if status == SeidelStatus::TooSmall {
        weights = vec![0.0_f32; kernel.width as usize * kernel.height as usize];
        kernel.weights = weights.as_mut_ptr();
        kernel.capacity = weights.len() as u64;
        status = ask(&mut kernel);
    }
    ffi::done(status)?;
    let window = SeidelRect {
        left: kernel.left,
        top: kernel.top,
        width: kernel.width as i32,
        height: kernel.height as i32,
    };
    Ok((weights, window))
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
