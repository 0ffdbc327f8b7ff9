//! The scattering of sparse light: lit tiles spread their light, level by level, and the levels are upsampled and added.
//!
//! The cost grows with the lit area, not with the area that the blur reaches.

use super::edges::{add_folded, with_mirrored_margin};
use super::fir::BilinearFir;
use super::gather_pass::set_corners;
use super::image::{Image, Rect, Size, View};
use super::pyramid::{MARGIN, UpsampleBuffers, upsample_tile};
use super::source_tiles::{SourceLevel, SourceTiles};
use super::spread::{TileLight, spread};
use super::tile_grid::GridIndex;
use crate::{Edges, RenderWindow, cancelled};
use rayon::prelude::*;
use seidel_optics::error::Result;

/// Tiles scattered before they are added to their level; bounds the memory taken.
const WAVE: usize = 64;

/// Side of the squares that are upsampled, px.
const SQUARE: usize = 64;

/// Light to scatter over a plate.
pub(super) struct ScatterPass<'a> {
    /// Finest first.
    pub(super) levels: Vec<SourceLevel>,
    /// Index of each plane's light on every level.
    pub(super) light_of: &'a [usize],
    /// Index of each plane's channel mix.
    pub(super) mix_of: &'a [usize],
    pub(super) size: Size,
    pub(super) edges: Edges,
}

/// The pixels of a level in which its light is summed.
#[derive(Clone, Copy)]
enum Target {
    /// Those of the plate: light beyond its edges is folded back or dropped at once.
    Plate(Size),
    /// All that light reaches.
    Reached,
}

impl Target {
    fn rect(self, level: &SourceLevel) -> Rect {
        match self {
            Self::Plate(Size { width, height }) => Rect {
                left: 0,
                top: 0,
                width,
                height,
            },
            Self::Reached => level.reached,
        }
    }
}

impl ScatterPass<'_> {
    /// Returns the blurred plates.
    ///
    /// # Errors
    /// A cancelled render, if `progress` returned false.
    pub(super) fn render(
        mut self,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Vec<Vec<f32>>> {
        let count: usize = self.levels.iter().map(SourceLevel::tile_count).sum();
        let mut done = 0;
        let mut coarser: Vec<Image> = vec![Image::default(); self.mix_of.len()];
        let level_count = self.levels.len();
        // What is done with is dropped at once: all of it is several times the plate.
        while let Some(level) = self.levels.pop() {
            let index = self.levels.len();
            // Each is allocated as zeros, which the system gives page by page once they are written; clones would be copied.
            let target = self.target(index);
            let mut images: Vec<Image> = (0..self.mix_of.len())
                .map(|_| Image::zeros(target.rect(&level)))
                .collect();
            for part in &level.parts {
                for wave in part.tiles.chunks(WAVE) {
                    self.add_wave(&level.light, part, wave, target, &mut images);
                    done += wave.len();
                    if !progress(done as f64 / count as f64) {
                        return Err(cancelled());
                    }
                }
            }
            drop(level);
            let is_closed = index + 1 < level_count && self.closes(index + 1);
            let images = images.into_par_iter().zip(coarser);
            coarser = images
                .map(|(image, coarser)| self.joined(index, target, image, &coarser, is_closed))
                .collect();
        }
        Ok(coarser.into_iter().map(|image| image.samples).collect())
    }

    /// Scatters the `light` of a wave of tiles into `images`.
    fn add_wave(
        &self,
        light: &[Image],
        part: &SourceTiles,
        wave: &[GridIndex],
        target: Target,
        images: &mut [Image],
    ) {
        let side = part.grid.tile;
        let mixes = 0..self.mix_of.iter().max().map_or(0, |last| last + 1);
        let patches: Vec<Vec<Option<Image>>> = wave
            .par_iter()
            // Light fills tiles unevenly.
            .with_max_len(4)
            .map_init(BilinearFir::default, |fir, tile| {
                let [left, top] = part.grid.first_pixel(*tile);
                let take = |image| TileLight::take(image, left, top, side);
                let light: Vec<Option<TileLight>> = light.iter().map(take).collect();
                let mut patches = vec![None; self.mix_of.len()];
                for mix in mixes.clone() {
                    let planes = (self.mix_of.iter().enumerate()).filter(|(_, of)| **of == mix);
                    let (lit, lights): (Vec<usize>, Vec<&TileLight>) = planes
                        .filter_map(|(plane, _)| {
                            let light = light[self.light_of[plane]].as_ref()?;
                            Some((plane, light))
                        })
                        .unzip();
                    if lit.is_empty() {
                        continue;
                    }
                    set_corners(side, &part.kernels, mix, *tile, fir);
                    if fir.len() > 0 {
                        for (plane, patch) in lit.into_iter().zip(spread(fir, &lights, left, top)) {
                            patches[plane] = Some(patch);
                        }
                    }
                }
                patches
            })
            .collect();
        images
            .par_iter_mut()
            .enumerate()
            .for_each(|(plane, image)| {
                for patch in patches.iter().filter_map(|patches| patches[plane].as_ref()) {
                    match target {
                        Target::Plate(size) => {
                            let whole = RenderWindow::from_size(size.width, size.height);
                            add_folded(patch, size, self.edges, whole, &mut image.samples);
                        }
                        Target::Reached => image.add(patch),
                    }
                }
            });
    }

    /// Returns where the light of level `index` is summed.
    fn target(&self, index: usize) -> Target {
        // Light may be folded back where the plate's edges lie between pixels of the level.
        if index == 0 || self.closes(index) {
            Target::Plate(self.size_at(index))
        } else {
            Target::Reached
        }
    }

    fn size_at(&self, level: usize) -> Size {
        Size {
            width: self.size.width.div_ceil(1 << level),
            height: self.size.height.div_ceil(1 << level),
        }
    }

    /// Adds the upsampled `coarser` level to `image` and cuts both to what the next finer level needs. `is_closed` says whether
    /// `coarser` holds a plate with mirrored margins.
    fn joined(
        &self,
        level: usize,
        target: Target,
        mut image: Image,
        coarser: &Image,
        is_closed: bool,
    ) -> Image {
        let size = self.size_at(level);
        if let Target::Plate(_) = target {
            if is_closed {
                add_upsampled(&mut image, &coarser.view());
            } else if !coarser.samples.is_empty() {
                let whole = RenderWindow::from_size(size.width, size.height);
                let mut finer = Image::zeros(upsampled_rect(coarser));
                add_upsampled(&mut finer, &coarser.view());
                add_folded(&finer, size, self.edges, whole, &mut image.samples);
            }
            if level == 0 {
                return image;
            }
            return with_mirrored_margin(&image.samples, size);
        }
        let mut rect = image.rect().joined(upsampled_rect(coarser));
        if self.edges == Edges::Black {
            // What lies farther beyond the plate is dropped in the end.
            rect = within_margin(rect, size);
        }
        let mut all = image.cropped(rect);
        add_upsampled(&mut all, &coarser.view());
        all
    }

    /// Returns whether light beyond the plate is folded back at `level`, so that its image holds a plate with mirrored margins.
    fn closes(&self, level: usize) -> bool {
        let divides = (self.size.width | self.size.height).trailing_zeros() as usize >= level;
        divides && self.edges == Edges::Mirror
    }
}

