//! Fit of S1..S10 of one channel at one object distance (Eqs 18-24).

use crate::least_squares;
use crate::measure::MeasuredTile;
use seidel_optics::error::{Error, Result};
use seidel_optics::field::{FieldPoint, Frame};
use seidel_optics::lens::MomentCoefficients;
use seidel_optics::numeric::median;
use seidel_optics::psf::LEAST_VARIANCE_PX2;

/// Weights of the residuals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Weighting {
    /// Iteratively reweighted least squares with outlier rejection. Weights are relative to each PSF's size
    /// and noise, and rotation-invariant. Small PSFs near focus keep their influence.
    #[default]
    Weighted,
    /// Equal weights and no rejection, as in the paper.
    Unweighted,
}

/// The fitted coefficients of one channel at one object distance.
#[derive(Debug, Clone)]
pub struct PlaneFit<'a> {
    /// S1..S10: optical moments in px to their order, field in half frame widths.
    pub s: MomentCoefficients,
    /// Standard errors of S1..S10.
    pub s_sigma: [f64; 10],
    /// Tiles fitted.
    pub used: Vec<&'a MeasuredTile>,
    /// Rejected tiles, with reasons.
    pub rejected: Vec<(&'a MeasuredTile, String)>,
    /// Root mean square residual of second moments, relative to size².
    pub second_residual: f64,
    /// Root mean square residual of third moments, relative to size³.
    pub third_residual: f64,
    /// Model error of second and third moments, relative to size² and size³, used in the last weights. Zero
    /// if unweighted.
    pub misfit: [f64; 2],
    /// Iterations of reweighting and rejection.
    pub iterations: usize,
    /// Whether the last iteration found no outlier and changed the model error by at most 1 %.
    pub converged: bool,
}

/// Multiplicity of each moment in its symmetric tensor. These weights make a sum of squares
/// rotation-invariant.
const TENSOR_WEIGHT: [f64; 7] = [1.0, 2.0, 1.0, 1.0, 3.0, 3.0, 1.0];
/// Order of each of the seven moments.
const ORDER: [i32; 7] = [2, 2, 2, 3, 3, 3, 3];
/// Residual, in units of the typical one, above which a tile is rejected. No tile of the real sets tried
/// exceeds it by chance.
const REJECTION_LIMIT: f64 = 8.0;
const MAX_ITERATIONS: usize = 12;
/// Weight of a realisability constraint relative to the largest weight: practically exact.
const CONSTRAINT_WEIGHT: f64 = 1e3;
/// Maximum number of constraints. Each removes the worst remaining violation; two or three suffice.
const MAX_CONSTRAINTS: usize = 24;
/// Number of field radii at which variances are checked.
const FIELD_STEPS: u32 = 60;
/// Minimum number of tiles: each gives three second and four third moments for five unknowns each.
const MIN_TILES: usize = 3;

/// Fits S1..S10 to `tiles` of one channel at one distance.
///
/// # Errors
/// Fewer than three usable tiles, or positions that do not determine S1..S10.
pub fn fit_plane<'a>(
    frame: &Frame,
    tiles: &[&'a MeasuredTile],
    weighting: Weighting,
) -> Result<PlaneFit<'a>> {
    let mut used: Vec<&MeasuredTile> = tiles.to_vec();
    let mut rejected: Vec<(&MeasuredTile, String)> = Vec::new();
    // Model error relative to PSF size, of second and third moments, updated in every iteration.
    let mut misfit = [0.0, 0.0];
    let mut iterations = 0;
    loop {
        iterations += 1;
        if used.len() < MIN_TILES {
            return Err(Error::new(
                "observations",
                format!("{} usable tiles, {} rejected", used.len(), rejected.len()),
                format!("S1..S10 need at least {MIN_TILES} at different field positions"),
            )
            .with_kind(seidel_optics::ErrorKind::InsufficientData));
        }
        let (s, s_sigma) = solve(frame, &used, weighting, misfit)?;
        let residuals: Vec<[f64; 7]> = used
            .iter()
            .map(|t| relative_residual(frame, t, &s))
            .collect();
        let rms = |orders: std::ops::Range<usize>| {
            let sum: f64 = residuals
                .iter()
                .flat_map(|r| r[orders.clone()].iter().map(|x| x * x))
                .sum();
            (sum / (residuals.len() * orders.len()) as f64).sqrt()
        };
        let done = |converged, misfit| PlaneFit {
            s,
            s_sigma,
            used: used.clone(),
            rejected: rejected.clone(),
            second_residual: rms(0..3),
            third_residual: rms(3..7),
            misfit,
            iterations,
            converged,
        };
        if weighting == Weighting::Unweighted {
            return Ok(done(true, misfit));
        }
        let found = typical_misfit(&used, &residuals);
        let outliers = outliers(&used, &residuals, found);
        let settled = iterations > 1
            && (0..2).all(|k| (found[k] - misfit[k]).abs() <= 0.01 * found[k].max(1e-12));
        let finished = outliers.is_empty() && settled;
        if finished || iterations == MAX_ITERATIONS {
            return Ok(done(finished, misfit));
        }
        misfit = found;
        for (index, reason) in outliers.into_iter().rev() {
            rejected.push((used.remove(index), reason));
        }
    }
}

