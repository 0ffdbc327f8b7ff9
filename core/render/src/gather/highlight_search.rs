//! The search for highlights: pixels far brighter than their block of the plate.

use crate::Plane;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::Range;

/// Side of the blocks in which highlights are searched, px.
const BLOCK: usize = 32;

/// Fewest covered pixels of a block with uncovered ones: black stands for those that fewer lack, so that a speck over nothing stands out.
const LEAST_COVERED: usize = BLOCK * BLOCK / 4;

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

/// The pixels among which highlights are searched.
#[derive(Clone, Copy)]
pub(crate) struct SearchArea<'a> {
    /// Columns of the plate.
    pub(crate) width: usize,
    /// Pixels of the first block that lie outside the plate, along x and y.
    pub(crate) before: [usize; 2],
    /// Whether each pixel is covered, and counts; `None` if all do.
    pub(crate) covered: Option<&'a [bool]>,
}

impl SearchArea<'_> {
    /// All of a plate `width` columns wide, its first block at its first pixel.
    pub(crate) fn whole(width: usize) -> Self {
        Self {
            width,
            before: [0; 2],
            covered: None,
        }
    }

    /// Returns the number of blocks along `axis`, of a plate of `size` pixels there.
    fn blocks(&self, axis: usize, size: usize) -> usize {
        (size + self.before[axis]).div_ceil(BLOCK)
    }

    /// Returns the pixels of a block along `axis`.
    fn pixels_of(&self, axis: usize, block: usize, size: usize) -> Range<usize> {
        let first = |block: usize| (block * BLOCK).saturating_sub(self.before[axis]).min(size);
        first(block)..first(block + 1)
    }

    /// Returns the plate columns of a block.
    fn columns_of(&self, block: usize) -> Range<usize> {
        self.pixels_of(0, block, self.width)
    }

    /// Returns the number of covered pixels in each block of some `rows`.
    fn counts(&self, rows: &Range<usize>) -> Vec<usize> {
        let count = |block: usize| {
            let columns = self.columns_of(block);
            let Some(covered) = self.covered else {
                return columns.len() * rows.len();
            };
            let lines = covered[rows.start * self.width..rows.end * self.width].chunks(self.width);
            let lines = lines.map(|line| line[columns.clone()].iter().filter(|is| **is).count());
            lines.sum()
        };
        (0..self.blocks(0, self.width)).map(count).collect()
    }

    /// Returns the number of pixels that a block's values are compared with.
    fn compared(&self, count: usize) -> usize {
        match self.covered {
            Some(_) => count.max(LEAST_COVERED),
            None => count,
        }
    }
}

/// The highlights of one block.
pub(crate) struct HighlightBlock {
    /// Whether a part of the block is uncovered, or outside the plate.
    pub(crate) is_partial: bool,
    /// Row and column of each highlight pixel, row by row.
    pub(crate) pixels: Vec<(usize, usize)>,
    /// Light subtracted there: one value per plane, pixel by pixel.
    pub(crate) excess: Vec<f32>,
}

/// Returns the highlights of planes in an `area`.
pub(crate) fn find_highlights(
    planes: &[Plane],
    area: &SearchArea,
    criterion: &HighlightCriterion,
) -> Vec<HighlightBlock> {
    let height = planes
        .first()
        .map_or(0, |plane| plane.samples.len() / area.width);
    let bands: Vec<Band> = (0..area.blocks(1, height))
        .into_par_iter()
        .map(|band| {
            let rows = area.pixels_of(1, band, height);
            let counts = area.counts(&rows);
            let of = |plane: &Plane| {
                BandSummary::new(plane.samples, area, &rows, &counts, criterion.contrast)
            };
            Band {
                summaries: planes.iter().map(of).collect(),
                rows,
                counts,
            }
        })
        .collect();
    let means: Vec<f64> = (0..planes.len())
        .map(|plane| mean(bands.iter().map(|band| &band.summaries[plane])))
        .collect();
    bands
        .par_iter()
        .flat_map_iter(|band| highlights_of_band(planes, area, band, &means, criterion))
        .collect()
}

/// A row of blocks.
struct Band {
    rows: Range<usize>,
    /// Number of covered pixels of each block.
    counts: Vec<usize>,
    /// One a plane.
    summaries: Vec<BandSummary>,
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
    fn new(
        samples: &[f32],
        area: &SearchArea,
        rows: &Range<usize>,
        counts: &[usize],
        contrast: f32,
    ) -> Self {
        let width = area.width;
        let mut blocks = vec![BlockStats::default(); counts.len()];
        for row in samples[rows.start * width..rows.end * width].chunks_exact(width) {
            for (block, stats) in blocks.iter_mut().enumerate() {
                stats.add(&row[area.columns_of(block)]);
            }
        }
        let mut summary = Self::default();
        for (block, stats) in blocks.iter().enumerate() {
            let (max, sum) = (stats.max(), stats.sum());
            if sum == 0.0 {
                continue;
            }
            summary.light += sum;
            summary.pixels += counts[block];
            if stands_out(max, sum / area.compared(counts[block]) as f64, contrast) {
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

/// Returns the highlights of one row of blocks, given the mean of each plane.
fn highlights_of_band(
    planes: &[Plane],
    area: &SearchArea,
    band: &Band,
    means: &[f64],
    criterion: &HighlightCriterion,
) -> Vec<HighlightBlock> {
    // One threshold per plane for blocks with highlights.
    let mut thresholds: BTreeMap<usize, Vec<Threshold>> = BTreeMap::new();
    let mut values = Vec::new();
    for (index, (plane, summary)) in planes.iter().zip(&band.summaries).enumerate() {
        for &(block, max) in &summary.candidates {
            if !stands_out(max, means[index], criterion.contrast) {
                continue;
            }
            values.clear();
            for row in band.rows.clone() {
                let first = row * area.width;
                let columns = area.columns_of(block);
                let line = &plane.samples[first..][columns.clone()];
                match area.covered {
                    None => values.extend(line),
                    Some(covered) => {
                        let pixels = line.iter().zip(&covered[first..][columns]);
                        values.extend(pixels.filter(|(_, is)| **is).map(|(light, _)| light));
                    }
                }
            }
            values.resize(area.compared(values.len()), 0.0);
            if let Some(threshold) = threshold(&mut values, max, criterion) {
                let none = || vec![Threshold::NONE; planes.len()];
                thresholds.entry(block).or_insert_with(none)[index] = threshold;
            }
        }
    }
    thresholds
        .iter()
        .map(|(block, thresholds)| {
            let columns = area.columns_of(*block);
            let is_partial = band.counts[*block] < BLOCK * BLOCK;
            let found = HighlightBlock::new(planes, area.width, &columns, &band.rows, thresholds);
            HighlightBlock {
                is_partial,
                ..found
            }
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
            is_partial: false,
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
