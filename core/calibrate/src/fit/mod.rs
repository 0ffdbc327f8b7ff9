//! From observations to a lens profile: `--model moments`, the paper's own fit.
//!
//! Moments of every tile ([`crate::measure`]) -> S1..S10 per channel and object distance by linear least
//! squares ([`plane`]) -> centroid displacement ([`displacement`]) -> [`LensProfile`]. The optical
//! axis is found on request ([`axis`]).
//!
//! For fits to pixels: where they may start ([`starts`]) and what they keep aside ([`holdout`]).

pub mod axis;
pub mod displacement;
pub mod holdout;
pub mod linear;
pub mod pixels;
pub mod plane;
mod remarks;
pub mod starts;

use rayon::prelude::*;

use crate::measure::{MeasuredTile, Rejection, measure};
use axis::AxisFit;
use plane::{PlaneFit, fit_plane};
use seidel_optics::distance::ObjectDistance;
use seidel_optics::error::{Error, Result};
use seidel_optics::field::{Frame, ImagePoint};
use seidel_optics::moments::support::Support;
use seidel_optics::observations::ObservationSet;
use seidel_optics::profile::{
    LensDescription, LensProfile, MomentsChannel, MomentsPlane, Provenance,
};

pub use pixels::{Extension, PupilFit, PupilSettings, fit_pupil};
pub use plane::Weighting;

/// How to fit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FitSettings {
    /// Weighted and robust, or unweighted as in the paper.
    pub weighting: Weighting,
    /// Where the optical axis is.
    pub axis: AxisChoice,
    /// Which pixels of a tile take part.
    pub support: Support,
}

/// Where the optical axis meets the frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum AxisChoice {
    /// Where the observation set says; the frame's centre if it does not.
    #[default]
    AsObserved,
    /// At this frame position.
    At(ImagePoint),
    /// Where the moments agree best, searched from what the set says.
    Free,
}

/// A fitted lens and how the fit went.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The lens.
    pub lens: LensProfile,
    /// One report a channel and plane, in the profile's order.
    pub planes: Vec<PlaneReport>,
    /// Tiles that took no part, and why.
    pub rejected: Vec<Rejection>,
    /// How the search for the axis ended, where one was asked for.
    pub axis: Option<AxisFit>,
    /// What a user should know about the result, such as what the planes at hand cannot tell.
    pub remarks: Vec<String>,
}

/// How the fit of one channel at one distance went.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaneReport {
    /// Channel name.
    pub channel: String,
    /// Object distance.
    pub distance: ObjectDistance,
    /// Tiles that took part.
    pub used: usize,
    /// Root mean square residual of second moments over the PSF's trace.
    pub second_residual: f64,
    /// Root mean square residual of third moments over the PSF's trace to the power 3/2.
    pub third_residual: f64,
    /// Rounds of reweighting and rejection.
    pub rounds: usize,
    /// Whether the last round changed nothing.
    pub converged: bool,
    /// Least variance in px² that the fit predicts anywhere in the frame; negative is not realisable.
    pub least_variance_px2: f64,
}
/// Fits S1..S10 per channel and distance to one or more observation sets of one camera.
///
/// # Errors
/// Sets of different frames or channels, a channel and distance with too few usable tiles, or
/// positions that do not determine S1..S10 (such as all at one field radius).
pub fn fit_moments(sets: &[ObservationSet], settings: &FitSettings) -> Result<Fit> {
    let first = one_camera(sets)?;
    let start = match settings.axis {
        AxisChoice::At(axis) => first.frame.with_axis(axis)?,
        AxisChoice::AsObserved | AxisChoice::Free => first.frame,
    };
    let mut rejected = Vec::new();
    let tiles = measure(sets, settings.support, &mut rejected);
    let groups = grouped(sets, &tiles)?;
    let (frame, axis) = if settings.axis == AxisChoice::Free {
        let found = axis::find_axis(&start, &groups_of_tiles(&groups), settings.weighting)?;
        (start.with_axis(found.axis)?, Some(found))
    } else {
        (start, None)
    };
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

fn groups_of_tiles<'a>(groups: &'a [Group<'a>]) -> Vec<&'a [&'a MeasuredTile]> {
    groups.iter().map(|group| group.tiles.as_slice()).collect()
}

/// Checks that all sets are of one camera and returns the first.
fn one_camera(sets: &[ObservationSet]) -> Result<&ObservationSet> {
    let first = sets.first().ok_or_else(|| {
        Error::new(
            "observations",
            "none were given",
            "give at least one observation set",
        )
    })?;
    for (index, set) in sets.iter().enumerate().skip(1) {
        let differs = |field: &str, theirs: String, ours: String| {
            Err(Error::new(
                format!("observation set {} {field}", index + 1),
                format!("is {theirs}, the first set's is {ours}"),
                "fit sets of one camera and frame together, others apart",
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

fn grouped<'a>(sets: &[ObservationSet], tiles: &'a [MeasuredTile]) -> Result<Vec<Group<'a>>> {
    let mut distances: Vec<ObjectDistance> = Vec::new();
    for distance in sets.iter().flat_map(ObservationSet::distances) {
        if !distances.contains(&distance) {
            distances.push(distance);
        }
    }
    // From infinity inwards, by rising vergence; unknown last.
    distances.sort_by(|a, b| {
        let rank = |d: &ObjectDistance| d.vergence_per_m().unwrap_or(f64::INFINITY);
        rank(a).total_cmp(&rank(b))
    });
    if distances.len() > 1 && distances.contains(&ObjectDistance::Unknown) {
        return Err(Error::new(
            "depth_m",
            "is left out for some observations and given for others",
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
    settings: &FitSettings,
    frame: Frame,
    axis: Option<AxisFit>,
    groups: &[Group],
    fits: &[PlaneFit],
    mut rejected: Vec<Rejection>,
) -> Fit {
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
    let mut said = Vec::new();
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
            rounds: fit.rounds,
            converged: fit.converged,
            least_variance_px2: least,
        });
        if least < 0.0 {
            said.push(format!(
                "channel {name} at {}: the fit predicts a variance of {least:.3} px² somewhere in the frame; it is drawn as if it were the least a kernel can have",
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
        },
    };
    said.extend(remarks::on_depth(&lens));
    Fit {
        lens,
        planes,
        rejected,
        axis,
        remarks: said,
    }
}

impl FitSettings {
    fn describe(&self) -> String {
        let weighting = match self.weighting {
            Weighting::Weighted => "weighted",
            Weighting::Unweighted => "unweighted",
        };
        let axis = match self.axis {
            AxisChoice::AsObserved => "axis as observed".to_owned(),
            AxisChoice::At(p) => format!("axis at ({}, {})", p.x_px, p.y_px),
            AxisChoice::Free => "axis free".to_owned(),
        };
        let support = match self.support {
            Support::Auto => "pixels above the noise",
            Support::AllPixels => "all pixels",
        };
        format!("moments, {weighting}, {axis}, {support}")
    }
}

#[cfg(test)]
mod tests;
