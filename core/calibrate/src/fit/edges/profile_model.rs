//! The profile of an edge as a lens makes it, and how it differs from a measured one.
//!
//! A ray that lands d off the chief ray shifts the step by n.d: `E(t) = sum of w_k Phi((t - n.d_k) / s)`, where s² adds the
//! symmetric blur, the pixel's area and the spread of distances within a bin. Levels, gradient of the light and place of the
//! edge are eliminated: they are linear, or nearly so.

use nalgebra::{DMatrix, SMatrix, SVector};
use seidel_optics::edges::Edge;
use seidel_optics::field::{FieldPoint, Frame};
use seidel_optics::lens::LocalPupil;
use seidel_optics::moments::pixels::PIXEL_VARIANCE_PX2;
use seidel_optics::numeric::StandardNormal;

use super::rays::{ProjectedRays, PupilCentre, Quadrature};
use crate::fit::pixels::lens_equations::LensEquations;
use crate::fit::pixels::parameters::ParameterLayout;

/// Nuisance parameters of an edge: dark level, step, gradient of the light, place.
const OWN: usize = 4;
/// Shift of an edge above which its profile is drawn again, px, and the largest number of drawings.
const SHIFT_PX: f64 = 0.02;
const MAX_DRAWINGS: usize = 4;
/// Step of the differences by a parameter.
const DIFFERENCE: f64 = 1e-4;

/// A measured edge, ready to be compared.
#[derive(Debug, Clone)]
pub(super) struct FitEdge {
    /// Index of the channel.
    pub(super) channel: usize,
    /// Field position relative to the initial axis.
    pub(super) at: FieldPoint,
    /// Vergence of the object, 1/m.
    pub(super) vergence: f64,
    normal: [f64; 2],
    dark_over_step: f64,
    bins: Vec<Bin>,
    /// Fourth cumulant of the pixel's area along the normal, px⁴.
    pixel_cumulant: f64,
    quadrature: Quadrature,
}

#[derive(Debug, Clone, Copy)]
struct Bin {
    t: f64,
    level: f64,
    weight: f64,
    spread: f64,
}

/// The drawn profile: levels, their slope along t, and their change with the variance of the blur.
struct Drawn {
    level: Vec<f64>,
    slope: Vec<f64>,
    by_blur: Vec<f64>,
}

/// A comparison of the measured with the drawn profile.
struct Compared {
    drawn: Drawn,
    /// Weighted residuals.
    residuals: Vec<f64>,
    /// Columns of the nuisance parameters, weighted, and the inverse of their normal matrix.
    own: Vec<SVector<f64, OWN>>,
    inverse: SMatrix<f64, OWN, OWN>,
    step: f64,
    shift: f64,
}

impl FitEdge {
    pub(super) fn new(edge: &Edge, frame: &Frame) -> Self {
        let [x, y] = edge.normal;
        let bins = edge.profile.iter().map(|bin| Bin {
            t: bin.t_px,
            level: bin.level,
            weight: 1.0 / bin.sigma,
            spread: bin.spread_px2,
        });
        // The projections of rays must lie closer than the blur that smooths them.
        let radius = 2.0 * edge.variance_px2.max(0.25).sqrt();
        let angles = (10.0 + 5.0 * radius).clamp(16.0, 120.0) as usize;
        let rings = (4.0 + radius / 2.0).clamp(5.0, 12.0) as usize;
        Self {
            channel: edge.channel,
            at: frame.field_point(edge.mid),
            vergence: edge.distance.vergence_per_m().unwrap_or(0.0),
            normal: edge.normal,
            dark_over_step: edge.dark_over_step(),
            bins: bins.collect(),
            pixel_cumulant: -(x.powi(4) + y.powi(4)) / 120.0,
            quadrature: Quadrature::new(rings, angles),
        }
    }

    /// Returns the degrees of freedom.
    pub(super) fn freedom(&self) -> f64 {
        (self.bins.len() - OWN) as f64
    }

    /// Returns the standard deviation of the levels, over the step: that of bins of mean weight.
    pub(super) fn noise(&self) -> f64 {
        let weights = self.bins.iter().map(|bin| bin.weight * bin.weight);
        (weights.sum::<f64>() / self.bins.len() as f64)
            .sqrt()
            .recip()
    }

    /// Returns chi squared per degree of freedom for a pupil.
    pub(super) fn misfit(&self, pupil: &LocalPupil) -> f64 {
        let rays = self
            .quadrature
            .project(pupil, PupilCentre::of(pupil), self.normal);
        let compared = self.compare(&rays, pupil.blur_variance_px2);
        let square: f64 = compared.residuals.iter().map(|r| r * r).sum();
        square / self.freedom()
    }

    fn draw(&self, rays: &ProjectedRays, blur: f64, shift: f64) -> Drawn {
        let count = self.bins.len();
        let mut drawn = Drawn {
            level: Vec::with_capacity(count),
            slope: Vec::with_capacity(count),
            by_blur: Vec::with_capacity(count),
        };
        for bin in &self.bins {
            let variance = blur + PIXEL_VARIANCE_PX2 + bin.spread;
            let width = variance.sqrt();
            // Gram-Charlier correction: the pixel's area is no Gaussian.
            let flat = self.pixel_cumulant / (24.0 * variance * variance);
            let (mut level, mut slope, mut by_blur) = (0.0, 0.0, 0.0);
            for (at, light) in rays.at.iter().zip(&rays.light) {
                let z = (bin.t - shift - at) / width;
                let normal = StandardNormal::at(z);
                let density = light * normal.density;
                level += light * normal.cumulative - flat * z * (z * z - 3.0) * density;
                slope += density;
                by_blur -= density * z;
            }
            drawn.level.push(level);
            drawn.slope.push(slope / width);
            drawn.by_blur.push(by_blur / (2.0 * variance));
        }
        drawn
    }

