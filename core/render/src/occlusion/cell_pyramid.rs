//! A pyramid of cells with the visible samples of the farther surface along depth edges.
//!
//! It holds the pixels within a few px of a jump in depth, on its far side. Cells have sides of 2, 4, 8, ... pixels on
//! a grid fixed to the frame, and hold the average of their farthest surface.

use super::layered_plate::LayeredPlate;
use rayon::prelude::*;

/// Least jump between surfaces, layers. Samples within this distance of the farthest are one surface.
pub(super) const JUMP: f32 = 1.5;
/// Width of the band along a jump, px.
const BAND_PX: usize = 4;
/// Weight of pixels right at a jump, whose colour is often mixed with that of the near side.
pub(super) const AT_JUMP: f32 = 0.05;
/// Brightness relative to the rest of a cell above which a part's weight is reduced: a small light next to an edge must
/// not grow into a large one.
const BRIGHTEST: f32 = 4.0;

/// The cells of one size, row-major.
pub(super) struct CellLevel {
    pub(super) columns: usize,
    rows: usize,
    /// Weight of the farther surface in each cell.
    pub(super) weight: Vec<f32>,
    /// Layer coordinate of that surface.
    pub(super) coordinate: Vec<f32>,
    /// Its samples, cell by cell, one per plane.
    pub(super) samples: Vec<f32>,
}

impl CellLevel {
    /// Returns the index of the first cell of `row`, counted from the plate's first; `None` beyond the plate.
    pub(super) fn row(&self, row: i64) -> Option<usize> {
        let row = usize::try_from(row).ok()?;
        (row < self.rows).then(|| row * self.columns)
    }

    /// Returns the index of the cell (`column`, `row`), counted from the plate's first; `None` beyond the plate.
    fn cell(&self, column: i64, row: i64) -> Option<usize> {
        let column = usize::try_from(column).ok()?;
        (column < self.columns).then_some(self.row(row)? + column)
    }

    /// Empty cells of a side of 2^`level` px for a plate of `size` whose first pixel has the position `origin` on their grid.
    fn empty(origin: [usize; 2], size: [usize; 2], level: u32, planes: usize) -> Self {
        let last = |k: usize| (origin[k] + size[k] - 1) >> level;
        let [columns, rows] = [0, 1].map(|k| last(k) - (origin[k] >> level) + 1);
        let count = columns * rows;
        Self {
            columns,
            rows,
            weight: vec![0.0; count],
            coordinate: vec![0.0; count],
            samples: vec![0.0; count * planes],
        }
    }

    /// Fills every cell with the average of its `parts`, of `planes` planes whose first `light_count` hold light. `read` returns the sample
    /// of a part by index and plane.
    fn fill(
        &mut self,
        planes: usize,
        light_count: usize,
        parts: impl Fn(usize, usize, &mut Vec<Part>) + Sync,
        read: impl Fn(usize, usize) -> f32 + Sync,
    ) {
        let columns = self.columns;
        let weights = self.weight.par_chunks_mut(columns);
        let coordinates = self.coordinate.par_chunks_mut(columns);
        let samples = self.samples.par_chunks_mut(columns * planes);
        let rows = weights.zip(coordinates).zip(samples).enumerate();
        rows.for_each(|(row, ((weights, coordinates), samples))| {
            let mut found = Vec::with_capacity(4);
            let cells = weights.iter_mut().zip(coordinates);
            for (column, ((weight, coordinate), out)) in
                cells.zip(samples.chunks_exact_mut(planes)).enumerate()
            {
                found.clear();
                parts(column, row, &mut found);
                if !found.is_empty() {
                    (*weight, *coordinate) = merged(&mut found, light_count, &read, out);
                }
            }
        });
    }
}

/// A part of a cell: a pixel or a smaller cell.
struct Part {
    weight: f32,
    coordinate: f32,
    index: usize,
}

/// Builds the cells of 2 px of `input`, which has at least one plane, from the pixels of its `band`. They are the same on all grids whose
/// origins differ by whole cells.
pub(super) fn finest(input: &LayeredPlate, origin: [usize; 2], band: &[f32]) -> CellLevel {
    let (planes, size) = (input.planes.len(), [input.width, input.height]);
    let before = origin.map(|at| at % 2);
    let mut cells = CellLevel::empty(origin, size, 1, planes);
    cells.fill(
        planes,
        input.light_count,
        |column, row, found| {
            for (dx, dy) in CHILDREN {
                let place = [2 * column + dx, 2 * row + dy];
                let [Some(x), Some(y)] = [0, 1].map(|k| {
                    let at = place[k].checked_sub(before[k]);
                    at.filter(|at| *at < size[k])
                }) else {
                    continue;
                };
                let index = y * input.width + x;
                if band[index] > 0.0 {
                    found.push(Part {
                        weight: band[index],
                        coordinate: input.coordinates[index],
                        index,
                    });
                }
            }
        },
        |index, plane| input.planes[plane].samples[index],
    );
    cells
}

