//! The depth of a scene: windows at nearly one distance are compared there, and others are left out.

use std::collections::BTreeMap;

use seidel_optics::distance::ObjectDistance;
use seidel_optics::error::{Error, Result};
use seidel_optics::field::Frame;
use seidel_optics::lens::VergenceSeries;
use seidel_optics::profile::PupilChannel;

use super::PairImage;
use super::placement;
use crate::registration::Similarity;

/// Change of the blur within a window up to which its depth is one, px.
const MAX_BLUR_CHANGE_PX: f64 = 0.5;
/// Change of the blur up to which windows count as at the same distance, px.
const SAME_BLUR_PX: f64 = 0.1;

/// Object vergence of the pixels of the frame, 1/m; NaN where unknown.
pub(super) struct DepthPlane {
    width: usize,
    vergence: Vec<f32>,
    /// Vergences that change the blur by one pixel.
    per_px: f64,
}

impl DepthPlane {
    /// Places `vergence`, one value for each pixel of `sharp`, in `frame`.
    ///
    /// # Errors
    /// Another number of values, and one that is negative or not finite.
    pub(super) fn new(
        channels: &[PupilChannel],
        frame: &Frame,
        sharp: &PairImage<'_>,
        vergence: &[f32],
        transform: &Similarity,
    ) -> Result<Self> {
        let is_wrong = |v: &f32| !(v.is_finite() && *v >= 0.0);
        if vergence.len() != sharp.width * sharp.height || vergence.iter().any(is_wrong) {
            return Err(Error::new(
                "depth",
                format!(
                    "has not one distance for each of the {} x {} px of the sharp picture",
                    sharp.width, sharp.height
                ),
                "render the depth pass with the sharp picture",
            ));
        }
        let (least, most) = (vergence.iter().copied())
            .map(f64::from)
            .fold((f64::INFINITY, 0.0_f64), |(least, most), v| {
                (least.min(v), most.max(v))
            });
        let planes = [vergence.to_vec()];
        let picture = PairImage {
            planes: &planes,
            quantisation: None,
            ..*sharp
        };
        let mut placed = placement::planes_in_frame(frame, &picture, transform, None);
        let blur = |alpha: &VergenceSeries| {
            let [near, far] = [most, least].map(|v| alpha.at(v));
            (near - far).abs()
        };
        let most_px = channels.iter().map(|c| blur(&c.alpha)).fold(0.0, f64::max);
        Ok(Self {
            width: frame.width_px() as usize,
            vergence: placed.swap_remove(0),
            per_px: (most - least) / most_px.max(1e-9),
        })
    }

    /// Returns the vergence of a square; `None` where it is not nearly the same all over.
    pub(super) fn of_square(&self, [left, top]: [usize; 2], side: usize) -> Option<f64> {
        let (mut least, mut most, mut sum) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
        for row in top..top + side {
            for v in &self.vergence[row * self.width + left..][..side] {
                let v = f64::from(*v);
                if !v.is_finite() {
                    return None;
                }
                (least, most, sum) = (least.min(v), most.max(v), sum + v);
            }
        }
        let is_one = most - least <= MAX_BLUR_CHANGE_PX * self.per_px;
        is_one.then(|| (sum / (side * side) as f64).max(0.0))
    }

    /// Returns the values for a renderer; unknown ones are at infinity.
    pub(super) fn rendered(&self) -> Vec<f32> {
        let known = |v: &f32| if v.is_finite() { v.max(0.0) } else { 0.0 };
        self.vergence.iter().map(known).collect()
    }

    /// Returns the vergences by which windows at `vergences` are compared: those of nearly the same blur have one.
    pub(super) fn levels(&self, vergences: &[f64]) -> Vec<f64> {
        let step = (SAME_BLUR_PX * self.per_px).max(1e-6);
        let level = |v: f64| (v / step).round() as i64;
        let mut sums: BTreeMap<i64, (f64, f64)> = BTreeMap::new();
        for v in vergences {
            let sum = sums.entry(level(*v)).or_default();
            *sum = (sum.0 + v, sum.1 + 1.0);
        }
        let mean = |v: &f64| {
            let (sum, count) = sums[&level(*v)];
            sum / count
        };
        vergences.iter().map(mean).collect()
    }
}

/// Returns the distance of that vergence.
pub(super) fn distance(vergence: f64) -> ObjectDistance {
    ObjectDistance::metres(1.0 / vergence).unwrap_or(ObjectDistance::Infinity)
}

#[cfg(test)]
mod tests;
