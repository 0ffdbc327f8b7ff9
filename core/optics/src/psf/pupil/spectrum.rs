//! The spectrum of a PSF, and the transfer function of a sensor.

use std::f64::consts::PI;

use super::fourier::{C, Grid};
use crate::sensor::Sensor;

/// The tile that a PSF is drawn for.
#[derive(Debug, Clone, Copy)]
pub(super) struct View {
    /// Its top-left outer corner from the chief ray, px.
    pub(super) corner: [f64; 2],
    /// Columns and rows.
    pub(super) size: [usize; 2],
    /// Margin around the tile from which blur carries light into it, px along x and y.
    pub(super) room: [f64; 2],
}

/// The spectrum of a PSF on a periodic window, including integration over pixels.
pub(super) struct Spectrum {
    /// A line of all frequencies along y for each frequency along x, from 0.
    pub(super) values: Vec<C>,
    /// Total number of frequencies along x (at most half of them are stored) and y.
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// Pixels of the window (x, y), the unit of the frequencies.
    pub(super) pixels: [usize; 2],
    /// Tile pixel at the top-left corner of the window.
    pub(super) first: [i64; 2],
    /// Tile pixel whose centre has phase zero.
    pub(super) origin: [i64; 2],
}

impl Spectrum {
    /// Returns the spectrum sampled at pixel centres behind streak, box and copies of `sensor`.
    ///
    /// Frequencies beyond those of `grid` alias, as they do on a sensor.
    pub(super) fn folded(&self, sensor: &Sensor, grid: &Grid) -> Vec<C> {
        let [width, height] = self.pixels;
        let mut folded = vec![C::default(); grid.half() * height];
        let share = 1.0 / (width * height) as f64;
        let through = SensorTransfer::new(self, sensor);
        let lines = self.values.chunks_exact(self.rows).enumerate();
        for (k, line) in lines {
            let here = k % width;
            let there = (width - here) % width;
            let paired = k > 0 && 2 * k != self.columns;
            let target =
                |column: usize, wanted: bool| (wanted && column < grid.half()).then_some(column);
            let (here, there) = (target(here, true), target(there, paired));
            let across = through.across[k] * share;
            let mut put = |row: usize, value: C| {
                let (up, down) = through.rows[row];
                if let Some(column) = here {
                    folded[column * height + up as usize] += value;
                }
                if let Some(column) = there {
                    folded[column * height + down as usize] += value.conj();
                }
            };
            match &through.streak {
                None => {
                    for (row, value) in line.iter().enumerate() {
                        put(row, value * (across * through.down[row]));
                    }
                }
                Some(streak) => {
                    for (row, value) in line.iter().enumerate() {
                        let spread = streak.at(k, row);
                        put(row, value * (across * through.down[row] * spread));
                    }
                }
            }
        }
        folded
    }
}

/// The transfer function of a sensor, without its halo.
struct SensorTransfer {
    /// Factors of box and copies along x and along y.
    across: Vec<f64>,
    down: Vec<f64>,
    /// For each frequency along y, the pixel frequency that it and its negative alias to.
    rows: Vec<(u32, u32)>,
    streak: Option<Streak>,
}

impl SensorTransfer {
    fn new(spectrum: &Spectrum, sensor: &Sensor) -> Self {
        let lines = spectrum.values.len() / spectrum.rows.max(1);
        let plain = |axis: usize, k: i64| {
            let f = k as f64 / spectrum.pixels[axis] as f64;
            sinc(f * sensor.box_px[axis]) * (PI * f * sensor.copies_px[axis]).cos()
        };
        let along = |axis: usize, k: i64| {
            let phase = PI * k as f64 / spectrum.pixels[axis] as f64 * sensor.streak_px[axis];
            (phase, phase.sin(), phase.cos())
        };
        let row = |k: usize| signed(k, spectrum.rows);
        let height = spectrum.pixels[1] as i64;
        let fold = |k: i64| k.rem_euclid(height) as u32;
        Self {
            across: (0..lines).map(|k| plain(0, k as i64)).collect(),
            down: (0..spectrum.rows).map(|k| plain(1, row(k))).collect(),
            rows: (0..spectrum.rows)
                .map(|k| (fold(row(k)), fold(-row(k))))
                .collect(),
            streak: (sensor.streak_px != [0.0; 2]).then(|| Streak {
                across: (0..lines).map(|k| along(0, k as i64)).collect(),
                down: (0..spectrum.rows).map(|k| along(1, row(k))).collect(),
            }),
        }
    }
}

/// The sinc of a streak: phases along x and y with their sines and cosines.
struct Streak {
    across: Vec<(f64, f64, f64)>,
    down: Vec<(f64, f64, f64)>,
}

impl Streak {
    #[inline(always)]
    fn at(&self, k: usize, row: usize) -> f64 {
        let ((a, sin_a, cos_a), (b, sin_b, cos_b)) = (self.across[k], self.down[row]);
        let phase = a + b;
        if phase.abs() < 1e-4 {
            1.0 - phase * phase / 6.0
        } else {
            (sin_a * cos_b + cos_a * sin_b) / phase
        }
    }
}

/// Returns `sin(pi x) / (pi x)`.
pub(super) fn sinc(x: f64) -> f64 {
    let phase = PI * x;
    if phase.abs() < 1e-4 {
        1.0 - phase * phase / 6.0
    } else {
        phase.sin() / phase
    }
}

/// Returns the frequency of index `k` of `count`: the upper half are negative.
pub(super) fn signed(k: usize, count: usize) -> i64 {
    if 2 * k > count {
        k as i64 - count as i64
    } else {
        k as i64
    }
}
