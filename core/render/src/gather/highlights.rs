//! Highlights: small lights far brighter than their surroundings, scattered exactly.
//!
//! The errors of the fast renderer are relative to the brightest light, so a light of ten thousand would make them
//! visible around it. Pixels that stand out by far are subtracted from the plate and scattered with a kernel each.

use super::edges::add_folded;
use super::image::{Image, Rect, Size};
use super::lens_probe::LensProbe;
use crate::{Plane, RenderWindow, Scene, cancelled};
use rayon::prelude::*;
use seidel_optics::error::Result;
use seidel_optics::psf::KernelRows;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;

/// Side of the blocks in which highlights are searched, px.
const BLOCK: usize = 32;

/// Least ratio of a block's brightest pixel to the mean of the block and of the plane for the block to be searched,
/// and of a highlight to the median of its block.
const CONTRAST: f32 = 16.0;

/// Largest number of highlight pixels of a block in each plane; larger areas are left to the fast renderer.
const MAX_PIXELS: usize = 16;

/// Least ratio of a block's brightest pixel to its threshold. Weaker highlights are not worth a kernel per pixel.
const WORTHWHILE: f32 = 4.0;

/// Blocks scattered before they are added to the plate; bounds the memory taken.
const WAVE: usize = 64;

/// Planes with their highlights subtracted.
pub(super) struct HighlightSplit<'a> {
    /// The rest of each plane.
    pub(super) rest: Vec<Cow<'a, [f32]>>,
    blocks: Vec<HighlightBlock>,
}

/// The highlights of one block.
struct HighlightBlock {
    /// Row and column of each highlight pixel, row by row.
    pixels: Vec<(usize, usize)>,
    /// Light subtracted there: one value per plane, pixel by pixel.
    excess: Vec<f32>,
}

impl<'a> HighlightSplit<'a> {
    /// Splits planes that are `width` pixels wide.
    pub(super) fn new(planes: &[Plane<'a>], width: usize) -> Self {
        let height = planes
            .first()
            .map_or(0, |plane| plane.samples.len() / width);
        let bands: Vec<Range<usize>> = (0..height)
            .step_by(BLOCK)
            .map(|row| row..height.min(row + BLOCK))
            .collect();
        let summaries: Vec<Vec<BandSummary>> = bands
            .par_iter()
            .map(|rows| {
                let of = |plane: &Plane| BandSummary::new(plane.samples, width, rows);
                planes.iter().map(of).collect()
            })
            .collect();
        let means: Vec<f64> = (0..planes.len())
            .map(|plane| mean(summaries.iter().map(|summaries| &summaries[plane])))
            .collect();
        let blocks: Vec<HighlightBlock> = (&bands, &summaries)
            .into_par_iter()
            .flat_map_iter(|(rows, summaries)| {
                highlights_of_band(planes, width, rows, summaries, &means)
            })
            .collect();
        let rest = planes
            .iter()
            .enumerate()
            .map(|(index, plane)| without(plane.samples, index, planes.len(), width, &blocks))
            .collect();
        Self { rest, blocks }
    }

    /// Returns the number of pixels subtracted.
    pub(super) fn pixel_count(&self) -> usize {
        self.blocks.iter().map(|block| block.pixels.len()).sum()
    }

    /// Scatters the highlights of `planes` and adds them to `out`, a window of the plate.
    ///
    /// # Errors
    /// A lens that cannot be drawn at a highlight, and a cancelled render.
    pub(super) fn scatter(
        &self,
        scene: &Scene,
        window: RenderWindow,
        lens: &LensProbe,
        planes: &[Plane],
        out: &mut [Vec<f32>],
    ) -> Result<()> {
        let size = Size {
            width: scene.width,
            height: scene.height,
        };
        for wave in self.blocks.chunks(WAVE) {
            let patches = wave
                .par_iter()
                .map_init(KernelRows::default, |kernel, block| {
                    block.scattered(lens, planes, kernel)
                })
                .collect::<Result<Vec<_>>>()?;
            out.par_iter_mut().enumerate().for_each(|(plane, out)| {
                for patch in &patches {
                    add_folded(&patch[plane], size, scene.edges, window, out);
                }
            });
            if !(lens.progress)(1.0) {
                return Err(cancelled());
            }
        }
        Ok(())
    }
}

/// Returns the `samples` of plane `index` of `count` without the highlights.
fn without<'a>(
    samples: &'a [f32],
    index: usize,
    count: usize,
    width: usize,
    blocks: &[HighlightBlock],
) -> Cow<'a, [f32]> {
    let mut rest = Cow::Borrowed(samples);
    for block in blocks {
        for (&(row, column), excess) in block.pixels.iter().zip(block.excess.chunks(count)) {
            if excess[index] != 0.0 {
                rest.to_mut()[row * width + column] -= excess[index];
            }
        }
    }
    rest
}

