//! The share of a lens's blur that a plate shows, from the zeros and lobes of its power spectrum.

use super::canvas::window_scene;
use super::detailed_tiles::detailed_tiles;
use super::tile_fft::TileFft;
use super::tile_spectrum::TileFrequencies;
use crate::{
    AdjustedLens, LocalKernels, Plane, RenderWindow, Scene, VergencePass, cancelled, kernel_reach,
};
use rayon::prelude::*;
use seidel_fourier::Complex;
use seidel_optics::Progress;
use seidel_optics::error::Result;

/// Shares that are tried on either side of 1, from 0.5 to 1.52 of the lens's blur in steps of 7 %.
const SMALLER_SHARES: i32 = 10;
const LARGER_SHARES: i32 = 6;
const STEP: f64 = 1.072;
/// Largest logarithm of a share that counts as the lens's own.
const SAME: f64 = 0.11;
/// Decrease of the mean deviance of a frequency from which another share than 1 is believed.
const DOUBTED: f64 = 0.01;
/// The same for the largest share, and for the smallest if the lens's own is a minimum beside it: shares at the ends need not be minima,
/// and lights, occlusion and pictures with an unusual spectrum let the deviance fall slowly.
const DOUBTED_AT_ENDS: f64 = 0.05;
/// Increase of it over all other shares from which the lens itself is believed.
const BELIEVED: f64 = 0.005;
/// Least number of tiles that count in these means: a few may be unlike other pictures.
const ENOUGH_TILES: f64 = 5.0;
/// Least side of a tile, px, and least side in widths of its kernel.
const MIN_SIDE: usize = 96;
const SIDE_IN_KERNELS: f64 = 3.0;
const MAX_SIDE: usize = 384;
/// Largest number of tiles.
const TILES: usize = 12;
/// Largest difference of the kernel size within a tile, as a share of it.
const MAX_CHANGE: f64 = 0.1;
/// Share of a tile's samples that may be as bright as the brightest of the plate: more are clipped.
const MAX_CLIPPED: f64 = 0.002;

/// Returns the share of the blur of `scene`'s lens that best explains the spectra of `plane`, 1 if none explains them better, or `None`
/// if they decide nothing: without detail, where the depth of every tile varies, and for kernels without zeros.
///
/// # Errors
/// A lens that cannot be drawn, and cancellation by `progress`.
pub(super) fn share_by_spectra(
    scene: &Scene,
    plane: &Plane,
    progress: &Progress,
) -> Result<Option<f64>> {
    let Some(side) = tile_side(scene) else {
        return Ok(None);
    };
    let frequencies = TileFrequencies::new(side);
    let brightest = plane.samples.iter().copied().fold(0.0, f32::max);
    let shares: Vec<f64> = (-SMALLER_SHARES..=LARGER_SHARES)
        .map(|k| STEP.powi(k))
        .collect();
    let mut tiles: Vec<Vec<f64>> = Vec::new();
    for tile in detailed_tiles(scene, plane, side) {
        let samples = tile.cut(scene.width, plane.samples);
        let bright = samples.iter().filter(|v| **v >= brightest).count();
        if bright as f64 > MAX_CLIPPED * samples.len() as f64 {
            continue;
        }
        let (Some(vergence), Some(spectrum)) = (
            even_vergence(scene, tile, side),
            frequencies.spectrum(&samples),
        ) else {
            continue;
        };
        if !progress(tiles.len() as f64 / TILES as f64) {
            return Err(cancelled());
        }
        let part = Scene {
            vergence: VergencePass::Constant(vergence),
            ..window_scene(scene, tile)
        };
        let deviance = |share: &f64| {
            let transfer = transfer_function(&part, plane.weights, *share, frequencies.fft())?;
            Ok(spectrum.deviance(&frequencies, &transfer))
        };
        tiles.push((shares.par_iter()).map(deviance).collect::<Result<_>>()?);
        if tiles.len() == TILES {
            break;
        }
    }
    leave_out_outlier(&shares, &mut tiles);
    let sums = sums_of(&tiles, shares.len());
    let frequencies = (tiles.len() as f64).max(ENOUGH_TILES) * frequencies.count() as f64;
    Ok(decide(&shares, &sums, frequencies))
}

/// Returns the transfer function at the middle of a tile, `part`, for a `share` of the blur of its lens.
fn transfer_function(
    part: &Scene,
    weights: &[f64],
    share: f64,
    fft: &TileFft,
) -> Result<Vec<Complex<f32>>> {
    let scales = vec![share; part.lens.channel_count()];
    let lens = AdjustedLens::new(part.lens, 1.0, scales, (0.0, 0.0))?;
    let scene = Scene {
        lens: &lens,
        ..*part
    };
    let middle = 0.5 * fft.side as f64;
    let kernel = LocalKernels::new(&scene, weights)?.at((middle, middle))?;
    Ok(fft.transfer_function(&kernel, (fft.side, fft.side)))
}

/// Takes out the tile that speaks most against the lens if the others together speak for it: a doubt must not rest on one tile.
fn leave_out_outlier(shares: &[f64], tiles: &mut Vec<Vec<f64>>) {
    let sums = sums_of(tiles, shares.len());
    let Some([own, other]) = best_of_each(shares, &sums) else {
        return;
    };
    let gain = |tile: &Vec<f64>| tile[own] - tile[other];
    let most = (0..tiles.len()).max_by(|a, b| gain(&tiles[*a]).total_cmp(&gain(&tiles[*b])));
    if let Some(most) = most
        && sums[own] - sums[other] > 0.0
        && sums[own] - sums[other] < gain(&tiles[most])
    {
        tiles.remove(most);
    }
}