fn solve(
    frame: &Frame,
    tiles: &[&MeasuredTile],
    weighting: Weighting,
    misfit: [f64; 2],
) -> Result<(MomentCoefficients, [f64; 10])> {
    let mut s = [0.0; 10];
    let mut s_sigma = [0.0; 10];
    // Second and third moments share no coefficient, so they are solved separately.
    for (moments, unknowns, kind) in [(0..3, 0..5, 0), (3..7, 5..10, 1)] {
        let (mut rows, mut targets, mut weights) = (Vec::new(), Vec::new(), Vec::new());
        for tile in tiles {
            let basis = MomentCoefficients::basis(tile.field_point(frame));
            let measured = tile.optical.to_array();
            for m in moments.clone() {
                rows.push(basis[m][unknowns.clone()].to_vec());
                targets.push(measured[m]);
                weights.push(match weighting {
                    Weighting::Unweighted => 1.0,
                    Weighting::Weighted => {
                        TENSOR_WEIGHT[m].sqrt() / uncertainty(tile, m, misfit[kind])
                    }
                });
            }
        }
        let mut fit = least_squares::solve(&rows, &targets, &weights)?;
        if weighting == Weighting::Weighted && kind == 0 {
            let heavy = weights.iter().copied().fold(0.0, f64::max) * CONSTRAINT_WEIGHT;
            for _ in 0..MAX_CONSTRAINTS {
                let found = MomentCoefficients(second_only(&fit.values));
                let Some(row) = violated(frame, &found) else {
                    break;
                };
                rows.push(row);
                targets.push(LEAST_VARIANCE_PX2);
                weights.push(heavy);
                fit = least_squares::solve(&rows, &targets, &weights)?;
            }
        }
        s[unknowns.clone()].copy_from_slice(&fit.values);
        s_sigma[unknowns].copy_from_slice(&fit.sigma);
    }
    Ok((MomentCoefficients(s), s_sigma))
}

fn second_only(values: &[f64]) -> [f64; 10] {
    std::array::from_fn(|k| values.get(k).copied().unwrap_or(0.0))
}

/// Returns the constraint row for the most negative meridional or sagittal variance that `s` predicts inside
/// the frame, if any. The constraint sets this variance to the least that can be drawn.
fn violated(frame: &Frame, s: &MomentCoefficients) -> Option<Vec<f64>> {
    let edge = frame.corner_radius();
    let mut worst = (-1e-9 * s.meridional(0.5 * edge).mu20.abs(), None);
    for step in 0..=FIELD_STEPS {
        let h = edge * f64::from(step) / f64::from(FIELD_STEPS);
        let m = s.meridional(h);
        for (variance, moment) in [(m.mu20, 0), (m.mu02, 2)] {
            if variance < worst.0 {
                worst = (variance, Some((h, moment)));
            }
        }
    }
    worst.1.map(|(h, moment)| {
        MomentCoefficients::basis(FieldPoint::new(h, 0.0))[moment][0..5].to_vec()
    })
}

