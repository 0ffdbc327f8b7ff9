//! From observations to a lens profile: `--model moments`, the paper's own fit.
//!
//! Moments of every tile ([`measure`]) -> S1..S10 per channel and object distance by linear least
//! squares ([`plane`]) -> centroid displacement ([`displacement`]) -> [`LensProfile`]. The optical
//! axis is found on request ([`axis`]).

pub mod axis;
pub mod displacement;
pub mod linear;
pub mod measure;
pub mod plane;

use rayon::prelude::*;

use crate::distance::ObjectDistance;
use crate::error::{Error, Result};
use crate::field::{Frame, ImagePoint};
use crate::lens::DepthLaw;
use crate::moments::support::Support;
use crate::observations::ObservationSet;
use crate::profile::{LensProfile, MomentsChannel, MomentsPlane, Provenance};
use axis::AxisFit;
use measure::{MeasuredTile, measure};
use plane::{PlaneFit, fit_plane};

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

/// A tile that took no part in a fit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rejection {
    /// Index of the observation set among those given.
    pub set: usize,
    /// Index of the observation in its set.
    pub observation: usize,
    /// The observation's file.
    pub file: String,
    /// Channel name.
    pub channel: String,
    /// Why, in words.
    pub reason: String,
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
    let mut remarks = Vec::new();
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
            remarks.push(format!(
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
        channels,
        provenance: Provenance {
            program: concat!("seidel ", env!("CARGO_PKG_VERSION")).to_owned(),
            sources: Vec::new(),
            settings: settings.describe(),
        },
    };
    remarks.extend(depth_remarks(&lens));
    Fit {
        lens,
        planes,
        rejected,
        axis,
        remarks,
    }
}

/// What the object distances at hand allow to be known across depth; channels of which the same is to
/// be said share a remark.
fn depth_remarks(lens: &LensProfile) -> Vec<String> {
    let Ok(laws) = lens.depth_laws() else {
        return Vec::new();
    };
    let mut by_text: Vec<(String, Vec<&str>)> = Vec::new();
    for (channel, law) in lens.channels.iter().zip(laws) {
        for text in depth_remark(channel, law.as_ref()) {
            match by_text.iter_mut().find(|(known, _)| *known == text) {
                Some((_, names)) => names.push(&channel.name),
                None => by_text.push((text, vec![&channel.name])),
            }
        }
    }
    by_text
        .into_iter()
        .map(|(text, names)| format!("{}: {text}", names.join(", ")))
        .collect()
}

