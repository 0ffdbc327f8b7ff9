//! What is behind the near side of depth edges, guessed from what can be seen beside it.
//!
//! A blurred foreground is half transparent towards its edge, and there one sees what the plate does
//! not show. Each pixel near an edge gets one hidden sample, colour, alpha and vergence alike: the far
//! side's own samples next to the edge, and averages of ever larger cells of them further in, as far as
//! the blur of both reaches. The rule is local ([`HIDDEN_REACH_PX`]) and cells lie on a grid fixed to
//! the frame, so that tiles with that much margin give what the whole gives.

use super::depth_layers::DepthLayers;
use super::pyramid::{self, JUMP, Level};
use crate::{Plane, PlateMap};
use rayon::prelude::*;

/// Levels of the pyramid at most.
const MOST_LEVELS: u32 = 8;

/// How far a hidden sample can come from, px: larger blurs see through to repeated averages.
pub const HIDDEN_REACH_PX: usize = 3 << (MOST_LEVELS - 1);

/// One over the weight from which on a guess is taken to be all there: a quarter of what is about.
const ENOUGH: f32 = 4.0;
/// Samples that count less than this are left out.
const LEAST_WEIGHT: f32 = 1e-3;

/// A plate as the search for hidden samples sees it.
pub(super) struct HiddenInput<'a> {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Where the plate's first pixel is on the frame's grid of cells.
    pub(super) origin: [usize; 2],
    /// Place of every pixel on the layers.
    pub(super) places: &'a [f32],
    pub(super) planes: &'a [Plane<'a>],
}

/// Where the first pixel of a plate is on the grid of cells.
pub(super) fn grid_origin(map: PlateMap) -> [usize; 2] {
    let period = f64::from(1 << MOST_LEVELS);
    [map.origin.x_px, map.origin.y_px]
        .map(|at| (at * map.scale).round().rem_euclid(period) as usize)
}

/// Samples besides those of the plate, of one of its rows: hidden ones, or corrections.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct HiddenRow {
    /// Ascending.
    pub(super) columns: Vec<u32>,
    /// Presence of each.
    pub(super) weights: Vec<f32>,
    pub(super) places: Vec<f32>,
    /// Of each, one sample a plane, times its presence.
    pub(super) samples: Vec<f32>,
}

/// The hidden samples of all rows; nothing where `goes_on` once said no.
pub(super) fn sheet(
    input: &HiddenInput,
    layers: &DepthLayers,
    goes_on: &(dyn Fn() -> bool + Sync),
) -> Option<Vec<HiddenRow>> {
    let largest = input.places.par_iter().map(|place| layers.size(*place));
    let reach = 2.0 * largest.reduce(|| 0.0, f32::max);
    let levels = (1..MOST_LEVELS)
        .find(|level| (1 << level) as f32 >= 6.0 * (reach + SPARE_PX))
        .unwrap_or(MOST_LEVELS);
    let pyramid = pyramid::build(input, levels);
    (0..input.height)
        .into_par_iter()
        .map(|row| goes_on().then(|| hidden_row(input, layers, &pyramid, row)))
        .collect()
}

/// Reach beyond that of the blur, px.
const SPARE_PX: f32 = 2.0;

fn hidden_row(
    input: &HiddenInput,
    layers: &DepthLayers,
    pyramid: &[Level],
    row: usize,
) -> HiddenRow {
    let mut out = HiddenRow::default();
    let mut guess = Guess {
        samples: vec![0.0; input.planes.len()],
        ..Guess::default()
    };
    let lines: Vec<Line> = pyramid
        .iter()
        .enumerate()
        .map(|(index, level)| Line::new(level, (2 << index) as f32, row + input.origin[1]))
        .collect();
    for column in 0..input.width {
        let place = input.places[row * input.width + column];
        guess.look(&lines, layers, column + input.origin[0], place);
        if guess.weight > LEAST_WEIGHT {
            out.columns.push(column as u32);
            let presence = (ENOUGH * guess.weight).min(1.0);
            out.weights.push(presence);
            out.places.push(guess.place / guess.weight);
            let gain = presence / guess.weight;
            out.samples
                .extend(guess.samples.iter().map(|sample| gain * sample));
        }
    }
    out
}

