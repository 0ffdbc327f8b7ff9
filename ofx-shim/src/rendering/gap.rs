//! The gap map: where a result and a photograph differ.

use seidel_core::{Image, PLATE_GAP_BLOCK_PX, Rectangle, picture_gap};

use super::Source;
use crate::clips::REFERENCE;
use crate::geometry::PixelMap;
use crate::host::{Call, Failure, Result};
use crate::interleaved::Interleaved;
use crate::knobs::Knobs;

/// Returns the gap between `result` and the input Reference over `window`: that of its block in each colour, 0 where the
/// reference has no pixels, with an alpha of 1.
///
/// # Errors
/// No reference, or one of other channels; one that cannot be read.
pub(crate) fn gap_map(
    call: &Call,
    knobs: &Knobs,
    map: PixelMap,
    result: &Interleaved,
    window: Rectangle,
) -> Result<Interleaved> {
    let extent = result.rectangle();
    let reference = Source::fetch_optional(call, REFERENCE)?.ok_or_else(|| {
        Failure::failed(
            "Output: Gap compares the result with the input Reference; connect the photograph there, or set Output to Result.",
        )
    })?;
    let encoding = reference.encoding(call, knobs)?;
    let mut photograph = reference
        .read(knobs, map, extent, encoding.as_ref())?
        .with_alpha(None, Vec::new(), Default::default());
    let known = reference.rectangle(map);
    for plane in &mut photograph.colours {
        let rows = plane.chunks_exact_mut(extent.width).zip(extent.rows());
        for (row, y) in rows {
            for (value, x) in row.iter_mut().zip(extent.columns()) {
                if !known.is_some_and(|known| known.contains(x, y)) {
                    *value = f32::NAN;
                }
            }
        }
    }
    let channels = result.channels();
    let planes = (0..photograph.colours.len().min(channels)).map(|channel| result.plane(channel));
    let rendering = Image::new(
        extent.width,
        extent.height,
        photograph.names.clone(),
        planes.collect(),
    )?;
    let gap = picture_gap(&photograph, &rendering)?;
    Interleaved::new(window, channels, |(x, y), row| {
        let block_row = (y - extent.y) as usize / PLATE_GAP_BLOCK_PX;
        for (pixel, x) in row.chunks_exact_mut(channels).zip(x..) {
            let block = block_row * gap.columns + (x - extent.x) as usize / PLATE_GAP_BLOCK_PX;
            pixel.fill(1.0);
            for (value, channel) in pixel.iter_mut().zip(&gap.channels) {
                let gap = channel.blocks[block];
                *value = if gap.is_nan() { 0.0 } else { gap as f32 };
            }
        }
    })
}
