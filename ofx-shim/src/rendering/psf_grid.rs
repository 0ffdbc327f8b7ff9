//! How the lens draws points of light over the frame, each as bright as can be shown.

use seidel_c::{SeidelRect, SeidelSettings};

use super::Outcome;
use crate::host::{Effect, Result};
use crate::lens::{Lens, points};
use crate::pixels::Pixels;

/// Names of a picture's channels that are colours.
const COLOURS: [&str; 3] = ["R", "G", "B"];

/// Draws the lens's kernels over `within`, black between them; `vergence` tells 1/m of a pixel.
///
/// # Errors
/// What the library says.
pub(crate) fn psf_grid(
    (effect, lens, settings): (&Effect, &Lens, &SeidelSettings),
    result: &Pixels,
    (format, within): (SeidelRect, SeidelRect),
    vergence: impl Fn((i32, i32)) -> f64,
) -> Result<Outcome> {
    let colours = COLOURS.len().min(result.channels() as usize);
    result.each(within, |result, place| {
        for channel in 0..result.channels() {
            result.put(place, channel, if channel == 3 { 1.0 } else { 0.0 });
        }
    });
    for (x, y) in points(format) {
        let pixel = (x.floor() as i32, y.floor() as i32);
        let vergence = vergence(pixel);
        if !(vergence.is_finite() && vergence >= 0.0) {
            continue;
        }
        if effect.is_aborted() {
            return Ok(Outcome::Aborted);
        }
        let kernel = |colour: &&str| {
            let channel = lens.channel(colour);
            lens.kernel(settings, (format, channel), (x, y), 1.0 / vergence)
        };
        let kernels = COLOURS[..colours].iter().map(kernel);
        let kernels = kernels.collect::<Result<Vec<_>>>()?;
        // One measure for all colours, so that what a colour has wider is dimmer.
        let all = kernels.iter().flat_map(|kernel| &kernel.weights);
        let peak = all.fold(0.0_f32, |peak, weight| peak.max(*weight));
        for (channel, kernel) in kernels.iter().enumerate() {
            let columns = kernel.window.width.max(1) as usize;
            for (k, weight) in kernel.weights.iter().enumerate() {
                let place = (
                    pixel.0 + kernel.window.left + (k % columns) as i32,
                    pixel.1 + kernel.window.top + (k / columns) as i32,
                );
                if !contains(within, place) {
                    continue;
                }
                let old = result.get(place, channel as u32).unwrap_or(0.0);
                result.put(place, channel as u32, old + weight / peak);
            }
        }
    }
    Ok(Outcome::Done)
}

fn contains(rect: SeidelRect, (x, y): (i32, i32)) -> bool {
    (rect.left..rect.left + rect.width).contains(&x)
        && (rect.top..rect.top + rect.height).contains(&y)
}
