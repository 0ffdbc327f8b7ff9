//! What lies beyond the plate's edges, on any level of the pyramid.
//!
//! Light that leaves a mirrored plate is folded back. Doubling is even and keeps to the plate's grid, so
//! that folding before it is as good as after, where the plate's edges lie between pixels of the level.

use super::image::Image;
use super::plan::Level;
use super::pyramid::MARGIN;
use crate::scatter::fold;
use crate::{Edges, RenderWindow};

/// The level at which light beyond the edges of a plate of `size` is folded back: the coarsest below
/// which all tiles are doubled, and of whose pixels the plate is made up. Finer levels then need nothing
/// beyond the plate, and their tiles there are taken off.
pub(super) fn fold_early(
    (width, height): (usize, usize),
    edges: Edges,
    levels: &mut [Level],
) -> usize {
    if edges == Edges::Black {
        return 0;
    }
    let doubled = levels.iter().take_while(|l| l.gathered.is_empty()).count();
    let coarsest = doubled.min(levels.len().saturating_sub(1));
    let whole = |level: &usize| (width | height).trailing_zeros() as usize >= *level;
    let folded = (0..=coarsest).rev().find(whole).unwrap_or(0);
    for (index, level) in levels[..folded].iter_mut().enumerate() {
        let side = level.grid.tile;
        let within =
            |at: i32, size: usize| usize::try_from(at).is_ok_and(|at| at * side < size >> index);
        level
            .doubled
            .retain(|(row, column)| within(*row, height) && within(*column, width));
    }
    folded
}

/// The `window` of a plate of `size` out of `image`; what is beyond the plate is folded back or left out.
pub(super) fn cut(
    image: &Image,
    (width, height): (usize, usize),
    edges: Edges,
    window: RenderWindow,
) -> Vec<f32> {
    let mut out = vec![0.0_f32; window.width * window.height];
    fold_onto(image, (width, height), edges, window, &mut out);
    out
}

/// Adds to `out`, a `window` of a plate of `size`, what [`cut`] gives.
pub(super) fn fold_onto(
    image: &Image,
    (width, height): (usize, usize),
    edges: Edges,
    window: RenderWindow,
    out: &mut [f32],
) {
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
        // On the plate but outside the window nothing lands in it.
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

/// The other way round than [`cut`] of a whole plate of `size`: an image over columns and rows from `place` on
/// with at each pixel the sample onto which its light is folded, zero where it is left out.
pub(super) fn unfolded(
    samples: &[f32],
    (width, height): (usize, usize),
    edges: Edges,
    (place, size): ((i32, i32), (usize, usize)),
) -> Image {
    let mut image = Image::zeros(place, size);
    let columns: Vec<Option<usize>> = (0..size.0)
        .map(|x| fold(place.0 + x as i32, width, edges))
        .collect();
    for (y, out) in image.samples.chunks_exact_mut(size.0.max(1)).enumerate() {
        let Some(row) = fold(place.1 + y as i32, height, edges) else {
            continue;
        };
        let line = &samples[row * width..(row + 1) * width];
        for (out, column) in out.iter_mut().zip(&columns) {
            *out = column.map_or(0.0, |column| line[column]);
        }
    }
    image
}

/// An image of `size` with what doubling sees of the mirrored ones about it.
pub(super) fn mirrored(samples: &[f32], (width, height): (usize, usize)) -> Image {
    let wider = |size: usize| -MARGIN..size as i32 + MARGIN;
    let mut image = Image::zeros(
        (-MARGIN, -MARGIN),
        (wider(width).len(), wider(height).len()),
    );
    let columns: Vec<usize> = wider(width)
        .filter_map(|x| fold(x, width, Edges::Mirror))
        .collect();
    let stride = image.width.max(1);
    for (y, out) in wider(height).zip(image.samples.chunks_exact_mut(stride)) {
        let Some(row) = fold(y, height, Edges::Mirror) else {
            continue;
        };
        let line = &samples[row * width..(row + 1) * width];
        for (out, column) in out.iter_mut().zip(&columns) {
            *out = line[*column];
        }
    }
    image
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gather::pyramid::{Doubling, doubled};

    /// The square of `side` pixels from (`left`, `left`) on, out of the level above.
    fn double(coarse: &Image, left: i32, side: usize) -> Image {
        let mut image = Image::zeros((left, left), (side, side));
        let space = &mut Doubling::default();
        doubled(
            &coarse.view(),
            (left, left),
            side,
            space,
            &mut image.samples,
        );
        image
    }

    #[test]
    fn folding_before_doubling_is_as_good_as_after() {
        let mut coarse = Image::zeros((-14, -12), (37, 33));
        for (k, sample) in coarse.samples.iter_mut().enumerate() {
            *sample = ((k * 7919) % 101) as f32 / 101.0;
        }
        let (size, above) = ((16, 12), (8, 6));
        let all = |image: &Image, (width, height): (usize, usize), edges: Edges| {
            let window = RenderWindow {
                column: 0,
                row: 0,
                width,
                height,
            };
            cut(image, (width, height), edges, window)
        };
        let late = all(&double(&coarse, -48, 112), size, Edges::Mirror);
        let closed = mirrored(&all(&coarse, above, Edges::Mirror), above);
        let early = all(&double(&closed, 0, 16), size, Edges::Black);
        for (early, late) in early.iter().zip(&late) {
            assert!((early - late).abs() < 1e-4, "{early} {late}");
        }
    }
}
