//! PSF estimation from a pair of images: one sharp, and the same seen through a lens.
//!
//! Over a patch small relative to the field the plate is the sharp image convolved with one tile: O(x) = sum I(x') P(x - x'),
//! the renderer's own model. The pictures are placed in the frame of the lens (`placement`), and windows with much texture
//! are chosen (`windows`). Offsets of the windows (`offsets`) say whether the plate is distorted and how it is registered
//! (`geometry`). Each window then gives a tile per channel: the PSF that the lens predicts there (`lens_view`) plus an
//! estimate of the difference from it (`estimate`), with the response of that estimate (`response`).

mod depth;
mod estimate;
mod geometry;
mod lens_view;
mod mistakes;
mod offsets;
mod patch;
mod placement;
mod quantisation;
mod registering;
mod rendering;
mod response;
mod windows;

use crate::reference_channel::reference_channel;
pub use quantisation::{Quantisation, StoredCurve};
pub use response::TileResponse;

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use rayon::prelude::*;

use estimate::{Estimate, NoiseCheck, Plans, estimate};
use lens_view::{Drawing, LensView, Positions};
use offsets::WindowOffset;
use patch::{Patch, Window};
use registering::Registering;
use seidel_optics::Progress;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::error::{Error, Result};
use seidel_optics::field::Frame;
use seidel_optics::observations::{Observation, ObservationSet};
use seidel_optics::predict::Predictor;
use seidel_optics::profile::LensProfile;
use seidel_optics::tile::Tile;

use crate::registration::Similarity;
use seidel_optics::numeric::median;

/// Smallest and largest side of tiles, px.
const SIDES: (usize, usize) = (9, 129);
/// Share of the light near the tiles' edges above which a remark recommends larger tiles.
const MOST_AT_EDGES: f64 = 0.05;
/// One of so many windows is checked with simulated noise.
const CHECKED_WINDOWS: usize = 4;

/// A scene-linear image.
#[derive(Debug, Clone, Copy)]
pub struct PairImage<'a> {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// One plane per channel, row-major.
    pub planes: &'a [Vec<f32>],
    /// Rounding of the samples, for images of integers.
    pub quantisation: Option<Quantisation>,
}

/// Displacement of light in a plate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PairGeometry {
    /// The one that fits the plate better.
    #[default]
    Measured,
    /// The plate is undistorted: channels are displaced against each other only.
    Undistorted,
    /// The plate is distorted by the lens.
    Distorted,
}

/// Settings of [`estimate_pair`].
#[derive(Debug, Clone, PartialEq)]
pub struct PairSettings {
    /// Side of the tiles, px: odd, and larger than the widest blur.
    pub side: usize,
    /// Object distance of the whole scene, where `vergence` is not given.
    pub distance: ObjectDistance,
    /// Vergence of each pixel of the sharp image, 1 / distance in 1/m and 0 at infinity: windows at one distance are compared there.
    pub vergence: Option<Vec<f32>>,
    /// Clipping level of both images, where known.
    pub clip: Option<f32>,
    /// Whether pixels of the sharp image are area means, as a camera's are. If not they are point samples, as
    /// of a plate blurred by a renderer, and tiles then include pixel integration.
    pub area_means: bool,
    /// Maximum number of patches.
    pub most_patches: usize,
    /// Displacement of light in the plate.
    pub geometry: PairGeometry,
}

impl Default for PairSettings {
    fn default() -> Self {
        Self {
            side: 33,
            distance: ObjectDistance::Unknown,
            vergence: None,
            clip: None,
            area_means: false,
            most_patches: 48,
            geometry: PairGeometry::Measured,
        }
    }
}

/// A pair of images on the pixels of the lens's frame; unknown pixels are NaN.
#[derive(Debug, Clone)]
pub struct PlacedPictures {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Planes of the sharp image, one a channel.
    pub sharp: Vec<Vec<f32>>,
    /// Planes of the plate. Between area means they are integrated over pixels once more, as a rendering is.
    pub plate: Vec<Vec<f32>>,
    /// From pixels of the sharp image as given to those of the frame, by which it was moved.
    pub registration: Similarity,
    /// Vergence of each pixel, 1/m, where the scene is not at one distance.
    pub vergence: Option<Vec<f32>>,
    /// Whether the plate is distorted by the lens.
    pub distorted: bool,
    /// Reach of the blur that the tiles hold, px.
    pub reach_px: usize,
}