/// Returns the weighted residuals of all moments after refitting S1..S10 for `frame`, with the tiles and
/// weights of `fit`.
///
/// # Errors
/// Positions that do not determine S1..S10.
pub(super) fn projected_residuals(
    frame: &Frame,
    fit: &PlaneFit,
    weighting: Weighting,
) -> Result<Vec<f64>> {
    let (s, _) = solve(frame, &fit.used, weighting, fit.misfit)?;
    let mut all = Vec::with_capacity(7 * fit.used.len());
    for tile in &fit.used {
        let residual = relative_residual(frame, tile, &s);
        for (m, residual) in residual.into_iter().enumerate() {
            let size = tile.size_px().powi(ORDER[m]);
            all.push(match weighting {
                // Orders have different units: third moments are divided by the size.
                Weighting::Unweighted => residual * size / tile.size_px().powi(ORDER[m] - 2),
                Weighting::Weighted => {
                    let kind = usize::from(m >= 3);
                    residual * size * TENSOR_WEIGHT[m].sqrt()
                        / uncertainty(tile, m, fit.misfit[kind])
                }
            });
        }
    }
    Ok(all)
}

/// Returns the expected standard deviation of moment `m`: noise and model error in quadrature.
fn uncertainty(tile: &MeasuredTile, m: usize, misfit: f64) -> f64 {
    let scale = tile.size_px().powi(ORDER[m]);
    // Before the first estimate of the model error all PSFs count in proportion to their size.
    let misfit = if misfit > 0.0 { misfit } else { 1.0 };
    (misfit * scale).hypot(tile.noise[m])
}

fn relative_residual(frame: &Frame, tile: &MeasuredTile, s: &MomentCoefficients) -> [f64; 7] {
    let model = s.moments(tile.field_point(frame)).to_array();
    let measured = tile.optical.to_array();
    std::array::from_fn(|m| (measured[m] - model[m]) / tile.size_px().powi(ORDER[m]))
}

/// Returns the root mean square of a tile's relative residuals of second (`0..3`) or third (`3..7`) moments,
/// and the same of the noise.
fn tile_rms(
    tile: &MeasuredTile,
    residual: &[f64; 7],
    moments: std::ops::Range<usize>,
) -> (f64, f64) {
    let count = moments.len() as f64;
    let size = tile.size_px();
    let (mut square, mut noise) = (0.0, 0.0);
    for m in moments {
        square += residual[m] * residual[m];
        noise += (tile.noise[m] / size.powi(ORDER[m])).powi(2);
    }
    ((square / count).sqrt(), (noise / count).sqrt())
}

/// Returns the median over tiles of the model error beyond noise.
fn typical_misfit(tiles: &[&MeasuredTile], residuals: &[[f64; 7]]) -> [f64; 2] {
    [0..3, 3..7].map(|moments| {
        let mut beyond: Vec<f64> = tiles
            .iter()
            .zip(residuals)
            .map(|(tile, residual)| {
                let (rms, noise) = tile_rms(tile, residual, moments.clone());
                rms * rms - noise * noise
            })
            .collect();
        // The floor keeps weights finite where the model fits exactly.
        median(&mut beyond).max(0.0).sqrt().max(1e-6)
    })
}

fn outliers(
    tiles: &[&MeasuredTile],
    residuals: &[[f64; 7]],
    misfit: [f64; 2],
) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for (index, (tile, residual)) in tiles.iter().zip(residuals).enumerate() {
        for (moments, kind, name) in [(0..3, 0, "second"), (3..7, 1, "third")] {
            let (rms, noise) = tile_rms(tile, residual, moments);
            let expected = misfit[kind].hypot(noise);
            if rms > REJECTION_LIMIT * expected && rms > 1e-4 {
                found.push((
                    index,
                    format!(
                        "its {name} moments deviate from the fit by {:.1} times the typical residual",
                        rms / expected
                    ),
                ));
                break;
            }
        }
    }
    found
}
