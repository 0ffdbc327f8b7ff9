//! Share of the gap that a nonparametric model of the residual closes.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::hypothesis::Hypothesis;
use super::prediction::TilePredictor;
use super::tiles::{FOLDS, TileData};
use seidel_optics::psf::pupil::Detail;

/// Sizes of the tried polynomial bases over the field: constant, linear, quadratic.
const BASES: [usize; 3] = [1, 3, 6];
/// Ridge penalty of the regression.
const RIDGE: f64 = 0.1;

/// A tile with the residual of each of its pixels.
struct TileResidual<'a> {
    tile: &'a TileData,
    residual: Vec<f64>,
}

impl TileResidual<'_> {
    /// Returns the gap of the tile if `residual` is left.
    fn gap(&self, residual: &[f64]) -> f64 {
        residual.iter().map(|v| v * v).sum::<f64>() / self.tile.norm - self.tile.noise
    }

    /// Returns whether the tiles have one model: channel, distance and size are the same.
    fn has_model_of(&self, other: &Self) -> bool {
        let key = |t: &TileData| (t.of_lens, t.distance, t.size);
        key(self.tile) == key(other.tile)
    }

    /// Returns the first `size` monomials of the field position.
    fn basis(&self, size: usize) -> DVector<f64> {
        let (x, y) = (self.tile.point.at.x, self.tile.point.at.y);
        DVector::from_row_slice(&[1.0, x, y, x * x, x * y, y * y][..size])
    }
}

/// Returns the cross-validated share of the gap that a smooth field of residual tiles closes.
///
/// For each channel and distance every pixel is a polynomial of the field position, fitted by ridge
/// regression without the fold under test. The result is a lower bound: detail finer than pixels or faster
/// variation over the field is not modelled.
pub(super) fn explainable(tiles: &[&TileData], nothing: &Hypothesis) -> f64 {
    let tiles: Vec<TileResidual> = tiles
        .par_iter()
        .map_init(
            || (TilePredictor::default(), Vec::new()),
            |(predictor, picture), tile| {
                predictor.predict(nothing, &[], *tile, Detail::COARSE, picture);
                let residual = tile.residual(picture);
                TileResidual { tile, residual }
            },
        )
        .collect();
    let total: f64 = tiles.iter().map(|t| t.gap(&t.residual)).sum();
    if total <= 0.0 {
        return 0.0;
    }
    let mut groups: Vec<Vec<&TileResidual>> = Vec::new();
    for tile in &tiles {
        match groups.iter_mut().find(|group| tile.has_model_of(group[0])) {
            Some(group) => group.push(tile),
            None => groups.push(vec![tile]),
        }
    }
    let least = |group: &Vec<&TileResidual>| {
        let gaps = BASES.iter().map(|&size| remaining_gap(group, size));
        gaps.fold(f64::INFINITY, f64::min)
    };
    let remaining: f64 = groups.iter().map(least).sum();
    (1.0 - remaining / total).clamp(0.0, 1.0)
}

/// Returns the gap of `group` after each fold is predicted from the others by a polynomial with `size` terms.
fn remaining_gap(group: &[&TileResidual], size: usize) -> f64 {
    let mut gap = 0.0;
    for fold in 0..FOLDS {
        let (own, others): (Vec<&TileResidual>, Vec<&TileResidual>) =
            group.iter().partition(|t| t.tile.fold == fold);
        let bases: Vec<_> = others.iter().map(|t| t.basis(size).transpose()).collect();
        // With too few other tiles no prediction is made.
        let regression = (others.len() >= 3 * size).then(|| DMatrix::from_rows(&bases));
        let regression = regression.and_then(|matrix| {
            let normal = matrix.transpose() * &matrix + DMatrix::identity(size, size) * RIDGE;
            Some((normal.try_inverse()?, matrix))
        });
        for own in own {
            let mut residual = own.residual.clone();
            if let Some((inverse, matrix)) = &regression {
                let shares = matrix * (inverse * own.basis(size));
                for (share, other) in shares.iter().zip(&others) {
                    for (left, predicted) in residual.iter_mut().zip(&other.residual) {
                        *left -= share * predicted;
                    }
                }
            }
            gap += own.gap(&residual);
        }
    }
    gap
}
