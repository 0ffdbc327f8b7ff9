//! The check of a lens against a plate: the strength of the blur that the plate shows, as a share of the lens's.
//!
//! The spectra of tiles come first (`spectrum_check`). Where they decide nothing, as for kernels without zeros, the sharpness of
//! results does: sharp images have sparse gradients. Blur that is left spreads them out, and so does the ringing of too much removal. The
//! share of the plate is the q that minimises
//!
//! ```text
//! ln(mean |D x_q| / rms |D x_q|) + 0.1 ln(mean |D x_q|)
//! ```
//!
//! x_q is the sharp image once the share q of the lens's blur is removed, and D the gradient. The first term is the
//! normalised sparsity measure of Krishnan, Tay and Fergus (2011).

use super::canvas::window_scene;
use super::deconvolver::{Variant, is_uniform};
use super::detailed_tiles::detailed_tiles;
use super::gradient::{LinkedPlane, norms, sampled_norms, white_noise_power};
use super::problem::Refinement;
use super::spectrum_check::share_by_spectra;
use super::winsorised::WinsorisedStatistics;
use super::{Deconvolver, Lights, SharpPlane};
use crate::{AdjustedLens, Plane, RenderWindow, Scene, VergencePass};
use seidel_optics::Progress;
use seidel_optics::error::Result;

/// Shares of the lens's blur that are tried, in steps of about 15 %.
const SHARES: [f64; 9] = [0.5, 0.57, 0.66, 0.76, 0.87, 1.0, 1.15, 1.32, 1.52];
/// Index of the share 1.
const FULL: usize = 5;
/// Side of the tiles that are looked at, px.
const SIDE: usize = 192;
/// Number of tiles that are looked at.
const TILES: usize = 3;
/// Least side of a plate that is checked, px: smaller ones have too little detail.
const MIN_PLATE_SIDE: usize = SIDE / 2;
/// Share of the progress that the spectra take.
const SPECTRA_PROGRESS: f64 = 0.1;
/// Weight of the second term. The first alone prefers to remove a little too much blur (found on photographs).
const MEAN_WEIGHT: f64 = 0.1;
/// Least decrease of the score for a smaller share than 1 to be chosen. This margin and those below are per tile and plane,
/// and keep the right lens from being doubted.
const SMALLER_MARGIN: f64 = 0.03;
/// Least decrease for a larger share than 1.
const LARGER_MARGIN: f64 = 0.05;
/// Least decrease where the share 1 has a lower score than its neighbours, so that the minimum is a second one.
const SECOND_MINIMUM_MARGIN: f64 = 0.1;
/// Least decrease for the smallest share, which need not be a minimum.
const SMALLEST_MARGIN: f64 = 0.25;
/// Smallest root mean square gradient of a usable tile, as a multiple of the gradient that noise alone would have.
const MIN_DETAIL: f64 = 1.25;
/// Least share of a tile's pixels that do not keep their blur.
const MIN_SHARPENED: f64 = 0.4;
/// Relative error of lens and operator, larger than in a removal: gradients must not come from the ringing that such errors
/// cause.
const MODEL_ERROR: f64 = 6e-3;
/// Number of ADMM iterations: fewer than in a removal, since the score needs gradients alone.
const ITERATIONS: usize = 7;

/// The score of each share: low where gradients are sparse and small.
type Scores = [f64; SHARES.len()];

/// Estimates the strength of the blur that `planes` show as a share of the blur of `scene`'s lens, from 0.5 to 1.52.
/// Returns 1 if nothing speaks against the lens, or if the plate is too small, too noisy, mostly keeps its blur, or has tiles of varying
/// depth alone.
///
/// Tiles of the plane with most detail are compared with each share of the lens. Each plane comes with the settings of its removal.
/// `progress` gets the share done.
///
/// # Errors
/// Those of [`Deconvolver::remove`].
pub fn estimate_blur_share(
    scene: &Scene,
    planes: &[(Deconvolver, Plane)],
    progress: &Progress,
) -> Result<f64> {
    let all: Vec<Plane> = planes.iter().map(|(_, plane)| *plane).collect();
    scene.check(&all)?;
    let planes: Vec<_> = (planes.iter())
        .filter(|(_, plane)| !is_uniform(plane.samples))
        .copied()
        .collect();
    // All planes show one scene through one lens: that with the most detail says most.
    let detail = |plane: &Plane| {
        let image = LinkedPlane::plain(plane.samples, scene.width);
        WinsorisedStatistics::new(sampled_norms(image)).root_mean_square
    };
    let best = planes
        .iter()
        .max_by(|a, b| detail(&a.1).total_cmp(&detail(&b.1)));
    let Some((deconvolver, plane)) = best else {
        return Ok(1.0);
    };
    let in_spectra = |share: f64| progress(SPECTRA_PROGRESS * share);
    if let Some(share) = share_by_spectra(scene, plane, &in_spectra)? {
        return Ok(share);
    }
    if let VergencePass::PerPixel(_) = scene.vergence {
        // Seven iterations are too few to solve for hidden surfaces, and what is left of them decides the score.
        return Ok(1.0);
    }
    if scene.width.min(scene.height) < MIN_PLATE_SIDE {
        return Ok(1.0);
    }
    let tiles = detailed_tiles(scene, plane, SIDE);
    let tiles = &tiles[..TILES.min(tiles.len())];
    let (mut sums, mut count) = ([0.0; SHARES.len()], 0.0);
    let total = tiles.len() as f64;
    for (done, tile) in tiles.iter().enumerate() {
        let trial = Trial {
            scene,
            deconvolver,
            plane,
            tile: *tile,
        };
        let progress = |share| {
            let done = (done as f64 + share) / total;
            progress(SPECTRA_PROGRESS + (1.0 - SPECTRA_PROGRESS) * done)
        };
        if let Some(scores) = trial.scores(&progress)? {
            count += 1.0;
            for (sum, score) in sums.iter_mut().zip(scores) {
                *sum += score;
            }
        }
    }
    Ok(best_index(&sums, count).map_or(1.0, |index| interpolated_share(&sums, index)))
}

