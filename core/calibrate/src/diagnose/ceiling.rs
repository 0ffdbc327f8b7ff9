//! What a free-form model of the residual can close at best.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::hypothesis::Hypothesis;
use super::picture::Easel;
use super::seen::{FOLDS, Seen};
use seidel_optics::distance::ObjectDistance;
use seidel_optics::psf::pupil::Detail;

/// Channel, distance and size of tiles that are compared.
type Key = (usize, ObjectDistance, (usize, usize));

/// Sizes of the bases over the field that are tried: constant, linear, quadratic.
const BASES: [usize; 3] = [1, 3, 6];

/// Share of the gap that a smooth field of residual tiles closes, one for each channel and distance:
/// every pixel a polynomial of the field position, fitted without the fold that it is scored on. No
/// effect is asked; finer detail than the tiles' pixels, and what changes faster over the field, is beyond
/// it, so more than this can be explained by a good model.
pub(super) fn explainable(tiles: &[&Seen], nothing: &Hypothesis) -> f64 {
    let residuals: Vec<Vec<f64>> = tiles
        .par_iter()
        .map_init(
            || (Easel::default(), Vec::new()),
            |(easel, picture), seen| {
                easel.predict(nothing, &[], seen, Detail::COARSE, picture);
                seen.light
                    .iter()
                    .zip(&*picture)
                    .map(|(o, p)| o - p)
                    .collect()
            },
        )
        .collect();
    let mut groups: Vec<(Key, Vec<usize>)> = Vec::new();
    for (index, tile) in tiles.iter().enumerate() {
        let key = (tile.of_lens, tile.distance, tile.size);
        match groups.iter_mut().find(|g| g.0 == key) {
            Some(group) => group.1.push(index),
            None => groups.push((key, vec![index])),
        }
    }
    let total: f64 = tiles
        .iter()
        .zip(&residuals)
        .map(|(t, r)| r.iter().map(|v| v * v).sum::<f64>() / t.norm - t.noise)
        .sum();
    if total <= 0.0 {
        return 0.0;
    }
    let left: f64 = groups
        .iter()
        .map(|(_, members)| {
            BASES
                .iter()
                .map(|&size| left(tiles, &residuals, members, size))
                .fold(f64::INFINITY, f64::min)
        })
        .sum();
    (1.0 - left / total).clamp(0.0, 1.0)
}

fn basis(tile: &Seen, size: usize) -> [f64; 6] {
    let (x, y) = (tile.point.at.x, tile.point.at.y);
    let mut all = [1.0, x, y, x * x, x * y, y * y];
    all[size..].fill(0.0);
    all
}

/// Gap that `members` are left with, each predicted from the others' folds.
fn left(tiles: &[&Seen], residuals: &[Vec<f64>], members: &[usize], size: usize) -> f64 {
    let mut sum = 0.0;
    for fold in 0..FOLDS {
        let (own, others): (Vec<usize>, Vec<usize>) =
            members.iter().partition(|k| tiles[**k].fold == fold);
        // Without enough others to learn from nothing is taken off.
        let enough = others.len() >= 3 * size;
        let matrix = DMatrix::from_fn(others.len(), size, |i, j| basis(tiles[others[i]], size)[j]);
        let normal = matrix.transpose() * &matrix + DMatrix::identity(size, size) * RIDGE;
        let inverse = normal.try_inverse().filter(|_| enough);
        for &k in &own {
            let tile = tiles[k];
            let mut residual = residuals[k].clone();
            if let Some(inverse) = &inverse {
                let at = DVector::from_row_slice(&basis(tile, size)[..size]);
                let shares = &matrix * (inverse * at);
                for (share, &other) in shares.iter().zip(&others) {
                    let of_other = residuals[other].iter();
                    residual
                        .iter_mut()
                        .zip(of_other)
                        .for_each(|(r, o)| *r -= share * o);
                }
            }
            sum += residual.iter().map(|v| v * v).sum::<f64>() / tile.norm - tile.noise;
        }
    }
    sum
}

/// Keeps coefficients of scattered places small.
const RIDGE: f64 = 0.1;
