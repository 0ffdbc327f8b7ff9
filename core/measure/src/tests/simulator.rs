//! A small simulator of photographs: lights through a lens with field curvature and coma, a mosaic, noise, defects.

use seidel_optics::distance::ObjectDistance;
use seidel_optics::mosaic::Mosaic;
use seidel_optics::numeric::SplitMix64;

use crate::photograph::{Photograph, SampleErrors};

/// Counts per electron.
pub(super) const GAIN: f64 = 0.5;
/// Read noise, electrons.
pub(super) const READ_NOISE: f64 = 4.0;
/// Full well, electrons.
const FULL_WELL: f64 = 30_000.0;
/// Rays of one light.
const RAYS: usize = 1500;
/// Response of R, G and B.
const RESPONSE: [f64; 3] = [0.6, 1.0, 0.5];

/// A light: place of its centroid and peak relative to clipping, in green.
#[derive(Debug, Clone, Copy)]
pub(super) struct Light {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) peak: f64,
}

pub(super) struct Simulator {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) random: SplitMix64,
    /// Light in electrons, one plane a channel.
    planes: Vec<Vec<f64>>,
}

impl Simulator {
    pub(super) fn new(width: usize, height: usize, seed: u64) -> Self {
        Self {
            width,
            height,
            random: SplitMix64::new(seed),
            planes: vec![vec![0.0; width * height]; 3],
        }
    }

    pub(super) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.random.unit()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.random.unit()).cos()
    }

    /// Draws a light by rays: a defocused pupil with coma, wider towards the corners, and a Gaussian.
    pub(super) fn add(&mut self, light: Light) {
        let half = self.width as f64 / 2.0;
        let field = [
            light.x / half - 1.0,
            (light.y - self.height as f64 / 2.0) / half,
        ];
        let square = field[0] * field[0] + field[1] * field[1];
        for channel in 0..3 {
            let defocus = [2.2, 1.6, 2.4][channel] - 0.8 * square;
            let mut rays = Vec::with_capacity(RAYS);
            for k in 0..RAYS {
                let (radius, turn) = (
                    ((k as f64 + 0.5) / RAYS as f64).sqrt(),
                    2.399_963 * k as f64,
                );
                let u = [radius * turn.cos(), radius * turn.sin()];
                let along = u[0] * field[0] + u[1] * field[1];
                let r2 = radius * radius;
                let ray = [0, 1].map(|axis| {
                    (defocus + r2) * u[axis] - 0.3 * (r2 * field[axis] + 2.0 * along * u[axis])
                });
                rays.push(ray);
            }
            let mean = [0, 1].map(|axis| rays.iter().map(|r| r[axis]).sum::<f64>() / RAYS as f64);
            let sigma = 0.75;
            // Peak of a disc of the defocus, about.
            let area = std::f64::consts::PI * (defocus * 0.8).powi(2) + 4.0;
            let electrons = light.peak * FULL_WELL * RESPONSE[channel] * area;
            let (left, top) = (light.x as i64 - 14, light.y as i64 - 14);
            for y in top.max(0)..(top + 29).min(self.height as i64) {
                for x in left.max(0)..(left + 29).min(self.width as i64) {
                    let mut sum = 0.0;
                    for ray in &rays {
                        let dx = x as f64 + 0.5 - light.x - (ray[0] - mean[0]);
                        let dy = y as f64 + 0.5 - light.y - (ray[1] - mean[1]);
                        sum += (-(dx * dx + dy * dy) / (2.0 * sigma * sigma)).exp();
                    }
                    let density = sum / RAYS as f64 / (std::f64::consts::TAU * sigma * sigma);
                    self.planes[channel][y as usize * self.width + x as usize] +=
                        electrons * density;
                }
            }
        }
    }

    /// Exposes the light through a mosaic, with photon and read noise and `hot` defective pixels. Returns the photograph and
    /// the indices of the defects.
    pub(super) fn expose(&mut self, hot: usize) -> (Photograph, Vec<usize>) {
        let mosaic = Mosaic::parse("GRBG").expect("a pattern");
        let pixels = self.width * self.height;
        let mut counts = Vec::with_capacity(pixels);
        for index in 0..pixels {
            let colour = mosaic.colour_at(index % self.width, index / self.width);
            let channel = "RGB".find(colour).expect("a colour");
            let electrons = self.planes[channel][index] + 20.0;
            let noisy = electrons + electrons.sqrt() * self.normal() + READ_NOISE * self.normal();
            counts.push(noisy);
        }
        let defects: Vec<usize> = (0..hot)
            .map(|_| (self.random.unit() * pixels as f64) as usize)
            .collect();
        for &defect in &defects {
            counts[defect] += 1500.0 + 8000.0 * self.random.unit();
        }
        let white = FULL_WELL * GAIN;
        let stored = counts.iter().map(|e| (e * GAIN).round().min(white) as f32);
        let photograph = Photograph {
            name: "simulated.dng".to_owned(),
            width: self.width,
            height: self.height,
            planes: vec![stored.collect()],
            channels: ["R", "G", "B"].map(str::to_owned).to_vec(),
            mosaic: Some(mosaic),
            white: white as f32 * 0.998,
            distance: ObjectDistance::Metres(2.0),
            gain: None,
            errors: SampleErrors {
                quantum: 1.0,
                ..SampleErrors::default()
            },
            bad: Vec::new(),
        };
        (photograph, defects)
    }
}

/// Lights on a jittered grid of `columns` x `rows`, each within the frame.
pub(super) fn grid(simulator: &mut Simulator, columns: usize, rows: usize) -> Vec<Light> {
    let step = [
        simulator.width as f64 / columns as f64,
        simulator.height as f64 / rows as f64,
    ];
    (0..columns * rows)
        .map(|k| Light {
            x: (k % columns) as f64 * step[0] + step[0] / 2.0 + 3.0 * simulator.random.unit(),
            y: (k / columns) as f64 * step[1] + step[1] / 2.0 + 3.0 * simulator.random.unit(),
            peak: 0.15 + 0.6 * simulator.random.unit(),
        })
        .collect()
}