/// Returns the index of the lowest of `sums` over `count` tiles and planes, if it is lower than that of the share 1 by
/// its margin.
fn best_index(sums: &Scores, count: f64) -> Option<usize> {
    let best = (0..SHARES.len()).min_by(|a, b| sums[*a].total_cmp(&sums[*b]))?;
    let beside = sums[FULL - 1].min(sums[FULL + 1]);
    let margin = match best {
        0 => SMALLEST_MARGIN,
        _ if sums[FULL] < beside => SECOND_MINIMUM_MARGIN,
        1..FULL => SMALLER_MARGIN,
        _ => LARGER_MARGIN,
    };
    (sums[best] < sums[FULL] - margin * count).then_some(best)
}

/// Returns the share at the minimum of the parabola through the sums at `index`, the lowest, and its neighbours, rounded
/// to a hundredth. Shares at the ends are returned as they are.
fn interpolated_share(sums: &Scores, index: usize) -> f64 {
    if index == 0 || index == SHARES.len() - 1 {
        return SHARES[index];
    }
    let (before, here, after) = (sums[index - 1], sums[index], sums[index + 1]);
    let curvature = before + after - 2.0 * here;
    if curvature <= 0.0 {
        return SHARES[index];
    }
    // Shares are nearly evenly spaced in their logarithms.
    let offset = 0.5 * (before - after) / curvature;
    let step = if offset < 0.0 {
        SHARES[index] / SHARES[index - 1]
    } else {
        SHARES[index + 1] / SHARES[index]
    };
    (100.0 * SHARES[index] * step.powf(offset)).round() / 100.0
}

/// A tile of a plane from which blur is removed at every share.
struct Trial<'a> {
    scene: &'a Scene<'a>,
    deconvolver: &'a Deconvolver,
    plane: &'a Plane<'a>,
    tile: RenderWindow,
}

