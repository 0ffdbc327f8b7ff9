//! Texture of hidden samples in focus, continued from what the plate shows around them.
//!
//! The cell pyramid estimates hidden samples by local means, which is enough where the hidden surface is blurred. Where it is in focus, its
//! bricks, lines and patterns would end at a blurred foreground. They are continued by non-local means over offsets (Buades et al. 2005; He
//! and Sun 2012). The visible pixels about a block are compared with the same pixels moved by an offset s (`offset_search`):
//!
//!   D(s) = mean of |I(x) - I(x + s)|² over the variance V of I,   hidden sample = sum of w(s) I(x + s) / sum of w(s),
//!
//! with w = exp(-D / T), over the best offsets. So periods and lines are continued, from both sides of a thin foreground. The mean of D
//! estimates the error. Where it is no less than the error of the local mean, which the variogram of I gives, the local mean stays.

mod offset_search;

use super::cell_pyramid::{self, JUMP};
use super::depth_layers::DepthLayers;
use super::edge_distance::EdgeDistance;
use super::extra_samples::{ExtraSamples, SPARE_PX};
use super::layered_plate::LayeredPlate;
use offset_search::{BlockOffsets, OffsetSearch, window_weights};
use rayon::prelude::*;

/// Side of the blocks whose samples share offsets, on a grid fixed to the frame, px. With 16 `foreground` of docs/background/depth-edges.md
/// loses 0.4 dB.
const BLOCK_PX: usize = 8;
/// Side of the tiles of blocks that share a copy of their surroundings, px.
const TILE_PX: usize = 32;
/// Width of the surroundings of a block that are compared, px.
const ABOUT_PX: usize = 12;
/// Largest offset along either axis, px. With 24 `foreground` loses 0.5 dB.
const OFFSET_PX: usize = 32;
/// Width of the margin about a tile.
const MARGIN_PX: usize = ABOUT_PX + OFFSET_PX;
/// Side of a tile with its margin.
const LOCAL_PX: usize = TILE_PX + 2 * MARGIN_PX;
/// Largest kernel size of a hidden surface whose texture is continued, px; at twice the size no texture is left.
const SHARP_PX: f32 = 2.0;
/// Distance from what is visible at which texture begins to be continued, and the width of the transition, px. Closer pixels are interpolated:
/// from 0 px on hair before a sharp wall loses 0.6 dB.
const FIRST_PX: f32 = 0.5;
const TRANSITION_PX: f32 = 1.0;
/// One over the least share of the weights of offsets that lead to visible pixels.
const FULL_VISIBILITY: f32 = 10.0;

/// The plate whose texture is continued, its depth and the distances from its edges.
pub(super) struct VisibleTexture<'a> {
    pub(super) input: &'a LayeredPlate<'a>,
    pub(super) layers: &'a DepthLayers,
    pub(super) distance: &'a EdgeDistance,
    /// Weights of pixels as the far sides of jumps.
    pub(super) band: &'a [f32],
}

/// Rows of hidden samples that lie in one row of tiles.
struct TileRows<'a> {
    /// Row of the plate of the first.
    first: usize,
    rows: &'a mut [ExtraSamples],
}

/// A hidden sample whose texture is continued.
struct HiddenPixel {
    /// Row within the row of tiles, and place of the sample in it.
    row: usize,
    sample: usize,
    /// Position within the tile.
    place: [usize; 2],
    coordinate: f32,
    presence: f32,
    /// Distance from the visible side of its edge, px.
    distance_px: f32,
    /// Largest share of its light that is replaced.
    share: f32,
}

/// The plate about a tile, its margin included.
struct Surroundings {
    /// Sum of the planes of light.
    luminance: Vec<f32>,
    /// Those planes.
    light: Vec<Vec<f32>>,
    /// Layer coordinates; not a number at pixels beyond the plate and at mixed ones.
    coordinates: Vec<f32>,
    /// One at visible pixels of the surface that is continued.
    known: Vec<f32>,
}

