//! The search for highlights: pixels far brighter than their block of the plate.

use crate::Plane;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::Range;

/// Side of the blocks in which highlights are searched, px.
const BLOCK: usize = 32;

/// The criterion by which pixels are highlights.
#[derive(Debug, Clone, Copy)]
pub(crate) struct HighlightCriterion {
    /// Most highlights of a block in each plane.
    pub(crate) most: usize,
    /// Least ratio of a block's brightest pixel to the mean of the block and of the plane for the block to be searched,
    /// and of a highlight to the median of its block.
    pub(crate) contrast: f32,
    /// Least ratio of a block's brightest pixel to its threshold. Weaker highlights are not worth a kernel per pixel.
    pub(crate) worthwhile: f32,
}

/// The highlights of one block.
pub(crate) struct HighlightBlock {
    /// Row and column of each highlight pixel, row by row.
    pub(crate) pixels: Vec<(usize, usize)>,
    /// Light subtracted there: one value per plane, pixel by pixel.
    pub(crate) excess: Vec<f32>,
}

/// Returns the highlights of planes that are `width` pixels wide.
pub(crate) fn find_highlights(
    planes: &[Plane],
    width: usize,
    criterion: &HighlightCriterion,
) -> Vec<HighlightBlock> {
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
            let of =
                |plane: &Plane| BandSummary::new(plane.samples, width, rows, criterion.contrast);
            planes.iter().map(of).collect()
        })
        .collect();
    let means: Vec<f64> = (0..planes.len())
        .map(|plane| mean(summaries.iter().map(|summaries| &summaries[plane])))
        .collect();
    (&bands, &summaries)
        .into_par_iter()
        .flat_map_iter(|(rows, summaries)| {
            highlights_of_band(planes, width, rows, summaries, &means, criterion)
        })
        .collect()
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
    fn new(samples: &[f32], width: usize, rows: &Range<usize>, contrast: f32) -> Self {
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
            if stands_out(max, sum / count as f64, contrast) {
                summary.candidates.push((block, max));
            }
        }
        summary
    }
}

fn stands_out(max: f32, mean: f64, contrast: f32) -> bool {
    f64::from(max) > f64::from(contrast) * mean
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
    criterion: &HighlightCriterion,
) -> Vec<HighlightBlock> {
    // One threshold per plane for blocks with highlights.
    let mut thresholds: BTreeMap<usize, Vec<Threshold>> = BTreeMap::new();
    let mut values = Vec::new();
    for (index, (plane, summary)) in planes.iter().zip(summaries).enumerate() {
        for &(block, max) in &summary.candidates {
            if !stands_out(max, means[index], criterion.contrast) {
                continue;
            }
            values.clear();
            for row in rows.clone() {
                values.extend(&plane.samples[row * width..][columns_of(block, width)]);
            }
            if let Some(threshold) = threshold(&mut values, max, criterion) {
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
fn threshold(values: &mut [f32], max: f32, criterion: &HighlightCriterion) -> Option<Threshold> {
    let last = criterion.most.min(values.len().checked_sub(1)?);
    let (_, next, _) = values.select_nth_unstable_by(last, |a, b| b.total_cmp(a));
    let remainder = next.max(0.0);
    values.iter_mut().for_each(|v| *v = v.abs());
    let (_, median, _) = values.select_nth_unstable_by(values.len() / 2, f32::total_cmp);
    let above = remainder.max(criterion.contrast * *median);
    // The division keeps the largest finite values finite.
    (max / criterion.worthwhile > above).then_some(Threshold { above, remainder })
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
}
