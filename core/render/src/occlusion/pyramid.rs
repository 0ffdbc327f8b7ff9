//! What can be seen of the farther surface along depth edges, averaged over cells of growing size.
//!
//! Pixels on the far side of a jump in depth are gathered in a band a few pixels wide. Cells have sides
//! of 2, 4, 8, ... pixels on a grid fixed to the frame, and keep the average of their farthest surface.

use super::HiddenInput;
use rayon::prelude::*;

/// A jump from one pixel to the next is more than this many layers; what is within as much of the
/// farthest is one surface.
pub(super) const JUMP: f32 = 1.5;
/// How wide the band along a jump is, px.
const BAND_PX: usize = 4;
/// What pixels right at the jump count, whose colour is often mixed with that of the near side.
const AT_JUMP: f32 = 0.05;
/// Part of a cell that is brighter than this many times the rest counts less: a small light next to an
/// edge must not be drawn out into a large one.
const BRIGHTEST: f32 = 4.0;

/// The cells of one size, row-major; planes beside each other.
pub(super) struct Level {
    /// Cell of the plate's first pixel on the frame's grid.
    pub(super) first: [usize; 2],
    pub(super) columns: usize,
    rows: usize,
    /// How much of the farther surface is in each cell; zero: none.
    pub(super) weight: Vec<f32>,
    /// Its place on the layers.
    pub(super) place: Vec<f32>,
    /// Its samples, those of a cell together.
    pub(super) samples: Vec<f32>,
}

impl Level {
    /// Index of the first cell of `row` on the frame's grid, if the plate has it.
    pub(super) fn row(&self, row: i64) -> Option<usize> {
        let row = usize::try_from(row - self.first[1] as i64).ok()?;
        (row < self.rows).then(|| row * self.columns)
    }

    /// Index of the cell (`column`, `row`) on the frame's grid, if the plate has it.
    fn cell(&self, column: i64, row: i64) -> Option<usize> {
        let column = usize::try_from(column - self.first[0] as i64).ok()?;
        (column < self.columns).then_some(self.row(row)? + column)
    }

    fn empty(first: [usize; 2], last: [usize; 2], planes: usize) -> Self {
        let [columns, rows] = [0, 1].map(|k| last[k] - first[k] + 1);
        let count = columns * rows;
        Self {
            first,
            columns,
            rows,
            weight: vec![0.0; count],
            place: vec![0.0; count],
            samples: vec![0.0; count * planes],
        }
    }

    /// Fills every cell with the merger of the `parts` that lie in it, whose samples are `read` by index
    /// and plane.
    fn fill(
        &mut self,
        planes: usize,
        parts: impl Fn(usize, usize, &mut Vec<Part>) + Sync,
        read: impl Fn(usize, usize) -> f32 + Sync,
    ) {
        let columns = self.columns;
        let [first_column, first_row] = self.first;
        let weights = self.weight.par_chunks_mut(columns);
        let places = self.place.par_chunks_mut(columns);
        let samples = self.samples.par_chunks_mut(columns * planes);
        let rows = weights.zip(places).zip(samples).enumerate();
        rows.for_each(|(row, ((weights, places), samples))| {
            let mut found = Vec::with_capacity(4);
            let cells = weights.iter_mut().zip(places);
            for (column, ((weight, place), out)) in
                cells.zip(samples.chunks_exact_mut(planes)).enumerate()
            {
                found.clear();
                parts(first_column + column, first_row + row, &mut found);
                if !found.is_empty() {
                    (*weight, *place) = merged(&mut found, &read, out);
                }
            }
        });
    }
}

/// A cell's part: a pixel or a smaller cell.
struct Part {
    weight: f32,
    place: f32,
    index: usize,
}