/// Builds the cells of 4 px and more, up to 2^`levels`, from the `finest` ones on a grid with this `origin`.
pub(super) fn coarser(
    input: &LayeredPlate,
    origin: [usize; 2],
    finest: &CellLevel,
    levels: u32,
) -> Vec<CellLevel> {
    let (planes, size) = (input.planes.len(), [input.width, input.height]);
    let mut pyramid: Vec<CellLevel> = Vec::new();
    for level in 2..=levels {
        let finer = pyramid.last().unwrap_or(finest);
        let before = origin.map(|at| (at >> (level - 1)) % 2);
        let mut next = CellLevel::empty(origin, size, level, planes);
        next.fill(
            planes,
            input.light_count,
            |column, row, found| {
                for (dx, dy) in CHILDREN {
                    let [cx, cy] = [2 * column + dx, 2 * row + dy].map(|place| place as i64);
                    let cell = finer.cell(cx - before[0] as i64, cy - before[1] as i64);
                    let lit = cell.filter(|index| finer.weight[*index] > 0.0);
                    found.extend(lit.map(|index| Part {
                        weight: finer.weight[index],
                        coordinate: finer.coordinate[index],
                        index,
                    }));
                }
            },
            |index, plane| finer.samples[index * planes + plane],
        );
        pyramid.push(next);
    }
    pyramid
}

const CHILDREN: [(usize, usize); 4] = [(0, 0), (1, 0), (0, 1), (1, 1)];

/// Writes the average samples of the farthest surface in `parts` to `out`; returns its weight and coordinate.
fn merged(
    parts: &mut Vec<Part>,
    light_count: usize,
    read: impl Fn(usize, usize) -> f32,
    out: &mut [f32],
) -> (f32, f32) {
    let coordinates = parts.iter().map(|part| part.coordinate);
    let farthest = coordinates.fold(f32::INFINITY, f32::min);
    parts.retain(|part| part.coordinate <= farthest + JUMP);
    let brightness = |part: &Part| {
        let planes = (0..light_count).map(|plane| read(part.index, plane).abs());
        planes.fold(0.0, f32::max)
    };
    let bright: Vec<f32> = parts.iter().map(brightness).collect();
    let sum: f32 = parts.iter().map(|part| part.weight).sum();
    let light: f32 = parts.iter().zip(&bright).map(|(p, b)| p.weight * b).sum();
    let (mut total, mut coordinate) = (0.0, 0.0);
    for (part, own) in parts.iter().zip(&bright) {
        let rest = sum - part.weight;
        // Mean brightness of the other parts; a single part has none to compare with.
        let others = (light - part.weight * own).max(0.0) / rest.max(f32::MIN_POSITIVE);
        let share = if rest > 0.0 && *own > BRIGHTEST * others {
            BRIGHTEST * others / own
        } else {
            1.0
        };
        // Never zero: a cell of one light on black would be empty.
        let weight = part.weight * share.max(1e-6);
        total += weight;
        coordinate += weight * part.coordinate;
        for (plane, out) in out.iter_mut().enumerate() {
            *out += weight * read(part.index, plane);
        }
    }
    out.iter_mut().for_each(|sample| *sample /= total);
    (sum, coordinate / total)
}

/// Returns the weight of each pixel as the far side of a jump; that of unknown pixels is zero.
pub(super) fn band(input: &LayeredPlate) -> Vec<f32> {
    let (width, height, coordinates) = (input.width, input.height, input.coordinates);
    // Coordinates of the near sides of jumps.
    let mut near = vec![f32::NEG_INFINITY; coordinates.len()];
    near.par_chunks_mut(width)
        .enumerate()
        .for_each(|(row, out)| {
            for (column, out) in out.iter_mut().enumerate() {
                let index = row * width + column;
                let mut least = coordinates[index];
                for (dx, dy) in [(-1, 0), (1, 0), (0, -1), (0, 1)] {
                    let (x, y) = (column as i64 + dx, row as i64 + dy);
                    if (0..width as i64).contains(&x) && (0..height as i64).contains(&y) {
                        least = least.min(coordinates[y as usize * width + x as usize]);
                    }
                }
                if coordinates[index] - least > JUMP {
                    *out = coordinates[index];
                }
            }
        });
    let close = dilated(&near, width, 1);
    let about = dilated(&near, width, BAND_PX);
    let weigh = |(index, ((coordinate, close), about)): (usize, ((&f32, &f32), &f32))| {
        if !input.known.holds(index % width, index / width) {
            0.0
        } else if *close > coordinate + JUMP {
            AT_JUMP
        } else if *about > coordinate + JUMP {
            1.0
        } else {
            0.0
        }
    };
    let all = coordinates.par_iter().zip(&close).zip(&about);
    all.enumerate().map(weigh).collect()
}

/// Returns the largest value within `radius` pixels along both axes: a dilation.
fn dilated(values: &[f32], width: usize, radius: usize) -> Vec<f32> {
    let height = values.len() / width;
    let mut across = vec![0.0; values.len()];
    let rows = across.par_chunks_mut(width).zip(values.par_chunks(width));
    rows.for_each(|(out, row)| {
        out.copy_from_slice(row);
        if row.iter().all(|v| *v == f32::NEG_INFINITY) {
            return;
        }
        for shift in 1..=radius.min(width - 1) {
            raise(&mut out[shift..], &row[..width - shift]);
            raise(&mut out[..width - shift], &row[shift..]);
        }
    });
    let mut both = vec![f32::NEG_INFINITY; values.len()];
    both.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        for row in y.saturating_sub(radius)..(y + radius + 1).min(height) {
            raise(out, &across[row * width..][..width]);
        }
    });
    both
}

/// Raises each of `out` to at least the corresponding value.
fn raise(out: &mut [f32], values: &[f32]) {
    for (out, value) in out.iter_mut().zip(values) {
        *out = if *value > *out { *value } else { *out };
    }
}