    fn compare(&self, rays: &ProjectedRays, blur: f64) -> Compared {
        let mut shift = 0.0;
        let mut drawings = 0;
        loop {
            let drawn = self.draw(rays, blur, shift);
            drawings += 1;
            let mut normal = SMatrix::<f64, OWN, OWN>::zeros();
            let mut right = SVector::<f64, OWN>::zeros();
            let mut own = Vec::with_capacity(self.bins.len());
            for (k, bin) in self.bins.iter().enumerate() {
                let level = drawn.level[k];
                let row = SVector::from([
                    1.0,
                    level,
                    bin.t * (self.dark_over_step + level),
                    -drawn.slope[k],
                ]) * bin.weight;
                normal += row * row.transpose();
                right += row * (bin.level * bin.weight);
                own.push(row);
            }
            let inverse = normal.try_inverse().unwrap_or_default();
            let solution = inverse * right;
            let residuals = (self.bins.iter().zip(&own))
                .map(|(bin, row)| bin.level * bin.weight - row.dot(&solution))
                .collect();
            let step = solution[1];
            let moved = if step > 0.2 { solution[3] / step } else { 0.0 };
            if moved.abs() < SHIFT_PX || drawings == MAX_DRAWINGS {
                return Compared {
                    drawn,
                    residuals,
                    own,
                    inverse,
                    step,
                    shift,
                };
            }
            shift += moved.clamp(-1.0, 1.0);
        }
    }

    /// Returns the normal equations of the lens parameters, and the misfit.
    pub(super) fn equations(
        &self,
        layout: &ParameterLayout,
        theta: &[f64],
    ) -> (LensEquations, f64) {
        let pupil = layout.pupil(theta, self.channel, self.at, self.vergence);
        let centre = PupilCentre::of(&pupil);
        let rays = self.quadrature.project(&pupil, centre, self.normal);
        let blur = pupil.blur_variance_px2;
        let compared = self.compare(&rays, blur);
        let kernels = self.kernels(&rays, blur, compared.shift);
        let parameters = layout.free_parameters_of(self.channel);
        let (count, bins) = (parameters.len(), self.bins.len());
        let mut columns = DMatrix::zeros(bins, count);
        let mut moved = theta.to_vec();
        for (column, &slot) in parameters.iter().enumerate() {
            let mut at_offset = |by: f64| {
                moved[slot] = theta[slot] + by;
                let pupil = layout.pupil(&moved, self.channel, self.at, self.vergence);
                moved[slot] = theta[slot];
                let rays = self.quadrature.project(&pupil, centre, self.normal);
                (rays, pupil.blur_variance_px2)
            };
            let ((low, low_blur), (high, high_blur)) =
                (at_offset(-DIFFERENCE), at_offset(DIFFERENCE));
            let scale = 1.0 / (2.0 * DIFFERENCE);
            let blur_rate = (high_blur - low_blur) * scale;
            let rates: Vec<[f64; 2]> = (0..rays.at.len())
                .map(|k| {
                    let moved = (high.at[k] - low.at[k]) * scale;
                    [
                        moved * rays.light[k],
                        (high.light[k] - low.light[k]) * scale,
                    ]
                })
                .collect();
            for (row, bin) in self.bins.iter().enumerate() {
                let kernel = &kernels[row * rates.len()..][..rates.len()];
                let change: f64 = (kernel.iter().zip(&rates))
                    .map(|([density, cumulative], [moved, light])| {
                        light * cumulative - moved * density
                    })
                    .sum();
                let change = change + blur_rate * compared.drawn.by_blur[row];
                columns[(row, column)] = compared.step * change * bin.weight;
            }
        }
        // Projection onto what the nuisance parameters do not describe.
        let own = DMatrix::from_fn(bins, OWN, |row, k| compared.own[row][k]);
        let inverse = DMatrix::from_fn(OWN, OWN, |a, b| compared.inverse[(a, b)]);
        let shares = inverse * own.tr_mul(&columns);
        let columns = columns - own * shares;
        let residuals = nalgebra::DVector::from_column_slice(&compared.residuals);
        let misfit = residuals.norm_squared() / self.freedom();
        let equations = LensEquations {
            normal: columns.tr_mul(&columns),
            right: columns.tr_mul(&residuals),
            parameters,
        };
        (equations, misfit)
    }

    /// Returns the density, per px, and the cumulative probability of every ray at every bin.
    fn kernels(&self, rays: &ProjectedRays, blur: f64, shift: f64) -> Vec<[f64; 2]> {
        let mut kernels = Vec::with_capacity(self.bins.len() * rays.at.len());
        for bin in &self.bins {
            let width = (blur + PIXEL_VARIANCE_PX2 + bin.spread).sqrt();
            kernels.extend(rays.at.iter().map(|at| {
                let normal = StandardNormal::at((bin.t - shift - at) / width);
                [normal.density / width, normal.cumulative]
            }));
        }
        kernels
    }
}
