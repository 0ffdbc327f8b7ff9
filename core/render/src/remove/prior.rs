//! What sharp pictures look like: most slopes are none, some are steep.

use super::sums::{products, total};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Differences that are looked at: columns and rows to the other sample, and their weight.
const WAYS: [(i32, usize, f32); 4] = [
    (1, 0, 1.0),
    (0, 1, 1.0),
    (1, 1, std::f32::consts::FRAC_1_SQRT_2),
    (-1, 1, std::f32::consts::FRAC_1_SQRT_2),
];

/// What D^T D does to a wave of (x, y) cycles a pixel.
pub(super) fn response(x: f64, y: f64) -> f64 {
    let ways = WAYS.iter().map(|(dx, dy, weight)| {
        let turn = TAU * (x * f64::from(*dx) + y * *dy as f64);
        f64::from(*weight).powi(2) * (2.0 - 2.0 * turn.cos())
    });
    ways.sum()
}

/// Mean square slope of noise of unit variance.
pub(super) fn slope_of_noise() -> f64 {
    let ways = WAYS.iter();
    ways.map(|(_, _, weight)| 2.0 * f64::from(weight * weight))
        .sum()
}

/// Differences of a plane along four ways, none across its edges: D.
#[derive(Clone)]
pub(super) struct Slopes {
    width: usize,
    ways: [Vec<f32>; 4],
}

/// The samples of a row that have another one (`dx`, `dy`) further on: the first's column, and those others.
fn pairs(plane: &[f32], width: usize, row: usize, way: usize) -> (usize, &[f32], &[f32]) {
    let (dx, dy, _) = WAYS[way];
    let first = (-dx).max(0) as usize;
    let length = width.saturating_sub(dx.unsigned_abs() as usize);
    let other = (row + dy) * width + (first as i32 + dx).max(0) as usize;
    if other + length > plane.len() {
        return (first, &[], &[]);
    }
    let here = row * width + first;
    (
        first,
        &plane[here..here + length],
        &plane[other..other + length],
    )
}

/// Writes the differences of a row along `way`.
fn row_of(plane: &[f32], width: usize, row: usize, way: usize, out: &mut [f32]) {
    let weight = WAYS[way].2;
    let (first, here, other) = pairs(plane, width, row, way);
    out.fill(0.0);
    for (out, (a, b)) in out[first.min(width)..]
        .iter_mut()
        .zip(here.iter().zip(other))
    {
        *out = weight * (b - a);
    }
}

/// <D a, D a>, <D a, D b> and <D b, D b>.
pub(super) fn slope_products(a: &[f32], b: &[f32], width: usize) -> [f64; 3] {
    let rows: Vec<[f64; 3]> = (0..a.len() / width.max(1))
        .into_par_iter()
        .map_init(
            || (vec![0.0; width], vec![0.0; width]),
            |(of_a, of_b), row| {
                let along = (0..WAYS.len()).map(|way| {
                    row_of(a, width, row, way, of_a);
                    row_of(b, width, row, way, of_b);
                    products(of_a, of_b)
                });
                total(along)
            },
        )
        .collect();
    total(rows.into_iter())
}

/// Lengths of the differences of a plane, of some of its rows.
pub(super) fn slope_lengths(plane: &[f32], width: usize) -> Vec<f32> {
    let height = plane.len() / width.max(1);
    lengths_of_rows(plane, width, (height / 128).max(1))
}

/// Lengths of the differences of a plane, row-major.
pub(super) fn all_slope_lengths(plane: &[f32], width: usize) -> Vec<f32> {
    lengths_of_rows(plane, width, 1)
}

/// Of one row of every `step`.
fn lengths_of_rows(plane: &[f32], width: usize, step: usize) -> Vec<f32> {
    let height = plane.len() / width.max(1);
    let rows: Vec<Vec<f32>> = (0..height)
        .into_par_iter()
        .step_by(step)
        .map_init(
            || [(); 4].map(|()| vec![0.0; width]),
            |ways, row| {
                for (way, out) in ways.iter_mut().enumerate() {
                    row_of(plane, width, row, way, out);
                }
                (0..width).map(|k| length(ways, k)).collect()
            },
        )
        .collect();
    rows.concat()
}

