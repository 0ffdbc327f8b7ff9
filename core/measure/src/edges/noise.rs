//! Noise of pixels from the even parts beside edges: photon transfer.

use nalgebra::{DMatrix, DVector};

use super::line_fit::{EdgePixel, LineFit};
use super::profile::EdgeNoise;
use crate::checks::noise_correlation::NoiseCorrelation;
use crate::photograph::Photograph;
use seidel_optics::numeric::median;

/// Distance from the edge at which its blur has ended, widths.
const BEYOND_WIDTHS: f64 = 3.0;
/// Pixels that a plateau needs, and plateaus that a gain needs.
const MIN_PIXELS: usize = 10;
const MIN_PLATEAUS: usize = 12;
/// Tolerance of the distance of neighbours, shares of it.
const SAME_DISTANCE: f64 = 0.05;
/// Threshold of outliers, standard deviations, and the number of iterations.
const CLIP_SIGMAS: f64 = 4.0;
const ITERATIONS: usize = 12;

/// A side of an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Dark,
    Bright,
}

impl Side {
    pub(super) const BOTH: [Self; 2] = [Self::Dark, Self::Bright];
}

/// The even part on one side of an edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Plateau {
    channel: usize,
    /// Mean level, counts.
    level: f64,
    /// Variance of its pixels, counts².
    variance: f64,
    /// Degrees of freedom of the variance.
    freedom: f64,
    /// Sums of products of residuals of pixels so far apart, and their numbers: neighbours of one colour, and twice as far.
    pairs: [Pairs; 2],
}

/// Products of the residuals of pairs of pixels.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Pairs {
    sum: f64,
    /// Sum of the covariances of the plane at both pixels, over the variance of one.
    follows: f64,
    count: f64,
}

/// Returns the plateau on one side of an edge; `None` where it has too few pixels.
pub(super) fn plateau(
    channel: usize,
    pixels: &[EdgePixel],
    line: &LineFit,
    on: Side,
    pitch: f64,
) -> Option<Plateau> {
    let side = pixels.iter().filter(|pixel| {
        let t = line.distance(pixel);
        (t > 0.0) == (on == Side::Bright) && t.abs() > BEYOND_WIDTHS * line.sigma
    });
    let side: Vec<&EdgePixel> = side.collect();
    if side.len() < MIN_PIXELS {
        return None;
    }
    // A plane of its own, as the line fit knows the light only as well as a Gaussian describes the blur.
    let count = side.len() as f64;
    let rows = DMatrix::from_fn(side.len(), 3, |r, c| [1.0, side[r].s, side[r].t][c]);
    let values = DVector::from_fn(side.len(), |r, _| side[r].value);
    let plane = rows.clone().svd(true, true).solve(&values, 1e-12).ok()?;
    let variance_of_plane = (rows.transpose() * &rows).try_inverse();
    let variance_of_plane = variance_of_plane.unwrap_or_else(|| DMatrix::zeros(3, 3));
    let residuals = &values - &rows * plane;
    let mut pairs = [Pairs::default(); 2];
    for (k, a) in side.iter().enumerate() {
        for (j, b) in side.iter().enumerate().skip(k + 1) {
            let apart = (a.s - b.s).hypot(a.t - b.t) / pitch;
            for (times, pairs) in pairs.iter_mut().enumerate() {
                if (apart - times as f64 - 1.0).abs() < SAME_DISTANCE {
                    pairs.sum += residuals[k] * residuals[j];
                    // The plane follows the noise: that of pixels which do not correlate has this correlation about it.
                    pairs.follows +=
                        (rows.row(k) * &variance_of_plane * rows.row(j).transpose())[0];
                    pairs.count += 1.0;
                }
            }
        }
    }
    let square = residuals.norm_squared();
    let freedom = count - 3.0;
    Some(Plateau {
        channel,
        level: values.sum() / count,
        variance: square / freedom,
        freedom,
        pairs,
    })
}

