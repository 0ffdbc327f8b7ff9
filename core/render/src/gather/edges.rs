//! The boundary condition at the plate's edges, on any level of the pyramid.
//!
//! Light that leaves a mirrored plate is folded back. Upsampling is symmetric and aligned with the plate's pixels.
//! Folding before it equals folding after it wherever the plate's edges lie between pixels of the level.

use super::image::{Image, Rect, Size};
use super::plan::Level;
use super::pyramid::MARGIN;
use crate::scatter::fold;
use crate::{Edges, RenderWindow};

/// Chooses the level at which light beyond the edges is folded back, and drops finer tiles that lie beyond them.
///
/// It is the coarsest level below which all tiles are upsampled and whose pixels divide the plate evenly. Finer
/// levels then need nothing beyond the plate.
pub(super) fn fold_early(size: Size, edges: Edges, levels: &mut [Level]) -> usize {
    if edges == Edges::Black {
        return 0;
    }
    let Size { width, height } = size;
    let upsampled = levels.iter().take_while(|l| l.gathered.is_empty()).count();
    let coarsest = upsampled.min(levels.len().saturating_sub(1));
    let divides = |level: &usize| (width | height).trailing_zeros() as usize >= *level;
    let fold_level = (0..=coarsest).rev().find(divides).unwrap_or(0);
    for (index, level) in levels[..fold_level].iter_mut().enumerate() {
        let side = level.grid.tile;
        let within =
            |at: i32, size: usize| usize::try_from(at).is_ok_and(|at| at * side < size >> index);
        level
            .upsampled
            .retain(|tile| within(tile.row, height) && within(tile.column, width));
    }
    fold_level
}

/// Returns `window` of a plate of `size` out of `image`; samples beyond the plate are folded back or dropped.
pub(super) fn folded(image: &Image, size: Size, edges: Edges, window: RenderWindow) -> Vec<f32> {
    let mut out = vec![0.0_f32; window.width * window.height];
    add_folded(image, size, edges, window, &mut out);
    out
}

/// Adds the result of [`folded`] to `out`, a `window` of a plate of `size`.
pub(super) fn add_folded(
    image: &Image,
    size: Size,
    edges: Edges,
    window: RenderWindow,
    out: &mut [f32],
) {
    let Size { width, height } = size;
    let end = image.left + image.width as i32;
    let (first, last) = (window.column as i32, (window.column + window.width) as i32);
    let inside = image.left.max(first).min(last)..end.max(first).min(last);
    let slot = |at: usize, first: usize, size: usize| at.checked_sub(first).filter(|k| *k < size);
    for (y, line) in image.samples.chunks_exact(image.width.max(1)).enumerate() {
        let Some(row) = fold(image.top + y as i32, height, edges)
            .and_then(|row| slot(row, window.row, window.height))
        else {
            continue;
        };
        let out = &mut out[row * window.width..(row + 1) * window.width];
        let mut add = |columns: std::ops::Range<i32>| {
            for column in columns {
                if let Some(place) = fold(column, width, edges)
                    .and_then(|place| slot(place, window.column, window.width))
                {
                    out[place] += line[(column - image.left) as usize];
                }
            }
        };
        // Columns of the plate outside the window do not land in it.
        add(image.left..end.min(0));
        add(image.left.max(width as i32)..end);
        if inside.is_empty() {
            continue;
        }
        let outs = &mut out[(inside.start - first) as usize..(inside.end - first) as usize];
        for (out, light) in outs
            .iter_mut()
            .zip(&line[(inside.start - image.left) as usize..])
        {
            *out += light;
        }
    }
}

/// The transpose of [`folded`] for the whole plate: an image over `rect` whose pixels hold the sample that their light
/// is folded onto, zero where it is dropped.
pub(super) fn unfolded(samples: &[f32], size: Size, edges: Edges, rect: Rect) -> Image {
    let mut image = Image::zeros(rect);
    let columns: Vec<Option<usize>> = (0..rect.width)
        .map(|x| fold(rect.left + x as i32, size.width, edges))
        .collect();
    for (y, out) in image
        .samples
        .chunks_exact_mut(rect.width.max(1))
        .enumerate()
    {
        let Some(row) = fold(rect.top + y as i32, size.height, edges) else {
            continue;
        };
        let line = &samples[row * size.width..(row + 1) * size.width];
        for (out, column) in out.iter_mut().zip(&columns) {
            *out = column.map_or(0.0, |column| line[column]);
        }
    }
    image
}

/// Returns a plane of `size` with the mirrored margin that upsampling reads.
pub(super) fn with_mirrored_margin(samples: &[f32], size: Size) -> Image {
    let wider = |size: usize| -MARGIN..size as i32 + MARGIN;
    let mut image = Image::zeros(margin_rect(size));
    let columns: Vec<usize> = wider(size.width)
        .filter_map(|x| fold(x, size.width, Edges::Mirror))
        .collect();
    let stride = image.width.max(1);
    for (y, out) in wider(size.height).zip(image.samples.chunks_exact_mut(stride)) {
        let Some(row) = fold(y, size.height, Edges::Mirror) else {
            continue;
        };
        let line = &samples[row * size.width..(row + 1) * size.width];
        for (out, column) in out.iter_mut().zip(&columns) {
            *out = line[*column];
        }
    }
    image
}

/// Returns the rectangle of a plane of `size` with the margin that upsampling reads.
pub(super) fn margin_rect(size: Size) -> Rect {
    let margin = 2 * MARGIN as usize;
    Rect {
        left: -MARGIN,
        top: -MARGIN,
        width: size.width + margin,
        height: size.height + margin,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gather::pyramid::{UpsampleBuffers, upsample_tile};

    /// Upsamples the square of `side` pixels whose first column and row are `start`.
    fn upsampled(coarse: &Image, start: i32, side: usize) -> Image {
        let mut image = Image::zeros(Rect {
            left: start,
            top: start,
            width: side,
            height: side,
        });
        let buffers = &mut UpsampleBuffers::default();
        upsample_tile(
            &coarse.view(),
            start,
            start,
            side,
            buffers,
            &mut image.samples,
        );
        image
    }

    #[test]
    fn folding_before_upsampling_equals_folding_after() {
        let mut coarse = Image::zeros(Rect {
            left: -14,
            top: -12,
            width: 37,
            height: 33,
        });
        for (k, sample) in coarse.samples.iter_mut().enumerate() {
            *sample = ((k * 7919) % 101) as f32 / 101.0;
        }
        let size = |width, height| Size { width, height };
        let (fine_size, coarse_size) = (size(16, 12), size(8, 6));
        let whole = |image: &Image, size: Size, edges: Edges| {
            let window = RenderWindow::from_size(size.width, size.height);
            folded(image, size, edges, window)
        };
        let late = whole(&upsampled(&coarse, -48, 112), fine_size, Edges::Mirror);
        let closed = whole(&coarse, coarse_size, Edges::Mirror);
        let closed = with_mirrored_margin(&closed, coarse_size);
        let early = whole(&upsampled(&closed, 0, 16), fine_size, Edges::Black);
        for (early, late) in early.iter().zip(&late) {
            assert!((early - late).abs() < 1e-4, "{early} {late}");
        }
    }
}
