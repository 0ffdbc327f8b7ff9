//! PSF estimation from a pair of images: one sharp, and the same seen through a lens.
//!
//! The images are registered pixel by pixel. Over a patch small relative to the field the plate is the sharp
//! image convolved with one tile: O(x) = sum I(x') P(x - x'), the renderer's own model.

mod estimate;
mod helix;

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use rayon::prelude::*;

use estimate::{Estimate, Patch, estimate};
use helix::Helix;
use seidel_optics::Progress;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::error::{Error, ErrorKind, Result};
use seidel_optics::field::{Frame, ImagePoint};
use seidel_optics::observations::{Observation, ObservationSet};
use seidel_optics::tile::Tile;

/// Side of the window from which a tile is estimated, in tiles.
const WINDOW_TILES: usize = 4;
/// Share of a window's side over which weights rise from its edges.
const TAPER: f64 = 0.5;
/// Smallest and largest side of tiles, px.
const SIDES: (usize, usize) = (9, 129);
/// Share of the light near the tiles' edges above which a remark recommends larger tiles.
const MOST_AT_EDGES: f64 = 0.05;

/// A scene-linear image.
#[derive(Debug, Clone, Copy)]
pub struct PairImage<'a> {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// One plane per channel, row-major.
    pub planes: &'a [Vec<f32>],
}

/// Settings of [`estimate_pair`].
#[derive(Debug, Clone, PartialEq)]
pub struct PairSettings {
    /// Side of the tiles, px: odd, and larger than the widest blur.
    pub side: usize,
    /// Object distance of the whole scene.
    pub distance: ObjectDistance,
    /// Clipping level of both images, where known.
    pub clip: Option<f32>,
    /// Whether pixels of the sharp image are area means, as a camera's are. If not they are point samples, as
    /// of a plate blurred by a renderer, and tiles then include pixel integration.
    pub area_means: bool,
    /// Maximum number of patches.
    pub most_patches: usize,
}

impl Default for PairSettings {
    fn default() -> Self {
        Self {
            side: 33,
            distance: ObjectDistance::Unknown,
            clip: None,
            area_means: false,
            most_patches: 120,
        }
    }
}

/// Result of [`estimate_pair`].
#[derive(Debug, Clone, PartialEq)]
pub struct PairEstimate {
    /// The estimated PSFs, each with its ideal position at the centre of its patch.
    pub set: ObservationSet,
    /// Number of patches tried.
    pub tried: usize,
    /// Number of patches rejected for lack of detail, noise or clipping.
    pub left_out: usize,
    /// Share of the light within two pixels of the tiles' edges.
    pub at_edges: f64,
}

impl PairEstimate {
    /// Returns remarks on the result.
    pub fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        if self.left_out > 0 {
            remarks.push(format!(
                "{} of {} patches were left out: too even, too noisy or clipped to tell their PSF",
                self.left_out, self.tried
            ));
        }
        if self.at_edges > MOST_AT_EDGES {
            remarks.push(format!(
                "{:.0} % of the light lies at the edges of the estimated tiles; larger ones would hold more of it",
                100.0 * self.at_edges
            ));
        }
        remarks
    }
}

/// Estimates PSFs over `frame`, which both images fill; `channels` names their planes.
///
/// # Errors
/// Images that differ in size from each other or the frame; an invalid tile size; images too small for the
/// tiles; no patch with enough detail; cancellation.
pub fn estimate_pair(
    frame: &Frame,
    channels: &[String],
    sharp: &PairImage<'_>,
    plate: &PairImage<'_>,
    settings: &PairSettings,
    progress: &Progress<'_>,
) -> Result<PairEstimate> {
    check(frame, channels, sharp, plate, settings)?;
    let side = settings.side;
    let window = WINDOW_TILES * side;
    let places = places(plate.width, plate.height, side, settings.most_patches)?;
    let helix = Helix::new(window + side - 1);
    let done = AtomicUsize::new(0);
    let cancelled = AtomicBool::new(false);
    let found: Vec<Option<Vec<Estimate>>> = places
        .par_iter()
        .map(|&place| {
            let estimates = (0..channels.len())
                .map(|channel| {
                    if cancelled.load(Ordering::Relaxed) {
                        return None;
                    }
                    let patch = patch(sharp, plate, channel, place, settings);
                    estimate(&helix, &patch, side)
                })
                .collect();
            let count = done.fetch_add(1, Ordering::Relaxed) + 1;
            if !progress(count as f64 / places.len() as f64) {
                cancelled.store(true, Ordering::Relaxed);
            }
            estimates
        })
        .collect();
    if cancelled.load(Ordering::Relaxed) {
        let error = Error::new("estimation", "was stopped", "start it again");
        return Err(error.with_kind(ErrorKind::Cancelled));
    }
    let mut observations = Vec::new();
    for (&(left, top), estimates) in places.iter().zip(found) {
        if let Some(estimates) = estimates {
            let half = window as f64 / 2.0;
            let at = ImagePoint::new(left as f64 + half, top as f64 + half);
            observations.push(observation(observations.len(), at, &estimates, settings)?);
        }
    }
    let mut set = ObservationSet {
        axis_stated: true,
        ..ObservationSet::new(*frame, channels.to_vec(), observations)
    };
    leave_out_unsound(&mut set);
    let tried = places.len();
    if set.observations.is_empty() {
        return Err(Error::new(
            "pictures",
            format!("none of {tried} patches has enough detail to tell its PSF"),
            "photograph something with fine detail all over, such as a chart of noise, sharply and brightly; \
             or give smaller tiles",
        ));
    }
    Ok(PairEstimate {
        tried,
        left_out: tried - set.observations.len(),
        at_edges: at_edges(&set),
        set,
    })
}