/// Result of [`estimate_pair`].
#[derive(Debug, Clone)]
pub struct PairEstimate {
    /// The estimated PSFs. They have ideal positions where the plate shows the lens's distortion.
    pub set: ObservationSet,
    /// Response of the estimator for each observation and channel of `set`.
    pub responses: Vec<Vec<TileResponse>>,
    /// Number of patches tried.
    pub tried: usize,
    /// Number of patches rejected for lack of detail, noise or clipping.
    pub left_out: usize,
    /// Share of the light within two pixels of the tiles' edges.
    pub at_edges: f64,
    /// Both images in the frame of the lens.
    pub pictures: PlacedPictures,
    remarks: Vec<String>,
}

impl PairEstimate {
    /// Returns remarks on the result.
    pub fn remarks(&self) -> Vec<String> {
        let mut remarks = self.remarks.clone();
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

/// Estimates PSFs in the frame of `lens`, which one of the images fills; its channels name their planes.
///
/// # Errors
/// A lens described by moments, or one whose blur depends on a distance that is not known; images that cannot be placed in
/// the frame; an invalid tile size; images too small for the tiles; no patch with enough detail; cancellation.
pub fn estimate_pair(
    lens: &LensProfile,
    sharp: &PairImage<'_>,
    plate: &PairImage<'_>,
    settings: &PairSettings,
    progress: &Progress<'_>,
) -> Result<PairEstimate> {
    let (channels, predictor) = (super::rays(lens)?, Predictor::new(lens)?);
    let names = predictor.channel_names();
    check(names, [sharp, plate], settings)?;
    let frame = lens.frame;
    let placement = placement::place(&frame, sharp, plate)?;
    let [left, top] = placement.plate_corner.map(|v| v as f64);
    let corner = Similarity::shift(left, top);
    let of_plate = placement::planes_in_frame(&frame, plate, &corner, None);
    let of_plate: Vec<Vec<f32>> = if settings.area_means {
        of_plate.iter().map(|p| over_pixels(p, &frame)).collect()
    } else {
        of_plate
    };
    let in_frame = |planes, quantisation| PairImage {
        width: frame.width_px() as usize,
        height: frame.height_px() as usize,
        planes,
        quantisation,
    };
    let view = LensView {
        channels,
        frame,
        vergence: match &settings.vergence {
            Some(each) => each.iter().map(|v| f64::from(*v)).sum::<f64>() / each.len() as f64,
            None => predictor.vergence(settings.distance)?,
        },
        positions: Positions::Undistorted,
    };
    let known = channels.iter().map(|c| c.name.as_str());
    let registering = Registering {
        view,
        reference: reference_channel(&lens.camera, known),
        settings,
        progress,
        plate: in_frame(&of_plate, plate.quantisation),
    };
    let registered = registering.register(sharp, placement.sharp)?;
    let view = LensView {
        positions: registered.positions,
        ..view
    };
    let depth = registering.depth(sharp, &registered.transform)?;
    let rendered_depth = depth.as_ref().map(depth::DepthPlane::rendered);
    let sharp = in_frame(&registered.sharp, sharp.quantisation);
    let (side, most) = (settings.side, settings.most_patches);
    let chosen = windows::choose(&sharp, side, most, settings.clip, depth.as_ref())?;
    let windows = chosen.windows;
    let job = registering.job(sharp, &windows);
    let rendered = if settings.area_means {
        None
    } else {
        Some(rendering::rendered(
            &view,
            &predictor,
            &job.sharp,
            rendered_depth.as_deref(),
            &|share| progress(OFFSET_SHARE + share * (RENDERED_SHARE - OFFSET_SHARE)),
        )?)
    };
    let found = job.estimates(&view, &windows, rendered.as_deref())?;
    let remarks = placement.remark.into_iter();
    let of_depth = (chosen.uneven > 0).then(|| {
        format!(
            "{} parts of the frame were left out: no window in them is at one distance",
            chosen.uneven
        )
    });
    let remarks = remarks.chain(registered.movement.remark());
    let of_encoding =
        mistakes::encoding_remark(&registered.sharp, &of_plate, frame.width_px() as usize);
    let remarks = remarks.chain(of_depth).chain(of_encoding).collect();
    let (observed, tried) = (collected(&view, names, found, settings)?, windows.len());
    if observed.set.observations.is_empty() {
        return Err(Error::new(
            "pictures",
            format!("none of {tried} patches has enough detail to tell its PSF"),
            "photograph something with fine detail all over, such as a chart of noise, sharply and brightly; \
             or give smaller tiles",
        ));
    }
    Ok(PairEstimate {
        tried,
        left_out: tried - observed.set.observations.len(),
        at_edges: at_edges(&observed.set),
        set: observed.set,
        responses: observed.responses,
        pictures: PlacedPictures {
            width: frame.width_px() as usize,
            height: frame.height_px() as usize,
            registration: registered.transform,
            vergence: rendered_depth,
            distorted: registered.positions == Positions::Lens,
            sharp: registered.sharp,
            plate: of_plate,
            reach_px: settings.side / 2,
        },
        remarks,
    })
}

/// Everything that the windows share.
struct Job<'a> {
    plans: Plans,
    sharp: PairImage<'a>,
    plate: PairImage<'a>,
    settings: &'a PairSettings,
    progress: &'a Progress<'a>,
    done: AtomicUsize,
    cancelled: AtomicBool,
}

/// Shares of the work that are done once offsets are measured, and the sharp picture is rendered.
const OFFSET_SHARE: f64 = 0.2;
const RENDERED_SHARE: f64 = 0.4;

impl Job<'_> {
    /// Runs `work` on every window, with progress from `from` to `to`.
    ///
    /// # Errors
    /// Cancellation.
    fn each<T: Send>(
        &self,
        windows: &[Window],
        shares: [f64; 2],
        work: impl Fn(usize, Window) -> T + Sync,
    ) -> Result<Vec<T>> {
        self.done.store(0, Ordering::Relaxed);
        let results = windows
            .par_iter()
            .enumerate()
            .map(|(index, window)| {
                if self.cancelled.load(Ordering::Relaxed) {
                    return None;
                }
                let result = work(index, *window);
                let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
                let share = done as f64 / windows.len() as f64;
                if !(self.progress)(shares[0] + share * (shares[1] - shares[0])) {
                    self.cancelled.store(true, Ordering::Relaxed);
                }
                Some(result)
            })
            .collect::<Option<Vec<T>>>();
        match results {
            Some(results) if !self.cancelled.load(Ordering::Relaxed) => Ok(results),
            _ => Err(Error::cancelled("estimation")),
        }
    }

