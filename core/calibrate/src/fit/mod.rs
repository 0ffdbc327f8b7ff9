//! Fits of a lens profile to observed point-spread functions (PSFs).
//!
//! [`fit`] fits any [`Model`]:
//!
//! - [`fit_moments`]: the moments model of the paper. S1..S10 per channel and object distance by weighted
//!   linear least squares ([`plane`], Eqs 18-24), and the centroid displacement ([`displacement`]).
//! - [`fit_pupil`]: a lens described by its pupil, fitted to the pixels of all tiles by robust nonlinear
//!   least squares ([`pixels`]).
//!
//! [`edges::fit_edges`] fits the same lens to the profiles of straight edges, [`plate_match::match_plate`] to those of a plate
//! of any content.
//!
//! Shared parts: moments of every tile ([`crate::measure`]), the optical axis ([`axis`]), initial estimates
//! from moments ([`initial`]) and the held-out tiles ([`holdout`]).

pub mod axis;
mod axis_problem;
pub mod coverage;
pub mod displacement;
pub mod edges;
mod front;
pub mod holdout;
pub mod initial;
pub mod pixels;
pub mod plane;
pub mod plate_match;
mod warnings;

use rayon::prelude::*;

use crate::measure::{MeasuredTile, Rejection, measure};
use crate::stage::Stage;
use axis::AxisEstimate;
use plane::{PlaneFit, fit_plane};
use seidel_optics::Progress;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::error::{Error, Result};
use seidel_optics::field::{Frame, ImagePoint};
use seidel_optics::moments::support::Support;
use seidel_optics::observations::ObservationSet;
use seidel_optics::profile::{
    LensDescription, LensProfile, MomentsChannel, MomentsPlane, Provenance,
};

pub use front::{Fit, FitSettings, Model, fit, refit};
pub use pixels::{PartTrial, PupilFit, PupilModel, PupilSettings, fit_pupil, refit_pupil};
pub use plane::Weighting;

/// Settings of [`fit_moments`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MomentsSettings {
    /// Weights of the residuals.
    pub weighting: Weighting,
    /// Position of the optical axis.
    pub axis: AxisChoice,
    /// Pixels of a tile that enter its moments.
    pub support: Support,
}

/// Position of the optical axis in the frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum AxisChoice {
    /// The axis stated by the observation set, or else the frame's centre.
    #[default]
    AsObserved,
    /// The given frame position, px.
    At(ImagePoint),
    /// Estimated from the PSFs by Levenberg-Marquardt, starting at the axis of the observation set.
    Free,
}

/// A fitted moments model and its report.
#[derive(Debug, Clone)]
pub struct MomentsFit {
    /// The fitted lens profile.
    pub lens: LensProfile,
    /// Reports per channel and object distance, in the profile's order.
    pub planes: Vec<PlaneReport>,
    /// Tiles excluded from the fit, with reasons.
    pub rejected: Vec<Rejection>,
    /// The estimated optical axis, for [`AxisChoice::Free`].
    pub axis: Option<AxisEstimate>,
    /// Limits of the result, such as coefficients that the object distances do not determine.
    pub warnings: Vec<String>,
}