/// The cells of one level about a row of pixels.
struct Line<'a> {
    level: &'a Level,
    /// Side of a cell, px.
    side: f32,
    /// First cell of each of the two rows of cells, and the row's share; none where the plate has no such row.
    rows: [Option<(usize, f32)>; 2],
    /// Columns in which either row has something, on the frame's grid; end not included.
    lit: (i32, i32),
}

impl<'a> Line<'a> {
    /// Those about row `y` of the frame's grid.
    fn new(level: &'a Level, side: f32, y: usize) -> Self {
        let at = (y as f32 + 0.5) / side - 0.5;
        let row = at.floor();
        let share = at - row;
        let found = |dy: i64, share: f32| level.row(row as i64 + dy).map(|first| (first, share));
        let rows = [found(0, 1.0 - share), found(1, share)];
        let mut lit = (i32::MAX, i32::MIN);
        for (first, _) in rows.iter().flatten() {
            let weights = &level.weight[*first..first + level.columns];
            if let Some(start) = weights.iter().position(|w| *w > 0.0) {
                let end = weights.iter().rposition(|w| *w > 0.0).unwrap_or(start) + 1;
                let on_grid = |column: usize| (column + level.first[0]) as i32;
                lit = (lit.0.min(on_grid(start)), lit.1.max(on_grid(end)));
            }
        }
        Self {
            level,
            side,
            rows,
            lit,
        }
    }
}

/// What is behind one pixel, summed up from fine cells to coarse ones.
#[derive(Default)]
struct Guess {
    weight: f32,
    /// Times the weight, as the samples.
    place: f32,
    samples: Vec<f32>,
}

impl Guess {
    /// Looks behind the pixel in column `x` of the frame's grid, which is at `place` on the layers.
    fn look(&mut self, lines: &[Line], layers: &DepthLayers, x: usize, place: f32) {
        (self.weight, self.place) = (0.0, 0.0);
        self.samples.fill(0.0);
        let size = layers.size(place);
        for line in lines {
            let left = 1.0 - self.weight;
            if left < LEAST_WEIGHT {
                return;
            }
            let at = (x as f32 + 0.5) / line.side - 0.5;
            // Rounds down from -0.5 on.
            let column = (at + 1.0) as i32 - 1;
            if column + 1 < line.lit.0 || column >= line.lit.1 {
                continue;
            }
            let share = at - column as f32;
            for (first, across) in line.rows.iter().flatten() {
                for (column, down) in [(column, 1.0 - share), (column + 1, share)] {
                    if column < line.lit.0 || column >= line.lit.1 {
                        continue;
                    }
                    let cell = first + column as usize - line.level.first[0];
                    self.take((line, cell), left * across * down, (place, size), layers);
                }
            }
        }
    }

    /// Adds a cell, as far as it is behind `place` and in reach of a blur of `size`.
    fn take(
        &mut self,
        (line, cell): (&Line, usize),
        share: f32,
        (place, size): (f32, f32),
        layers: &DepthLayers,
    ) {
        let level = line.level;
        let behind = (place - level.place[cell] - JUMP / 2.0).clamp(0.0, 1.0);
        if level.weight[cell] == 0.0 || behind == 0.0 {
            return;
        }
        // Cells twice as large as the blur reaches still count in full.
        let reach = size + layers.size(level.place[cell]) + SPARE_PX;
        let near = (3.0 * reach / line.side - 0.5).clamp(0.0, 1.0);
        // A cell of mixed pixels alone says little where a larger one knows better.
        let known = level.weight[cell].min(1.0);
        self.add(level, cell, share * behind * near * known);
    }

    fn add(&mut self, level: &Level, cell: usize, weight: f32) {
        self.weight += weight;
        self.place += weight * level.place[cell];
        let planes = self.samples.len();
        let from = &level.samples[cell * planes..(cell + 1) * planes];
        for (sum, sample) in self.samples.iter_mut().zip(from) {
            *sum += weight * sample;
        }
    }
}