    /// Measures the offsets of the windows in `channel`.
    fn offsets(
        &self,
        view: &LensView<'_>,
        windows: &[Window],
        channel: usize,
    ) -> Result<Vec<WindowOffset>> {
        let clip = self.settings.clip;
        let measured = self.each(windows, [0.0, OFFSET_SHARE], |_, window| {
            let pictures = [&self.sharp, &self.plate];
            let view = view.at(window);
            offsets::measure(&view, &self.plans, pictures, channel, window, clip)
        })?;
        Ok(measured.into_iter().flatten().collect())
    }

    /// Estimates the PSFs of all channels of every window; `None` where a channel is not determined. `rendered` are the planes
    /// of the sharp picture through the lens by the fast renderer.
    fn estimates(
        &self,
        view: &LensView<'_>,
        windows: &[Window],
        rendered: Option<&[Vec<f32>]>,
    ) -> Result<Vec<Option<WindowEstimate>>> {
        let mut found = self.each(windows, [RENDERED_SHARE, 1.0], |index, window| {
            let view = &view.at(window);
            let place = WindowPlace {
                index,
                window,
                offset: view.window_offset(window),
            };
            let estimates = (0..view.channels.len())
                .map(|channel| self.estimate(view, place, channel, rendered))
                .collect::<Option<Vec<Estimate>>>()?;
            Some(WindowEstimate {
                window,
                offset: place.offset,
                estimates,
            })
        })?;
        let checked = found.iter().flatten().flat_map(|w| &w.estimates);
        let mut ratios: Vec<f64> = checked.filter_map(|e| e.noise_ratio).collect();
        let factor = if ratios.is_empty() {
            1.0
        } else {
            median(&mut ratios).sqrt()
        };
        for window in found.iter_mut().flatten() {
            window.estimates.iter_mut().for_each(|e| e.sigma *= factor);
        }
        Ok(found)
    }

    fn estimate(
        &self,
        view: &LensView<'_>,
        place: WindowPlace,
        channel: usize,
        rendered: Option<&[Vec<f32>]>,
    ) -> Option<Estimate> {
        let WindowPlace {
            index,
            window,
            offset,
        } = place;
        let clip = self.settings.clip;
        let patch = Patch::cut(&self.sharp, &self.plate, channel, window, offset, clip);
        let mut drawing = Drawing::default();
        let mut expected =
            view.expectation(&self.plans, &patch, channel, window, offset, &mut drawing);
        if let Some(planes) = rendered {
            let image = PairImage {
                planes,
                ..self.plate
            };
            let by_renderer = Patch::cut(&self.sharp, &image, channel, window, offset, None).plate;
            let misfit =
                |expected: &[f64]| estimate::misfit(&patch, expected, self.plans.window.stride);
            if misfit(&by_renderer) < misfit(&expected.plate) {
                expected.plate = by_renderer;
            }
        }
        if let Some(rounding) = self.plate.quantisation {
            expected.least_variance = patch.plate_mean(|v| rounding.variance(v));
        }
        if let Some(rounding) = self.sharp.quantisation {
            expected.sharp_variance = patch.sharp_mean(|v| rounding.variance(v));
        }
        let check = if index.is_multiple_of(CHECKED_WINDOWS) {
            NoiseCheck::Simulated((index * view.channels.len() + channel) as u64)
        } else {
            NoiseCheck::Skipped
        };
        estimate(&self.plans, &patch, &expected, check)
    }
}

