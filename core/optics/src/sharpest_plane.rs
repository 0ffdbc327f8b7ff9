//! The distance at which a lens is sharpest on its axis.

/// Steps of the search, 1/m: the first spans infinity to half a metre.
const WIDE_STEPS: [f64; 4] = [2.0, 1.0, 0.5, 0.25];
const NARROW_STEPS: [f64; 3] = [0.1, 0.03, 0.01];

/// Returns the vergence at which `variance` is least, 1/m; `None` where it does not grow on both sides.
///
/// `variance` is that of the blur on the axis of a lens as a function of vergence, in the mean of its channels, which is close
/// to a parabola.
pub fn sharpest_vergence(variance: impl Fn(f64) -> f64) -> Option<f64> {
    let mut middle = 0.0;
    for step in WIDE_STEPS {
        let by = step_to_least(&variance, middle, step);
        // Flat at a wide step: no focus. Flat at a narrow one: close enough to it.
        let Some(by) = by else {
            return (step < 1.0).then_some(middle);
        };
        middle += by;
    }
    Some(nearby_sharpest_vergence(variance, middle))
}

/// Returns the vergence near `start` at which `variance` is least; `start` where it is flat.
pub(crate) fn nearby_sharpest_vergence(variance: impl Fn(f64) -> f64, start: f64) -> f64 {
    let mut middle = start;
    for step in NARROW_STEPS {
        let Some(by) = step_to_least(&variance, middle, step) else {
            break;
        };
        middle += by;
    }
    middle
}

/// Returns the step to the least value of the parabola through three values; `None` where it does not bend upwards.
fn step_to_least(variance: impl Fn(f64) -> f64, middle: f64, step: f64) -> Option<f64> {
    let [before, here, after] = [-step, 0.0, step].map(|by| variance(middle + by));
    let bend = before - 2.0 * here + after;
    let scale = before.abs() + here.abs() + after.abs();
    let is_valley = bend.is_finite() && bend > 1e-9 * scale;
    is_valley.then(|| (0.5 * step * (before - after) / bend).clamp(-20.0, 20.0))
}
