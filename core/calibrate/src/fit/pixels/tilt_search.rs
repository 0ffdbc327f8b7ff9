//! A search for a tilted sensor by the sizes of tiles, for fits to start from.

use nalgebra::{DMatrix, DVector};

use super::defocus_starts::{defocus_alone, disc_radius};
use crate::fit::initial::InitialEstimate;
use crate::measure::MeasuredTile;
use seidel_optics::field::{FieldPoint, Frame};

/// Directions, and sizes relative to the largest disc, of the tilts at which searches start.
const TILT_DIRECTIONS: usize = 12;
const TILT_SIZES: [f64; 3] = [0.5, 1.0, 2.0];
/// Defocus at the middle of the frame and over the range of vergence there, relative to the largest disc.
const TILT_OFFSETS: [f64; 3] = [-0.5, 0.0, 0.5];
/// Steps of such a search, and the most that it returns.
const TILT_STEPS: usize = 30;
const MAX_TILTED: usize = 4;
/// Difference, relative to the tilt, below which two of them count as one.
const SAME_TILT: f64 = 0.1;

/// Defocus of a lens before a tilted sensor.
#[derive(Debug, Clone, Copy)]
pub(super) struct TiltedDefocus {
    /// Defocus on the axis and field curvature.
    pub(super) estimate: InitialEstimate,
    /// Change of defocus over half a frame width along x and y, px.
    pub(super) tilt: [f64; 2],
}