/// Lanes of sums that are kept in registers.
const LANES: usize = 8;

/// Largest value and sum of absolute values of a block, lane by lane.
#[derive(Clone, Copy, Default)]
struct BlockStats {
    max: [f32; LANES],
    sum: [f32; LANES],
}

impl BlockStats {
    #[inline]
    fn add(&mut self, samples: &[f32]) {
        let (blocks, rest) = samples.as_chunks::<LANES>();
        for block in blocks {
            self.add_lanes(block);
        }
        if rest.is_empty() {
            return;
        }
        let mut last = [0.0; LANES];
        last[..rest.len()].copy_from_slice(rest);
        self.add_lanes(&last);
    }

    #[inline(always)]
    fn add_lanes(&mut self, block: &[f32; LANES]) {
        for ((max, sum), v) in self.max.iter_mut().zip(&mut self.sum).zip(block) {
            *max = if *v > *max { *v } else { *max };
            *sum += v.abs();
        }
    }

    fn max(&self) -> f32 {
        self.max.iter().copied().fold(0.0, f32::max)
    }

    fn sum(&self) -> f64 {
        self.sum.iter().map(|sum| f64::from(*sum)).sum()
    }
}

/// The light in one row of blocks of a plane.
#[derive(Default)]
struct BandSummary {
    /// Sum of absolute values in blocks that are not black.
    light: f64,
    /// Number of pixels in these blocks.
    pixels: usize,
    /// Blocks with a value that stands out, and the largest there.
    candidates: Vec<(usize, f32)>,
}

impl BandSummary {
    fn new(samples: &[f32], width: usize, rows: &Range<usize>) -> Self {
        let mut blocks = vec![BlockStats::default(); width.div_ceil(BLOCK)];
        for row in samples[rows.start * width..rows.end * width].chunks_exact(width) {
            for (block, samples) in blocks.iter_mut().zip(row.chunks(BLOCK)) {
                block.add(samples);
            }
        }
        let mut summary = Self::default();
        for (block, stats) in blocks.iter().enumerate() {
            let (max, sum) = (stats.max(), stats.sum());
            if sum == 0.0 {
                continue;
            }
            let count = columns_of(block, width).len() * rows.len();
            summary.light += sum;
            summary.pixels += count;
            if stands_out(max, sum / count as f64) {
                summary.candidates.push((block, max));
            }
        }
        summary
    }
}

fn stands_out(max: f32, mean: f64) -> bool {
    f64::from(max) > f64::from(CONTRAST) * mean
}

/// Returns the mean absolute value of a plane over blocks that are not black.
fn mean<'a>(bands: impl Iterator<Item = &'a BandSummary>) -> f64 {
    let sum = |sum: (f64, usize), band: &BandSummary| (sum.0 + band.light, sum.1 + band.pixels);
    let (light, pixels) = bands.fold((0.0, 0), sum);
    light / pixels.max(1) as f64
}

/// Returns the plate columns of a block.
fn columns_of(block: usize, width: usize) -> Range<usize> {
    block * BLOCK..width.min((block + 1) * BLOCK)
}

/// The threshold of a block's highlights in one plane.
#[derive(Clone, Copy)]
struct Threshold {
    /// Brighter pixels are highlights.
    above: f32,
    /// The light left at a highlight.
    remainder: f32,
}

impl Threshold {
    /// A plane without highlights.
    const NONE: Self = Self {
        above: f32::INFINITY,
        remainder: 0.0,
    };
}

