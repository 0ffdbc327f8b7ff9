//! Overlapping squares under smooth windows: a plane is cut into them, each is worked on, and they are put together.

use rayon::prelude::*;
use std::f64::consts::PI;

/// Share of a square that it has in common with the next.
const COMMON: f64 = 0.5;
/// Rows that one thread puts together.
const BAND: usize = 32;

/// The squares over a plane.
pub(super) struct Squares {
    /// Columns and rows of the plane.
    size: (usize, usize),
    /// Of a square, px.
    pub(super) side: usize,
    /// First column and row of each square, row by row.
    pub(super) places: Vec<(i32, i32)>,
    /// How many squares there are in a row, and from one to the next, px.
    columns: usize,
    hop: usize,
    /// Along one axis: rises and falls as a sine where neighbours share samples.
    window: Vec<f32>,
}

impl Squares {
    /// Squares of some side over a plane of `size`, as far beyond one edge as beyond the other.
    pub(super) fn new(size: (usize, usize), side: usize) -> Self {
        let ramp = (COMMON * side as f64) as usize;
        let hop = side - ramp;
        let count = |size: usize| (size + ramp).div_ceil(hop);
        let starts = |size: usize| {
            let before = (ramp + count(size) * hop - size) / 2;
            (0..count(size)).map(move |k| (k * hop) as i32 - before as i32)
        };
        Self {
            size,
            side,
            places: starts(size.1)
                .flat_map(|y| starts(size.0).map(move |x| (x, y)))
                .collect(),
            columns: count(size.0),
            hop,
            window: (0..side)
                .map(|k| {
                    let inwards = (k.min(side - 1 - k) as f64 + 0.5) / ramp as f64;
                    (0.5 * PI * inwards.min(1.0)).sin() as f32
                })
                .collect(),
        }
    }

    /// The middle of the square at `place`, on the plane.
    pub(super) fn middle(&self, place: (i32, i32)) -> (f64, f64) {
        let along = |start: i32, size: usize| {
            (f64::from(start) + self.side as f64 / 2.0).clamp(0.0, size as f64)
        };
        (along(place.0, self.size.0), along(place.1, self.size.1))
    }

    /// The squares whose middles are about a point, and their shares by how near they are.
    pub(super) fn about(&self, (x, y): (f64, f64)) -> [(usize, f32); 4] {
        let (first, rows) = (self.places[0], self.places.len() / self.columns);
        let along = |at: f64, first: i32, count: usize| {
            let half = self.side as f64 / 2.0;
            let step =
                ((at - f64::from(first) - half) / self.hop as f64).clamp(0.0, (count - 1) as f64);
            let low = (step as usize).min(count.saturating_sub(2));
            (low, (low + 1).min(count - 1), (step - low as f64) as f32)
        };
        let (left, right, by_x) = along(x, first.0, self.columns);
        let (top, bottom, by_y) = along(y, first.1, rows);
        [
            (top * self.columns + left, (1.0 - by_x) * (1.0 - by_y)),
            (top * self.columns + right, by_x * (1.0 - by_y)),
            (bottom * self.columns + left, (1.0 - by_x) * by_y),
            (bottom * self.columns + right, by_x * by_y),
        ]
    }

    /// Whether all of the square at `place` lies on the plane.
    pub(super) fn is_whole(&self, place: (i32, i32)) -> bool {
        let inside = self.stretches(place).map(|s| s.inside.len());
        inside.sum::<usize>() == self.side * self.side
    }

    /// Whether `share` is above zero all over the square at `place`, or nowhere.
    pub(super) fn is_full(&self, share: &[f32], place: (i32, i32)) -> bool {
        let mut stretches = self.stretches(place);
        stretches.all(|s| share[s.plate..][..s.inside.len()].iter().all(|v| *v > 0.0))
    }

    pub(super) fn is_dark(&self, share: &[f32], place: (i32, i32)) -> bool {
        let mut stretches = self.stretches(place);
        stretches.all(|s| share[s.plate..][..s.inside.len()].iter().all(|v| *v == 0.0))
    }

    /// The windowed square at `place`, dark beyond the plane.
    pub(super) fn cut(&self, plane: &[f32], place: (i32, i32)) -> Vec<f32> {
        let mut square = vec![0.0; self.side * self.side];
        for Stretch { inside, plate, wy } in self.stretches(place) {
            let samples = plane[plate..][..inside.len()].iter();
            let windows = &self.window[inside.start % self.side..];
            for ((out, sample), wx) in square[inside].iter_mut().zip(samples).zip(windows) {
                *out = wy * wx * sample;
            }
        }
        square
    }

    /// A square of one value under the window.
    pub(super) fn even(&self, value: f32) -> Vec<f32> {
        let rows = self.window.iter();
        rows.flat_map(|wy| self.window.iter().map(move |wx| value * wy * wx))
            .collect()
    }

    /// Sum of a square's windows.
    pub(super) fn weight(&self) -> f32 {
        self.window.iter().sum::<f32>().powi(2)
    }

    /// Sum of their squares.
    pub(super) fn energy(&self) -> f32 {
        self.window.iter().map(|w| w * w).sum::<f32>().powi(2)
    }

    /// The sum of squares, windowed once more, in order, so that it does not depend on threads.
    pub(super) fn put_together(&self, parts: &[Option<Vec<f32>>]) -> Vec<f32> {
        let mut out = vec![0.0; self.size.0 * self.size.1];
        let bands = out.par_chunks_mut(BAND * self.size.0).enumerate();
        bands.for_each(|(band, out)| {
            for (place, part) in self.places.iter().zip(parts) {
                if let Some(part) = part {
                    self.add(part, *place, band * BAND, out);
                }
            }
        });
        out
    }

    /// Adds what of a windowed square lies on the rows of the plane from `first` on, `out`.
    fn add(&self, square: &[f32], place: (i32, i32), first: usize, out: &mut [f32]) {
        let before = first * self.size.0;
        for Stretch { inside, plate, wy } in self.stretches(place) {
            if plate < before || plate >= before + out.len() {
                continue;
            }
            let samples = square[inside.clone()].iter();
            let windows = &self.window[inside.start % self.side..];
            for ((out, sample), wx) in out[plate - before..].iter_mut().zip(samples).zip(windows) {
                *out += wy * wx * sample;
            }
        }
    }

    /// The rows of the square at `place` that lie on the plane.
    pub(super) fn stretches(&self, (left, top): (i32, i32)) -> impl Iterator<Item = Stretch> + '_ {
        let (width, height) = (self.size.0 as i32, self.size.1 as i32);
        let side = self.side as i32;
        let columns = (-left).max(0) as usize..(width - left).clamp(0, side) as usize;
        let rows = (-top).max(0) as usize..(height - top).clamp(0, side) as usize;
        let rows = if columns.is_empty() { 0..0 } else { rows };
        rows.map(move |y| Stretch {
            inside: y * self.side + columns.start..y * self.side + columns.end,
            plate: (top + y as i32) as usize * self.size.0 + (left + columns.start as i32) as usize,
            wy: self.window[y],
        })
    }
}

/// A row of a square, as far as it lies on the plane.
pub(super) struct Stretch {
    /// Its samples in the square.
    pub(super) inside: std::ops::Range<usize>,
    /// Its first sample on the plane.
    pub(super) plate: usize,
    /// Its window.
    wy: f32,
}