impl Trial<'_> {
    /// Returns the score of each share, or `None` if the tile has little but noise or mostly keeps its blur.
    fn scores(&self, progress: &Progress) -> Result<Option<Scores>> {
        let samples = self.tile.cut(self.scene.width, self.plane.samples);
        let mut scores = [0.0; SHARES.len()];
        // The share 1 comes first: it gives the noise, and the pixels that are sharpened.
        let first = self.sharpened(&samples, FULL, 0, progress)?;
        let sharpened: Vec<bool> = first.confidence.iter().map(|c| *c > 0.0).collect();
        let count = sharpened.iter().filter(|sharpened| **sharpened).count();
        if (count as f64) < MIN_SHARPENED * sharpened.len() as f64
            || !has_detail(&samples, self.tile.width, first.noise)
        {
            return Ok(None);
        }
        scores[FULL] = self.score(&first, &sharpened);
        let others = (0..SHARES.len()).filter(|index| *index != FULL);
        for (done, index) in others.enumerate() {
            let sharp = self.sharpened(&samples, index, done + 1, progress)?;
            scores[index] = self.score(&sharp, &sharpened);
        }
        Ok(Some(scores))
    }

    /// Removes a share of the blur from the tile's `samples`, after `done` other shares.
    fn sharpened(
        &self,
        samples: &[f32],
        index: usize,
        done: usize,
        progress: &Progress,
    ) -> Result<SharpPlane> {
        let scene = self.scene;
        let scales = vec![SHARES[index]; scene.lens.channel_count()];
        let lens = AdjustedLens::new(scene.lens, 1.0, scales, (0.0, 0.0))?;
        let part = Scene {
            lens: &lens,
            ..window_scene(scene, self.tile)
        };
        let plane = Plane {
            samples,
            ..*self.plane
        };
        let variant = Variant {
            model_error: MODEL_ERROR,
            picture_error: MODEL_ERROR,
            refinement: Refinement::Skip,
            lights: Lights::KeepBlur,
        };
        let progress = |share: f64| progress((done as f64 + share) / SHARES.len() as f64);
        let deconvolver = Deconvolver {
            iterations: ITERATIONS,
            ..*self.deconvolver
        };
        deconvolver.remove_variant(variant, &part, &plane, &progress)
    }

    /// Returns the score of a result, from the gradients of the `sharpened` pixels.
    fn score(&self, plane: &SharpPlane, sharpened: &[bool]) -> f64 {
        let gradients = norms(LinkedPlane::plain(
            &plane.canvas.crop(&plane.sharp),
            self.tile.width,
        ));
        let gradients: Vec<f32> = (gradients.into_iter().zip(sharpened))
            .filter_map(|(norm, sharpened)| sharpened.then_some(norm))
            .collect();
        let mean = |of: &dyn Fn(f64) -> f64| {
            gradients.iter().map(|v| of(f64::from(*v))).sum::<f64>() / gradients.len().max(1) as f64
        };
        let (mean, mean_square) = (mean(&|v| v), mean(&|v| v * v));
        if mean > 0.0 {
            (mean / mean_square.sqrt()).ln() + MEAN_WEIGHT * mean.ln()
        } else {
            0.0
        }
    }
}

/// Returns whether the gradients of an image exceed those of its noise.
fn has_detail(samples: &[f32], width: usize, noise: f64) -> bool {
    let gradients = sampled_norms(LinkedPlane::plain(samples, width));
    let squares = gradients.iter().map(|v| f64::from(*v).powi(2));
    let mean_square = squares.sum::<f64>() / gradients.len().max(1) as f64;
    mean_square > (MIN_DETAIL * noise).powi(2) * white_noise_power()
}

#[cfg(test)]
mod tests {
    use super::super::test_scenes::{NormalDeviates, WEIGHTS, discs, lens};
    use super::*;
    use crate::{Displacement, Edges, PlateMap};
    use seidel_optics::field::ImagePoint;
    use seidel_optics::psf::SkewNormal;

    fn share_of(width: usize, height: usize, samples: &[f32]) -> f64 {
        let lens = lens(1.0);
        let scene = Scene {
            lens: &lens,
            model: &SkewNormal,
            width,
            height,
            map: PlateMap {
                origin: ImagePoint::new(0.0, 0.0),
                scale: 1.0,
            },
            vergence: VergencePass::Constant(0.0),
            edges: Edges::Mirror,
            displacement: Displacement::None,
        };
        let plane = Plane {
            samples,
            weights: &WEIGHTS,
        };
        let planes = [(Deconvolver::default(), plane)];
        estimate_blur_share(&scene, &planes, &|_| true).expect("a valid scene")
    }

    /// The images have no blur, so a check of them would find a share below 1.
    #[test]
    fn small_noisy_and_uniform_planes_are_not_checked() {
        for (width, height) in [(1, 1), (2, 1), (1, 3), (5, 4), (120, 60), (60, 120)] {
            assert_eq!(share_of(width, height, &discs(width, height)), 1.0);
        }
        assert!(share_of(120, 120, &discs(120, 120)) < 1.0);
        let mut deviates = NormalDeviates(9);
        let noise = (0..120 * 120).map(|_| 0.4 + 0.01 * deviates.next() as f32);
        assert_eq!(share_of(120, 120, &noise.collect::<Vec<f32>>()), 1.0);
        assert_eq!(share_of(120, 120, &[0.4; 120 * 120]), 1.0);
    }

    #[test]
    fn minimum_of_a_parabola_in_the_logarithm_is_found() {
        let found = |sums: &Scores, count: f64| {
            best_index(sums, count).map(|index| interpolated_share(sums, index))
        };
        for share in [0.55, 0.62, 0.71, 0.8, 1.24, 1.4] {
            let sums = SHARES.map(|tried| (tried / share).ln().powi(2));
            let found = found(&sums, 0.1).unwrap_or(1.0);
            assert!((found - share).abs() < 0.012, "{share}: {found}");
        }
        let close_to_one = SHARES.map(|tried| (tried / 0.97).ln().powi(2));
        assert_eq!(found(&close_to_one, 1.0), None);
        let (falling, rising) = (SHARES.map(|share| -share), SHARES);
        assert_eq!(found(&falling, 1.0), Some(1.52));
        assert_eq!(found(&rising, 1.0), Some(0.5));
    }
}
