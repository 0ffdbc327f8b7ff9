//! What sharp pictures look like: most slopes are none, some are steep.

use std::f64::consts::TAU;

/// Differences that are looked at: columns and rows to the other sample, and their weight.
const WAYS: [(i32, i32, f32); 4] = [
    (1, 0, 1.0),
    (0, 1, 1.0),
    (1, 1, std::f32::consts::FRAC_1_SQRT_2),
    (-1, 1, std::f32::consts::FRAC_1_SQRT_2),
];

/// Differences of a plane along [`WAYS`], none across its edges: D.
#[derive(Clone)]
pub(super) struct Slopes {
    ways: Vec<Vec<f32>>,
}

/// What D^T D does to a wave of (x, y) cycles a pixel.
pub(super) fn response(x: f64, y: f64) -> f64 {
    let ways = WAYS.iter().map(|(dx, dy, weight)| {
        let turn = TAU * (x * f64::from(*dx) + y * f64::from(*dy));
        f64::from(*weight).powi(2) * (2.0 - 2.0 * turn.cos())
    });
    ways.sum()
}

/// Rows and columns of samples that have another one (`dx`, `dy`) further on.
fn pairs(
    dx: i32,
    dy: i32,
    width: usize,
    count: usize,
) -> impl Iterator<Item = (usize, usize, usize)> {
    let height = count / width.max(1);
    let first = (-dx).max(0) as usize;
    let length = width.saturating_sub(dx.unsigned_abs() as usize);
    (0..height.saturating_sub(dy as usize)).map(move |y| {
        let at = y * width + first;
        let other = ((y as i32 + dy) as usize * width) + (first as i32 + dx) as usize;
        (at, other, length)
    })
}

impl Slopes {
    pub(super) fn of(plane: &[f32], width: usize) -> Self {
        let ways = WAYS.iter().map(|&(dx, dy, weight)| {
            let mut way = vec![0.0; plane.len()];
            for (at, other, length) in pairs(dx, dy, width, plane.len()) {
                let both = plane[at..at + length]
                    .iter()
                    .zip(&plane[other..other + length]);
                for (out, (a, b)) in way[at..at + length].iter_mut().zip(both) {
                    *out = weight * (b - a);
                }
            }
            way
        });
        Self {
            ways: ways.collect(),
        }
    }

    /// D^T: what has these inner products with the slopes of planes.
    pub(super) fn gathered(&self, width: usize) -> Vec<f32> {
        let count = self.ways[0].len();
        let mut sum = vec![0.0; count];
        for (way, &(dx, dy, weight)) in self.ways.iter().zip(&WAYS) {
            for (at, other, length) in pairs(dx, dy, width, count) {
                for k in 0..length {
                    let slope = weight * way[at + k];
                    sum[at + k] -= slope;
                    sum[other + k] += slope;
                }
            }
        }
        sum
    }

    pub(super) fn dot(&self, other: &Self) -> f64 {
        let ways = self.ways.iter().flatten().zip(other.ways.iter().flatten());
        ways.map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
    }

    fn length(&self, k: usize) -> f32 {
        self.ways
            .iter()
            .map(|way| way[k] * way[k])
            .sum::<f32>()
            .sqrt()
    }

    /// Mean length.
    pub(super) fn mean_length(&self) -> f64 {
        let count = self.ways[0].len();
        (0..count).map(|k| f64::from(self.length(k))).sum::<f64>() / count.max(1) as f64
    }

    /// Each shortened by `by`, down to none.
    pub(super) fn shortened(&self, by: f32) -> Self {
        let mut out = self.ways.clone();
        for k in 0..self.ways[0].len() {
            let length = self.length(k);
            let share = if length > by { 1.0 - by / length } else { 0.0 };
            for way in &mut out {
                way[k] *= share;
            }
        }
        Self { ways: out }
    }

    pub(super) fn plus(&self, other: &Self, gain: f32) -> Self {
        let sum =
            |(a, b): (&Vec<f32>, &Vec<f32>)| a.iter().zip(b).map(|(a, b)| a + gain * b).collect();
        Self {
            ways: self.ways.iter().zip(&other.ways).map(sum).collect(),
        }
    }
}
