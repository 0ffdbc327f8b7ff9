//! Registration of a pair by the offsets of its windows, and the positions that the plate gives its PSFs.

use nalgebra::{DMatrix, DVector};

use super::lens_view::{LensView, Positions};
use super::offsets::WindowOffset;
use crate::registration::Similarity;
use seidel_optics::field::{FieldPoint, Frame};
use seidel_optics::numeric::{dot, median};

/// Windows from which scale and rotation are fitted too.
const LEAST_WINDOWS: usize = 8;
/// Standard errors from which a shift, and a movement by scale or rotation, counts.
const SHIFT_SIGMAS: f64 = 4.0;
const STRETCH_SIGMAS: f64 = 5.0;
/// Median offset below which a plate is aligned, px.
const ON_SOURCE_PX: f64 = 0.1;
/// Largest median offset that a change of shape alone causes, px.
const APPARENT_PX: f64 = 0.5;
/// Ratio of the offsets without and with the lens's displacement that separates an undistorted plate from a distorted one.
const DISTINCT_RATIO: f64 = 0.7;
/// Iterations of reweighting, and the residual in medians from which a window loses weight.
const ITERATIONS: usize = 6;
const OUTLIER_RATIO: f64 = 3.0;
const LEAST_RESIDUAL_PX: f64 = 0.02;

/// The smallest movements that count.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tolerance {
    /// Shift, px.
    shift_px: f64,
    /// Movement at the edge of the frame by scale or rotation, px.
    stretch_px: f64,
}

impl Tolerance {
    /// For pictures that may be aligned: they are not moved needlessly.
    pub(super) const ALIGNED: Self = Self {
        shift_px: 0.05,
        stretch_px: 0.15,
    };
    /// For pictures that are moved anyway.
    pub(super) const MOVED: Self = Self {
        shift_px: 0.005,
        stretch_px: 0.015,
    };
}

/// The geometry of a pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Geometry {
    pub(super) positions: Positions,
    /// Movement of the plate, taken off by moving the sharp picture.
    pub(super) movement: Movement,
}

/// Movements of the plate against the sharp picture.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Movement {
    /// Shift (x, y), px.
    shift_px: [f64; 2],
    /// At the edge of the frame, outwards by scale and around by rotation, px.
    stretch_px: [f64; 2],
}

impl Movement {
    pub(super) fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// Adds a further movement.
    pub(super) fn add(&mut self, further: &Self) {
        for axis in 0..2 {
            self.shift_px[axis] += further.shift_px[axis];
            self.stretch_px[axis] += further.stretch_px[axis];
        }
    }

    /// Returns the transform from pixels of the sharp picture to ideal positions in `frame`.
    pub(super) fn transform(&self, frame: &Frame) -> Similarity {
        let half = frame.half_width_px();
        let (scale, turn) = (self.stretch_px[0] / half, self.stretch_px[1] / half);
        let (cx, cy) = (frame.axis().x_px, frame.axis().y_px);
        Similarity {
            a: 1.0 + scale,
            b: turn,
            shift_px: [
                self.shift_px[0] - scale * cx + turn * cy,
                self.shift_px[1] - turn * cx - scale * cy,
            ],
        }
    }

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
    tolerance: Tolerance,
) -> Geometry {
    let by_lens: Vec<[f64; 2]> = offsets
        .iter()
        .map(|o| view.mean_displacement(o.at))
        .collect();
    let as_lens: Vec<WindowOffset> = offsets
        .iter()
        .zip(&by_lens)
        .map(|(o, d)| WindowOffset {
            offset_px: [o.offset_px[0] - d[0], o.offset_px[1] - d[1]],
            ..*o
        })
        .collect();
    let positions = wanted.unwrap_or_else(|| positions(view, offsets, &as_lens));
    let moves = match positions {
        Positions::Undistorted => offsets,
        Positions::Lens => &as_lens,
    };
    Geometry {
        positions,
        movement: movement(view, moves, tolerance),
    }
}