impl VisibleTexture<'_> {
    /// Continues the texture of the hidden samples of all `rows` of the plate.
    pub(super) fn continue_behind(&self, rows: &mut [ExtraSamples]) {
        let [before_x, before_y] = self.input.origin.map(|at| at % TILE_PX);
        let mut tiles = Vec::new();
        let (mut rest, mut first) = (rows, 0);
        while !rest.is_empty() {
            let count = (TILE_PX - (first + before_y) % TILE_PX).min(rest.len());
            let (rows, after) = rest.split_at_mut(count);
            tiles.push(TileRows { first, rows });
            (rest, first) = (after, first + count);
        }
        let weights = window_weights();
        tiles.into_par_iter().for_each(|mut tiles| {
            let top = tiles.first as i64 - ((tiles.first + before_y) % TILE_PX) as i64;
            let mut local = None;
            for tile in 0..(self.input.width + before_x).div_ceil(TILE_PX) {
                let corner = [(tile * TILE_PX) as i64 - before_x as i64, top];
                let pixels = self.textured_pixels(&tiles, corner);
                if !pixels.is_empty() {
                    let planes = self.input.light_count;
                    let local = local.get_or_insert_with(|| Surroundings::empty(planes));
                    self.copy_surroundings(corner, local);
                    self.continue_tile(&mut tiles, pixels, corner, local, &weights);
                }
            }
        });
    }

    /// Returns the hidden samples whose texture shows, of the tile whose first pixel is `corner`.
    fn textured_pixels(&self, tiles: &TileRows, [left, top]: [i64; 2]) -> Vec<HiddenPixel> {
        let mut found = Vec::new();
        for (row, samples) in tiles.rows.iter().enumerate() {
            let first_of = |end: i64| samples.columns.partition_point(|c| i64::from(*c) < end);
            for sample in first_of(left)..first_of(left + TILE_PX as i64) {
                let column = samples.columns[sample] as usize;
                let index = (tiles.first + row) * self.input.width + column;
                let coordinate = samples.coordinates[sample];
                let size = self.layers.size(coordinate);
                let distance_px = self.distance.px(index);
                let reach = self.layers.size(self.input.coordinates[index]) + size + SPARE_PX;
                let sharp = (2.0 - size / SHARP_PX).clamp(0.0, 1.0);
                let apart = ((distance_px - FIRST_PX) / TRANSITION_PX).clamp(0.0, 1.0);
                // Farther in, blur uncovers next to nothing.
                let uncovered = (2.5 - 4.0 * distance_px / reach).clamp(0.0, 1.0);
                let share = sharp * apart * uncovered;
                if share > 0.0 {
                    found.push(HiddenPixel {
                        row,
                        sample,
                        place: [
                            (column as i64 - left) as usize,
                            ((tiles.first + row) as i64 - top) as usize,
                        ],
                        coordinate,
                        presence: samples.weights[sample],
                        distance_px,
                        share,
                    });
                }
            }
        }
        found
    }

    /// Copies the plate about the tile whose first pixel is `corner`.
    fn copy_surroundings(&self, corner: [i64; 2], local: &mut Surroundings) {
        let input = self.input;
        local.luminance.fill(0.0);
        local.coordinates.fill(f32::NAN);
        for (y, row) in on_plate(corner[1], input.height) {
            for (x, column) in on_plate(corner[0], input.width) {
                let (at, index) = (y * LOCAL_PX + x, row * input.width + column);
                let is_mixed = self.band[index] == cell_pyramid::AT_JUMP;
                if is_mixed || !input.known.holds(column, row) {
                    continue;
                }
                local.coordinates[at] = input.coordinates[index];
                for (out, plane) in local.light.iter_mut().zip(input.planes) {
                    out[at] = plane.samples[index];
                    local.luminance[at] += out[at];
                }
            }
        }
    }

    /// Continues the texture of the hidden `pixels` of the tile whose first pixel is `corner`, surface by surface.
    fn continue_tile(
        &self,
        tiles: &mut TileRows,
        mut pixels: Vec<HiddenPixel>,
        corner: [i64; 2],
        local: &mut Surroundings,
        weights: &[f32],
    ) {
        const BLOCKS: usize = TILE_PX / BLOCK_PX;
        while let Some(farthest) = pixels.iter().map(|pixel| pixel.coordinate).reduce(f32::min) {
            local.mark_known(farthest - JUMP, farthest + 2.0 * JUMP);
            let is_nearer = |pixel: &HiddenPixel| pixel.coordinate > farthest + JUMP;
            let (nearer, of_surface): (Vec<_>, Vec<_>) = pixels.into_iter().partition(is_nearer);
            pixels = nearer;
            let mut blocks: Vec<Vec<HiddenPixel>> = Vec::new();
            blocks.resize_with(BLOCKS * BLOCKS, Vec::new);
            for pixel in of_surface {
                let [x, y] = pixel.place.map(|at| at / BLOCK_PX);
                blocks[y * BLOCKS + x].push(pixel);
            }
            for (block, pixels) in blocks.iter().enumerate().filter(|(_, p)| !p.is_empty()) {
                let first = [block % BLOCKS, block / BLOCKS].map(|at| at * BLOCK_PX);
                let search = OffsetSearch::new(local, first, weights);
                let Some(offsets) = search.and_then(|search| search.best()) else {
                    continue;
                };
                for pixel in pixels {
                    self.replace(tiles, pixel, corner, &offsets, local);
                }
            }
        }
    }

    /// Replaces the light of a hidden pixel by the mean of the visible pixels at the `offsets` of its block.
    fn replace(
        &self,
        tiles: &mut TileRows,
        pixel: &HiddenPixel,
        corner: [i64; 2],
        offsets: &BlockOffsets,
        local: &Surroundings,
    ) {
        let planes = self.input.planes;
        // Weights and pixels of the plate.
        let mut visible = [(0.0, 0); offset_search::USED];
        let mut count = 0;
        for offset in &offsets.best {
            let moved = [
                pixel.place[0] as i64 + i64::from(offset.x),
                pixel.place[1] as i64 + i64::from(offset.y),
            ];
            let [x, y] = moved.map(|at| (at + MARGIN_PX as i64) as usize);
            if local.known[y * LOCAL_PX + x] > 0.0 {
                let [column, row] = [0, 1].map(|axis| (moved[axis] + corner[axis]) as usize);
                visible[count] = (offset.weight, row * self.input.width + column);
                count += 1;
            }
        }
        let visible = &visible[..count];
        let known: f32 = visible.iter().map(|(weight, _)| weight).sum();
        if known == 0.0 {
            return;
        }
        let visibility = (FULL_VISIBILITY * known / offsets.weight).min(1.0);
        let share = pixel.share * visibility * offsets.share(pixel.distance_px);
        let samples = &mut tiles.rows[pixel.row].samples[pixel.sample * planes.len()..];
        for (sample, plane) in samples.iter_mut().zip(planes) {
            let light = visible
                .iter()
                .map(|(weight, index)| weight * plane.samples[*index]);
            *sample += share * (pixel.presence * light.sum::<f32>() / known - *sample);
        }
    }
}

impl Surroundings {
    fn empty(planes: usize) -> Self {
        let [luminance, coordinates, known] = [0.0; 3].map(|v| vec![v; LOCAL_PX * LOCAL_PX]);
        Self {
            light: vec![luminance.clone(); planes],
            luminance,
            coordinates,
            known,
        }
    }

    /// Marks the pixels with layer coordinates from `least` to `most` as known.
    fn mark_known(&mut self, least: f32, most: f32) {
        for (known, coordinate) in self.known.iter_mut().zip(&self.coordinates) {
            *known = f32::from(u8::from((least..=most).contains(coordinate)));
        }
    }
}

/// Returns the rows or columns of a plate of `size` that lie about a tile which starts at `first`, with their places there.
fn on_plate(first: i64, size: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..LOCAL_PX).filter_map(move |at| {
        let place = usize::try_from(first + at as i64 - MARGIN_PX as i64).ok()?;
        (place < size).then_some((at, place))
    })
}