/// Returns the highlights of one row of blocks, given the summary of each plane there and its mean.
fn highlights_of_band(
    planes: &[Plane],
    width: usize,
    rows: &Range<usize>,
    summaries: &[BandSummary],
    means: &[f64],
) -> Vec<HighlightBlock> {
    // One threshold per plane for blocks with highlights.
    let mut thresholds: BTreeMap<usize, Vec<Threshold>> = BTreeMap::new();
    let mut values = Vec::new();
    for (index, (plane, summary)) in planes.iter().zip(summaries).enumerate() {
        for &(block, max) in &summary.candidates {
            if !stands_out(max, means[index]) {
                continue;
            }
            values.clear();
            for row in rows.clone() {
                values.extend(&plane.samples[row * width..][columns_of(block, width)]);
            }
            if let Some(threshold) = threshold(&mut values, max) {
                let none = || vec![Threshold::NONE; planes.len()];
                thresholds.entry(block).or_insert_with(none)[index] = threshold;
            }
        }
    }
    thresholds
        .iter()
        .map(|(block, thresholds)| {
            let columns = columns_of(*block, width);
            HighlightBlock::new(planes, width, &columns, rows, thresholds)
        })
        .collect()
}

/// Returns the threshold of a block with these `values`, `max` the largest; `None` if it has no highlights.
fn threshold(values: &mut [f32], max: f32) -> Option<Threshold> {
    let last = MAX_PIXELS.min(values.len().checked_sub(1)?);
    let (_, next, _) = values.select_nth_unstable_by(last, |a, b| b.total_cmp(a));
    let remainder = next.max(0.0);
    values.iter_mut().for_each(|v| *v = v.abs());
    let (_, median, _) = values.select_nth_unstable_by(values.len() / 2, f32::total_cmp);
    let above = remainder.max(CONTRAST * *median);
    // The division keeps the largest finite values finite.
    (max / WORTHWHILE > above).then_some(Threshold { above, remainder })
}

impl HighlightBlock {
    /// Finds the highlights of a block with these `columns` and `rows`, given one threshold per plane.
    fn new(
        planes: &[Plane],
        width: usize,
        columns: &Range<usize>,
        rows: &Range<usize>,
        thresholds: &[Threshold],
    ) -> Self {
        let mut block = Self {
            pixels: Vec::new(),
            excess: Vec::new(),
        };
        for row in rows.clone() {
            for column in columns.clone() {
                let excess = planes.iter().zip(thresholds).map(|(plane, threshold)| {
                    let light = plane.samples[row * width + column];
                    if light > threshold.above {
                        light - threshold.remainder
                    } else {
                        0.0
                    }
                });
                if excess.clone().any(|light| light != 0.0) {
                    block.pixels.push((row, column));
                    block.excess.extend(excess);
                }
            }
        }
        block
    }

    /// Scatters the highlights into one image per plane. Every pixel has a kernel of its own, even where the exact
    /// renderer lets neighbours share one.
    fn scattered(
        &self,
        lens: &LensProbe,
        planes: &[Plane],
        kernel: &mut KernelRows,
    ) -> Result<Vec<Image>> {
        let mut images = vec![Image::default(); planes.len()];
        let mut found = Vec::new();
        for (index, (row, column)) in self.pixels.iter().enumerate() {
            lens.sources_at((*column as f64 + 0.5, *row as f64 + 0.5), &mut found)?;
            for (channel, source) in found.iter().enumerate() {
                let Some(source) = source else { continue };
                lens.model.draw_rows(&source.blur, source.shift_px, kernel);
                self.scatter_pixel(index, channel, planes, kernel, &mut images);
            }
        }
        Ok(images)
    }

    /// Scatters highlight `index` as one lens channel spreads it.
    fn scatter_pixel(
        &self,
        index: usize,
        channel: usize,
        planes: &[Plane],
        kernel: &KernelRows,
        images: &mut [Image],
    ) {
        let (row, column) = self.pixels[index];
        let excess = &self.excess[index * planes.len()..];
        let (column, row) = (column as i32, row as i32);
        for ((image, plane), excess) in images.iter_mut().zip(planes).zip(excess) {
            let gain = f64::from(*excess) * plane.weights[channel] / kernel.sum();
            if gain != 0.0 {
                make_room(image, kernel, column, row);
                add(image, kernel, column, row, gain as f32);
            }
        }
    }
}

/// Extends `image` to hold `kernel` around a source pixel, with some spare room for the next highlight near by.
fn make_room(image: &mut Image, kernel: &KernelRows, column: i32, row: i32) {
    const SPARE: i32 = 4;
    let over = |start: i32, size: usize, at: i32, reach: Range<i32>| {
        let (first, end) = (at + reach.start, at + reach.end);
        if size == 0 {
            return first - SPARE..end + SPARE;
        }
        let old = start..start + size as i32;
        let start = if first < old.start {
            first - SPARE
        } else {
            old.start
        };
        start..if end > old.end { end + SPARE } else { old.end }
    };
    let columns = over(image.left, image.width, column, kernel.columns());
    let rows = over(image.top, image.height, row, kernel.rows());
    if (columns.len(), rows.len()) == (image.width, image.height) {
        return;
    }
    let mut roomy = Image::zeros(Rect {
        left: columns.start,
        top: rows.start,
        width: columns.len(),
        height: rows.len(),
    });
    for (y, line) in image.samples.chunks_exact(image.width.max(1)).enumerate() {
        let start = (image.top - roomy.top) as usize + y;
        let start = start * roomy.width + (image.left - roomy.left) as usize;
        roomy.samples[start..start + line.len()].copy_from_slice(line);
    }
    *image = roomy;
}

