//! Pictures with the statistics of photographs, and their differences.

use std::f64::consts::TAU;

use seidel_optics::numeric::SplitMix64;

/// A square picture of one channel.
#[derive(Clone)]
pub(crate) struct Picture {
    pub side: usize,
    /// Samples, row-major.
    pub samples: Vec<f32>,
}

impl Picture {
    /// Draws discs of random size and brightness over each other, which gives edges and the spectrum of photographs
    /// ("dead leaves": Lee, Mumford and Huang 2001). Radii are 2 px to a third of the side, their density falls by
    /// radius³. Samples are 0.05 to 0.95.
    pub(crate) fn dead_leaves(side: usize, seed: u64) -> Self {
        let mut random = SplitMix64::new(seed);
        let mut samples = vec![f32::NAN; side * side];
        let mut empty = samples.len();
        let [least, most] = [2.0, side as f64 / 3.0].map(|radius: f64| radius.powi(-2));
        while empty > 0 {
            // From front to back: a leaf shows where nothing is yet.
            let radius = (least - random.unit() * (least - most)).powf(-0.5);
            let [x, y] = [(); 2].map(|()| random.unit() * (side as f64 + 2.0 * radius) - radius);
            let brightness = (0.05 + 0.9 * random.unit()) as f32;
            let range = |at: f64| {
                let [first, end] = [(at - radius).floor(), (at + radius).ceil()];
                first.max(0.0) as usize..(end.max(0.0) as usize).min(side)
            };
            for row in range(y) {
                for column in range(x) {
                    let sample = &mut samples[row * side + column];
                    let distance = (row as f64 + 0.5 - y).hypot(column as f64 + 0.5 - x);
                    if sample.is_nan() && distance < radius {
                        *sample = brightness;
                        empty -= 1;
                    }
                }
            }
        }
        Self { side, samples }.smoothed()
    }

    /// Returns the picture after a binomial filter of 3 x 3, about the footprint of a pixel with its optical low-pass.
    fn smoothed(&self) -> Self {
        let at = |row: usize, column: usize| self.samples[row * self.side + column];
        let last = self.side - 1;
        let mut samples = Vec::with_capacity(self.samples.len());
        for row in 0..self.side {
            for column in 0..self.side {
                let rows = [
                    (row.max(1) - 1, 1.0),
                    (row, 2.0),
                    ((row + 1).min(last), 1.0),
                ];
                let columns = [
                    (column.max(1) - 1, 1.0),
                    (column, 2.0),
                    ((column + 1).min(last), 1.0),
                ];
                let sum: f32 = (rows.iter())
                    .flat_map(|r| columns.map(|c| r.1 * c.1 * at(r.0, c.0)))
                    .sum();
                samples.push(sum / 16.0);
            }
        }
        Self {
            side: self.side,
            samples,
        }
    }

    /// Returns the middle of the picture, without `border` pixels on each side.
    pub(crate) fn cropped(&self, border: usize) -> Self {
        let side = self.side - 2 * border;
        let rows = (border..border + side).map(|row| row * self.side + border);
        let samples = rows
            .flat_map(|first| self.samples[first..first + side].to_vec())
            .collect();
        Self { side, samples }
    }

    /// Returns the picture with Gaussian noise of standard deviation `sigma`.
    pub(crate) fn with_noise(&self, sigma: f64, seed: u64) -> Self {
        let mut random = SplitMix64::new(seed);
        let mut noise = || {
            let (u, v) = (1.0 - random.unit(), random.unit());
            (sigma * (-2.0 * u.ln()).sqrt() * (TAU * v).cos()) as f32
        };
        let samples = self.samples.iter().map(|s| s + noise()).collect();
        Self {
            side: self.side,
            samples,
        }
    }

    /// Returns the peak signal-to-noise ratio against `truth`, peak 1, without `border` pixels on each side, dB. Above 60, a
    /// step of ten bits, no picture shows a difference: 60 is the most.
    pub(crate) fn psnr(&self, truth: &Self, border: usize) -> f64 {
        let (own, truth) = (self.cropped(border), truth.cropped(border));
        let squares = own.samples.iter().zip(&truth.samples);
        let sum: f64 = squares.map(|(a, b)| f64::from(a - b).powi(2)).sum();
        -10.0 * (sum / own.samples.len() as f64).max(1e-6).log10()
    }
}
