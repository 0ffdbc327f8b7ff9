//! Sums over planes, the same for any number of threads.

use rayon::prelude::*;

/// Sums of single precision are kept as short as this.
const LANES: usize = 16;
const PIECE: usize = 4096;

/// <a, b>.
pub(super) fn dot(a: &[f32], b: &[f32]) -> f64 {
    let pieces: Vec<f64> = a
        .par_chunks(PIECE)
        .zip(b.par_chunks(PIECE))
        .map(|(a, b)| piece(a, b))
        .collect();
    pieces.iter().sum()
}

fn piece(a: &[f32], b: &[f32]) -> f64 {
    let mut lanes = [0.0_f32; LANES];
    let (a, rest_a) = a.as_chunks::<LANES>();
    let (b, rest_b) = b.as_chunks::<LANES>();
    for (a, b) in a.iter().zip(b) {
        for k in 0..LANES {
            lanes[k] += a[k] * b[k];
        }
    }
    let rest = rest_a.iter().zip(rest_b).map(|(a, b)| f64::from(a * b));
    lanes.iter().map(|v| f64::from(*v)).sum::<f64>() + rest.sum::<f64>()
}

/// <a, a>, <a, b> and <b, b> of short planes.
pub(super) fn products(a: &[f32], b: &[f32]) -> [f64; 3] {
    weighted(a, b, std::iter::repeat(&[1.0; LANES]), &[1.0; LANES])
}

/// <W a, a>, <W a, b> and <W b, b>.
pub(super) fn weighted_products(a: &[f32], b: &[f32], weights: &[f32]) -> [f64; 3] {
    let pieces: Vec<[f64; 3]> = (a.par_chunks(PIECE))
        .zip(b.par_chunks(PIECE))
        .zip(weights.par_chunks(PIECE))
        .map(|((a, b), weights)| {
            let (weights, rest) = weights.as_chunks::<LANES>();
            weighted(a, b, weights.iter(), rest)
        })
        .collect();
    total(pieces.into_iter())
}

fn weighted<'a>(
    a: &[f32],
    b: &[f32],
    weights: impl Iterator<Item = &'a [f32; LANES]>,
    last: &[f32],
) -> [f64; 3] {
    let mut lanes = [[0.0_f32; LANES]; 3];
    let (a, rest_a) = a.as_chunks::<LANES>();
    let (b, rest_b) = b.as_chunks::<LANES>();
    for ((a, b), weight) in a.iter().zip(b).zip(weights) {
        for k in 0..LANES {
            let of_a = weight[k] * a[k];
            lanes[0][k] += of_a * a[k];
            lanes[1][k] += of_a * b[k];
            lanes[2][k] += weight[k] * b[k] * b[k];
        }
    }
    let mut sums = lanes.map(|lane| lane.iter().map(|v| f64::from(*v)).sum());
    for ((a, b), weight) in rest_a.iter().zip(rest_b).zip(last) {
        for (sum, product) in sums.iter_mut().zip([a * a, a * b, b * b]) {
            *sum += f64::from(weight * product);
        }
    }
    sums
}

/// The sum of each, in order.
pub(super) fn total(all: impl Iterator<Item = [f64; 3]>) -> [f64; 3] {
    all.fold([0.0; 3], |sum, one| {
        [sum[0] + one[0], sum[1] + one[1], sum[2] + one[2]]
    })
}

/// Adds `gain` times `other`.
pub(super) fn add(out: &mut [f32], other: &[f32], gain: f32) {
    out.par_chunks_mut(PIECE)
        .zip(other.par_chunks(PIECE))
        .for_each(|(out, other)| {
            for (out, other) in out.iter_mut().zip(other) {
                *out += gain * other;
            }
        });
}

/// How large most of many sizes are: a few bright lights do not change it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Typical {
    /// All but a hundredth are no more than this.
    pub(super) most: f64,
    /// Their mean, none counted as more than `most`.
    pub(super) mean: f64,
    /// Likewise the root of their mean square.
    pub(super) root_mean_square: f64,
}

/// Share of sizes below [`Typical::most`].
const MOST: f64 = 0.99;

impl Typical {
    pub(super) fn of(mut sizes: Vec<f32>) -> Self {
        if sizes.is_empty() {
            return Self::default();
        }
        let place = ((sizes.len() - 1) as f64 * MOST) as usize;
        let (_, most, above) = sizes.select_nth_unstable_by(place, f32::total_cmp);
        let most = f64::from(*most);
        let (held, count) = ((1 + above.len()) as f64, sizes.len() as f64);
        let below = || sizes[..place].iter().map(|v| f64::from(*v));
        Self {
            most,
            mean: (below().sum::<f64>() + held * most) / count,
            root_mean_square: ((below().map(|v| v * v).sum::<f64>() + held * most * most) / count)
                .sqrt(),
        }
    }
}