/// Returns the sums over `tiles` of their deviances for each of `count` shares.
fn sums_of(tiles: &[Vec<f64>], count: usize) -> Vec<f64> {
    let sum = |index: usize| tiles.iter().map(|tile| tile[index]).sum();
    (0..count).map(sum).collect()
}

/// Returns the indices of the least deviance among the shares that count as the lens's own, and among the others.
fn best_of_each(shares: &[f64], sums: &[f64]) -> Option<[usize; 2]> {
    let is_same = |index: &usize| shares[*index].ln().abs() < SAME;
    let least = |indices: &mut dyn Iterator<Item = usize>| {
        indices.min_by(|a, b| sums[*a].total_cmp(&sums[*b]))
    };
    let own = least(&mut (0..shares.len()).filter(is_same))?;
    let other = least(&mut (0..shares.len()).filter(|index| !is_same(index)))?;
    Some([own, other])
}

/// Returns the share that the deviances `sums` over this number of `frequencies` show, if they show one.
fn decide(shares: &[f64], sums: &[f64], frequencies: f64) -> Option<f64> {
    let [own, other] = best_of_each(shares, sums)?;
    let gain = (sums[own] - sums[other]) / frequencies;
    let is_minimum = |own: usize| {
        let between = sums[..own].iter().copied().fold(0.0, f64::max);
        between - sums[own] > BELIEVED * frequencies
    };
    let is_end = other == shares.len() - 1 || other == 0 && is_minimum(own);
    let doubted = if is_end { DOUBTED_AT_ENDS } else { DOUBTED };
    if gain > doubted {
        Some((100.0 * shares[other]).round() / 100.0)
    } else {
        (gain < -BELIEVED).then_some(1.0)
    }
}

/// Returns the side of the tiles of a plate, or `None` if it is too small for one.
fn tile_side(scene: &Scene) -> Option<usize> {
    let middle = scene.width * (scene.height / 2) + scene.width / 2;
    let widest = kernel_width(scene, RenderWindow::whole(scene), scene.vergence_at(middle));
    let mut side = MIN_SIDE;
    while side < MAX_SIDE && (side as f64) < SIDE_IN_KERNELS * widest {
        side *= 2;
    }
    (scene.width.min(scene.height) >= side).then_some(side)
}

/// Returns the vergence of a tile whose kernels are alike and small enough for it.
fn even_vergence(scene: &Scene, tile: RenderWindow, side: usize) -> Option<f64> {
    let vergences: Vec<f64> = match scene.vergence {
        VergencePass::Constant(vergence) => vec![vergence],
        VergencePass::PerPixel(pass) => {
            let pass = tile.cut(scene.width, pass).into_iter().map(f64::from);
            let (low, high) = pass.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                (low.min(v), high.max(v))
            });
            vec![0.5 * (low + high), low, high]
        }
    };
    let width = |vergence: &f64| kernel_width(scene, tile, *vergence);
    let middle = width(&vergences[0]);
    let is_even = |at: &f64| (width(at) - middle).abs() <= MAX_CHANGE * middle;
    let fits = SIDE_IN_KERNELS * middle <= side as f64;
    (fits && vergences.iter().all(is_even)).then_some(vergences[0])
}

/// Returns the width of the widest kernel in a window of `scene` at a vergence, px.
fn kernel_width(scene: &Scene, window: RenderWindow, vergence: f64) -> f64 {
    let reach = kernel_reach(scene, window, vergence);
    (reach.left_px + reach.right_px).max(reach.up_px + reach.down_px)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_far_from_one_need_the_larger_gain() {
        let shares = [0.5, 0.76, 0.93, 1.0, 1.32, 1.52];
        let decided = |others: [f64; 4], ends: f64| {
            let [a, b, c, d] = others;
            decide(&shares, &[ends, a, b, c, d, ends], 1000.0)
        };
        assert_eq!(decided([40.0, 60.0, 51.0, 70.0], 80.0), Some(0.76));
        assert_eq!(decided([45.0, 60.0, 51.0, 70.0], 80.0), None);
        assert_eq!(decided([50.0, 60.0, 47.0, 70.0], 80.0), None);
        assert_eq!(decided([50.0, 43.0, 47.0, 70.0], 80.0), Some(1.0));
    }

    /// Five tiles fit the lens, one fits nothing.
    #[test]
    fn one_tile_cannot_outweigh_the_others() {
        let shares = [0.5, 1.0, 1.52];
        let usual = vec![1.3, 1.2, 1.4];
        let mut tiles = vec![usual.clone(); 5];
        tiles.push(vec![4.0, 9.0, 12.0]);
        leave_out_outlier(&shares, &mut tiles);
        assert_eq!(tiles, vec![usual; 5]);
        let mut doubting = vec![vec![1.1, 1.2, 1.4]; 6];
        leave_out_outlier(&shares, &mut doubting);
        assert_eq!(doubting.len(), 6);
    }

    /// The smallest share is no minimum that is known as one.
    #[test]
    fn shares_at_the_ends_need_a_gain_of_their_own() {
        let decided = |sums: [f64; 5]| decide(&[0.5, 0.71, 0.93, 1.0, 1.52], &sums, 1000.0);
        assert_eq!(decided([60.0, 99.0, 90.0, 91.0, 99.0]), None);
        assert_eq!(decided([30.0, 99.0, 90.0, 91.0, 99.0]), Some(0.5));
        assert_eq!(decided([60.0, 75.0, 90.0, 91.0, 99.0]), Some(0.5));
        assert_eq!(decided([99.0, 99.0, 90.0, 91.0, 60.0]), None);
    }
}
