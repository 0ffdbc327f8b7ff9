//! Parts of the tiles, for searches that need not see all of them.

use super::gap_problem::{GapProblem, weight};
use super::hypothesis::Hypothesis;
use super::tiles::TileData;
use seidel_optics::psf::pupil::Detail;

/// Lower bound of the gap of a part.
pub(super) const MIN_EXCESS: f64 = 1e-6;

/// A part of the tiles, with its sums.
pub(super) struct Subsample<'a> {
    pub(super) tiles: Vec<&'a TileData>,
    /// Gap of the given lens in every tile.
    pub(super) gaps: Vec<f64>,
    /// Weighted mean gap of the given lens, without noise.
    pub(super) excess: f64,
    /// Sum of weights.
    pub(super) weight: f64,
    /// Weighted sum of noise contributions.
    pub(super) noise: f64,
}

impl<'a> Subsample<'a> {
    /// Takes about `count` of `tiles`. `nothing` is the hypothesis that no effect is missing.
    pub(super) fn new(tiles: &'a [TileData], count: usize, nothing: &Hypothesis) -> Self {
        let tiles = thinned(tiles, count);
        let gaps = GapProblem::new(nothing, &tiles, Detail::FULL).gaps(&[]);
        let cost: f64 = gaps.iter().zip(&tiles).map(|(g, t)| g * weight(t)).sum();
        let noise = noise_sum(&tiles);
        let weight: f64 = tiles.iter().map(|t| weight(t)).sum();
        Self {
            excess: ((cost - noise) / weight).max(MIN_EXCESS),
            tiles,
            gaps,
            weight,
            noise,
        }
    }
}

/// Returns the weighted sum of the noise contributions of `tiles`.
pub(super) fn noise_sum(tiles: &[&TileData]) -> f64 {
    tiles.iter().map(|t| weight(t) * t.noise).sum()
}

/// Returns about `count` of `tiles`, in whole observations spread over the list.
fn thinned(tiles: &[TileData], count: usize) -> Vec<&TileData> {
    if tiles.len() <= count {
        return tiles.iter().collect();
    }
    let mut observations: Vec<usize> = tiles.iter().map(|t| t.observation).collect();
    observations.dedup();
    let wanted = (count * observations.len() / tiles.len()).max(1);
    // A golden-ratio sequence covers every distance, whatever the order of the list.
    let chosen: std::collections::BTreeSet<usize> = (0..wanted)
        .map(|k| {
            let turn = (k as f64 + 0.5) * 0.618_033_988_749_895;
            observations[(turn.fract() * observations.len() as f64) as usize]
        })
        .collect();
    tiles
        .iter()
        .filter(|t| chosen.contains(&t.observation))
        .collect()
}
