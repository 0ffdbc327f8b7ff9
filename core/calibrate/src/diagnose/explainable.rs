//! Share of the gap that a nonparametric model of the residual closes.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::hypothesis::Hypothesis;
use super::prediction::TilePredictor;
use super::tiles::{FOLDS, TileData};
use seidel_optics::distance::ObjectDistance;
use seidel_optics::psf::pupil::Detail;

/// Channel, distance and size of tiles that share a model.
type Key = (usize, ObjectDistance, (usize, usize));

/// Sizes of the tried polynomial bases over the field: constant, linear, quadratic.
const BASES: [usize; 3] = [1, 3, 6];

/// Returns the cross-validated share of the gap that a smooth field of residual tiles closes.
///
/// For each channel and distance every pixel is a polynomial of the field position, fitted by ridge
/// regression without the fold under test. The result is a lower bound: detail finer than pixels or faster
/// variation over the field is not modelled.
pub(super) fn explainable(tiles: &[&TileData], nothing: &Hypothesis) -> f64 {
    let residuals: Vec<Vec<f64>> = tiles
        .par_iter()
        .map_init(
            || (TilePredictor::default(), Vec::new()),
            |(predictor, picture), tile| {
                predictor.predict(nothing, &[], *tile, Detail::COARSE, picture);
                tile.residual(picture)
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

fn basis(tile: &TileData, size: usize) -> [f64; 6] {
    let (x, y) = (tile.point.at.x, tile.point.at.y);
    let mut all = [1.0, x, y, x * x, x * y, y * y];
    all[size..].fill(0.0);
    all
}

/// Returns the gap of `members` after each fold is predicted from the others.
fn left(tiles: &[&TileData], residuals: &[Vec<f64>], members: &[usize], size: usize) -> f64 {
    let mut sum = 0.0;
    for fold in 0..FOLDS {
        let (own, others): (Vec<usize>, Vec<usize>) =
            members.iter().partition(|k| tiles[**k].fold == fold);
        // With too few other tiles no prediction is made.
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

/// Ridge penalty of the regression.
const RIDGE: f64 = 0.1;
