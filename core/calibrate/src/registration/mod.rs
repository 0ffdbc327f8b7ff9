//! Registration of two pictures of one scene: the similarity transform that takes one to the other.
//!
//! Phase correlation of reduced pictures finds the shift to a few pixels, at each scale that the sizes of the pictures
//! suggest. Normalised cross-correlation of blocks at full size refines it, and a robust fit over the blocks gives shift,
//! scale and rotation.

mod block_matching;
mod phase_correlation;
mod picture;
mod resample;
mod similarity;

pub use picture::Picture;
pub use similarity::{Freedom, PointPair, Similarity};

pub(crate) use resample::Planes;

use phase_correlation::peak;
use seidel_optics::error::{Error, ErrorKind, Result};
use seidel_optics::numeric::median;

/// Longest side of the pictures in the first search, px.
const COARSE_SIDE: usize = 480;
/// Height of the correlation peak, in root mean squares, below which pictures have nothing in common. Pictures of
/// different noise stay below 7.
const LEAST_SIGNIFICANCE: f64 = 9.0;
/// Relative difference of scales that count as one.
const SAME_SCALE: f64 = 2e-3;
/// Ratio of the median residuals of a similarity transform and of a shift below which the transform has a scale and a rotation.
const WORTHWHILE_RATIO: f64 = 0.5;
/// Least number of blocks that must match.
const LEAST_BLOCKS: usize = 4;

/// The registration of two pictures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Registration {
    /// The transform from pixels of the first picture to pixels of the second.
    pub transform: Similarity,
    /// Median distance of a matched block from its place by the transform, px.
    pub residual_px: f64,
    /// Number of matched blocks.
    pub blocks: usize,
}

/// Registers `from` to `to`. The pictures may differ in size and sharpness; `to` shows a part of the scene in `from`, or
/// the reverse.
///
/// # Errors
/// [`ErrorKind::InsufficientData`] for pictures without common detail.
pub fn register(from: &Picture, to: &Picture) -> Result<Registration> {
    let nothing_in_common = |problem: String| {
        Err(Error::new(
            "pictures",
            problem,
            "give two pictures of one scene at about one scale, each with fine detail",
        )
        .with_kind(ErrorKind::InsufficientData))
    };
    let longest = [from.width, from.height, to.width, to.height]
        .into_iter()
        .max()
        .unwrap_or(1);
    let factor = longest.div_ceil(COARSE_SIDE).max(1);
    let small_to = to.reduced(factor);
    let found = scales(from, to).into_iter().map(|scale| {
        let scaled = if scale == 1.0 {
            from.clone()
        } else {
            from.scaled(scale)
        };
        let peak = peak(&scaled.reduced(factor), &small_to);
        (scale, scaled, peak)
    });
    let best = found.max_by(|a, b| a.2.significance.total_cmp(&b.2.significance));
    let Some((scale, scaled, peak)) = best.filter(|b| b.2.significance >= LEAST_SIGNIFICANCE)
    else {
        return nothing_in_common("show no common detail at any shift".to_owned());
    };
    let shift = peak.shift_px.map(|s| s * factor as isize);
    let pairs = block_matching::matches(&scaled.smoothed(), &to.smoothed(), shift, factor + 3);
    let fitted = simplest_fit(&pairs);
    let Some(fitted) = fitted.filter(|_| pairs.len() >= LEAST_BLOCKS) else {
        return nothing_in_common(format!(
            "show common detail in {} places only, near a shift of ({}, {}) px at scale {scale:.3}",
            pairs.len(),
            shift[0],
            shift[1]
        ));
    };
    let mut residuals: Vec<f64> = pairs.iter().map(|p| fitted.residual(p)).collect();
    Ok(Registration {
        transform: Similarity {
            a: fitted.a * scale,
            b: fitted.b * scale,
            ..fitted
        },
        residual_px: median(&mut residuals),
        blocks: pairs.len(),
    })
}

/// Fits a shift to `pairs`, or a similarity transform if that lowers the median residual markedly: errors of a few hundredths of a
/// pixel are no change of scale.
fn simplest_fit(pairs: &[PointPair]) -> Option<Similarity> {
    let of = |freedom| {
        let fitted = Similarity::fit(pairs, freedom)?;
        let mut residuals: Vec<f64> = pairs.iter().map(|p| fitted.residual(p)).collect();
        Some((fitted, median(&mut residuals)))
    };
    let (shift, left) = of(Freedom::Shift)?;
    let (similarity, least) = of(Freedom::Similarity)?;
    Some(if least < WORTHWHILE_RATIO * left {
        similarity
    } else {
        shift
    })
}

/// Returns the scales that the sizes of the pictures suggest, 1 first.
fn scales(from: &Picture, to: &Picture) -> Vec<f64> {
    let mut scales = vec![1.0];
    for (own, other) in [(from.width, to.width), (from.height, to.height)] {
        let scale = other as f64 / own as f64;
        if scales.iter().all(|s| (s / scale - 1.0).abs() > SAME_SCALE) {
            scales.push(scale);
        }
    }
    scales
}

#[cfg(test)]
mod tests;