/// Returns the positions that fit the plate, from its `offsets` and what remains of them if the lens displaces it.
///
/// A change of scale looks like the linear part of a lens's displacement. Where neither kind of plate would be aligned, the
/// offsets are therefore compared without their similarity transform: what remains is the lens's distortion.
fn positions(view: &LensView<'_>, offsets: &[WindowOffset], as_lens: &[WindowOffset]) -> Positions {
    let (undistorted, distorted) = (scatter(offsets), scatter(as_lens));
    if undistorted < ON_SOURCE_PX {
        return Positions::Undistorted;
    }
    if distorted < ON_SOURCE_PX {
        return Positions::Lens;
    }
    if let [Some(undistorted), Some(distorted)] =
        [offsets, as_lens].map(|moves| scatter_about_similarity(view, moves))
    {
        if undistorted < DISTINCT_RATIO * distorted {
            return Positions::Undistorted;
        }
        if distorted < DISTINCT_RATIO * undistorted {
            return Positions::Lens;
        }
    }
    let is_undistorted = undistorted < DISTINCT_RATIO * distorted
        || (undistorted <= distorted && undistorted < APPARENT_PX);
    if is_undistorted {
        Positions::Undistorted
    } else {
        Positions::Lens
    }
}

/// Returns the median distance of offsets from their fitted shift, scale and rotation; `None` of too few.
fn scatter_about_similarity(view: &LensView<'_>, moves: &[WindowOffset]) -> Option<f64> {
    if moves.len() < LEAST_WINDOWS {
        return None;
    }
    let fit = Fit::new(view, moves, 4)?;
    let left = moves.iter().map(|m| {
        let at = view.frame.field_point(m.at);
        let rows = Fit::terms(at);
        let off = [0, 1].map(|axis| m.offset_px[axis] - dot(&rows[axis], fit.values.as_slice()));
        off[0].hypot(off[1])
    });
    Some(median(&mut left.collect::<Vec<_>>()))
}

/// Returns the median distance of offsets from their median.
fn scatter(offsets: &[WindowOffset]) -> f64 {
    let along = |axis: usize| -> Vec<f64> { offsets.iter().map(|o| o.offset_px[axis]).collect() };
    let (x, y) = (median(&mut along(0)), median(&mut along(1)));
    let mut distances: Vec<f64> = offsets
        .iter()
        .map(|o| (o.offset_px[0] - x).hypot(o.offset_px[1] - y))
        .collect();
    median(&mut distances)
}

/// Fits shift, scale and rotation, with a cubic radial term that protects the scale from distortion; keeps what is
/// significant.
fn movement(view: &LensView<'_>, moves: &[WindowOffset], tolerance: Tolerance) -> Movement {
    let mut movement = Movement::default();
    let whole = moves.len() >= LEAST_WINDOWS;
    let Some(mut fit) = Fit::new(view, moves, if whole { 5 } else { 2 }) else {
        return movement;
    };
    if whole {
        let is_real = |k: usize| {
            fit.values[k].abs() > tolerance.stretch_px
                && fit.values[k].abs() > STRETCH_SIGMAS * fit.sigma[k]
        };
        if is_real(2) || is_real(3) {
            movement.stretch_px = [fit.values[2], fit.values[3]];
        } else if let Some(shift) = Fit::new(view, moves, 2) {
            fit = shift;
        }
    }
    let size = fit.values[0].hypot(fit.values[1]);
    if size > tolerance.shift_px && size > SHIFT_SIGMAS * fit.sigma[0].max(fit.sigma[1]) {
        movement.shift_px = [fit.values[0], fit.values[1]];
    }
    movement
}

/// A robust fit of movements: shift x and y, outwards, around, and outwards in the cube of the field; the last three at
/// the edge of the frame.
struct Fit {
    values: DVector<f64>,
    sigma: Vec<f64>,
}

impl Fit {
    /// Returns the movements (x, y) of a point by each value.
    fn terms(at: FieldPoint) -> [[f64; 5]; 2] {
        let square = at.x * at.x + at.y * at.y;
        [
            [1.0, 0.0, at.x, -at.y, at.x * square],
            [0.0, 1.0, at.y, at.x, at.y * square],
        ]
    }

    /// Fits the first `size` movements; `None` if they are not determined.
    fn new(view: &LensView<'_>, moves: &[WindowOffset], size: usize) -> Option<Self> {
        let rows = 2 * moves.len();
        if rows <= size {
            return None;
        }
        let design = DMatrix::from_fn(rows, size, |row, column| {
            let at = view.frame.field_point(moves[row / 2].at);
            Self::terms(at)[row % 2][column]
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
            let scale = (OUTLIER_RATIO * median(&mut distances.clone())).max(LEAST_RESIDUAL_PX);
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
