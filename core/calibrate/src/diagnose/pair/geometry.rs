//! Registration of a pair by the offsets of its windows, and the positions that the plate gives its PSFs.

use nalgebra::{DMatrix, DVector};

use super::lens_view::{LensView, Positions};
use super::offsets::WindowOffset;
use crate::registration::{Similarity, median};

/// Windows from which scale and rotation are fitted too.
const LEAST_WINDOWS: usize = 8;
/// Smallest shift that counts as one, px, and in standard errors.
const LEAST_SHIFT_PX: f64 = 0.05;
const SHIFT_SIGMAS: f64 = 4.0;
/// Smallest movement at the edge of the frame by scale or rotation that counts, px, and in standard errors.
const LEAST_STRETCH_PX: f64 = 0.15;
const STRETCH_SIGMAS: f64 = 5.0;
/// Median offset below which all PSFs lie on their source pixels, px.
const ON_SOURCE_PX: f64 = 0.1;
/// Largest median offset that a change of shape alone causes, px.
const APPARENT_PX: f64 = 0.5;
/// Ratio of the offsets without and with the lens's displacement that tells an undistorted plate from a distorted one.
const DISTINCT_RATIO: f64 = 0.7;
/// Iterations of reweighting, and the residual in medians from which a window loses weight.
const ITERATIONS: usize = 6;
const OUTLIER_RATIO: f64 = 3.0;
const LEAST_RESIDUAL_PX: f64 = 0.02;

/// The geometry of a pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Geometry {
    pub(super) positions: Positions,
    /// From pixels of the sharp picture to ideal positions in the frame of the lens.
    pub(super) registration: Similarity,
    /// Movements that the registration takes away, px: shift (x, y), and at the edge of the frame.
    pub(super) shift_px: [f64; 2],
    pub(super) stretch_px: [f64; 2],
}

impl Geometry {
    /// Returns a remark on a registration that moves anything.
    pub(super) fn remark(&self) -> Option<String> {
        let [x, y] = self.shift_px;
        let [out, around] = self.stretch_px;
        let mut found = Vec::new();
        if x != 0.0 || y != 0.0 {
            found.push(format!("a shift of ({x:.2}, {y:.2}) px"));
        }
        if out != 0.0 || around != 0.0 {
            found.push(format!(
                "a scale and rotation that move the edge of the frame by {out:.2} px outwards and {around:.2} px around"
            ));
        }
        (!found.is_empty()).then(|| {
            format!(
                "registration: the plate has {} against the sharp picture, taken off before the comparison",
                found.join(", and ")
            )
        })
    }
}

/// Decides the geometry from `offsets`, measured with `view` as for an undistorted plate.
pub(super) fn decide(
    view: &LensView<'_>,
    offsets: &[WindowOffset],
    wanted: Option<Positions>,
) -> Geometry {
    let by_lens: Vec<[f64; 2]> = offsets
        .iter()
        .map(|o| view.mean_displacement(view.registration.apply(o.at)))
        .collect();
    let as_lens: Vec<WindowOffset> = offsets
        .iter()
        .zip(&by_lens)
        .map(|(o, d)| WindowOffset {
            offset_px: [o.offset_px[0] - d[0], o.offset_px[1] - d[1]],
            ..*o
        })
        .collect();
    let positions = wanted.unwrap_or_else(|| {
        let (undistorted, distorted) = (scatter(offsets), scatter(&as_lens));
        let is_undistorted = undistorted < ON_SOURCE_PX
            || undistorted < DISTINCT_RATIO * distorted
            || (undistorted <= distorted && undistorted < APPARENT_PX);
        if is_undistorted {
            Positions::Undistorted
        } else {
            Positions::Lens
        }
    });
    let moves = match positions {
        Positions::Undistorted => offsets,
        Positions::Lens => &as_lens,
    };
    registered(view, moves, positions)
}

/// Returns the median distance of offsets from their median.
fn scatter(offsets: &[WindowOffset]) -> f64 {
    let along = |axis: usize| -> Vec<f64> { offsets.iter().map(|o| o.offset_px[axis]).collect() };
    let (x, y) = (median(&along(0)), median(&along(1)));
    let distances: Vec<f64> = offsets
        .iter()
        .map(|o| (o.offset_px[0] - x).hypot(o.offset_px[1] - y))
        .collect();
    median(&distances)
}

