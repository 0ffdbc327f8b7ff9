//! What is behind the near side of depth edges, guessed from what can be seen beside it.
//!
//! A blurred foreground is half transparent towards its edge, and there one sees what the plate does
//! not show. Each pixel near an edge gets one hidden sample, colour, alpha and vergence alike: the far
//! side's own samples next to the edge, and averages of ever larger cells of them further in, as far as
//! the blur of both reaches. The rule is local ([`HIDDEN_REACH_PX`]) and cells lie on a grid fixed to
//! the frame, so that tiles with that much margin give what the whole gives.

use super::ladder::Ladder;
use super::pyramid::{self, JUMP, Level};
use crate::render::{Plane, PlateMap};
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
    /// Place of every pixel on the ladder.
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
    pub(super) columns: Vec<u32>,
    /// Presence of each.
    pub(super) weights: Vec<f32>,
    pub(super) places: Vec<f32>,
    /// Of each, one sample a plane, times its presence.
    pub(super) samples: Vec<f32>,
}

/// The hidden samples of all rows.
pub(super) fn sheet(input: &HiddenInput, ladder: &Ladder) -> Vec<HiddenRow> {
    let largest = input.places.par_iter().map(|place| ladder.size(*place));
    let reach = 2.0 * largest.reduce(|| 0.0, f32::max);
    let levels = (1..MOST_LEVELS)
        .find(|level| (1 << level) as f32 >= 6.0 * (reach + SPARE_PX))
        .unwrap_or(MOST_LEVELS);
    let pyramid = pyramid::build(input, levels);
    (0..input.height)
        .into_par_iter()
        .map(|row| hidden_row(input, ladder, &pyramid, row))
        .collect()
}

/// Reach beyond that of the blur, px.
const SPARE_PX: f32 = 2.0;

fn hidden_row(input: &HiddenInput, ladder: &Ladder, pyramid: &[Level], row: usize) -> HiddenRow {
    let mut out = HiddenRow::default();
    let mut guess = Guess {
        samples: vec![0.0; input.planes.len()],
        ..Guess::default()
    };
    for column in 0..input.width {
        let place = input.places[row * input.width + column];
        let at = [column + input.origin[0], row + input.origin[1]];
        guess.look(pyramid, ladder, at, place);
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

/// What is behind one pixel, summed up from fine cells to coarse ones.
#[derive(Default)]
struct Guess {
    weight: f32,
    /// Times the weight, as the samples.
    place: f32,
    samples: Vec<f32>,
}

impl Guess {
    /// Looks behind the pixel `at` on the frame's grid, which is at `place` on the ladder.
    fn look(&mut self, pyramid: &[Level], ladder: &Ladder, at: [usize; 2], place: f32) {
        (self.weight, self.place) = (0.0, 0.0);
        self.samples.fill(0.0);
        let size = ladder.size(place);
        for (index, level) in pyramid.iter().enumerate() {
            let side = (2 << index) as f32;
            let left = 1.0 - self.weight;
            if left < LEAST_WEIGHT {
                return;
            }
            let [x, y] = at.map(|at| (at as f32 + 0.5) / side - 0.5);
            let (column, row) = (x.floor(), y.floor());
            let (fx, fy) = (x - column, y - row);
            for (dx, dy, share) in [
                (0, 0, (1.0 - fx) * (1.0 - fy)),
                (1, 0, fx * (1.0 - fy)),
                (0, 1, (1.0 - fx) * fy),
                (1, 1, fx * fy),
            ] {
                let Some(cell) = level.cell(column as i64 + dx, row as i64 + dy) else {
                    continue;
                };
                let behind = (place - level.place[cell] - JUMP / 2.0).clamp(0.0, 1.0);
                if level.weight[cell] == 0.0 || behind == 0.0 {
                    continue;
                }
                // Cells twice as large as the blur reaches still count in full.
                let reach = size + ladder.size(level.place[cell]) + SPARE_PX;
                let near = (3.0 * reach / side - 0.5).clamp(0.0, 1.0);
                // A cell of mixed pixels alone says little where a larger one knows better.
                let known = level.weight[cell].min(1.0);
                self.add(level, cell, left * share * behind * near * known);
            }
        }
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