fn depth_remark(channel: &MomentsChannel, law: Option<&DepthLaw>) -> Vec<String> {
    let Some(law) = law else {
        return vec![
            "the object distance is unknown, so the blur is the same at every depth".to_owned(),
        ];
    };
    let mut remarks = Vec::new();
    let missing = law.undetermined();
    if channel.planes.len() == 1 {
        remarks.push(
            "one object distance, so the blur is the same at every depth; three or more tell how it changes"
                .to_owned(),
        );
    } else if !missing.is_empty() {
        let names: Vec<String> = missing.iter().map(|k| format!("S{k}")).collect();
        remarks.push(format!(
            "two object distances leave the full dependence on depth of {} open; a third would settle it",
            names.join(", ")
        ));
    }
    if law.aberrations_change() {
        remarks.push(
            "aberrations change with object distance, so S1..S10 are quadratic in 1/distance instead of the degrees of a constant lens"
                .to_owned(),
        );
    }
    remarks
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
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::lens::{MomentCoefficients, ReducedNumbers};
    use crate::moments::pixels::PIXEL_VARIANCE_PX2;
    use crate::observations::Observation;
    use crate::psf::{LocalBlur, MirroredPair, PsfModel, Window};
    use crate::tile::Tile;

    const TRUTH: ReducedNumbers = ReducedNumbers {
        alpha: 7.0,
        beta: 0.5,
        gamma: 0.9,
        delta: -0.8,
        phi: 0.6,
    };

    /// Tiles of a mirrored pair, whose seven moments are those of the lens, on a grid over the frame.
    fn planted(axis: ImagePoint, distance: ObjectDistance) -> ObservationSet {
        let frame = Frame::new(900, 600, Some(axis)).expect("valid");
        let s = TRUTH.coefficients();
        let mut observations = Vec::new();
        for row in 0..6 {
            for column in 0..8 {
                let ideal = ImagePoint::new(
                    60.0 + 112.3 * f64::from(column),
                    40.0 + 104.7 * f64::from(row),
                );
                let at = frame.field_point(ideal);
                let stretch = 1.0 + 2e-3 - 3e-3 * at.radius().powi(2);
                let centroid = frame.image_point(crate::field::FieldPoint::new(
                    at.x * stretch,
                    at.y * stretch,
                ));
                let size = 61;
                let centre =
                    ImagePoint::new(centroid.x_px.round() + 0.5, centroid.y_px.round() + 0.5);
                let window = Window::of_tile(
                    size,
                    size,
                    centroid.x_px - centre.x_px + size as f64 / 2.0,
                    centroid.y_px - centre.y_px + size as f64 / 2.0,
                );
                let blur = LocalBlur {
                    moments: s.moments(at).with_added_variance(PIXEL_VARIANCE_PX2),
                    meridian: at.meridian(),
                };
                let mut samples = vec![0.0; window.len()];
                MirroredPair.sample(&blur, &window, &mut samples);
                observations.push(Observation {
                    file: format!("psf/{row}{column}.exr"),
                    centre,
                    distance,
                    ideal: Some(ideal),
                    tiles: vec![
                        Tile::new(size, size, samples.iter().map(|&v| v as f32).collect())
                            .expect("valid"),
                    ],
                    noise_sigma: vec![None],
                    background: vec![0.0],
                    saturated: false,
                });
            }
        }
        ObservationSet {
            frame,
            axis_stated: true,
            pixel_pitch_um: Some(5.0),
            channels: vec!["Y".into()],
            camera: Camera::default(),
            observations,
        }
    }

    fn assert_close(got: &MomentCoefficients, relative: f64) {
        let want = TRUTH.coefficients();
        let distance = got.distance(&want, 1.0);
        assert!(distance < relative, "{distance}: {got:?} not {want:?}");
    }

    #[test]
    fn a_planted_lens_is_found_with_either_weighting() {
        let centre = ImagePoint::new(450.0, 300.0);
        let set = planted(centre, ObjectDistance::Metres(2.0));
        for weighting in [Weighting::Weighted, Weighting::Unweighted] {
            let settings = FitSettings {
                weighting,
                ..FitSettings::default()
            };
            let fit = fit_moments(std::slice::from_ref(&set), &settings).expect("fits");
            let plane = &fit.lens.channels[0].planes[0];
            assert_close(&plane.s, 1e-3);
            let moved = plane.displacement.expect("ideal positions are known");
            assert!((moved.magnification - 2e-3).abs() < 1e-6, "{moved:?}");
            assert!((moved.distortion + 3e-3).abs() < 1e-6, "{moved:?}");
            assert!(fit.rejected.is_empty() && fit.planes[0].converged);
            assert!(fit.planes[0].second_residual < 1e-3);
        }
    }

    #[test]
    fn the_axis_is_found_when_free() {
        let off = ImagePoint::new(462.0, 291.0);
        let mut set = planted(off, ObjectDistance::Infinity);
        set.frame = set
            .frame
            .with_axis(ImagePoint::new(450.0, 300.0))
            .expect("valid");
        let settings = FitSettings {
            axis: AxisChoice::Free,
            ..FitSettings::default()
        };
        let fit = fit_moments(&[set], &settings).expect("fits");
        let found = fit.axis.expect("asked for");
        assert!(found.converged, "{found:?}");
        assert!((found.axis.x_px - 462.0).abs() < 0.5, "{found:?}");
        assert!((found.axis.y_px - 291.0).abs() < 0.5, "{found:?}");
    }

    #[test]
    fn outliers_and_saturated_tiles_are_rejected_and_named() {
        let mut set = planted(ImagePoint::new(450.0, 300.0), ObjectDistance::Metres(2.0));
        set.observations[5].saturated = true;
        let tile = &set.observations[9].tiles[0];
        let mut samples = tile.samples().to_vec();
        samples[200] += 0.3;
        set.observations[9].tiles[0] = Tile::new(61, 61, samples).expect("valid");
        let fit = fit_moments(&[set], &FitSettings::default()).expect("fits");
        let named: Vec<usize> = fit.rejected.iter().map(|r| r.observation).collect();
        assert_eq!(named, [5, 9]);
        assert!(fit.rejected[0].reason.contains("saturated"));
        assert!(fit.rejected[1].reason.contains("residual"));
        assert_close(&fit.lens.channels[0].planes[0].s, 1e-3);
    }

    #[test]
    fn sets_that_do_not_belong_together_are_refused() {
        let centre = ImagePoint::new(450.0, 300.0);
        let near = planted(centre, ObjectDistance::Metres(2.0));
        let mut other = planted(centre, ObjectDistance::Metres(4.0));
        other.channels = vec!["R".into()];
        let error = fit_moments(&[near.clone(), other], &FitSettings::default())
            .expect_err("channels differ");
        assert!(error.place.contains("channels"), "{error}");
        let mut mixed = near.clone();
        mixed.observations[3].distance = ObjectDistance::Unknown;
        let error = fit_moments(&[mixed], &FitSettings::default()).expect_err("mixed distances");
        assert!(error.place.contains("depth_m"), "{error}");
        let mut few = near;
        few.observations.truncate(2);
        assert!(fit_moments(&[few], &FitSettings::default()).is_err());
        assert!(fit_moments(&[], &FitSettings::default()).is_err());
    }

    #[test]
    fn one_distance_is_said_to_tell_nothing_of_depth() {
        let set = planted(ImagePoint::new(450.0, 300.0), ObjectDistance::Metres(2.0));
        let fit = fit_moments(&[set], &FitSettings::default()).expect("fits");
        assert!(
            fit.remarks
                .iter()
                .any(|r| r.contains("one object distance")),
            "{:?}",
            fit.remarks
        );
    }
}
