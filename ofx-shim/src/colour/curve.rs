//! Transfer functions of cameras and displays, applied to each channel.

use seidel_colour::curves::{CurveTable, TransferFunction};

use super::AlphaHandling;
use crate::host::{Failure, Result};
use crate::interleaved::Interleaved;
use crate::knobs::colour;

/// Returns the transfer function of the option `chosen` of Source Encoding.
///
/// # Errors
/// An embedded table of curves that is not valid, or lacks the curve: a defect of the build.
pub(super) fn transfer_function(chosen: i32) -> Result<&'static TransferFunction> {
    let table = CurveTable::embedded().map_err(|error| Failure::failed(error.to_string()))?;
    let name = usize::try_from(chosen)
        .ok()
        .and_then(|chosen| colour::CURVES.get(chosen));
    let name = name.copied().unwrap_or_default();
    let curve = table.curves.get(name).ok_or_else(|| {
        Failure::failed(format!(
            "Source Encoding: the curve `{name}` does not exist; please report it."
        ))
    })?;
    Ok(&curve.transfer)
}

/// Applies `function` to the colours of `image`, divided by alpha where they are premultiplied. Alpha stays.
pub(super) fn convert(
    image: &mut Interleaved,
    alpha: AlphaHandling,
    threads: u32,
    function: impl Fn(f64) -> f64 + Sync,
) {
    let channels = image.channels();
    image.for_each_part(threads, |part| {
        for pixel in part.chunks_exact_mut(channels) {
            let own = pixel.get(3).copied().unwrap_or(1.0);
            let is_divided = alpha == AlphaHandling::Premultiplied && own != 0.0 && own.is_finite();
            let divisor = if is_divided { f64::from(own) } else { 1.0 };
            for sample in &mut pixel[..channels.min(3)] {
                *sample = (divisor * function(f64::from(*sample) / divisor)) as f32;
            }
        }
    });
}