/// Returns the correlation of the noise of neighbours in `channel`, over all `plateaus`; `None` without enough of them.
pub(super) fn correlation(plateaus: &[Plateau], channel: usize) -> Option<NoiseCorrelation> {
    let own = plateaus.iter().filter(|p| p.channel == channel);
    let own: Vec<&Plateau> = own.filter(|p| p.variance > 0.0).collect();
    // Of each plateau its own correlation, so that a few with structure do not outweigh the others.
    let typical = |times: usize| {
        let each = own.iter().filter(|p| p.pairs[times].count > 0.0);
        let mut each: Vec<f64> = each
            .map(|p| {
                let pairs = p.pairs[times];
                (pairs.sum / p.variance + pairs.follows) / pairs.count
            })
            .collect();
        (each.len() >= MIN_PLATEAUS).then(|| median(&mut each))
    };
    Some(NoiseCorrelation {
        neighbours: typical(0)?,
        second: typical(1)?,
        far: 0.0,
    })
}

/// Noise of all channels.
pub(super) struct Noises {
    channels: Vec<EdgeNoise>,
    /// Counts per electron, if known.
    pub(super) gain: Option<f64>,
}

impl Noises {
    pub(super) fn of(&self, channel: usize) -> EdgeNoise {
        self.channels[channel]
    }
}

/// Estimates the noise of the channels of `photo` from `plateaus`. Raw channels share their gain, as one amplifier reads them.
pub(super) fn estimate(photo: &Photograph, plateaus: &[Plateau]) -> Noises {
    let least = photo.errors.quantum.powi(2) / 12.0;
    let all: Vec<&Plateau> = plateaus.iter().collect();
    let joint = transfer(&all, photo.gain, least);
    let channels = (0..photo.channels.len()).map(|channel| {
        if photo.mosaic.is_some() {
            return joint;
        }
        let own: Vec<&Plateau> = all
            .iter()
            .filter(|p| p.channel == channel)
            .copied()
            .collect();
        transfer(&own, photo.gain, least)
    });
    Noises {
        channels: channels.collect(),
        gain: photo
            .gain
            .or((photo.mosaic.is_some() && joint.gain > 0.0).then_some(joint.gain)),
    }
}

/// Fits variance = dark + gain x level, with the stated gain if there is one.
fn transfer(plateaus: &[&Plateau], gain: Option<f64>, least: f64) -> EdgeNoise {
    if plateaus.is_empty() {
        return EdgeNoise {
            dark: least.max(1e-12),
            gain: gain.unwrap_or(0.0),
        };
    }
    let mut variances: Vec<f64> = plateaus.iter().map(|p| p.variance).collect();
    let typical = median(&mut variances).max(least).max(1e-12);
    let mut noise = EdgeNoise {
        dark: typical,
        gain: 0.0,
    };
    if plateaus.len() < MIN_PLATEAUS {
        return noise;
    }
    for _ in 0..ITERATIONS {
        let mut sums = [0.0; 5];
        for p in plateaus {
            let expected = noise.variance(p.level).max(least);
            // Standard deviation of a variance of so many pixels.
            let sigma = expected * (2.0 / p.freedom).sqrt();
            if (p.variance - expected).abs() > CLIP_SIGMAS * sigma.max(0.25 * expected) {
                continue;
            }
            let (weight, level) = (1.0 / (sigma * sigma), p.level.max(0.0));
            sums[0] += weight;
            sums[1] += weight * level;
            sums[2] += weight * level * level;
            sums[3] += weight * p.variance;
            sums[4] += weight * p.variance * level;
        }
        let [w, x, xx, y, xy] = sums;
        let determinant = w * xx - x * x;
        let mut now = EdgeNoise {
            dark: (xx * y - x * xy) / determinant,
            gain: (w * xy - x * y) / determinant,
        };
        if let Some(gain) = gain {
            now = EdgeNoise {
                dark: (y - gain * x) / w,
                gain,
            };
        } else if !(now.gain > 0.0 && now.gain.is_finite()) {
            now = EdgeNoise {
                dark: y / w,
                gain: 0.0,
            };
        } else if now.dark < least {
            now = EdgeNoise {
                dark: least,
                // Negative where even parts have no noise at all, not even that of rounding.
                gain: ((xy - least * x) / xx).max(0.0),
            };
        }
        if !(now.dark.is_finite() && now.gain.is_finite()) {
            break;
        }
        noise = EdgeNoise {
            dark: now.dark.max(least).max(1e-12),
            ..now
        };
    }
    noise
}
