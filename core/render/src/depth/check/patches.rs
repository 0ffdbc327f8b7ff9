//! Patches of a depth pass, and how planar each is under every possible reading of the pass.
//!
//! A perspective camera images the plane n . X = c with 1/z = (n . d)/c, d = (x/F, y/F, 1) being the ray through image
//! point (x, y). On every plane the inverse of distance along the axis is therefore linear in image coordinates. The
//! right reading makes planes linear, a wrong one gives them a quadratic part, the *bend*.

use rayon::prelude::*;
use std::sync::Arc;

use super::DepthCheck;
use seidel_optics::numeric::dot;

/// A possible meaning of the reciprocal w of the distance in the stated convention.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reading {
    /// w = 1/z: the stated convention is right.
    Stated,
    /// w = 1/(z s), s = |d| being the length of the ray per unit along the axis.
    AlongRay,
    /// w = z, up to a factor and an offset.
    Inverted,
    /// w = z s.
    InvertedAlongRay,
}

pub(super) const READINGS: [Reading; 4] = [
    Reading::Stated,
    Reading::AlongRay,
    Reading::Inverted,
    Reading::InvertedAlongRay,
];

/// Sides of patches as fractions of the picture's width: large ones for noisy passes, small ones for busy scenes.
const PARTS: [usize; 4] = [4, 8, 16, 32];
/// Largest number of samples along the side of a patch.
const MAX_SAMPLES: usize = 32;
/// Smallest number of samples along the side of a patch.
const MIN_SAMPLES: usize = 8;
/// Largest residual of a smooth patch, as a multiple of the root mean square; edges exceed it.
const LARGEST_RESIDUAL: f64 = 8.0;

/// The bend of a patch under every reading.
#[derive(Debug, Clone, Copy)]
pub(super) struct Patch {
    /// Root mean square of the quadratic part relative to the mean, by reading.
    pub bend: [f64; 4],
    /// Root mean square that noise alone gives the quadratic part, by reading.
    pub noise: [f64; 4],
}

/// A smooth patch of the pass, for any perspective.
#[derive(Debug, Clone)]
pub(super) struct Sampled {
    basis: Arc<Basis>,
    /// Reciprocals of the distance in the stated convention.
    w: Vec<f64>,
    /// Squared distances from the axis, pixel widths squared.
    off_axis: Vec<f64>,
    /// Bend and noise of w and 1/w, which do not depend on the perspective.
    plain: [(f64, f64); 2],
}

impl Sampled {
    /// Returns the bends at a focal length of `focal_px`; `None` where an edge appears.
    pub(super) fn at_focal_length(&self, focal_px: f64) -> Option<Patch> {
        let squared = 1.0 / (focal_px * focal_px);
        let rays: Vec<f64> = (self.off_axis.iter())
            .map(|r2| (1.0 + r2 * squared).sqrt())
            .collect();
        let both = || self.w.iter().zip(&rays);
        let along: Vec<f64> = both().map(|(w, ray)| w * ray).collect();
        let over: Vec<f64> = both().map(|(w, ray)| ray / w).collect();
        let ray = self.basis.bend(&along)?;
        let inverted = self.basis.bend(&over)?;
        let all = [self.plain[0], ray, self.plain[1], inverted];
        Some(Patch {
            bend: all.map(|(bend, _)| bend),
            noise: all.map(|(_, noise)| noise),
        })
    }

    /// Returns bend and noise in the stated convention.
    pub(super) fn as_stated(&self) -> (f64, f64) {
        self.plain[0]
    }
}

/// Returns all smooth patches.
pub(super) fn patches(check: &DepthCheck) -> Vec<Sampled> {
    let farthest = f64::from(farthest_vergence(check.vergence));
    let mut found = Vec::new();
    for part in PARTS {
        let side = check.width.div_ceil(part).min(check.height);
        let stride = side.div_ceil(MAX_SAMPLES).max(1);
        let count = side / stride;
        if count < MIN_SAMPLES {
            continue;
        }
        let side = count * stride;
        let basis = Arc::new(Basis::new(count));
        let columns = check.width / side;
        let patch = |index: usize| {
            let grid = Grid {
                left: index % columns * side,
                top: index / columns * side,
                stride,
                count,
            };
            grid.patch(check, &basis, farthest)
        };
        let places = 0..columns * (check.height / side);
        let patches: Vec<Sampled> = places.into_par_iter().filter_map(patch).collect();
        found.extend(patches);
    }
    found
}