/// Adds `gain` times the kernel's weights around a source pixel; `image` has room for them.
fn add(image: &mut Image, kernel: &KernelRows, column: i32, row: i32, gain: f32) {
    for span in kernel.spans() {
        let start = (row + span.row - image.top) as usize * image.width;
        let start = start + (column + span.column - image.left) as usize;
        let out = &mut image.samples[start..start + span.weights.len()];
        for (light, weight) in out.iter_mut().zip(span.weights) {
            *light += gain * weight;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 150;
    const HEIGHT: usize = 110;

    fn split(samples: &[f32]) -> HighlightSplit<'_> {
        let weights = &[1.0];
        HighlightSplit::new(&[Plane { samples, weights }], WIDTH)
    }

    /// Uneven light from 0.1 to 0.3.
    fn plate() -> Vec<f32> {
        let value = |k: usize| 0.1 + 0.2 * ((k * 7919) % 101) as f32 / 101.0;
        (0..WIDTH * HEIGHT).map(value).collect()
    }

    /// Returns a plate with a square of light.
    fn with_light(column: usize, row: usize, side: usize, light: f32) -> Vec<f32> {
        let mut samples = plate();
        for y in row..row + side {
            samples[y * WIDTH + column..][..side].fill(light);
        }
        samples
    }

    #[test]
    fn a_plate_without_highlights_is_borrowed() {
        // A bright and a dark half, and an outstanding negative value.
        let mut samples = plate();
        samples[..WIDTH * 50].iter_mut().for_each(|v| *v *= 300.0);
        samples[WIDTH * 80 + 40] = -1e4;
        let split = split(&samples);
        assert_eq!(split.pixel_count(), 0);
        assert!(matches!(split.rest[0], Cow::Borrowed(_)));
    }

    #[test]
    fn highlights_are_subtracted_and_no_light_is_lost() {
        for (column, row) in [(0, 0), (31, 31), (97, 64), (WIDTH - 2, HEIGHT - 2)] {
            let samples = with_light(column, row, 2, 1e4);
            let split = split(&samples);
            assert_eq!(split.pixel_count(), 4);
            let mut sum = split.rest[0].to_vec();
            let most = sum.iter().copied().fold(0.0, f32::max);
            assert!(most <= 0.3, "{most}");
            for block in &split.blocks {
                for ((row, column), excess) in block.pixels.iter().zip(&block.excess) {
                    sum[row * WIDTH + column] += excess;
                }
            }
            for (sum, sample) in sum.iter().zip(&samples) {
                assert!((sum - sample).abs() <= 1e-6 * sample);
            }
        }
    }

    /// A block may hold only a few pixels of a large light, at its corner.
    #[test]
    fn large_lights_are_not_highlights() {
        for (column, row) in [(32, 32), (40, 50), (10, 7), (62, 62)] {
            let samples = with_light(column, row, 40, 1e3);
            assert_eq!(split(&samples).pixel_count(), 0, "({column}, {row})");
        }
        // Four by four pixels are a highlight, five by five are not.
        for (side, expected) in [(4, 16), (5, 0)] {
            let samples = with_light(70, 38, side, 1e3);
            assert_eq!(split(&samples).pixel_count(), expected);
        }
    }

    #[test]
    fn planes_have_highlights_of_their_own() {
        let (dark, lit) = (plate(), with_light(70, 38, 1, 1e3));
        let planes = [&dark, &lit].map(|samples| Plane {
            samples,
            weights: &[1.0],
        });
        let split = HighlightSplit::new(&planes, WIDTH);
        assert_eq!(split.pixel_count(), 1);
        assert_eq!(split.blocks[0].excess[0], 0.0);
        assert!(matches!(split.rest[0], Cow::Borrowed(_)));
        assert!(matches!(split.rest[1], Cow::Owned(_)));
    }
}