/// A window with its number and the whole pixels to its place in the plate.
#[derive(Debug, Clone, Copy)]
struct WindowPlace {
    index: usize,
    window: Window,
    offset: [isize; 2],
}

/// The estimated PSFs of a window.
struct WindowEstimate {
    window: Window,
    /// Whole pixels by which the tiles lie away from the window.
    offset: [isize; 2],
    /// One estimate a channel.
    estimates: Vec<Estimate>,
}

/// Estimated PSFs with the responses of their estimator.
struct EstimatedSet {
    set: ObservationSet,
    responses: Vec<Vec<TileResponse>>,
}

/// Makes an observation set of the estimates; leaves out those that violate the rules of sets.
fn collected(
    view: &LensView<'_>,
    names: &[String],
    found: Vec<Option<WindowEstimate>>,
    settings: &PairSettings,
) -> Result<EstimatedSet> {
    let mut observations = Vec::new();
    let mut responses = Vec::new();
    for window in found.into_iter().flatten() {
        observations.push(observation(observations.len(), view, &window, settings)?);
        let estimates = window.estimates.into_iter();
        responses.push(estimates.map(|e| e.response).collect::<Vec<_>>());
    }
    let mut set = ObservationSet {
        axis_stated: true,
        ..ObservationSet::new(view.frame, names.to_vec(), observations)
    };
    leave_out_unsound(&mut set, &mut responses);
    Ok(EstimatedSet { set, responses })
}

fn check(names: &[String], pictures: [&PairImage<'_>; 2], settings: &PairSettings) -> Result<()> {
    for picture in pictures {
        let whole = |plane: &Vec<f32>| plane.len() == picture.width * picture.height;
        if picture.planes.len() != names.len() || !picture.planes.iter().all(whole) {
            return Err(Error::new(
                "pictures",
                format!("have not one plane for each of {}", names.join(", ")),
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

fn observation(
    index: usize,
    view: &LensView<'_>,
    window: &WindowEstimate,
    settings: &PairSettings,
) -> Result<Observation> {
    let side = settings.side;
    let tile = |estimate: &Estimate| {
        Tile::new(
            side,
            side,
            estimate.tile.iter().map(|&v| v as f32).collect(),
        )
    };
    let file = format!("psf/{index:04}.exr");
    let vergence = window.window.vergence;
    let distance = vergence.map_or(settings.distance, depth::distance);
    let tiles = window.estimates.iter().map(tile).collect::<Result<_>>()?;
    let at = window.window.centre;
    let mut middle = at;
    middle.x_px += window.offset[0] as f64;
    middle.y_px += window.offset[1] as f64;
    let ideal = match view.positions {
        Positions::Lens => Some(at),
        Positions::Undistorted => None,
    };
    Ok(Observation {
        ideal,
        noise_sigma: window.estimates.iter().map(|e| Some(e.sigma)).collect(),
        ..Observation::new(file, middle, distance, tiles)
    })
}

/// Integrates `plane` over the area of a pixel. Between area means the estimate would be the PSF alone, whereas tiles include
/// the integration. A three-tap filter with the variance of a pixel is exact enough on a pixel grid.
fn over_pixels(plane: &[f32], frame: &Frame) -> Vec<f32> {
    const SIDE_WEIGHT: f32 = (seidel_optics::moments::pixels::PIXEL_VARIANCE_PX2 / 2.0) as f32;
    let (width, height) = (frame.width_px() as usize, frame.height_px() as usize);
    let along = |from: &[f32], stride: usize, length: usize| -> Vec<f32> {
        (0..from.len())
            .map(|k| {
                let at = k / stride % length;
                let before = if at > 0 { from[k - stride] } else { from[k] };
                let after = if at + 1 < length {
                    from[k + stride]
                } else {
                    from[k]
                };
                (1.0 - 2.0 * SIDE_WEIGHT) * from[k] + SIDE_WEIGHT * (before + after)
            })
            .collect()
    };
    let across = along(plane, 1, width);
    along(&across, width, height)
}

/// Removes observations that violate the rules of sets, such as strongly negative samples.
fn leave_out_unsound(set: &mut ObservationSet, responses: &mut Vec<Vec<TileResponse>>) {
    let unsound: Vec<usize> = set.faults().iter().filter_map(|f| f.observation).collect();
    let mut index = 0;
    set.observations.retain(|_| {
        index += 1;
        !unsound.contains(&(index - 1))
    });
    index = 0;
    responses.retain(|_| {
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