/// Returns the smallest vergence above zero.
fn farthest_vergence(vergence: &[f32]) -> f32 {
    let finite = vergence.par_iter().copied().filter(|v| *v > 0.0);
    finite.reduce(|| f32::INFINITY, f32::min)
}

/// The positions of a patch's samples.
struct Grid {
    left: usize,
    top: usize,
    stride: usize,
    count: usize,
}

impl Grid {
    /// Samples the patch; `None` where some pixel has no distance, at edges, and in a constant background, which is
    /// planar in any convention.
    fn patch(&self, check: &DepthCheck, basis: &Arc<Basis>, farthest: f64) -> Option<Sampled> {
        let (w, off_axis) = self.read(check)?;
        let flat = w.iter().all(|v| (v / w[0] - 1.0).abs() < 1e-6);
        if flat && w[0] <= 1.01 * farthest {
            return None;
        }
        let over: Vec<f64> = w.iter().map(|w| 1.0 / w).collect();
        let plain = [basis.bend(&w)?, basis.bend(&over)?];
        Some(Sampled {
            basis: Arc::clone(basis),
            w,
            off_axis,
            plain,
        })
    }

    /// Returns vergences and squared distances from the axis; `None` where some pixel has no distance.
    fn read(&self, check: &DepthCheck) -> Option<(Vec<f64>, Vec<f64>)> {
        let mut w = Vec::with_capacity(self.count * self.count);
        let mut off_axis = Vec::with_capacity(self.count * self.count);
        for j in 0..self.count {
            let row = self.top + j * self.stride;
            let y = (row as f64 + 0.5 - check.view.axis.y_px) / check.view.pixel_aspect;
            for i in 0..self.count {
                let column = self.left + i * self.stride;
                let x = column as f64 + 0.5 - check.view.axis.x_px;
                let vergence = f64::from(check.vergence[row * check.width + column]);
                if !(vergence > 0.0 && vergence.is_finite()) {
                    return None;
                }
                w.push(vergence);
                off_axis.push(x * x + y * y);
            }
        }
        Some((w, off_axis))
    }
}

/// The functions 1, x, y, x² - c, xy and y² - c at the points of a centred square grid: orthogonal and of unit norm.
#[derive(Debug)]
struct Basis(Vec<[f64; 6]>);

impl Basis {
    fn new(count: usize) -> Self {
        let at = |i: usize| i as f64 - (count - 1) as f64 / 2.0;
        let square = (0..count).map(|i| at(i) * at(i)).sum::<f64>() / count as f64;
        let mut points: Vec<[f64; 6]> = (0..count * count)
            .map(|k| {
                let (x, y) = (at(k % count), at(k / count));
                [1.0, x, y, x * x - square, x * y, y * y - square]
            })
            .collect();
        for k in 0..6 {
            let norm = points.iter().map(|p| p[k] * p[k]).sum::<f64>().sqrt();
            points.iter_mut().for_each(|p| p[k] /= norm);
        }
        Self(points)
    }

    /// Returns the root mean square of the quadratic part of `values` and of the noise in it, relative to their mean;
    /// `None` where a residual stands out, as at an edge.
    fn bend(&self, values: &[f64]) -> Option<(f64, f64)> {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let share = |v: f64| v / mean - 1.0;
        let mut parts = [0.0; 6];
        for (v, point) in values.iter().zip(&self.0) {
            let v = share(*v);
            for (part, f) in parts.iter_mut().zip(point) {
                *part += v * f;
            }
        }
        let (mut squares, mut largest) = (0.0, 0.0_f64);
        for (v, point) in values.iter().zip(&self.0) {
            let rest = share(*v) - dot(&parts, point);
            squares += rest * rest;
            largest = largest.max(rest.abs());
        }
        let residual = (squares / (count - 6.0)).sqrt();
        // Single-precision rounding leaves meaningless residuals.
        if largest > LARGEST_RESIDUAL * residual.max(1e-7) {
            return None;
        }
        let quadratic: f64 = parts[3..].iter().map(|part| part * part).sum();
        Some(((quadratic / count).sqrt(), residual * (3.0 / count).sqrt()))
    }
}
