//! Centroid displacement: magnification and distortion per channel, whose differences are lateral colour.

use crate::least_squares;
use crate::measure::MeasuredTile;
use seidel_optics::field::{FieldPoint, Frame};
use seidel_optics::numeric::{dot, median};
use seidel_optics::profile::RadialDisplacement;

/// Passes of the reweighted least squares. Errors beyond this many medians, and at least this many half frame widths (0.001 px
/// of a common frame), lose weight.
const REWEIGHTED_PASSES: usize = 4;
const OUTLIER_MEDIANS: f64 = 4.0;
const MIN_OUTLIER: f64 = 1e-6;

/// The terms of a displacement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DisplacementTerms {
    /// X (magnification + distortion |X|²): complete to third order for a lens that is rotationally symmetric. Coma and
    /// magnification give the first term, distortion the second (docs/background/model.md section 3).
    Radial,
    /// Also x, x³ and x y² along x, and y³ along y: complete to third order for a lens with two planes of symmetry.
    TwoPlanes,
    /// Also a shift along x and y, and decentring distortion: X (X.k) and |X|² b with k and b along x and y (Brown,
    /// Photogrammetric Engineering 32, 1966).
    Decentred,
}

/// Coefficients of a displacement, half frame widths, in the order of its terms.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedDisplacement {
    /// The coefficients.
    pub values: Vec<f64>,
    /// Their standard errors.
    pub sigma: Vec<f64>,
}

impl DisplacementTerms {
    /// Number of the terms.
    pub const fn count(self) -> usize {
        match self {
            Self::Radial => 2,
            Self::TwoPlanes => 6,
            Self::Decentred => 8,
        }
    }

    /// Returns the displacement along x and along y by each term at `at`.
    fn at(self, at: FieldPoint) -> [Vec<f64>; 2] {
        let FieldPoint { x, y, .. } = at;
        let r2 = x * x + y * y;
        let mut along = [vec![x, x * r2], vec![y, y * r2]];
        match self {
            Self::Radial => {}
            Self::TwoPlanes => {
                along[0].extend([x, x * x * x, x * y * y, 0.0]);
                along[1].extend([0.0, 0.0, 0.0, y * y * y]);
            }
            Self::Decentred => {
                along[0].extend([1.0, 0.0, x * x, x * y, r2, 0.0]);
                along[1].extend([0.0, 1.0, x * y, y * y, 0.0, r2]);
            }
        }
        along
    }

    /// Fits centroid - origin by linear least squares.
    ///
    /// Uses the tiles with a known origin; returns `None` for fewer than three, or fewer than the terms.
    pub fn fit(self, frame: &Frame, tiles: &[&MeasuredTile]) -> Option<FittedDisplacement> {
        let (mut rows, mut targets) = (Vec::new(), Vec::new());
        for tile in tiles {
            let Some(origin) = tile.origin else { continue };
            let origin = frame.field_point(origin);
            let centroid = frame.field_point(tile.centroid);
            rows.extend(self.at(origin));
            targets.extend([centroid.x - origin.x, centroid.y - origin.y]);
        }
        if rows.len() / 2 < self.count().max(3) {
            return None;
        }
        // Reweighted least squares with Huber's weights: a PSF in focus may have its centroid far off.
        let mut fit = least_squares::solve(&rows, &targets, &vec![1.0; rows.len()]).ok()?;
        for _ in 0..REWEIGHTED_PASSES {
            let errors: Vec<f64> = (rows.iter().zip(&targets))
                .map(|(row, target)| (target - dot(row, &fit.values)).abs())
                .collect();
            let limit = OUTLIER_MEDIANS * median(&mut errors.clone()) + MIN_OUTLIER;
            let weights: Vec<f64> = (errors.iter())
                .map(|error| (limit / error.max(limit)).sqrt())
                .collect();
            fit = least_squares::solve(&rows, &targets, &weights).ok()?;
        }
        Some(FittedDisplacement {
            values: fit.values,
            sigma: fit.sigma,
        })
    }
}

/// Fits centroid - origin = X (magnification + distortion |X|²) by linear least squares.
///
/// Uses the tiles with a known origin; returns `None` for fewer than three.
pub fn fit_displacement(frame: &Frame, tiles: &[&MeasuredTile]) -> Option<RadialDisplacement> {
    let fit = DisplacementTerms::Radial.fit(frame, tiles)?;
    Some(RadialDisplacement {
        magnification: fit.values[0],
        distortion: fit.values[1],
        magnification_sigma: fit.sigma[0],
        distortion_sigma: fit.sigma[1],
    })
}