fn check(
    frame: &Frame,
    channels: &[String],
    sharp: &PairImage<'_>,
    plate: &PairImage<'_>,
    settings: &PairSettings,
) -> Result<()> {
    if (sharp.width, sharp.height) != (plate.width, plate.height) {
        return Err(Error::new(
            "pictures",
            format!(
                "differ in size: {} x {} sharp, {} x {} through the lens",
                sharp.width, sharp.height, plate.width, plate.height
            ),
            "give two pictures of one size, registered pixel by pixel",
        ));
    }
    let (width, height) = (frame.width_px() as usize, frame.height_px() as usize);
    if (plate.width, plate.height) != (width, height) {
        return Err(Error::new(
            "pictures",
            format!(
                "are {} x {} px, the lens's frame is {width} x {height}",
                plate.width, plate.height
            ),
            "give pictures that fill the frame of the lens",
        ));
    }
    for picture in [sharp, plate] {
        let whole = |plane: &Vec<f32>| plane.len() == picture.width * picture.height;
        if picture.planes.len() != channels.len() || !picture.planes.iter().all(whole) {
            return Err(Error::new(
                "pictures",
                format!("have not one plane for each of {}", channels.join(", ")),
                "give one plane a channel with one sample a pixel",
            ));
        }
    }
    let (least, most) = SIDES;
    if settings.side.is_multiple_of(2) || !(least..=most).contains(&settings.side) {
        return Err(Error::new(
            "patch",
            format!("is {} px", settings.side),
            format!("give an odd number from {least} to {most}"),
        ));
    }
    Ok(())
}

/// Returns the top-left corners of windows on a regular grid over the plate.
fn places(width: usize, height: usize, side: usize, most: usize) -> Result<Vec<(usize, usize)>> {
    let (window, margin) = (WINDOW_TILES * side, side / 2);
    let room = |size: usize| size.checked_sub(window + 2 * margin);
    let (Some(wide), Some(high)) = (room(width), room(height)) else {
        return Err(Error::new(
            "pictures",
            format!(
                "are {width} x {height} px, too small for tiles of {side} px, which need {} px each way",
                window + 2 * margin
            ),
            "give smaller tiles, or larger pictures",
        ));
    };
    // Windows overlap by half unless that exceeds the number of patches.
    let mut step = window / 2;
    let count = |free: usize, step: usize| free / step + 1;
    while count(wide, step) * count(high, step) > most.max(1) {
        step += window / 8;
    }
    let along = |free: usize| {
        let count = count(free, step);
        (0..count).map(move |k| {
            margin + free * (2 * k + usize::from(count == 1)) / (2 * (count - 1).max(1))
        })
    };
    let rows = along(high);
    Ok(rows
        .flat_map(|top| along(wide).map(move |left| (left, top)))
        .collect())
}

/// Returns the data of one channel in the window whose left and top are `place`, in the layout of the helix.
fn patch(
    sharp: &PairImage<'_>,
    plate: &PairImage<'_>,
    channel: usize,
    place: (usize, usize),
    settings: &PairSettings,
) -> Patch {
    let (left, top) = place;
    let side = settings.side;
    let (window, margin) = (WINDOW_TILES * side, side / 2);
    let square = window + 2 * margin;
    let cut = |picture: &PairImage<'_>| -> Vec<f64> {
        let plane = &picture.planes[channel];
        (0..square)
            .flat_map(|y| {
                let start = (top - margin + y) * picture.width + left - margin;
                plane[start..start + square].iter().map(|&v| f64::from(v))
            })
            .collect()
    };
    let (sharp, blurred) = (cut(sharp), cut(plate));
    let clipped = |v: f64| settings.clip.is_some_and(|clip| v >= f64::from(clip));
    // The value of a clipped pixel is unknown, and so is every plate pixel within its reach.
    let dark: Vec<bool> = spread(sharp.iter().map(|&v| clipped(v)).collect(), square, margin);
    let mut patch = Patch {
        plate: vec![0.0; square * square],
        weight: vec![0.0; square * square],
        sharp,
    };
    for y in 0..window {
        for x in 0..window {
            // Index of the plate's pixel in the square, and its index after the convolution.
            let from = (y + margin) * square + x + margin;
            let to = (y + 2 * margin) * square + x + 2 * margin;
            patch.plate[to] = blurred[from];
            if !clipped(blurred[from]) && !dark[from] {
                patch.weight[to] = taper(x, window) * taper(y, window);
            }
        }
    }
    patch
}