/// Report on one channel at one object distance.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaneReport {
    /// Channel name.
    pub channel: String,
    /// Object distance.
    pub distance: ObjectDistance,
    /// Number of tiles fitted.
    pub used: usize,
    /// Root mean square residual of second moments, relative to the PSF's trace.
    pub second_residual: f64,
    /// Root mean square residual of third moments, relative to the trace to the power 3/2.
    pub third_residual: f64,
    /// Iterations of reweighting and outlier rejection.
    pub iterations: usize,
    /// Whether the last iteration changed neither weights nor outliers.
    pub converged: bool,
    /// Smallest predicted variance anywhere in the frame, px². A negative value is not realisable.
    pub least_variance_px2: f64,
}
/// Fits S1..S10 (Eqs 18-24) per channel and object distance to observation sets of one camera.
///
/// # Errors
/// Sets that differ in frame, channels or axis; known and unknown distances mixed; fewer than three usable
/// tiles in a channel at a distance; positions that do not determine S1..S10, such as a single field radius;
/// cancellation by `progress`.
pub fn fit_moments(
    sets: &[ObservationSet],
    settings: &MomentsSettings,
    progress: &Progress,
) -> Result<MomentsFit> {
    let whole = Stage::whole(progress, "fit");
    whole.reach(0.0)?;
    let first = check_same_camera(sets)?;
    let start = match settings.axis {
        AxisChoice::At(axis) => first.frame.with_axis(axis)?,
        AxisChoice::AsObserved | AxisChoice::Free => first.frame,
    };
    let mut rejected = Vec::new();
    let tiles = measure(sets, settings.support, &mut rejected);
    check_channels(sets, &tiles, &rejected)?;
    let groups = group_tiles(sets, &tiles)?;
    whole.reach(0.3)?;
    let (frame, axis) = if settings.axis == AxisChoice::Free {
        let found = axis::find_axis(&start, &group_slices(&groups), settings.weighting)?;
        (start.with_axis(found.axis)?, Some(found))
    } else {
        (start, None)
    };
    whole.reach(0.6)?;
    let fits: Vec<PlaneFit> = groups
        .par_iter()
        .map(|group| {
            fit_plane(&frame, &group.tiles, settings.weighting).map_err(|error| {
                error.within(&format!(
                    "channel {} at {}",
                    first.channels[group.channel], group.distance
                ))
            })
        })
        .collect::<Result<_>>()?;
    whole.reach(1.0)?;
    Ok(assemble(
        sets, settings, frame, axis, &groups, &fits, rejected,
    ))
}

/// The tiles of one channel at one object distance.
struct Group<'a> {
    channel: usize,
    distance: ObjectDistance,
    tiles: Vec<&'a MeasuredTile>,
}

fn group_slices<'a>(groups: &'a [Group<'a>]) -> Vec<&'a [&'a MeasuredTile]> {
    groups.iter().map(|group| group.tiles.as_slice()).collect()
}

/// Returns the first set after checking that all sets have its frame size, channels and axis.
fn check_same_camera(sets: &[ObservationSet]) -> Result<&ObservationSet> {
    let first = sets.first().ok_or_else(|| {
        Error::new(
            "observations",
            "none given",
            "give at least one observation set",
        )
    })?;
    for (index, set) in sets.iter().enumerate().skip(1) {
        let differs = |field: &str, theirs: String, ours: String| {
            Err(Error::new(
                format!("observation set {} {field}", index + 1),
                format!("is {theirs}; that of the first set is {ours}"),
                "fit only sets of the same camera and frame together",
            ))
        };
        let size = |s: &ObservationSet| format!("{} x {}", s.frame.width_px(), s.frame.height_px());
        if size(set) != size(first) {
            return differs("image_size", size(set), size(first));
        }
        if set.channels != first.channels {
            return differs(
                "channels",
                set.channels.join(", "),
                first.channels.join(", "),
            );
        }
        if set.frame.axis() != first.frame.axis() {
            let axis =
                |s: &ObservationSet| format!("({}, {})", s.frame.axis().x_px, s.frame.axis().y_px);
            return differs("optical_axis", axis(set), axis(first));
        }
    }
    Ok(first)
}

/// Checks that each channel has a tile, and names the most frequent reason why one has none.
fn check_channels(
    sets: &[ObservationSet],
    tiles: &[MeasuredTile],
    rejected: &[Rejection],
) -> Result<()> {
    for (channel, name) in sets[0].channels.iter().enumerate() {
        let of_channel: Vec<&Rejection> = rejected.iter().filter(|r| r.channel == *name).collect();
        if of_channel.is_empty() || tiles.iter().any(|tile| tile.channel == channel) {
            continue;
        }
        // Figures follow the colon.
        let kind = |r: &&Rejection| r.reason.split(':').next().unwrap_or_default().to_owned();
        let count = |wanted: &String| of_channel.iter().filter(|r| kind(r) == *wanted).count();
        let reason = of_channel.iter().map(kind).max_by_key(count);
        let reason = reason.unwrap_or_default();
        return Err(Error::new(
            format!("channel {name}"),
            format!(
                "has no usable tile: {} of {} are left out with the reason `{reason}`",
                count(&reason),
                of_channel.len()
            ),
            "measure brighter lights or a darker background, or leave the channel out",
        )
        .with_kind(seidel_optics::ErrorKind::InsufficientData));
    }
    Ok(())
}

fn group_tiles<'a>(sets: &[ObservationSet], tiles: &'a [MeasuredTile]) -> Result<Vec<Group<'a>>> {
    let mut distances: Vec<ObjectDistance> = Vec::new();
    for distance in sets.iter().flat_map(ObservationSet::distances) {
        if !distances.contains(&distance) {
            distances.push(distance);
        }
    }
    // Rising vergence, from infinity inwards; unknown last.
    distances.sort_by(|a, b| {
        let rank = |d: &ObjectDistance| d.vergence_per_m().unwrap_or(f64::INFINITY);
        rank(a).total_cmp(&rank(b))
    });
    if distances.len() > 1 && distances.contains(&ObjectDistance::Unknown) {
        return Err(Error::new(
            "depth_m",
            "is missing for some observations and given for others",
            "give every observation's distance (null for infinity), or none's",
        ));
    }
    let channels = sets[0].channels.len();
    Ok((0..channels)
        .flat_map(|channel| distances.iter().map(move |&distance| (channel, distance)))
        .map(|(channel, distance)| Group {
            channel,
            distance,
            tiles: tiles
                .iter()
                .filter(|tile| tile.channel == channel && tile.distance == distance)
                .collect(),
        })
        .collect())
}

