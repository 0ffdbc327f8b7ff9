//! What a depth check can find, in numbers and in words.

use std::fmt;

use super::super::DepthConvention;

/// How sure a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// The evidence leaves little doubt: the blur would be wrong.
    Warning,
    /// Unusual, but it can be meant.
    Note,
}

/// One thing found in a depth pass.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthFinding {
    /// What it is, with its evidence.
    pub problem: DepthProblem,
    /// How sure it is.
    pub severity: Severity,
    /// What the user can do.
    pub remedy: String,
}

/// What can be wrong with a depth pass, and the evidence for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DepthProblem {
    /// Distances are along the ray from the camera, not along its axis.
    AlongRay {
        /// Patches that are planes only so.
        patches: usize,
        /// Patches that are planes as the pass is read.
        against: usize,
        /// Half the field of view across the picture's width, degrees, with which they are planes.
        half_field_deg: f64,
        /// Distance along the ray over distance along the axis in the farthest corner, less one.
        corner_error: f64,
    },
    /// Values are read upside down: inverse depth or disparity as distance, or distance as inverse.
    Inverted {
        /// Patches that are planes only so.
        patches: usize,
        /// Patches that are planes as the pass is read.
        against: usize,
        /// Whether distances are along the ray besides.
        along_ray: bool,
    },
    /// Distances lie where no scene is.
    ImplausibleRange {
        /// Nearest distance but for 2 % of pixels, metres.
        near_m: f64,
        /// Farthest distance but for 2 % of pixels, metres.
        far_m: f64,
    },
    /// Every distance lies far from those at which the lens was measured.
    OffTheLens {
        /// Nearest distance but for 2 % of pixels, metres.
        near_m: f64,
        /// Farthest distance but for 2 % of pixels, metres.
        far_m: f64,
        /// Nearest and farthest distance at which the lens was measured, metres.
        measured_m: (f64, f64),
    },
    /// Numbers from 0 to 1 read as metres.
    Normalised {
        /// Smallest number.
        least: f64,
        /// Largest number.
        largest: f64,
    },
    /// Depth was multiplied by alpha, or averaged with a background of zero.
    Premultiplied {
        /// Pixels on edges that were looked at.
        pixels: usize,
        /// Share of them whose depth is that of the surface times its coverage.
        share: f64,
    },
    /// Depth has as few levels as 8 bits hold, and surfaces climb them as steps.
    Quantised {
        /// Levels in the whole pass.
        levels: usize,
    },
    /// One depth in every pixel that has any.
    Constant {
        /// The number.
        value: f64,
    },
    /// No pixel, or next to none, has a distance.
    Empty {
        /// Share of pixels that have one.
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
                "distances seem to be along the ray, not along the axis: {patches} patches are planes only so (half field {half_field_deg:.1} degrees), {against} as it is read; in the corner that is {:.1} % too far",
                100.0 * corner_error
            ),
            Self::Inverted {
                patches,
                against,
                along_ray,
            } => write!(
                f,
                "values seem to be one over what they are read as{}: {patches} patches are planes only so, {against} as it is read",
                if along_ray { ", along the ray" } else { "" }
            ),
            Self::ImplausibleRange { near_m, far_m } => write!(
                f,
                "distances from {near_m:.4} m to {far_m:.4} m are hardly a scene: is the unit right?"
            ),
            Self::OffTheLens {
                near_m,
                far_m,
                measured_m: (near, far),
            } => write!(
                f,
                "everything lies between {near_m:.4} m and {far_m:.4} m, the lens was measured from {near:.4} m to {far:.4} m; is the unit right?"
            ),
            Self::Normalised { least, largest } => write!(
                f,
                "numbers fill 0 to 1 ({least:.4} to {largest:.4}) and seem normalised, but are read as metres"
            ),
            Self::Premultiplied { pixels, share } => write!(
                f,
                "depth seems multiplied by coverage, or smoothed against zero: on {:.0} % of {pixels} edge pixels it is a part of the surface's",
                100.0 * share
            ),
            Self::Quantised { levels } => write!(
                f,
                "has only {levels} levels, which surfaces climb in steps, as a pass of 8 bits does: blur will show them"
            ),
            Self::Constant { value } => write!(f, "is {value} in every pixel that has a depth"),
            Self::Empty { share } => write!(
                f,
                "is nearly empty: {:.3} % of pixels have a distance",
                100.0 * share
            ),
        }
    }
}

impl fmt::Display for DepthFinding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; {}", self.problem, self.remedy)
    }
}

/// What to do about distances along the ray.
pub(super) fn along_ray_remedy(focal_px: f64) -> String {
    format!(
        "give --along-ray with the camera's focal length in pixels of the plate (some {focal_px:.0}), or render depth along its axis"
    )
}

/// What to do about values that are one over what they are read as.
pub(super) fn inversion_remedy(convention: DepthConvention) -> &'static str {
    match convention {
        DepthConvention::Distance { .. } => {
            "give --depth-kind inverse, with --depth-unit where one over metres is not the unit; disparity or estimated depth must be turned into distance first"
        }
        DepthConvention::Inverse { .. } => "give --depth-kind distance",
        DepthConvention::FarOne { .. } | DepthConvention::FarZero { .. } => {
            "the pass is linear in one over the distance between near and far, as z-buffers are: turn it into distance first"
        }
    }
}
