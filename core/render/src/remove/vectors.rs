//! Inner products and sums of planes as vectors, the same to the bit for any number of threads.

use rayon::prelude::*;

/// Number of partial sums in single precision that are carried side by side, as wide as vector registers.
const LANES: usize = 16;
/// Samples that one task adds up in single precision, before its sum goes on in double precision.
const BLOCK: usize = 4096;

/// The Gram matrix of two vectors a and b: their inner products with themselves and with each other.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Gram {
    pub(super) aa: f64,
    pub(super) ab: f64,
    pub(super) bb: f64,
}

impl Gram {
    /// Adds up Gram matrices in order.
    pub(super) fn total(all: impl Iterator<Item = Self>) -> Self {
        all.fold(Self::default(), |sum, one| Self {
            aa: sum.aa + one.aa,
            ab: sum.ab + one.ab,
            bb: sum.bb + one.bb,
        })
    }
}

/// Returns <a, b>.
pub(super) fn dot(a: &[f32], b: &[f32]) -> f64 {
    let blocks: Vec<f64> = a
        .par_chunks(BLOCK)
        .zip(b.par_chunks(BLOCK))
        .map(|(a, b)| block_dot(a, b))
        .collect();
    blocks.iter().sum()
}

fn block_dot(a: &[f32], b: &[f32]) -> f64 {
    dot_of_rows(std::iter::once((a, b)))
}

/// Returns the inner product of two planes, given as pairs of rows, on one thread.
pub(super) fn dot_of_rows<'a>(rows: impl Iterator<Item = (&'a [f32], &'a [f32])>) -> f64 {
    let sum_of = |lanes: [f32; LANES]| lanes.iter().map(|v| f64::from(*v)).sum::<f64>();
    let (mut lanes, mut count, mut sum) = ([0.0_f32; LANES], 0, 0.0);
    for (row_a, row_b) in rows {
        let (a, rest_a) = row_a.as_chunks::<LANES>();
        let (b, rest_b) = row_b.as_chunks::<LANES>();
        for (a, b) in a.iter().zip(b) {
            for k in 0..LANES {
                lanes[k] += a[k] * b[k];
            }
        }
        for (lane, (a, b)) in lanes.iter_mut().zip(rest_a.iter().zip(rest_b)) {
            *lane += a * b;
        }
        count += row_a.len();
        if count >= BLOCK {
            sum += sum_of(std::mem::take(&mut lanes));
            count = 0;
        }
    }
    sum + sum_of(lanes)
}

/// Returns the Gram matrix of two short vectors, on one thread.
pub(super) fn short_gram(a: &[f32], b: &[f32]) -> Gram {
    block_gram(a, b, std::iter::repeat(&[1.0; LANES]), &[1.0; LANES])
}

/// Returns the Gram matrix under a diagonal weight W: <W a, a>, <W a, b> and <W b, b>.
pub(super) fn weighted_gram(a: &[f32], b: &[f32], weights: &[f32]) -> Gram {
    let blocks: Vec<Gram> = (a.par_chunks(BLOCK))
        .zip(b.par_chunks(BLOCK))
        .zip(weights.par_chunks(BLOCK))
        .map(|((a, b), weights)| {
            let (weights, rest) = weights.as_chunks::<LANES>();
            block_gram(a, b, weights.iter(), rest)
        })
        .collect();
    Gram::total(blocks.into_iter())
}

/// `last` has the weights of the samples that do not fill all lanes.
fn block_gram<'a>(
    a: &[f32],
    b: &[f32],
    weights: impl Iterator<Item = &'a [f32; LANES]>,
    last: &[f32],
) -> Gram {
    let mut lanes = [[0.0_f32; LANES]; 3];
    let (a, rest_a) = a.as_chunks::<LANES>();
    let (b, rest_b) = b.as_chunks::<LANES>();
    for ((a, b), weight) in a.iter().zip(b).zip(weights) {
        for k in 0..LANES {
            let weighted_a = weight[k] * a[k];
            lanes[0][k] += weighted_a * a[k];
            lanes[1][k] += weighted_a * b[k];
            lanes[2][k] += weight[k] * b[k] * b[k];
        }
    }
    let [mut aa, mut ab, mut bb] =
        lanes.map(|lane| lane.iter().map(|v| f64::from(*v)).sum::<f64>());
    for ((a, b), weight) in rest_a.iter().zip(rest_b).zip(last) {
        aa += f64::from(weight * (a * a));
        ab += f64::from(weight * (a * b));
        bb += f64::from(weight * (b * b));
    }
    Gram { aa, ab, bb }
}

/// Adds `gain` times `other` to `out`.
pub(super) fn add_scaled(out: &mut [f32], other: &[f32], gain: f32) {
    out.par_chunks_mut(BLOCK)
        .zip(other.par_chunks(BLOCK))
        .for_each(|(out, other)| {
            for (out, other) in out.iter_mut().zip(other) {
                *out += gain * other;
            }
        });
}
