//! Curves of cameras and displays, channel by channel.

use seidel_colour::curves::{CurveTable, TransferFunction};

use crate::host::{Failure, Result};
use crate::knobs::colour;
use crate::rendering::Copied;

/// The curve that is `chosen`.
///
/// # Errors
/// None but of a build from a table that is not in order.
pub(super) fn of(chosen: i32) -> Result<&'static TransferFunction> {
    let table = CurveTable::embedded().map_err(|why| Failure::failed(why.to_string()))?;
    let name = usize::try_from(chosen)
        .ok()
        .and_then(|chosen| colour::CURVES.get(chosen));
    let name = name.copied().unwrap_or_default();
    let curve = table.curves.get(name);
    let curve = curve
        .ok_or_else(|| Failure::failed(format!("Source Encoding: there is no curve `{name}`.")))?;
    Ok(&curve.transfer)
}

/// Changes colours, alpha aside, by which they may be multiplied.
pub(super) fn change(
    picture: &mut Copied,
    premultiplied: bool,
    threads: u32,
    change: impl Fn(f64) -> f64 + Sync,
) {
    let channels = picture.channels();
    picture.parts(threads, |part| {
        for pixel in part.chunks_exact_mut(channels) {
            let alpha = pixel.get(3).copied().unwrap_or(1.0);
            let divided = premultiplied && alpha != 0.0 && alpha.is_finite();
            let alpha = if divided { f64::from(alpha) } else { 1.0 };
            for sample in &mut pixel[..channels.min(3)] {
                *sample = (alpha * change(f64::from(*sample) / alpha)) as f32;
            }
        }
    });
}