/// The pyramid of `input`, which has planes, cells of 2 px first, up to those of 2^`levels`.
pub(super) fn build(input: &HiddenInput, levels: u32) -> Vec<Level> {
    let planes = input.planes.len();
    let band = band(input);
    let [x, y] = input.origin;
    let last = [x + input.width - 1, y + input.height - 1];
    let mut pyramid: Vec<Level> = Vec::new();
    for level in 1..=levels {
        let mut next = Level::empty([x >> level, y >> level], last.map(|l| l >> level), planes);
        match pyramid.last() {
            None => next.fill(
                planes,
                |column, row, found| {
                    for (dx, dy) in CHILDREN {
                        let (cx, cy) = (2 * column + dx, 2 * row + dy);
                        if cx < x || cy < y || cx > last[0] || cy > last[1] {
                            continue;
                        }
                        let index = (cy - y) * input.width + cx - x;
                        if band[index] > 0.0 {
                            found.push(Part {
                                weight: band[index],
                                place: input.places[index],
                                index,
                            });
                        }
                    }
                },
                |index, plane| input.planes[plane].samples[index],
            ),
            Some(finer) => next.fill(
                planes,
                |column, row, found| {
                    for (dx, dy) in CHILDREN {
                        let (cx, cy) = ((2 * column + dx) as i64, (2 * row + dy) as i64);
                        let cell = finer.cell(cx, cy);
                        let lit = cell.filter(|index| finer.weight[*index] > 0.0);
                        found.extend(lit.map(|index| Part {
                            weight: finer.weight[index],
                            place: finer.place[index],
                            index,
                        }));
                    }
                },
                |index, plane| finer.samples[index * planes + plane],
            ),
        }
        pyramid.push(next);
    }
    pyramid
}

const CHILDREN: [(usize, usize); 4] = [(0, 0), (1, 0), (0, 1), (1, 1)];

/// Weight and place of what is farthest in `parts`; its samples go to `out`.
fn merged(
    parts: &mut Vec<Part>,
    read: impl Fn(usize, usize) -> f32,
    out: &mut [f32],
) -> (f32, f32) {
    let places = parts.iter().map(|part| part.place);
    let farthest = places.fold(f32::INFINITY, f32::min);
    parts.retain(|part| part.place <= farthest + JUMP);
    let brightness = |part: &Part| {
        let planes = (0..out.len()).map(|plane| read(part.index, plane).abs());
        planes.fold(0.0, f32::max)
    };
    let bright: Vec<f32> = parts.iter().map(brightness).collect();
    let sum: f32 = parts.iter().map(|part| part.weight).sum();
    let light: f32 = parts.iter().zip(&bright).map(|(p, b)| p.weight * b).sum();
    let (mut total, mut place) = (0.0, 0.0);
    for (part, own) in parts.iter().zip(&bright) {
        let rest = sum - part.weight;
        // Mean brightness of the others; a part that is alone has nothing to be held against.
        let others = (light - part.weight * own).max(0.0) / rest.max(f32::MIN_POSITIVE);
        let share = if rest > 0.0 && *own > BRIGHTEST * others {
            BRIGHTEST * others / own
        } else {
            1.0
        };
        // A little is left: a cell of one light on black would otherwise be empty.
        let weight = part.weight * share.max(1e-6);
        total += weight;
        place += weight * part.place;
        for (plane, out) in out.iter_mut().enumerate() {
            *out += weight * read(part.index, plane);
        }
    }
    out.iter_mut().for_each(|sample| *sample /= total);
    (sum, place / total)
}

/// How much each pixel counts as the far side of a jump.
fn band(input: &HiddenInput) -> Vec<f32> {
    let (width, height, places) = (input.width, input.height, input.places);
    // The near sides of jumps.
    let mut near = vec![f32::NEG_INFINITY; places.len()];
    near.par_chunks_mut(width)
        .enumerate()
        .for_each(|(row, out)| {
            for (column, out) in out.iter_mut().enumerate() {
                let index = row * width + column;
                let mut least = places[index];
                for (dx, dy) in [(-1, 0), (1, 0), (0, -1), (0, 1)] {
                    let (x, y) = (column as i64 + dx, row as i64 + dy);
                    if (0..width as i64).contains(&x) && (0..height as i64).contains(&y) {
                        least = least.min(places[y as usize * width + x as usize]);
                    }
                }
                if places[index] - least > JUMP {
                    *out = places[index];
                }
            }
        });
    let close = largest_about(&near, width, 1);
    let about = largest_about(&near, width, BAND_PX);
    let weigh = |((place, close), about): ((&f32, &f32), &f32)| {
        if *close > place + JUMP {
            AT_JUMP
        } else if *about > place + JUMP {
            1.0
        } else {
            0.0
        }
    };
    let all = places.par_iter().zip(&close).zip(&about);
    all.map(weigh).collect()
}

/// Largest value within `radius` pixels along both axes.
fn largest_about(values: &[f32], width: usize, radius: usize) -> Vec<f32> {
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

/// Makes each of `out` at least the value beside it.
fn raise(out: &mut [f32], values: &[f32]) {
    for (out, value) in out.iter_mut().zip(values) {
        *out = if *value > *out { *value } else { *out };
    }
}