/// Returns the tilts that describe the sizes of `tiles` best, the best first.
///
/// Sizes tell the amount of defocus without its sign. Each search alternates between the signs that the present tilt gives and the
/// tilt that the signed sizes give, from many starts.
pub(super) fn tilted(frame: &Frame, tiles: &[&MeasuredTile]) -> Vec<TiltedDefocus> {
    let sized: Vec<SizedPlace> = (tiles.iter())
        .map(|tile| SizedPlace {
            at: tile.field_point(frame),
            vergence: tile.distance.vergence_per_m().unwrap_or(0.0),
            radius: disc_radius(tile),
        })
        .collect();
    let largest = sized.iter().map(|s| s.radius).fold(0.0, f64::max);
    let Some(search) = TiltSearch::new(&sized) else {
        return Vec::new();
    };
    let mut found: Vec<(f64, DVector<f64>)> = Vec::new();
    for start in search.starts(largest) {
        let (misfit, terms) = search.settle(start);
        let is_new = |(_, other): &(f64, DVector<f64>)| {
            (other - &terms).norm() > SAME_TILT * terms.norm()
                && (other + &terms).norm() > SAME_TILT * terms.norm()
        };
        if misfit.is_finite() && found.iter().all(is_new) {
            found.push((misfit, terms));
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.truncate(MAX_TILTED);
    found
        .into_iter()
        .map(|(_, terms)| search.unscaled(&terms))
        .collect()
}

/// A tile as the search sees it.
struct SizedPlace {
    at: FieldPoint,
    vergence: f64,
    radius: f64,
}

/// The search for a tilt: signed sizes are linear in its terms.
struct TiltSearch {
    /// Middle and half the range of vergence, 1/m.
    vergence: (f64, f64),
    /// One row a tile: 1, scaled vergence, x, y, squared field radius.
    basis: DMatrix<f64>,
    inverse: DMatrix<f64>,
    radii: DVector<f64>,
}

impl TiltSearch {
    /// Returns `None` where the places do not determine a tilt.
    fn new(sized: &[SizedPlace]) -> Option<Self> {
        let vergences = || sized.iter().map(|s| s.vergence);
        let (low, high) = (
            vergences().fold(f64::INFINITY, f64::min),
            vergences().fold(f64::NEG_INFINITY, f64::max),
        );
        let vergence = ((low + high) / 2.0, (high - low) / 2.0);
        // A single distance has no slope.
        let scaled = |v: f64| {
            if high > low {
                (v - vergence.0) / vergence.1
            } else {
                0.0
            }
        };
        let rows: Vec<f64> = (sized.iter())
            .flat_map(|s| {
                let FieldPoint { x, y } = s.at;
                [1.0, scaled(s.vergence), x, y, x * x + y * y]
            })
            .collect();
        let basis = DMatrix::from_row_slice(sized.len(), 5, &rows);
        let inverse = basis.clone().pseudo_inverse(1e-9).ok()?;
        Some(Self {
            vergence,
            basis,
            inverse,
            radii: DVector::from_iterator(sized.len(), sized.iter().map(|s| s.radius)),
        })
    }

    /// Returns the terms at which searches start.
    fn starts(&self, largest: f64) -> Vec<DVector<f64>> {
        let mut starts = Vec::new();
        for direction in 0..TILT_DIRECTIONS {
            let angle = std::f64::consts::TAU * direction as f64 / TILT_DIRECTIONS as f64;
            for size in TILT_SIZES {
                let (y, x) = angle.sin_cos();
                for middle in TILT_OFFSETS {
                    for slope in TILT_OFFSETS {
                        let tilt = [size * x, size * y];
                        let terms = [middle, slope, tilt[0], tilt[1], 0.0];
                        starts.push(DVector::from_row_slice(&terms) * largest);
                    }
                }
            }
        }
        starts
    }

    /// Returns the terms to which the search from `start` leads, with the mean squared misfit of sizes.
    fn settle(&self, start: DVector<f64>) -> (f64, DVector<f64>) {
        let mut terms = start;
        for _ in 0..TILT_STEPS {
            let defocus = &self.basis * &terms;
            let signed = defocus.zip_map(&self.radii, |d, radius| radius.copysign(d));
            let next = &self.inverse * signed;
            let is_settled = (&next - &terms).norm() <= 1e-9 * next.norm();
            terms = next;
            if is_settled {
                break;
            }
        }
        let defocus = &self.basis * &terms;
        let missed = defocus.zip_map(&self.radii, |d, radius| (d.abs() - radius).powi(2));
        (missed.mean(), terms)
    }

    /// Returns `terms` with the sign of the pupil for which defocus rises with vergence.
    fn unscaled(&self, terms: &DVector<f64>) -> TiltedDefocus {
        let (middle, half) = self.vergence;
        let sign = if terms[1] < 0.0 { -1.0 } else { 1.0 };
        let slope = if half > 0.0 {
            sign * terms[1] / half
        } else {
            0.0
        };
        TiltedDefocus {
            estimate: InitialEstimate {
                delta: sign * terms[4],
                ..defocus_alone([sign * terms[0] - slope * middle, slope])
            },
            tilt: [sign * terms[2], sign * terms[3]],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tilt_is_found_from_sizes_alone() {
        let mut sized = Vec::new();
        for vergence in [0.0, 0.5] {
            for (column, row) in (0..7).flat_map(|c| (0..5).map(move |r| (c, r))) {
                let at = FieldPoint::new(column as f64 / 3.0 - 1.0, row as f64 / 3.0 - 0.66);
                let defocus = -9.0 + 30.0 * vergence + 4.0 * at.x - 31.0 * at.y;
                sized.push(SizedPlace {
                    at,
                    vergence,
                    radius: f64::abs(defocus),
                });
            }
        }
        let search = TiltSearch::new(&sized).expect("places all over the field");
        let settled = search
            .starts(30.0)
            .into_iter()
            .map(|start| search.settle(start));
        let (misfit, terms) = settled.min_by(|a, b| a.0.total_cmp(&b.0)).expect("starts");
        assert!(misfit < 1e-9, "{misfit}");
        let found = search.unscaled(&terms);
        for (got, want) in [
            (found.tilt[0], 4.0),
            (found.tilt[1], -31.0),
            (found.estimate.alpha[0], -9.0),
            (found.estimate.alpha[1], 30.0),
            (found.estimate.delta, 0.0),
        ] {
            assert!((got - want).abs() < 1e-6, "{got} {want}");
        }
    }
}
