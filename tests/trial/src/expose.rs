//! Tiles, gaps and observation sets of a lens with its causes.

use rayon::prelude::*;

use seidel_optics::distance::ObjectDistance;
use seidel_optics::field::ImagePoint;
use seidel_optics::observations::{Observation, ObservationSet};
use seidel_optics::tile::Tile;

use super::lens::{CHANNELS, Lens, Place};
use super::pencil::Pencil;
use super::perturb::Change;
use super::rays::{self, CELLS, CELLS_COARSE};
use super::rng::Rng;
use super::sensor::FineGrid;
use super::waves;

/// A cause of given strength.
pub(super) struct Cause {
    pub(super) change: Change,
    pub(super) strength: f64,
}

/// A point of light in the scene.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spot {
    /// Ideal image position, frame pixels.
    pub(super) ideal: [f64; 2],
    /// Stated distance, metres.
    pub(super) depth_m: f64,
    /// Peak of the brightest channel in an exposed tile; full scale is 1.
    pub(super) level: f64,
}

/// The capture settings of a set.
#[derive(Debug, Clone, Copy)]
pub(super) struct Capture {
    /// Label of the random sequence.
    pub(super) label: u64,
    /// True if tiles hold exposed values up to 1 instead of shares of the light.
    pub(super) raw: bool,
    /// Peak over the standard deviation of the noise; `None` for no noise.
    pub(super) snr: Option<f64>,
    /// True if the set states its noise.
    pub(super) sigma_stated: bool,
    /// Constant background of every tile, which the set states.
    pub(super) background: f64,
}

/// Returns the pencil at `place` with all causes applied.
pub(super) fn pencil(lens: &Lens, causes: &[&Cause], place: &Place) -> Pencil {
    let mut pencil = lens.pencil(place);
    for cause in causes {
        (cause.change.apply)(cause.strength, lens, place, &mut pencil);
    }
    pencil
}

/// Returns the tile of a pencil about the frame position `centre`, before any tone curve.
pub(super) fn tile_of(pencil: &Pencil, centre: [f64; 2], tile: usize, cells: usize) -> Vec<f64> {
    let mut fine = FineGrid::new(tile, &pencil.sensor);
    match pencil.wave_px {
        Some(wave_px) => waves::diffract(pencil, wave_px, centre, &mut fine),
        None => rays::trace(pencil, centre, cells, &mut fine),
    }
    pencil.sensor.integrate(&fine, tile)
}

/// The tiles of all channels of a spot, without noise and background, and their centre in the frame.
pub(super) struct SpotTiles {
    pub(super) centre: [f64; 2],
    pub(super) tiles: Vec<Vec<f64>>,
}

/// The computation of the tiles of a spot.
#[derive(Debug, Clone, Copy)]
pub(super) struct TileOptions {
    /// Width and height of tiles, pixels.
    pub(super) tile: usize,
    /// Cells across the pupil.
    pub(super) cells: usize,
    /// True if tiles hold exposed values instead of shares of the light.
    pub(super) raw: bool,
}

/// Computes the tiles of `spot` about `centre`; without one, about the pixel centre nearest to the centroid.
pub(super) fn spot_tiles(
    lens: &Lens,
    causes: &[&Cause],
    spot: &Spot,
    options: TileOptions,
    centre: Option<[f64; 2]>,
) -> SpotTiles {
    let pencils: Vec<Pencil> = (0..CHANNELS.len())
        .map(|channel| {
            let place = Place {
                ideal: spot.ideal,
                depth_m: spot.depth_m,
                channel,
            };
            pencil(lens, causes, &place)
        })
        .collect();
    let centre = centre.unwrap_or_else(|| {
        let mut mean = [0.0; 2];
        for pencil in &pencils {
            let (at, shift) = (pencil.centroid(), pencil.sensor.shift());
            mean[0] += (at[0] + shift[0]) / CHANNELS.len() as f64;
            mean[1] += (at[1] + shift[1]) / CHANNELS.len() as f64;
        }
        mean.map(|m| m.floor() + 0.5)
    });
    let mut tiles: Vec<Vec<f64>> = pencils
        .iter()
        .map(|pencil| tile_of(pencil, centre, options.tile, options.cells))
        .collect();
    if options.raw {
        let peak = tiles.iter().flatten().copied().fold(0.0, f64::max);
        for (pixels, pencil) in tiles.iter_mut().zip(&pencils) {
            for pixel in pixels.iter_mut() {
                let value = *pixel * spot.level / peak;
                *pixel = pencil.sensor.tone.map_or(value, |tone| tone.apply(value));
            }
        }
    }
    SpotTiles { centre, tiles }
}

/// Returns the mean over `spots` and channels of |o - p|² / |o|², for unit-sum tiles with and without the causes.
pub(super) fn gap(lens: &Lens, causes: &[&Cause], spots: &[Spot], tile: usize) -> f64 {
    let options = TileOptions {
        tile,
        cells: CELLS_COARSE,
        raw: true,
    };
    let gaps: Vec<f64> = spots
        .par_iter()
        .map(|spot| {
            let real = spot_tiles(lens, causes, spot, options, None);
            let bare = spot_tiles(lens, &[], spot, options, Some(real.centre));
            let pairs = real.tiles.iter().zip(&bare.tiles);
            pairs.map(|(o, p)| difference(o, p)).sum::<f64>() / CHANNELS.len() as f64
        })
        .collect();
    gaps.iter().sum::<f64>() / gaps.len() as f64
}