fn length(ways: &[Vec<f32>; 4], k: usize) -> f32 {
    let [a, b, c, d] = [ways[0][k], ways[1][k], ways[2][k], ways[3][k]];
    (a * a + b * b + c * c + d * d).sqrt()
}

impl Slopes {
    /// No slopes.
    pub(super) fn none(count: usize, width: usize) -> Self {
        Self {
            width,
            ways: [(); 4].map(|()| vec![0.0; count]),
        }
    }

    #[cfg(test)]
    pub(super) fn of(plane: &[f32], width: usize) -> Self {
        let mut slopes = Self::none(plane.len(), width);
        for (way, out) in slopes.ways.iter_mut().enumerate() {
            for (row, out) in out.chunks_exact_mut(width).enumerate() {
                row_of(plane, width, row, way, out);
            }
        }
        slopes
    }

    #[cfg(test)]
    pub(super) fn dot(&self, other: &Self) -> f64 {
        let ways = self.ways.iter().zip(&other.ways);
        ways.map(|(a, b)| super::sums::dot(a, b)).sum()
    }

    /// One turn of alternating directions, these being the multipliers u of the slopes of `plane`: z is D x + u, each
    /// shortened by `by` down to none; u becomes D x + u - z. Gives z - u - D x.
    pub(super) fn turned(&mut self, plane: &[f32], by: f32) -> Self {
        let width = self.width;
        let mut pull = Self::none(plane.len(), width);
        let [u0, u1, u2, u3] = self.ways.each_mut().map(|way| way.par_chunks_mut(width));
        let [p0, p1, p2, p3] = pull.ways.each_mut().map(|way| way.par_chunks_mut(width));
        let multipliers = u0.zip(u1).zip(u2).zip(u3);
        let pulls = p0.zip(p1).zip(p2).zip(p3);
        multipliers.zip(pulls).enumerate().for_each(
            |(row, ((((u0, u1), u2), u3), (((p0, p1), p2), p3)))| {
                let (u, mut p) = ([u0, u1, u2, u3], [p0, p1, p2, p3]);
                for (way, out) in p.iter_mut().enumerate() {
                    row_of(plane, width, row, way, out);
                }
                for k in 0..width {
                    let slope = [p[0][k], p[1][k], p[2][k], p[3][k]];
                    let from = [u[0][k], u[1][k], u[2][k], u[3][k]];
                    let mut square = 0.0;
                    for way in 0..4 {
                        square += (slope[way] + from[way]) * (slope[way] + from[way]);
                    }
                    // Share that is cut off.
                    let cut = by / square.sqrt().max(by);
                    for way in 0..4 {
                        let pulled = slope[way] + from[way];
                        let next = cut * pulled;
                        u[way][k] = next;
                        p[way][k] = pulled - 2.0 * next - slope[way];
                    }
                }
            },
        );
        pull
    }

    /// D^T: what has these inner products with the slopes of planes.
    pub(super) fn gathered(&self) -> Vec<f32> {
        let width = self.width;
        let mut sum = vec![0.0; self.ways[0].len()];
        let rows = sum.par_chunks_mut(width.max(1)).enumerate();
        rows.for_each(|(row, out)| {
            for (way, (dx, dy, weight)) in self.ways.iter().zip(WAYS) {
                for (out, slope) in out.iter_mut().zip(&way[row * width..]) {
                    *out -= weight * slope;
                }
                if row < dy {
                    continue;
                }
                // From the sample that this one is the other of.
                let from = &way[(row - dy) * width..][..width];
                let (to, from) = match dx {
                    ..0 => (&mut out[..width - 1], &from[1..]),
                    0 => (&mut *out, from),
                    1.. => (&mut out[1..], &from[..width - 1]),
                };
                for (out, slope) in to.iter_mut().zip(from) {
                    *out += weight * slope;
                }
            }
        });
        sum
    }
}
