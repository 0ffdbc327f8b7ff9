//! Tiles, gaps and observation sets of a lens with its causes.

use rayon::prelude::*;

use seidel_optics::distance::ObjectDistance;
use seidel_optics::field::ImagePoint;
use seidel_optics::observations::{Observation, ObservationSet};
use seidel_optics::tile::Tile;

use super::change;
use super::lens::{CHANNELS, Lens, Place};
use super::pencil::Pencil;
use super::perturb::Perturbation;
use super::rays::{self, CELLS_COARSE};
use super::rng::Rng;
use super::sensor::FineGrid;
use super::waves;

/// A cause of given strength of the third-order simulator.
pub(super) type Cause = change::Cause<Perturbation>;

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
    /// True if the set states ideal positions.
    pub(super) ideal_positions: bool,
}

/// Returns the pencil at `place` with all causes applied.
pub(super) fn pencil(lens: &Lens, causes: &[&Cause], place: &Place) -> Pencil {
    let mut pencil = lens.pencil(place);
    for cause in causes {
        (cause.change.action)(cause.strength, lens, place, &mut pencil);
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

/// Returns the pencils of all channels of `spot` with all causes applied.
fn pencils(lens: &Lens, causes: &[&Cause], spot: &Spot) -> Vec<Pencil> {
    (0..CHANNELS.len())
        .map(|channel| {
            let place = Place {
                ideal: spot.ideal,
                depth_m: spot.depth_m,
                channel,
            };
            pencil(lens, causes, &place)
        })
        .collect()
}

/// Returns the mean over channels of the centroid on the sensor, frame pixels.
fn mean_centroid(pencils: &[Pencil]) -> [f64; 2] {
    let mut mean = [0.0; 2];
    for pencil in pencils {
        let (at, shift) = (pencil.centroid(), pencil.sensor.shift());
        mean[0] += (at[0] + shift[0]) / pencils.len() as f64;
        mean[1] += (at[1] + shift[1]) / pencils.len() as f64;
    }
    mean
}

/// Computes the tiles of `spot` about `centre`; without one, about the pixel centre nearest to the centroid.
pub(super) fn spot_tiles(
    lens: &Lens,
    causes: &[&Cause],
    spot: &Spot,
    options: TileOptions,
    centre: Option<[f64; 2]>,
) -> SpotTiles {
    let pencils = pencils(lens, causes, spot);
    let centre = centre.unwrap_or_else(|| mean_centroid(&pencils).map(|m| m.floor() + 0.5));
    let mut tiles: Vec<Vec<f64>> = pencils
        .iter()
        .map(|pencil| tile_of(pencil, centre, options.tile, options.cells))
        .collect();
    if options.raw {
        expose(&mut tiles, &pencils, spot.level);
    }
    SpotTiles { centre, tiles }
}

/// Scales the tiles of all channels of a spot to a peak of `level` and applies the tone curve of their pencils.
pub(super) fn expose(tiles: &mut [Vec<f64>], pencils: &[Pencil], level: f64) {
    let peak = tiles.iter().flatten().copied().fold(0.0, f64::max);
    for (pixels, pencil) in tiles.iter_mut().zip(pencils) {
        for pixel in pixels.iter_mut() {
            let value = *pixel * level / peak;
            *pixel = pencil.sensor.tone.map_or(value, |tone| tone.apply(value));
        }
    }
}

/// The positions at which the tiles of two lenses are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Alignment {
    /// The same position of the frame: shifts are part of the gap.
    Frame,
    /// The mean centroid of the channels: shifts common to all channels are not part of the gap.
    Centroid,
}

/// The computation of gaps.
#[derive(Debug, Clone, Copy)]
pub(super) struct GapOptions {
    /// Width and height of tiles, pixels.
    pub(super) tile: usize,
    pub(super) alignment: Alignment,
}

/// Returns the mean over `spots` and channels of |o - p|² / |o|², for unit-sum tiles with and without the causes.
pub(super) fn gap(lens: &Lens, causes: &[&Cause], spots: &[Spot], options: GapOptions) -> f64 {
    let tiles = TileOptions {
        tile: options.tile,
        cells: CELLS_COARSE,
        raw: true,
    };
    let gaps: Vec<f64> = spots
        .par_iter()
        .map(|spot| {
            let real = spot_tiles(lens, causes, spot, tiles, None);
            let mut centre = real.centre;
            if options.alignment == Alignment::Centroid {
                let of_real = mean_centroid(&pencils(lens, causes, spot));
                let of_bare = mean_centroid(&pencils(lens, &[], spot));
                for axis in 0..2 {
                    centre[axis] += of_bare[axis] - of_real[axis];
                }
            }
            let bare = spot_tiles(lens, &[], spot, tiles, Some(centre));
            mean_difference(&real.tiles, &bare.tiles)
        })
        .collect();
    gaps.iter().sum::<f64>() / gaps.len() as f64
}

/// Returns the mean over channels of the difference between tiles.
pub(super) fn mean_difference(o: &[Vec<f64>], p: &[Vec<f64>]) -> f64 {
    let pairs = o.iter().zip(p);
    pairs.map(|(o, p)| difference(o, p)).sum::<f64>() / CHANNELS.len() as f64
}

/// Returns |o - p|² / |o|² of two tiles after normalisation to unit sum. A tile p without light counts as dark.
pub(super) fn difference(o: &[f64], p: &[f64]) -> f64 {
    const DARK: f64 = 1e-9;
    let (sum_o, sum_p) = (o.iter().sum::<f64>(), p.iter().sum::<f64>());
    let scale = if sum_p > DARK * sum_o {
        1.0 / sum_p
    } else {
        0.0
    };
    let apart: f64 = o
        .iter()
        .zip(p)
        .map(|(o, p)| (o / sum_o - p * scale).powi(2))
        .sum();
    apart / o.iter().map(|o| (o / sum_o).powi(2)).sum::<f64>()
}

/// Returns `count` spots spread over the frame at each distance, at common positions with random offsets of up to `wander`
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
    let mut spots = Vec::with_capacity(lens.depths_m.len() * count);
    for &depth_m in &lens.depths_m {
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

/// A set to be captured.
pub(super) struct SetRequest<'a> {
    pub(super) spots: &'a [Spot],
    /// Width and height of tiles, pixels.
    pub(super) tile: usize,
    /// Seed of the noise.
    pub(super) seed: u64,
    pub(super) capture: Capture,
}

/// Returns the observation set of `request` on the camera of `lens`. `shoot` computes the tiles of a spot without noise.
pub(super) fn observation_set(
    lens: &Lens,
    request: &SetRequest,
    shoot: impl Fn(&Spot) -> SpotTiles + Sync,
) -> ObservationSet {
    let capture = &request.capture;
    let observations = request
        .spots
        .par_iter()
        .enumerate()
        .map(|(index, spot)| {
            let rng = Rng::stream(request.seed, capture.label, index as u64);
            observation(spot, shoot(spot), request.tile, capture, rng, index)
        })
        .collect();
    ObservationSet {
        frame: lens.frame,
        axis_stated: true,
        mosaic: None,
        pixel_pitch_um: Some(lens.pitch_um),
        channels: CHANNELS.iter().map(|&name| name.to_owned()).collect(),
        camera: lens.camera(),
        observations,
    }
}

/// Largest standard error of the sum of a tile as a share of that sum. A smaller tile would be cut from a noisier image.
const LARGEST_SUM_ERROR: f64 = 0.2;

/// Returns the standard deviation of the noise of a tile: `peak` over `snr`, unless the light of the tile would drown in it.
pub(super) fn noise_sigma(pixels: &[f64], peak: f64, snr: f64) -> f64 {
    let light: f64 = pixels.iter().sum();
    (peak / snr).min(LARGEST_SUM_ERROR * light / (pixels.len() as f64).sqrt())
}

fn observation(
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
    let sigmas: Vec<Option<f64>> = shot
        .tiles
        .iter()
        .zip(&peaks)
        .map(|(pixels, &peak)| {
            let against = if capture.sigma_stated {
                brightest
            } else {
                peak
            };
            capture.snr.map(|snr| noise_sigma(pixels, against, snr))
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
        ideal: capture
            .ideal_positions
            .then(|| ImagePoint::new(spot.ideal[0], spot.ideal[1])),
        tiles,
        noise_sigma: if capture.sigma_stated {
            sigmas
        } else {
            vec![None; CHANNELS.len()]
        },
        background: vec![capture.background; CHANNELS.len()],
        saturated: false,
        gain: None,
        weight_mask: None,
        measurement: None,
    }
}
