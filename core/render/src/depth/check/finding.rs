//! The findings of a depth check, as values and as messages.

use std::fmt;

use super::super::DepthConvention;
use super::picture::DepthPlace;

/// The certainty of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// Strong evidence that the blur would be wrong.
    Warning,
    /// Unusual, but possibly intended.
    Note,
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Warning => "is doubtful",
            Self::Note => "may be intended",
        })
    }
}

/// A finding in a depth pass.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthFinding {
    /// The problem and its evidence.
    pub problem: DepthProblem,
    /// Its certainty.
    pub severity: Severity,
    /// A remedy.
    pub remedy: String,
}

/// A problem of a depth pass, with the evidence for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DepthProblem {
    /// Distances run along the ray from the camera, not along its axis.
    AlongRay {
        /// Patches that are planar only in this reading.
        patches: usize,
        /// Patches that are planar in the stated reading.
        against: usize,
        /// Half the horizontal field of view that makes them planar, degrees.
        half_field_deg: f64,
        /// Distance along the ray over distance along the axis in the farthest corner, minus one.
        corner_error: f64,
    },
    /// Values have the inverse convention: inverse depth or disparity is read as distance, or the reverse.
    Inverted {
        /// Patches that are planar only in this reading.
        patches: usize,
        /// Patches that are planar in the stated reading.
        against: usize,
        /// Whether distances also run along the ray.
        along_ray: bool,
    },
    /// Distances are implausible for any scene.
    ImplausibleRange {
        /// Nearest distance without the nearest 2 % of pixels, metres.
        near_m: f64,
        /// Farthest distance without the farthest 2 % of pixels, metres.
        far_m: f64,
    },
    /// All distances are far from those at which the lens was measured.
    OffTheLens {
        /// Nearest distance without the nearest 2 % of pixels, metres.
        near_m: f64,
        /// Farthest distance without the farthest 2 % of pixels, metres.
        far_m: f64,
        /// Nearest and farthest distance at which the lens was measured, metres.
        measured_m: (f64, f64),
    },
    /// Numbers from 0 to 1 are read as metres.
    Normalised {
        /// Smallest number.
        least: f64,
        /// Largest number.
        largest: f64,
    },
    /// Depth equals a colour of the plate in every pixel.
    Colour,
    /// Depth is multiplied by alpha, or filtered against a background of zero.
    Premultiplied {
        /// Edge pixels examined.
        pixels: usize,
        /// Share of them whose depth is the surface's depth times its coverage.
        share: f64,
    },
    /// Depth is averaged at edges, by a filter or over the motion of a shutter.
    Averaged {
        /// Edges examined, along rows and columns.
        edges: usize,
        /// Share of them that are averages of both sides.
        share: f64,
        /// Their median width, px.
        width_px: usize,
    },
    /// Edges of depth lie on those of the picture in another place only.
    Misplaced {
        /// That place.
        place: DepthPlace,
        /// Edge pixels of depth examined.
        edges: usize,
        /// Mean rank of the picture's gradient over them as stated, 0 to 1: 1/2 by chance.
        stated: f64,
        /// The same in that place.
        best: f64,
    },
    /// Depth has at most 256 levels, and surfaces show them as steps.
    Quantised {
        /// Distinct values in the pass.
        levels: usize,
    },
    /// All pixels with a depth have the same one.
    Constant {
        /// The value.
        value: f64,
    },
    /// Almost no pixel has a distance.
    Empty {
        /// Share of pixels that have a distance.
        share: f64,
    },
}

impl fmt::Display for DepthProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::AlongRay {
                patches,
                against,
                half_field_deg,
                corner_error,
            } => write!(
                f,
                "distances seem to run along the ray, not along the axis: {patches} patches are planar only then (half field {half_field_deg:.1} degrees), {against} as stated; in the corner distances are {:.1} % too far",
                100.0 * corner_error
            ),
            Self::Inverted {
                patches,
                against,
                along_ray,
            } => write!(
                f,
                "values seem to be the reciprocal of what they are read as{}: {patches} patches are planar only then, {against} as stated",
                if along_ray { ", along the ray" } else { "" }
            ),
            Self::ImplausibleRange { near_m, far_m } => write!(
                f,
                "distances of {} are implausible for a scene: is the unit right?",
                distance_span(near_m, far_m)
            ),
            Self::OffTheLens {
                near_m,
                far_m,
                measured_m: (near, far),
            } => write!(
                f,
                "the scene is at {}, but the lens was measured at {}: is the unit right?",
                distance_span(near_m, far_m),
                distance_span(near, far)
            ),
            Self::Normalised { least, largest } => write!(
                f,
                "numbers fill 0 to 1 ({least:.4} to {largest:.4}) and seem normalised, but are read as metres"
            ),
            Self::Colour => write!(f, "equals a colour of the plate in every pixel"),
            Self::Premultiplied { pixels, share } => write!(
                f,
                "depth seems multiplied by coverage, or filtered against zero: on {:.0} % of {pixels} edge pixels it is a fraction of the surface's depth",
                100.0 * share
            ),
            Self::Averaged {
                edges,
                share,
                width_px,
            } => write!(
                f,
                "depth seems averaged at edges, by a filter or over a motion: {:.0} % of {edges} edges are even ramps between both sides, {width_px} px wide",
                100.0 * share
            ),
            Self::Misplaced {
                place,
                edges,
                stated,
                best,
            } => write!(
                f,
                "its edges lie on those of the picture only {place}: there {edges} edge pixels rank {:.0} of 100 by the picture's gradient, as they are {:.0}",
                100.0 * best,
                100.0 * stated
            ),
            Self::Quantised { levels } => write!(
                f,
                "has only {levels} levels, as an 8-bit pass does, and surfaces show them as steps: so will the blur"
            ),
            Self::Constant { value } => write!(
                f,
                "is constant: {} in every pixel that has a depth",
                significant(value)
            ),
            Self::Empty { share } => write!(
                f,
                "is nearly empty: only {:.3} % of pixels have a distance",
                100.0 * share
            ),
        }
    }
}

/// Returns a range of distances in words, such as `1.2 m to infinity`.
pub(crate) fn distance_span(near_m: f64, far_m: f64) -> String {
    let metres = |distance: f64| {
        if distance.is_infinite() {
            "infinity".to_owned()
        } else {
            let rounded: f64 = format!("{distance:.3e}").parse().unwrap_or(distance);
            format!("{rounded} m")
        }
    };
    let (near, far) = (metres(near_m), metres(far_m));
    if near == far {
        near
    } else {
        format!("{near} to {far}")
    }
}

/// Returns `value` with as many digits as a float sample holds.
fn significant(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}

impl fmt::Display for DepthFinding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; {}", self.problem, self.remedy)
    }
}

/// Returns the remedy for distances along the ray.
pub(super) fn along_ray_remedy(focal_px: f64) -> String {
    format!(
        "state that distances are along the ray, with the camera's focal length in pixels of the plate (about {focal_px:.0}), or render depth along its axis"
    )
}

/// Returns the remedy for values of the inverse convention.
pub(super) fn inversion_remedy(convention: DepthConvention) -> &'static str {
    match convention {
        DepthConvention::Distance { .. } => {
            "state the depth kind inverse, with the depth unit unless it is 1/m; convert disparity or estimated depth to distance first"
        }
        DepthConvention::Inverse { .. } => "state the depth kind distance",
        DepthConvention::FarOne { .. } | DepthConvention::FarZero { .. } => {
            "the pass is linear in 1/distance between near and far, as z-buffers are: convert it to distance first"
        }
    }
}
