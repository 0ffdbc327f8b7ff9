//! The map from positions of the photograph to positions of the chart: a homography after a polynomial correction.

use nalgebra::{DMatrix, DVector, Matrix3, SMatrix, SVector, Vector3};
use seidel_optics::error::{Error, ErrorKind, Result};

/// Degree of the polynomial correction: decentred and radial distortion of third order. Two terms of radial distortion of
/// fifth order follow, since the inverse of a third-order distortion has them.
const DEGREE: usize = 3;
const RADIAL_TERMS: usize = 2;
/// Blocks per coefficient that a correction needs.
const BLOCKS_PER_TERM: usize = 2;
/// Correction beyond this many standard deviations does not count.
const CLIP_SIGMAS: f64 = 4.0;
const ITERATIONS: usize = 6;

/// Photograph positions to chart positions.
#[derive(Debug, Clone, PartialEq)]
pub struct ChartMap {
    /// Homography of corrected photograph positions.
    homography: Matrix3<f64>,
    /// Coefficients of the correction along x and y, px.
    correction: Vec<[f64; 2]>,
    /// Photograph position and length that normalise positions for the correction.
    centre: [f64; 2],
    scale: f64,
}

/// The offset of the chart from the place that the map gives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Displacement {
    /// Photograph position.
    pub(crate) at: [f64; 2],
    /// Light's position less the expected one, px.
    pub(crate) shift: [f64; 2],
}

