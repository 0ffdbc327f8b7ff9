//! Candidates for lights: connected regions of a plate that are much brighter than their surroundings.

use super::hole_filling::interpolate_cells;

/// Brightness of a candidate, as a multiple of its surroundings.
const CONTRAST: f32 = 3.0;
/// Least excess over the surroundings, standard deviations of the noise.
const MIN_DEVIATIONS: f32 = 25.0;
/// Least excess of the brightest pixel of a region.
const MIN_PEAK_DEVIATIONS: f32 = 100.0;
/// Least side of the cells from which the surroundings are estimated, px.
const MIN_CELL: usize = 16;
/// Cells on either side of a cell that its surroundings reach.
const CELLS_AROUND: usize = 2;

/// A plane that is searched for candidates.
#[derive(Clone, Copy)]
pub(super) struct CandidateSearch<'a> {
    pub(super) samples: &'a [f32],
    pub(super) width: usize,
    /// Standard deviation of a typical sample.
    pub(super) deviation: f32,
    /// Reach of the lens's kernels, px.
    pub(super) reach: usize,
}

impl CandidateSearch<'_> {
    /// Returns the pixels of each region, in ascending order: pixels that exceed their surroundings, and those that are
    /// `bright` anyway, joined along sides and corners.
    pub(super) fn regions(&self, bright: impl Fn(usize) -> bool) -> Vec<Vec<usize>> {
        let surroundings = self.surroundings();
        let is_candidate = |k: usize| {
            let (sample, level) = (self.samples[k], surroundings[k].max(0.0));
            bright(k)
                || sample > CONTRAST * level && sample - level > MIN_DEVIATIONS * self.deviation
        };
        let open: Vec<bool> = (0..self.samples.len()).map(is_candidate).collect();
        let mut regions = connected_regions(open, self.width);
        let is_peak = |k: &usize| {
            bright(*k) || self.samples[*k] - surroundings[*k] > MIN_PEAK_DEVIATIONS * self.deviation
        };
        regions.retain(|region| region.iter().any(is_peak));
        regions
    }

    /// Returns the level of the surroundings of each pixel: the median over a cell and its neighbours, interpolated.
    fn surroundings(&self) -> Vec<f32> {
        let side = (self.reach / 2).max(MIN_CELL);
        let height = self.samples.len() / self.width;
        let (columns, rows) = (self.width.div_ceil(side), height.div_ceil(side));
        let mut medians = Vec::with_capacity(columns * rows);
        for cell in 0..columns * rows {
            let (x, y) = (cell % columns * side, cell / columns * side);
            let mut inside: Vec<f32> = (y..(y + side).min(height))
                .flat_map(|y| &self.samples[y * self.width..][x..(x + side).min(self.width)])
                .copied()
                .collect();
            medians.push(median(&mut inside));
        }
        let levels: Vec<f32> = (0..columns * rows)
            .map(|cell| {
                let (x, y) = (cell % columns, cell / columns);
                let near = |at: usize, count: usize| {
                    at.saturating_sub(CELLS_AROUND)..(at + CELLS_AROUND + 1).min(count)
                };
                let mut around: Vec<f32> = near(y, rows)
                    .flat_map(|y| near(x, columns).map(move |x| y * columns + x))
                    .map(|cell| medians[cell])
                    .collect();
                median(&mut around)
            })
            .collect();
        interpolate_cells(&levels, columns, side, (self.width, height))
    }
}

fn median(samples: &mut [f32]) -> f32 {
    if samples.is_empty() {
        return 0.0;
    }
    let middle = samples.len() / 2;
    *samples.select_nth_unstable_by(middle, f32::total_cmp).1
}

/// Returns the connected regions of the `open` pixels of a plane.
fn connected_regions(mut open: Vec<bool>, width: usize) -> Vec<Vec<usize>> {
    let height = open.len() / width.max(1);
    let mut regions = Vec::new();
    for first in 0..open.len() {
        if !std::mem::take(&mut open[first]) {
            continue;
        }
        let (mut region, mut next) = (vec![first], 0);
        while let Some(pixel) = region.get(next).copied() {
            next += 1;
            let (x, y) = (pixel % width, pixel / width);
            for row in y.saturating_sub(1)..(y + 2).min(height) {
                for column in x.saturating_sub(1)..(x + 2).min(width) {
                    if std::mem::take(&mut open[row * width + column]) {
                        region.push(row * width + column);
                    }
                }
            }
        }
        region.sort_unstable();
        regions.push(region);
    }
    regions
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bright_spots_are_regions_and_steps_are_not() {
        let (width, height) = (160, 120);
        let samples: Vec<f32> = (0..width * height)
            .map(|k| {
                let (x, y) = (k % width, k / width);
                match (x, y) {
                    (40..=43, 50..=52) => 2.0,
                    (44, 53) => 2.0,
                    (100.., _) => 0.4,
                    _ => 0.2,
                }
            })
            .collect();
        let search = CandidateSearch {
            samples: &samples,
            width,
            deviation: 0.001,
            reach: 10,
        };
        let regions = search.regions(|_| false);
        assert_eq!(regions.len(), 1);
        assert_eq!(regions[0].len(), 13);
        assert_eq!(search.regions(|k| k == 7).len(), 2);
    }
}