/// Window function: 1 in the middle, falling smoothly to 0 at the edges.
fn taper(at: usize, window: usize) -> f64 {
    let in_from_edge = (at as f64 + 0.5).min(window as f64 - at as f64 - 0.5) / window as f64;
    let rise = (in_from_edge / TAPER).min(1.0);
    0.5 - 0.5 * (std::f64::consts::PI * rise).cos()
}

/// Dilates a mask on a square of side `side` by `reach` pixels along both axes.
fn spread(mut set: Vec<bool>, side: usize, reach: usize) -> Vec<bool> {
    // Along rows, then along columns: steps between neighbours, and between lines.
    for (near, line) in [(1, side), (side, 1)] {
        let before: Vec<usize> = (0..set.len()).filter(|&k| set[k]).collect();
        for k in before {
            let at = k / near % side;
            let start = k / line % side * line;
            for other in at.saturating_sub(reach)..(at + reach + 1).min(side) {
                set[start + other * near] = true;
            }
        }
    }
    set
}

fn observation(
    index: usize,
    at: ImagePoint,
    estimates: &[Estimate],
    settings: &PairSettings,
) -> Result<Observation> {
    let side = settings.side;
    let tile = |estimate: &Estimate| {
        let light = if settings.area_means {
            over_pixels(&estimate.tile, side)
        } else {
            estimate.tile.clone()
        };
        Tile::new(side, side, light.iter().map(|&v| v as f32).collect())
    };
    let file = format!("psf/{index:04}.exr");
    let tiles = estimates.iter().map(tile).collect::<Result<_>>()?;
    Ok(Observation {
        ideal: Some(at),
        noise_sigma: estimates.iter().map(|e| Some(e.sigma)).collect(),
        ..Observation::new(file, at, settings.distance, tiles)
    })
}

/// Adds pixel integration to the tile. Between area means the estimate is the PSF alone, whereas tiles
/// include the integration. A three-tap filter with the variance of a pixel is exact enough on a pixel grid.
fn over_pixels(tile: &[f64], side: usize) -> Vec<f64> {
    const SIDE_WEIGHT: f64 = seidel_optics::moments::pixels::PIXEL_VARIANCE_PX2 / 2.0;
    let along = |from: &[f64], stride: usize, place: fn(usize, usize) -> usize| -> Vec<f64> {
        (0..from.len())
            .map(|k| {
                let at = place(k, side);
                let before = if at > 0 { from[k - stride] } else { 0.0 };
                let after = if at + 1 < side { from[k + stride] } else { 0.0 };
                (1.0 - 2.0 * SIDE_WEIGHT) * from[k] + SIDE_WEIGHT * (before + after)
            })
            .collect()
    };
    let across = along(tile, 1, |k, side| k % side);
    along(&across, side, |k, side| k / side)
}

/// Removes observations that violate the rules of sets, such as strongly negative samples.
fn leave_out_unsound(set: &mut ObservationSet) {
    let unsound: Vec<usize> = set.faults().iter().filter_map(|f| f.observation).collect();
    let mut index = 0;
    set.observations.retain(|_| {
        index += 1;
        !unsound.contains(&(index - 1))
    });
    for (index, observation) in set.observations.iter_mut().enumerate() {
        observation.file = format!("psf/{index:04}.exr");
    }
}

/// Returns the share of the light of all tiles within two pixels of their edges.
fn at_edges(set: &ObservationSet) -> f64 {
    let (mut edge, mut all) = (0.0, 0.0);
    for tile in set.observations.iter().flat_map(|o| &o.tiles) {
        let side = tile.width();
        let sum = tile.sum();
        for (k, &light) in tile.samples().iter().enumerate() {
            let (x, y) = (k % side, k / side);
            let inside = (2..side - 2).contains(&x) && (2..side - 2).contains(&y);
            edge += if inside { 0.0 } else { f64::from(light) / sum };
        }
        all += 1.0;
    }
    if all > 0.0 { edge / all } else { 0.0 }
}

#[cfg(test)]
mod tests;
