//! Faults that the blocks of a photograph of a chart show together: values that are no light, sharpening, motion, two lenses, and
//! residuals that no PSF explains.

use seidel_optics::numeric::{median, scatter};

use super::block_estimate::BlockEstimate;
use super::{ChartMeasurement, MeasuredBlock};
use crate::checks::direction::{self, Blur};
use crate::checks::two_lenses::{self, Width};
use crate::checks::{Concern, Severity};
use crate::photograph::{Photograph, SampleErrors};

/// Blocks that the checks need.
const MIN_BLOCKS: usize = 6;
/// Multiple of its own error from which on a fault is beyond doubt.
const MIN_SIGMAS: f64 = 6.0;
/// Bend of the values against the light, over their range, from which on they are not linear in light. Linear simulated charts have up
/// to 0.0004, those of gamma 2.2 have 0.1.
const MAX_CURVATURE: f64 = 0.02;
/// Depth of a dark ring around the core of the PSFs, over their peak, from which on a photograph was sharpened. Raw simulated charts
/// have at most 0.0001, an unsharp mask of 0.8 at 1 px on a blur of 1.6 px has 0.0033.
const MIN_RING: f64 = 0.003;
/// Residuals beyond the noise over the step from dark to bright from which on the tiles are less exact, and from which on useless. Linear
/// simulated charts have 0.006 to 0.014.
const DOUBTFUL_MISFIT: f64 = 0.03;
const WRONG_MISFIT: f64 = 0.06;

/// Returns the bend of the values against the light, if it is beyond doubt.
pub(super) fn bend(estimates: &[&BlockEstimate]) -> Option<f64> {
    let mut bends: Vec<f64> = estimates.iter().map(|e| e.curvature).collect();
    let sigma = 1.25 * scatter(&bends) / (bends.len().max(1) as f64).sqrt();
    let middle = median(&mut bends);
    let is_bent = middle.abs() > MAX_CURVATURE.max(MIN_SIGMAS * sigma);
    (bends.len() >= MIN_BLOCKS && is_bent).then_some(middle)
}

/// Returns whether the values of `photo` are not linear in light.
fn not_linear(photo: &Photograph, estimates: &[&BlockEstimate]) -> Option<Concern> {
    let bend = bend(estimates)?;
    Some(Concern::new(
        Severity::Refuse,
        &photo.name,
        format!(
            "is not linear in light: values between black and white are {:.0} % of the range too {}",
            100.0 * bend.abs(),
            if bend > 0.0 { "high" } else { "low" }
        ),
        "give the raw file, or state the transfer function of the picture",
    ))
}

/// Returns whether dark rings surround the cores of the PSFs.
fn sharpened(photo: &Photograph, estimates: &[&BlockEstimate], side: usize) -> Option<Concern> {
    if estimates.len() < MIN_BLOCKS {
        return None;
    }
    let half = (side / 2) as f64;
    let rings = side / 2;
    let profiles: Vec<Vec<f64>> = (estimates.iter())
        .map(|estimate| {
            let peak = estimate.unbounded.iter().copied().fold(0.0, f64::max);
            let (mut sums, mut counts) = (vec![0.0; rings], vec![0.0; rings]);
            for (k, value) in estimate.unbounded.iter().enumerate() {
                let (x, y) = ((k % side) as f64 - half, (k / side) as f64 - half);
                let ring = x.hypot(y).round() as usize;
                if ring < rings {
                    sums[ring] += value / peak;
                    counts[ring] += 1.0;
                }
            }
            sums.iter().zip(&counts).map(|(s, c)| s / c).collect()
        })
        .collect();
    let depths = (1..rings).map(|ring| {
        let mut own: Vec<f64> = profiles.iter().map(|p| p[ring]).collect();
        let sigma = 1.25 * scatter(&own) / (own.len() as f64).sqrt();
        (-median(&mut own), sigma, ring)
    });
    let (depth, sigma, ring) = depths.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (depth > MIN_RING.max(MIN_SIGMAS * sigma)).then(|| {
        Concern::new(
            Severity::Refuse,
            &photo.name,
            format!(
                "was sharpened or enlarged: a dark ring of {:.1} % of the peak surrounds the PSFs, {ring} px away",
                100.0 * depth
            ),
            "give the raw file, or develop it at its own size without sharpening",
        )
    })
}

/// Returns whether the residuals of the blocks are far beyond the noise.
fn misfit(photo: &Photograph, estimates: &[&BlockEstimate]) -> Option<Concern> {
    let share = median(&mut estimates.iter().map(|e| e.misfit).collect::<Vec<f64>>());
    let chi_square = median(&mut estimates.iter().map(|e| e.chi_square).collect::<Vec<f64>>());
    // Rounded samples of a development depart by as much.
    let allowed = photo.errors.relative;
    let severity = match share {
        _ if share > WRONG_MISFIT + allowed => Severity::Refuse,
        _ if share > DOUBTFUL_MISFIT + allowed => Severity::Widen(share),
        _ => return None,
    };
    Some(Concern::new(
        severity,
        &photo.name,
        format!(
            "differs from every blur of the chart by {:.1} % of the step from dark to bright beyond the noise ({:.1} times the noise): no lens does that",
            100.0 * share,
            chi_square.sqrt()
        ),
        "photograph raw, the chart flat and still; check that the picture given is the one photographed",
    ))
}

/// Returns the faults that the blocks of `photo` show; `estimates` are those of its reference channel.
pub(super) fn of_photograph(
    photo: &Photograph,
    estimates: &[&BlockEstimate],
    blocks: &[MeasuredBlock],
    side: usize,
) -> Vec<Concern> {
    let is_developed = photo.errors.relative >= SampleErrors::DEVELOPED.relative;
    let bent = not_linear(photo, estimates).filter(|_| !is_developed);
    let processed = bent.or_else(|| sharpened(photo, estimates, side));
    let all = processed.or_else(|| misfit(photo, estimates));
    all.into_iter().chain(moved(photo, blocks)).collect()
}

/// Returns whether all blocks are longer along one direction of the frame.
fn moved(photo: &Photograph, blocks: &[MeasuredBlock]) -> Option<Concern> {
    let of = |channel: usize| -> Vec<Blur> {
        let each = blocks.iter().map(|block| Blur {
            at: block.centroid(channel),
            covariance: block.covariance(channel),
        });
        each.collect()
    };
    let by_channel: Vec<Vec<Blur>> = (0..photo.channels.len()).map(of).collect();
    direction::check(photo, "blocks", &by_channel)
}

/// Returns the faults that photographs at one distance show together.
pub(super) fn of_pairs(
    photographs: &[Photograph],
    measurements: &[ChartMeasurement],
) -> Vec<Concern> {
    let of = |(photo, measurement): (&Photograph, &ChartMeasurement)| -> Vec<Width> {
        let channel = photo.reference_channel();
        let each = measurement.blocks.iter().map(|block| {
            let [xx, _, yy] = block.covariance(channel);
            Width {
                at: block.centroid(channel),
                normal: [0.0; 2],
                variance_px2: (xx + yy) / 2.0,
            }
        });
        each.collect()
    };
    let widths: Vec<Vec<Width>> = photographs.iter().zip(measurements).map(of).collect();
    two_lenses::check_all(photographs, &widths, "blocks")
}