impl ChartMap {
    /// Creates the map that takes four photograph positions to four chart positions.
    ///
    /// # Errors
    /// Positions of which three lie on a line.
    pub fn of_corners(
        photo: [[f64; 2]; 4],
        chart: [[f64; 2]; 4],
        size: [usize; 2],
    ) -> Result<Self> {
        let mut left = SMatrix::<f64, 8, 8>::zeros();
        let mut right = SVector::<f64, 8>::zeros();
        for (k, ([x, y], [u, v])) in photo.iter().zip(&chart).enumerate() {
            let rows = [
                [*x, *y, 1.0, 0.0, 0.0, 0.0, -x * u, -y * u],
                [0.0, 0.0, 0.0, *x, *y, 1.0, -x * v, -y * v],
            ];
            for (row, values) in rows.iter().enumerate() {
                for (column, value) in values.iter().enumerate() {
                    left[(2 * k + row, column)] = *value;
                }
            }
            right[2 * k] = *u;
            right[2 * k + 1] = *v;
        }
        let solved = left
            .lu()
            .solve(&right)
            .filter(|h| h.iter().all(|v| v.is_finite()));
        let Some(h) = solved else {
            return Err(Error::new(
                "corners",
                "are not four: three of them lie on one line",
                "give the four corners of the chart, from the top left clockwise",
            )
            .with_kind(ErrorKind::InvalidInput));
        };
        let [width, height] = size.map(|v| v as f64);
        Ok(Self {
            homography: Matrix3::new(h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], 1.0),
            correction: vec![[0.0; 2]; ALL_TERMS],
            centre: [width / 2.0, height / 2.0],
            scale: width.max(height) / 2.0,
        })
    }

    /// Returns the chart position, in pixels of the chart's picture, that appears at photograph position `at`.
    pub fn chart_of(&self, at: [f64; 2]) -> [f64; 2] {
        self.project(self.corrected(at))
    }

    /// Returns the photograph position in which `chart` appears, by fixed-point iteration of the correction.
    pub fn photo_of(&self, chart: [f64; 2]) -> Option<[f64; 2]> {
        let inverse = self.homography.try_inverse()?;
        let v = inverse * Vector3::new(chart[0], chart[1], 1.0);
        let plain = [v[0] / v[2], v[1] / v[2]];
        let mut at = plain;
        for _ in 0..20 {
            let corrected = self.corrected(at);
            at = [0, 1].map(|k| at[k] + plain[k] - corrected[k]);
        }
        Some(at)
    }

    fn project(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let v = self.homography * Vector3::new(x, y, 1.0);
        [v[0] / v[2], v[1] / v[2]]
    }

    fn corrected(&self, at: [f64; 2]) -> [f64; 2] {
        let row = self.correction_row(at);
        let mut corrected = at;
        for (term, [x, y]) in row.iter().zip(&self.correction) {
            corrected[0] += term * x;
            corrected[1] += term * y;
        }
        corrected
    }

    /// Returns `at` relative to the centre, in units of half the longer side.
    pub(crate) fn normalised(&self, at: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| (at[k] - self.centre[k]) / self.scale)
    }

    /// Returns the terms of the correction at a photograph position, by rising degree.
    pub(crate) fn correction_row(&self, at: [f64; 2]) -> [f64; ALL_TERMS] {
        let [x, y] = self.normalised(at);
        let (xx, xy, yy) = (x * x, x * y, y * y);
        let radial = (xx + yy) * (xx + yy);
        [
            1.0,
            x,
            y,
            xx,
            xy,
            yy,
            xx * x,
            xx * y,
            x * yy,
            yy * y,
            x * radial,
            y * radial,
        ]
    }

    /// Adds to the coefficients of the correction, px.
    pub(crate) fn add_correction(&mut self, steps: impl Iterator<Item = [f64; 2]>) {
        for (old, step) in self.correction.iter_mut().zip(steps) {
            old[0] += step[0];
            old[1] += step[1];
        }
    }

    /// Replaces the homography by itself after a first-order homography of normalised positions, whose displacements `flow`
    /// states in px.
    pub(crate) fn compose_normalised(&mut self, flow: Matrix3<f64>) {
        let [x, y] = self.centre;
        let normalise = Matrix3::new(
            1.0 / self.scale,
            0.0,
            -x / self.scale,
            0.0,
            1.0 / self.scale,
            -y / self.scale,
            0.0,
            0.0,
            1.0,
        );
        let step = Matrix3::identity() + flow / self.scale;
        if let Some(back) = normalise.try_inverse() {
            self.homography *= back * step * normalise;
            self.homography /= self.homography[(2, 2)];
        }
    }

    /// Moves the correction so that smooth displacements vanish, and returns the median distance that remains, px.
    pub(crate) fn correct(&mut self, displacements: &[Displacement]) -> f64 {
        let counts = (0..=DEGREE).map(terms).chain([ALL_TERMS]);
        let fitting = counts.filter(|c| displacements.len() >= BLOCKS_PER_TERM * c);
        let count = fitting.max().unwrap_or(1);
        let mut kept = vec![true; displacements.len()];
        let mut remaining = vec![0.0; displacements.len()];
        let mut coefficients = DMatrix::zeros(count, 2);
        for _ in 0..ITERATIONS {
            let rows = kept.iter().filter(|k| **k).count();
            if rows < count {
                break;
            }
            let mut normal = DMatrix::zeros(count, count);
            let mut right = DMatrix::zeros(count, 2);
            for (d, _) in displacements.iter().zip(&kept).filter(|(_, k)| **k) {
                let row = DVector::from_column_slice(&self.correction_row(d.at)[..count]);
                normal += &row * row.transpose();
                right += &row * nalgebra::RowVector2::new(-d.shift[0], -d.shift[1]);
            }
            for k in 0..count {
                normal[(k, k)] *= 1.0 + 1e-9;
            }
            let Some(cholesky) = normal.cholesky() else {
                break;
            };
            coefficients = cholesky.solve(&right);
            for (remaining, d) in remaining.iter_mut().zip(displacements) {
                let row = DVector::from_column_slice(&self.correction_row(d.at)[..count]);
                let fitted = coefficients.transpose() * row;
                *remaining = (d.shift[0] + fitted[0]).hypot(d.shift[1] + fitted[1]);
            }
            let typical = seidel_optics::numeric::median(&mut remaining.clone());
            // The median of the length of a two-dimensional normal vector is 1.18 standard deviations.
            let limit = (CLIP_SIGMAS * typical / 1.18).max(0.01);
            kept = remaining.iter().map(|r| *r <= limit).collect();
        }
        for (old, new) in self.correction.iter_mut().zip(coefficients.row_iter()) {
            old[0] += new[0];
            old[1] += new[1];
        }
        seidel_optics::numeric::median(&mut remaining)
    }
}

/// Terms of the whole correction.
const ALL_TERMS: usize = terms(DEGREE) + RADIAL_TERMS;

const fn terms(degree: usize) -> usize {
    (degree + 1) * (degree + 2) / 2
}
