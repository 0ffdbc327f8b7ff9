//! A pass turned round: from light on the blurred plate to the sources that it could have come from.
//!
//! Every step of the pass is linear, and its transpose is at hand: doubling is four times the transpose of
//! halving, a blend's is another blend, folding's is unfolding. So <A x, y> = <x, A^T y> to rounding.

use super::edges::{cut, unfolded};
use super::fir::{Blend, LANES};
use super::image::{Image, View};
use super::pass::{Pass, gathered_size, set_blend};
use super::plan::Level;
use super::pyramid::{Doubling, MARGIN, doubled, halved};
use crate::{Edges, RenderWindow};
use rayon::prelude::*;

/// Side of the squares in which light is taken down the pyramid, pixels.
const SQUARE: usize = 64;

impl Pass {
    /// The adjoint of [`Pass::forward`] for the whole plate, of the plane that has `index`.
    pub(super) fn adjoint(&self, plate: &[f32], index: usize) -> Vec<f32> {
        let mix = self.mix_of[index];
        let mut sources = self.sources();
        let Some(first) = self.levels.first() else {
            return sources.swap_remove(0).samples;
        };
        let mut light = unfolded(plate, self.size, self.edges_at(0), Self::place(first));
        for (index, level) in self.levels.iter().enumerate() {
            self.spread(index, mix, &light, &mut sources[index]);
            let Some(above) = self.levels.get(index + 1) else {
                break;
            };
            let only_doubled = kept(level, &light);
            let mut coarse = halved(&only_doubled.view());
            coarse.samples.iter_mut().for_each(|v| *v *= 4.0);
            light = self.opened(&coarse, index + 1, Self::place(above));
        }
        for index in (1..sources.len()).rev() {
            let (finer, coarser) = sources.split_at_mut(index);
            if let (Some(finer), Some(coarser)) = (finer.last_mut(), coarser.first()) {
                add_doubled(finer, &coarser.view());
            }
        }
        sources.swap_remove(0).samples
    }

    /// Dark images of the sources on each level.
    fn sources(&self) -> Vec<Image> {
        let mut sources = vec![Image::zeros((0, 0), self.size)];
        for level in 1..self.levels.len() {
            sources.push(halved(&sources[level - 1].view()));
        }
        sources
    }

    /// The other way round than what closes the images of `level`, which has this place.
    fn opened(&self, light: &Image, level: usize, place: ((i32, i32), (usize, usize))) -> Image {
        if level > self.folded {
            return light.cropped(place);
        }
        let size = self.size_at(level);
        let margin = 2 * MARGIN as usize;
        let seen = ((-MARGIN, -MARGIN), (size.0 + margin, size.1 + margin));
        let seen = light.cropped(seen);
        let folded = cut(
            &seen,
            size,
            Edges::Mirror,
            RenderWindow::from_size(size.0, size.1),
        );
        unfolded(&folded, size, self.edges_at(level), place)
    }

    /// Adds to `sources` of level `index` what its gathered tiles see there.
    fn spread(&self, index: usize, mix: usize, light: &Image, sources: &mut Image) {
        let (level, stencils) = (&self.levels[index], &self.stencils[index]);
        let tiles: Vec<(i32, i32)> = level.gathered.iter().copied().collect();
        let spread = tiles.par_iter().map_init(
            || (Blend::default(), Vec::new()),
            |(blend, window), tile| {
                set_blend((level, stencils, mix), *tile, blend);
                turned_tile(blend, (level.grid.tile, *tile), light, window)
            },
        );
        sources.add_all(&spread.flatten().collect::<Vec<_>>());
    }
}

/// What a tile of some side at (row, column) sees, its light being in `light`; none where it is dark.
fn turned_tile(
    blend: &Blend,
    (side, (row, column)): (usize, (i32, i32)),
    light: &Image,
    window: &mut Vec<f32>,
) -> Option<Image> {
    if blend.len() == 0 {
        return None;
    }
    let mut turned = blend.turned();
    let (columns, rows) = (blend.columns.len() - 1, blend.rows.len() - 1);
    let (width, height) = (
        gathered_size(side + columns).0,
        gathered_size(side + rows).1,
    );
    let stride = width + columns + LANES;
    window.clear();
    window.resize(stride * (height + rows), 0.0);
    let corner = (column * side as i32, row * side as i32);
    let tile = light.cropped((corner, (side, side)));
    if tile.samples.iter().all(|v| *v == 0.0) {
        return None;
    }
    for (y, line) in tile.samples.chunks_exact(side).enumerate() {
        window[(rows + y) * stride + columns..][..side].copy_from_slice(line);
    }
    let mut out = vec![0.0; width * height];
    turned.gather(window, stride, width, &mut out);
    let place = (corner.0 + blend.columns.start, corner.1 + blend.rows.start);
    let mut seen = Image::zeros(place, (side + columns, side + rows));
    for (line, out) in seen
        .samples
        .chunks_exact_mut(side + columns)
        .zip(out.chunks_exact(width))
    {
        line.copy_from_slice(&out[..side + columns]);
    }
    Some(seen)
}

/// What of `light` lies in tiles that are doubled.
fn kept(level: &Level, light: &Image) -> Image {
    let mut kept = Image::zeros((light.left, light.top), (light.width, light.height));
    let side = level.grid.tile;
    for &(row, column) in &level.doubled {
        let corner = (column * side as i32, row * side as i32);
        kept.add(&light.cropped((corner, (side, side))));
    }
    kept
}

/// Adds to `finer` the transpose of halving of what is on the level above.
fn add_doubled(finer: &mut Image, coarser: &View) {
    // Doubling begins at even pixels.
    let first = (finer.left.div_euclid(2) * 2, finer.top.div_euclid(2) * 2);
    let end = (
        finer.left + finer.width as i32,
        finer.top + finer.height as i32,
    );
    let rows: Vec<i32> = (first.1..end.1).step_by(SQUARE).collect();
    let places: Vec<(i32, i32)> = rows
        .iter()
        .flat_map(|top| (first.0..end.0).step_by(SQUARE).map(|left| (left, *top)))
        .collect();
    let squares = places
        .par_iter()
        .map_init(Doubling::default, |space, place| {
            let mut square = Image::zeros(*place, (SQUARE, SQUARE));
            doubled(coarser, *place, SQUARE, space, &mut square.samples);
            square.samples.iter_mut().for_each(|v| *v *= 0.25);
            square
        });
    finer.add_all(&squares.collect::<Vec<_>>());
}
