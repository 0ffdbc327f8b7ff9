//! Tiles, gaps and observation sets of a traced lens with its causes.

use rayon::prelude::*;

use super::assembly::Assembly;
use super::beam::Beam;
use super::change::{Action, GlassCause};
use super::lens::GlassLens;
use crate::expose::{Capture, Spot, SpotTiles, TileOptions, difference, observation};
use crate::lens::{CHANNELS, Place};
use crate::pencil::Pencil;
use crate::rays;
use crate::rng::Rng;
use crate::sensor::FineGrid;
use seidel_optics::field::ImagePoint;
use seidel_optics::observations::ObservationSet;

/// Cells across the beam for tiles of a case.
pub(super) const CELLS: usize = 128;
/// Cells across the beam for the measurement of gaps.
pub(super) const CELLS_COARSE: usize = 48;

/// A lens with its causes.
pub(super) struct Built<'a> {
    pub(super) lens: &'a GlassLens,
    pub(super) assembly: Assembly,
    causes: &'a [&'a GlassCause],
}

impl<'a> Built<'a> {
    pub(super) fn new(lens: &'a GlassLens, causes: &'a [&'a GlassCause]) -> Self {
        let mut assembly = lens.design.clone();
        for cause in causes {
            if let Action::Build(build) = &cause.change.action {
                build(cause.strength, lens, &mut assembly);
            }
        }
        Self {
            lens,
            assembly,
            causes,
        }
    }

    /// Returns the stop and the sensor at `place`, carried by a pencil without rays.
    fn capture(&self, place: &Place) -> Pencil {
        let [x, y] = place.ideal;
        let field = (self.lens.camera.frame).field_point(ImagePoint::new(x, y));
        let mut pencil = Pencil::sharp([field.x, field.y], place.ideal);
        for cause in self.causes {
            if let Action::Capture(apply) = &cause.change.action {
                apply(cause.strength, &self.lens.camera, place, &mut pencil);
            }
        }
        pencil
    }
}

/// Computes the tiles of `spot` about `centre`; without one, about the pixel centre nearest to the centroid. `None` if no
/// light passes.
pub(super) fn spot_tiles(
    built: &Built,
    spot: &Spot,
    options: TileOptions,
    centre: Option<[f64; 2]>,
) -> Option<SpotTiles> {
    let object = built.assembly.object(spot.ideal, spot.depth_m);
    let captures: Vec<Pencil> = (0..CHANNELS.len())
        .map(|channel| {
            built.capture(&Place {
                ideal: spot.ideal,
                depth_m: spot.depth_m,
                channel,
            })
        })
        .collect();
    let beams: Vec<Beam> = captures
        .iter()
        .enumerate()
        .map(|(channel, capture)| Beam::new(&built.assembly, channel, object, &capture.mask))
        .collect::<Option<_>>()?;
    let centre = centre.unwrap_or_else(|| {
        let mut mean = [0.0; 2];
        for (beam, capture) in beams.iter().zip(&captures) {
            let (at, shift) = (beam.centroid(), capture.sensor.shift());
            mean[0] += (at[0] + shift[0]) / CHANNELS.len() as f64;
            mean[1] += (at[1] + shift[1]) / CHANNELS.len() as f64;
        }
        mean.map(|m| m.floor() + 0.5)
    });
    let mut tiles: Vec<Vec<f64>> = beams
        .iter()
        .zip(&captures)
        .map(|(beam, capture)| {
            let mut fine = FineGrid::new(options.tile, &capture.sensor);
            rays::trace(beam, centre, options.cells, &mut fine);
            capture.sensor.integrate(&fine, options.tile)
        })
        .collect();
    if options.raw {
        let peak = tiles.iter().flatten().copied().fold(0.0, f64::max);
        for (pixels, capture) in tiles.iter_mut().zip(&captures) {
            for pixel in pixels.iter_mut() {
                let value = *pixel * spot.level / peak;
                *pixel = capture.sensor.tone.map_or(value, |tone| tone.apply(value));
            }
        }
    }
    Some(SpotTiles { centre, tiles })
}

/// Returns the mean over `spots` and channels of |o - p|² / |o|², for unit-sum tiles with and without the causes; infinite
/// if no light reaches a tile.
pub(super) fn gap(lens: &GlassLens, causes: &[&GlassCause], spots: &[Spot], tile: usize) -> f64 {
    let options = TileOptions {
        tile,
        cells: CELLS_COARSE,
        raw: true,
    };
    let (real, bare) = (Built::new(lens, causes), Built::new(lens, &[]));
    let gaps: Vec<f64> = spots
        .par_iter()
        .map(|spot| {
            let pair = spot_tiles(&real, spot, options, None).and_then(|seen| {
                let designed = spot_tiles(&bare, spot, options, Some(seen.centre))?;
                Some([seen, designed])
            });
            let Some([seen, designed]) = pair else {
                return f64::INFINITY;
            };
            let lit = |tiles: &SpotTiles| tiles.tiles.iter().all(|t| t.iter().sum::<f64>() > 0.0);
            if !(lit(&seen) && lit(&designed)) {
                return f64::INFINITY;
            }
            let tiles = seen.tiles.iter().zip(&designed.tiles);
            tiles.map(|(o, p)| difference(o, p)).sum::<f64>() / CHANNELS.len() as f64
        })
        .collect();
    gaps.iter().sum::<f64>() / gaps.len() as f64
}

/// Returns the observation set of `spots` with the settings of `capture`.
///
/// # Panics
/// If no light reaches a spot.
pub(super) fn set(
    lens: &GlassLens,
    causes: &[&GlassCause],
    spots: &[Spot],
    tile: usize,
    seed: u64,
    capture: &Capture,
) -> ObservationSet {
    let built = Built::new(lens, causes);
    let observations = spots
        .par_iter()
        .enumerate()
        .map(|(index, spot)| {
            let options = TileOptions {
                tile,
                cells: CELLS,
                raw: capture.raw,
            };
            let shot = spot_tiles(&built, spot, options, None).expect("light passes the lens");
            let rng = Rng::stream(seed, capture.label, index as u64);
            observation(spot, shot, tile, capture, rng, index)
        })
        .collect();
    ObservationSet {
        frame: lens.camera.frame,
        axis_stated: true,
        pixel_pitch_um: Some(lens.camera.pitch_um),
        channels: CHANNELS.iter().map(|&name| name.to_owned()).collect(),
        camera: lens.camera.camera(),
        observations,
    }
}
