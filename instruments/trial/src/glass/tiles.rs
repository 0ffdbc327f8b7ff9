//! Tiles and gaps of a traced lens with its causes.

use rayon::prelude::*;

use super::assembly::Assembly;
use super::beam::Beam;
use super::change::{Action, GlassCause};
use super::lens::GlassLens;
use super::vector::Vector;
use crate::expose::{Alignment, GapOptions, Spot, SpotTiles, TileOptions, expose, mean_difference};
use crate::lens::{CHANNELS, Place};
use crate::pencil::Pencil;
use crate::rays;
use crate::sensor::FineGrid;
use seidel_optics::field::ImagePoint;

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

/// The beams of all channels of a spot, and the capture of each.
struct SpotBeams<'a> {
    built: &'a Built<'a>,
    object: Vector,
    captures: Vec<Pencil>,
}

impl<'a> SpotBeams<'a> {
    fn new(built: &'a Built, spot: &Spot) -> Self {
        let place = |channel: usize| Place {
            ideal: spot.ideal,
            depth_m: spot.depth_m,
            channel,
        };
        Self {
            built,
            object: built.assembly.object(spot.ideal, spot.depth_m),
            captures: (0..CHANNELS.len())
                .map(|channel| built.capture(&place(channel)))
                .collect(),
        }
    }

    /// Finds the beams; `None` if no light passes in a channel.
    fn beams(&self) -> Option<Vec<Beam<'_>>> {
        let assembly = &self.built.assembly;
        self.captures
            .iter()
            .enumerate()
            .map(|(channel, capture)| Beam::new(assembly, channel, self.object, &capture.mask))
            .collect()
    }

    /// Returns the mean over channels of the centroid on the sensor, frame pixels.
    fn mean_centroid(&self, beams: &[Beam]) -> [f64; 2] {
        let mut mean = [0.0; 2];
        for (beam, capture) in beams.iter().zip(&self.captures) {
            let (at, shift) = (beam.centroid(), capture.sensor.shift());
            mean[0] += (at[0] + shift[0]) / CHANNELS.len() as f64;
            mean[1] += (at[1] + shift[1]) / CHANNELS.len() as f64;
        }
        mean
    }

    /// Computes the tiles about `centre`.
    fn tiles(
        &self,
        beams: &[Beam],
        options: TileOptions,
        centre: [f64; 2],
        level: f64,
    ) -> SpotTiles {
        let mut tiles: Vec<Vec<f64>> = beams
            .iter()
            .zip(&self.captures)
            .map(|(beam, capture)| {
                let mut fine = FineGrid::new(options.tile, &capture.sensor);
                rays::trace(beam, centre, options.cells, &mut fine);
                capture.sensor.integrate(&fine, options.tile)
            })
            .collect();
        if options.raw {
            expose(&mut tiles, &self.captures, level);
        }
        SpotTiles { centre, tiles }
    }
}

/// Computes the tiles of `spot` about the pixel centre nearest to the centroid. `None` if no light passes.
pub(super) fn spot_tiles(built: &Built, spot: &Spot, options: TileOptions) -> Option<SpotTiles> {
    let of_spot = SpotBeams::new(built, spot);
    let beams = of_spot.beams()?;
    let centre = of_spot.mean_centroid(&beams).map(|m| m.floor() + 0.5);
    Some(of_spot.tiles(&beams, options, centre, spot.level))
}

/// Returns the mean over `spots` and channels of |o - p|² / |o|², for unit-sum tiles with and without the causes; infinite
/// if no light reaches a tile.
pub(super) fn gap(
    lens: &GlassLens,
    causes: &[&GlassCause],
    spots: &[Spot],
    options: GapOptions,
) -> f64 {
    let (real, bare) = (Built::new(lens, causes), Built::new(lens, &[]));
    let gaps: Vec<f64> = spots
        .par_iter()
        .map(|spot| spot_gap(&real, &bare, spot, options).unwrap_or(f64::INFINITY))
        .collect();
    gaps.iter().sum::<f64>() / gaps.len() as f64
}

/// Returns the mean over channels of the gap of one spot; `None` if no light reaches a tile.
fn spot_gap(real: &Built, bare: &Built, spot: &Spot, options: GapOptions) -> Option<f64> {
    let tile_options = TileOptions {
        tile: options.tile,
        cells: CELLS_COARSE,
        raw: true,
    };
    let [of_real, of_bare] = [real, bare].map(|built| SpotBeams::new(built, spot));
    let (real_beams, bare_beams) = (of_real.beams()?, of_bare.beams()?);
    let at_real = of_real.mean_centroid(&real_beams);
    let centre = at_real.map(|m| m.floor() + 0.5);
    let mut bare_centre = centre;
    if options.alignment == Alignment::Centroid {
        let at_bare = of_bare.mean_centroid(&bare_beams);
        for axis in 0..2 {
            bare_centre[axis] += at_bare[axis] - at_real[axis];
        }
    }
    let seen = of_real.tiles(&real_beams, tile_options, centre, spot.level);
    let designed = of_bare.tiles(&bare_beams, tile_options, bare_centre, spot.level);
    let lit = |tiles: &SpotTiles| tiles.tiles.iter().all(|t| t.iter().sum::<f64>() > 0.0);
    (lit(&seen) && lit(&designed)).then(|| mean_difference(&seen.tiles, &designed.tiles))
}