/// Returns |o - p|² / |o|² of two tiles after normalisation to unit sum.
pub(super) fn difference(o: &[f64], p: &[f64]) -> f64 {
    let (sum_o, sum_p) = (o.iter().sum::<f64>(), p.iter().sum::<f64>());
    let apart: f64 = o
        .iter()
        .zip(p)
        .map(|(o, p)| (o / sum_o - p / sum_p).powi(2))
        .sum();
    apart / o.iter().map(|o| (o / sum_o).powi(2)).sum::<f64>()
}

/// Returns `count` spots spread over the frame at each depth, at common positions with random offsets of up to `wander`
/// pixels.
pub(super) fn spots(lens: &Lens, count: usize, wander: f64, rng: &mut Rng) -> Vec<Spot> {
    let (width, height) = (
        f64::from(lens.frame.width_px()),
        f64::from(lens.frame.height_px()),
    );
    let margin = 0.03 * width;
    let columns = ((count as f64 * width / height).sqrt().ceil() as usize).max(1);
    let rows = count.div_ceil(columns).max(1);
    let mut cells: Vec<usize> = (0..columns * rows).collect();
    rng.shuffle(&mut cells);
    cells.truncate(count);
    cells.sort_unstable();
    let places: Vec<[f64; 2]> = cells
        .into_iter()
        .map(|cell| {
            let x = ((cell % columns) as f64 + rng.unit()) / columns as f64;
            let y = ((cell / columns) as f64 + rng.unit()) / rows as f64;
            [
                margin + x * (width - 2.0 * margin),
                margin + y * (height - 2.0 * margin),
            ]
        })
        .collect();
    let mut spots = Vec::with_capacity(2 * count);
    for depth_m in lens.depths_m {
        for &[x, y] in &places {
            spots.push(Spot {
                ideal: [
                    x + wander * rng.between(-1.0, 1.0),
                    y + wander * rng.between(-1.0, 1.0),
                ],
                depth_m,
                level: rng.between(0.4, 0.95),
            });
        }
    }
    spots
}

/// Returns the observation set of `spots` with the settings of `capture`.
pub(super) fn set(
    lens: &Lens,
    causes: &[&Cause],
    spots: &[Spot],
    tile: usize,
    seed: u64,
    capture: &Capture,
) -> ObservationSet {
    let observations = spots
        .par_iter()
        .enumerate()
        .map(|(index, spot)| {
            let options = TileOptions {
                tile,
                cells: CELLS,
                raw: capture.raw,
            };
            let shot = spot_tiles(lens, causes, spot, options, None);
            let rng = Rng::stream(seed, capture.label, index as u64);
            observation(spot, shot, tile, capture, rng, index)
        })
        .collect();
    ObservationSet {
        frame: lens.frame,
        axis_stated: true,
        pixel_pitch_um: Some(lens.pitch_um),
        channels: CHANNELS.iter().map(|&name| name.to_owned()).collect(),
        camera: lens.camera(),
        observations,
    }
}

pub(super) fn observation(
    spot: &Spot,
    shot: SpotTiles,
    tile: usize,
    capture: &Capture,
    mut rng: Rng,
    index: usize,
) -> Observation {
    let peaks: Vec<f64> = shot
        .tiles
        .iter()
        .map(|pixels| pixels.iter().copied().fold(0.0, f64::max))
        .collect();
    let brightest = peaks.iter().copied().fold(0.0, f64::max);
    // Unstated noise is scaled to each channel, so that it is small in the weakest as well.
    let sigmas: Vec<Option<f64>> = peaks
        .iter()
        .map(|&peak| {
            let against = if capture.sigma_stated {
                brightest
            } else {
                peak
            };
            capture.snr.map(|snr| against / snr)
        })
        .collect();
    let tiles = shot
        .tiles
        .iter()
        .zip(&sigmas)
        .map(|(pixels, sigma)| {
            let samples = pixels
                .iter()
                .map(|pixel| {
                    let noise = sigma.map_or(0.0, |sigma| sigma * rng.normal());
                    (pixel + noise + capture.background) as f32
                })
                .collect();
            Tile::new(tile, tile, samples).expect("pixels are finite and fill the tile")
        })
        .collect();
    Observation {
        file: format!("psf/{index:04}.exr"),
        centre: ImagePoint::new(shot.centre[0], shot.centre[1]),
        distance: ObjectDistance::Metres(spot.depth_m),
        ideal: Some(ImagePoint::new(spot.ideal[0], spot.ideal[1])),
        tiles,
        noise_sigma: if capture.sigma_stated {
            sigmas
        } else {
            vec![None; CHANNELS.len()]
        },
        background: vec![capture.background; CHANNELS.len()],
        saturated: false,
    }
}