/// Fits shift, scale and rotation, with a cubic radial term that protects the scale from distortion; keeps what is
/// significant.
fn registered(view: &LensView<'_>, moves: &[WindowOffset], positions: Positions) -> Geometry {
    let mut geometry = Geometry {
        positions,
        registration: view.registration,
        shift_px: [0.0; 2],
        stretch_px: [0.0; 2],
    };
    let whole = moves.len() >= LEAST_WINDOWS;
    let Some(mut fit) = Fit::new(view, moves, if whole { 5 } else { 2 }) else {
        return geometry;
    };
    if whole {
        let is_real = |k: usize| {
            fit.values[k].abs() > LEAST_STRETCH_PX
                && fit.values[k].abs() > STRETCH_SIGMAS * fit.sigma[k]
        };
        if is_real(2) || is_real(3) {
            geometry.stretch_px = [fit.values[2], fit.values[3]];
        } else if let Some(shift) = Fit::new(view, moves, 2) {
            fit = shift;
        }
    }
    let size = fit.values[0].hypot(fit.values[1]);
    if size > LEAST_SHIFT_PX && size > SHIFT_SIGMAS * fit.sigma[0].max(fit.sigma[1]) {
        geometry.shift_px = [fit.values[0], fit.values[1]];
    }
    let half = view.frame.half_width_px();
    let (scale, turn) = (geometry.stretch_px[0] / half, geometry.stretch_px[1] / half);
    let axis = view.frame.axis();
    let (cx, cy) = (axis.x_px, axis.y_px);
    let before = view.registration;
    // The movements follow the transform so far, which is near the identity.
    let [tx, ty] = before.shift_px;
    geometry.registration = Similarity {
        a: before.a + scale,
        b: before.b + turn,
        shift_px: [
            tx + geometry.shift_px[0] - scale * cx + turn * cy,
            ty + geometry.shift_px[1] - turn * cx - scale * cy,
        ],
    };
    geometry
}

/// A robust fit of movements: shift x and y, outwards, around, and outwards in the cube of the field; the last three at
/// the edge of the frame.
struct Fit {
    values: DVector<f64>,
    sigma: Vec<f64>,
}

impl Fit {
    /// Fits the first `size` movements; `None` if they are not determined.
    fn new(view: &LensView<'_>, moves: &[WindowOffset], size: usize) -> Option<Self> {
        let rows = 2 * moves.len();
        if rows <= size {
            return None;
        }
        let design = DMatrix::from_fn(rows, size, |row, column| {
            let at = view.frame.field_point(moves[row / 2].at);
            let square = at.x * at.x + at.y * at.y;
            let terms = if row % 2 == 0 {
                [1.0, 0.0, at.x, -at.y, at.x * square]
            } else {
                [0.0, 1.0, at.y, at.x, at.y * square]
            };
            terms[column]
        });
        let right = DVector::from_fn(rows, |row, _| moves[row / 2].offset_px[row % 2]);
        let mut weights = vec![1.0; moves.len()];
        let mut result = None;
        for _ in 0..ITERATIONS {
            let weighted = DMatrix::from_fn(rows, size, |r, c| weights[r / 2] * design[(r, c)]);
            let inverse = (weighted.transpose() * &design).try_inverse()?;
            let values = &inverse * (weighted.transpose() * &right);
            let left = &right - &design * &values;
            let distances: Vec<f64> = (0..moves.len())
                .map(|k| left[2 * k].hypot(left[2 * k + 1]))
                .collect();
            let scale = (OUTLIER_RATIO * median(&distances)).max(LEAST_RESIDUAL_PX);
            let cost: f64 = (0..rows).map(|r| weights[r / 2] * left[r] * left[r]).sum();
            let sum: f64 = 2.0 * weights.iter().sum::<f64>();
            let variance = cost / (sum - size as f64).max(1.0);
            let sigma = (0..size)
                .map(|k| (variance * inverse[(k, k)]).max(0.0).sqrt())
                .collect();
            for (weight, distance) in weights.iter_mut().zip(&distances) {
                *weight = 1.0 / (1.0 + (distance / scale).powi(2)).powi(2);
            }
            result = Some(Self { values, sigma });
        }
        result
    }
}