fn assemble(
    sets: &[ObservationSet],
    settings: &MomentsSettings,
    frame: Frame,
    axis: Option<AxisEstimate>,
    groups: &[Group],
    fits: &[PlaneFit],
    mut rejected: Vec<Rejection>,
) -> MomentsFit {
    let first = &sets[0];
    let mut channels: Vec<MomentsChannel> = first
        .channels
        .iter()
        .map(|name| MomentsChannel {
            name: name.clone(),
            planes: Vec::new(),
        })
        .collect();
    let mut planes = Vec::new();
    let mut warnings = Vec::new();
    for (group, fit) in groups.iter().zip(fits) {
        let name = &first.channels[group.channel];
        channels[group.channel].planes.push(MomentsPlane {
            distance: group.distance,
            s: fit.s,
            s_sigma: fit.s_sigma,
            displacement: displacement::fit_displacement(&frame, &fit.used),
            tiles_used: fit.used.len(),
            tiles_rejected: fit.rejected.len(),
        });
        let least = fit.s.least_variance(frame.corner_radius());
        planes.push(PlaneReport {
            channel: name.clone(),
            distance: group.distance,
            used: fit.used.len(),
            second_residual: fit.second_residual,
            third_residual: fit.third_residual,
            iterations: fit.iterations,
            converged: fit.converged,
            least_variance_px2: least,
        });
        if least < 0.0 {
            warnings.push(format!(
                "channel {name} at {}: the fit predicts a variance of {least:.3} px² somewhere in the frame; rendering replaces it by the smallest variance of a kernel",
                group.distance
            ));
        }
        rejected.extend(fit.rejected.iter().map(|(tile, reason)| Rejection {
            set: tile.set,
            observation: tile.observation,
            file: tile.file.clone(),
            channel: name.clone(),
            reason: reason.clone(),
        }));
    }
    let lens = LensProfile {
        frame,
        pixel_pitch_um: first.pixel_pitch_um,
        camera: first.camera.clone(),
        description: LensDescription::Moments(channels),
        held_out: None,
        provenance: Provenance {
            program: concat!("seidel ", env!("CARGO_PKG_VERSION")).to_owned(),
            sources: Vec::new(),
            settings: settings.describe(),
            tiles: coverage::by_distance(fits.iter().flat_map(|fit| fit.used.iter().copied())),
        },
    };
    warnings.extend(warnings::depth_warnings(&lens));
    MomentsFit {
        lens,
        planes,
        rejected,
        axis,
        warnings,
    }
}

impl MomentsSettings {
    fn describe(&self) -> String {
        let weighting = match self.weighting {
            Weighting::Weighted => "weighted",
            Weighting::Unweighted => "unweighted",
        };
        format!(
            "moments, {weighting}, {}",
            axis_and_support(self.axis, self.support)
        )
    }
}

/// Returns the settings of the axis and of the pixels that count, in words.
fn axis_and_support(axis: AxisChoice, support: Support) -> String {
    let axis = match axis {
        AxisChoice::AsObserved => "axis as observed".to_owned(),
        AxisChoice::At(p) => format!("axis at ({}, {})", p.x_px, p.y_px),
        AxisChoice::Free => "axis free".to_owned(),
    };
    let support = match support {
        Support::Auto => "pixels above the noise",
        Support::AllPixels => "all pixels",
    };
    format!("{axis}, {support}")
}

#[cfg(test)]
mod tests;