/// Returns the pixels of the next finer level that upsampling `coarse` lights.
fn upsampled_rect(coarse: &Image) -> Rect {
    if coarse.samples.is_empty() {
        return Rect::default();
    }
    let margin = 2 * MARGIN as usize;
    Rect {
        left: 2 * (coarse.left - MARGIN),
        top: 2 * (coarse.top - MARGIN),
        width: 2 * (coarse.width + margin),
        height: 2 * (coarse.height + margin),
    }
}

/// Returns the part of `rect` within the margin of a plate of `size` that upsampling reads.
fn within_margin(rect: Rect, size: Size) -> Rect {
    let cut = |start: i32, length: usize, size: usize| {
        let low = start.max(-MARGIN);
        let high = (start + length as i32).min(size as i32 + MARGIN);
        (low, (high - low).max(0) as usize)
    };
    let (left, width) = cut(rect.left, rect.width, size.width);
    let (top, height) = cut(rect.top, rect.height, size.height);
    Rect {
        left,
        top,
        width,
        height,
    }
}

/// Adds the next coarser level, upsampled, to `image`.
fn add_upsampled(image: &mut Image, coarse: &View) {
    if coarse.samples.is_empty() || image.samples.is_empty() {
        return;
    }
    // Upsampled squares begin at even pixels.
    let even = |at: i32| at.div_euclid(2) * 2;
    let (left, width) = (image.left, image.width);
    let top = image.top;
    let bands = image.samples.par_chunks_mut(width * SQUARE).enumerate();
    bands.for_each_init(
        || (UpsampleBuffers::default(), vec![0.0; 4 * SQUARE * SQUARE]),
        |(buffers, square), (band, lines)| {
            let first_row = top + (band * SQUARE) as i32;
            // One more pixel where the band begins at an odd one.
            let side = SQUARE + 2;
            let square = &mut square[..side * side];
            for column in (0..width).step_by(SQUARE) {
                let first = left + column as i32;
                let (x, y) = (even(first), even(first_row));
                upsample_tile(coarse, x, y, side, buffers, square);
                let (skip_x, skip_y) = ((first - x) as usize, (first_row - y) as usize);
                for (row, line) in lines.chunks_exact_mut(width).enumerate() {
                    let from = &square[(row + skip_y) * side + skip_x..];
                    let end = (column + SQUARE).min(width);
                    for (out, value) in line[column..end].iter_mut().zip(from) {
                        *out += value;
                    }
                }
            }
        },
    );
}
