//! The sensor: from light on a fine grid to the pixels of a tile.

use std::f64::consts::PI;

/// Bins of the fine grid across one pixel.
pub(super) const BINS: usize = 4;
/// Margin of the fine grid around the tile if the sensor copies light, pixels.
const MARGIN_PX: usize = 8;

/// Light on bins a quarter of a pixel wide.
#[derive(Debug, Clone)]
pub(super) struct FineGrid {
    bins: usize,
    light: Vec<f64>,
}

impl FineGrid {
    /// Creates an empty grid for tiles of `tile` pixels behind `sensor`.
    pub(super) fn new(tile: usize, sensor: &Sensor) -> Self {
        let margin = if sensor.copies.is_empty() {
            0
        } else {
            MARGIN_PX
        };
        let bins = (tile + 2 * margin) * BINS;
        Self {
            bins,
            light: vec![0.0; bins * bins],
        }
    }

    pub(super) fn bins(&self) -> usize {
        self.bins
    }

    pub(super) fn width_px(&self) -> f64 {
        self.bins as f64 / BINS as f64
    }

    /// Returns the position of the centre of a bin along one axis, px from the centre of the grid.
    pub(super) fn bin_px(&self, bin: usize) -> f64 {
        (bin as f64 + 0.5) / BINS as f64 - self.width_px() / 2.0
    }

    /// Adds `weight` spread evenly over a box of size `extent` about `at`, px from the centre of the grid.
    pub(super) fn add_box(&mut self, at: [f64; 2], extent: [f64; 2], weight: f64) {
        let per_px = BINS as f64;
        let half = self.bins as f64 / 2.0;
        let most = self.bins as f64;
        let span = |i: usize| {
            let reach = 0.5 * extent[i].max(0.01) * per_px;
            let middle = at[i] * per_px + half;
            (middle - reach, middle + reach)
        };
        let ((x0, x1), (y0, y1)) = (span(0), span(1));
        if !(x1 > 0.0 && y1 > 0.0 && x0 < most && y0 < most) {
            return;
        }
        let density = weight / ((x1 - x0) * (y1 - y0));
        let (c0, c1) = (x0.max(0.0) as usize, (x1.min(most - 0.5)) as usize);
        let (r0, r1) = (y0.max(0.0) as usize, (y1.min(most - 0.5)) as usize);
        for row in r0..=r1 {
            let tall = y1.min(row as f64 + 1.0) - y0.max(row as f64);
            for column in c0..=c1 {
                let wide = x1.min(column as f64 + 1.0) - x0.max(column as f64);
                self.light[row * self.bins + column] += density * (tall * wide).max(0.0);
            }
        }
    }

    pub(super) fn scale(&mut self, factor: f64) {
        self.light.iter_mut().for_each(|l| *l *= factor);
    }

    /// Fills the grid from intensities at bin centres (times the area of a bin), integrated over bins to second order.
    pub(super) fn fill_from_points(&mut self, point: impl Fn(usize) -> f64) {
        let n = self.bins;
        let points: Vec<f64> = (0..n * n).map(point).collect();
        for row in 0..n {
            for column in 0..n {
                let here = points[row * n + column];
                let bent = if row > 0 && column > 0 && row + 1 < n && column + 1 < n {
                    let i = row * n + column;
                    points[i - 1] + points[i + 1] + points[i - n] + points[i + n] - 4.0 * here
                } else {
                    0.0
                };
                self.light[row * n + column] = here + bent / 24.0;
            }
        }
    }

    /// Returns the summed-area table of the bins, with one row and column more than bins.
    fn summed_area(&self) -> Vec<f64> {
        let n = self.bins;
        let mut sums = vec![0.0; (n + 1) * (n + 1)];
        for row in 0..n {
            let mut line = 0.0;
            for column in 0..n {
                line += self.light[row * n + column];
                sums[(row + 1) * (n + 1) + column + 1] = sums[row * (n + 1) + column + 1] + line;
            }
        }
        sums
    }
}

/// The radial profile of a halo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum HaloProfile {
    /// exp(-r / R).
    Exponential,
    /// (1 + r² / R²)^-2.
    Power,
}

/// A wide faint halo.
#[derive(Debug, Clone, Copy)]
pub(super) struct Halo {
    /// Share of the light.
    pub(super) share: f64,
    /// R, px.
    pub(super) radius_px: f64,
    pub(super) profile: HaloProfile,
}

/// A tone curve, for values from 0 to 1.
#[derive(Debug, Clone, Copy)]
pub(super) enum Tone {
    /// v to the given power.
    Power(f64),
    /// v / (1 + k v).
    Compress(f64),
    /// v clipped at the given value.
    Clip(f64),
}

impl Tone {
    pub(super) fn apply(self, value: f64) -> f64 {
        let v = value.max(0.0);
        match self {
            Self::Power(g) => libm::pow(v, g),
            Self::Compress(k) => v / (1.0 + k * v),
            Self::Clip(most) => v.min(most),
        }
    }
}

/// A sensor, with its effects in the order of application; by default square pixels of width 1.
#[derive(Debug, Clone, Default)]
pub(super) struct Sensor {
    /// Copies of the image: shift (x, y) in px, and weight. Empty for the image itself.
    pub(super) copies: Vec<[f64; 3]>,
    pub(super) halo: Option<Halo>,
    /// Amount and radius (standard deviation, px) of an unsharp mask on the pixels.
    pub(super) sharpen: Option<[f64; 2]>,
    /// Tone curve of exposed tiles. The caller applies it.
    pub(super) tone: Option<Tone>,
}

/// Largest depth of negative lobes as a share of the peak, as in files with a black level.
const DEEPEST_LOBE: f64 = 0.004;

impl Sensor {
    /// Convolves the present copies with `copies`.
    pub(super) fn spread(&mut self, copies: &[[f64; 3]]) {
        if self.copies.is_empty() {
            self.copies = vec![[0.0, 0.0, 1.0]];
        }
        self.copies = self
            .copies
            .iter()
            .flat_map(|a| {
                copies
                    .iter()
                    .map(|b| [a[0] + b[0], a[1] + b[1], a[2] * b[2]])
            })
            .collect();
    }

    /// Returns the shift of the centroid by the copies, px.
    pub(super) fn shift(&self) -> [f64; 2] {
        let sum = |i: usize| self.copies.iter().map(|c| c[i] * c[2]).sum::<f64>();
        [sum(0), sum(1)]
    }

    /// Returns the tile of `width` x `width` pixels, row-major, before any tone curve.
    pub(super) fn integrate(&self, fine: &FineGrid, width: usize) -> Vec<f64> {
        let mut tile = self.pixels(fine, width);
        if let Some(halo) = self.halo {
            tile = scatter(&tile, width, halo);
        }
        if let Some([amount, sigma]) = self.sharpen {
            tile = sharpen(&tile, width, amount, sigma);
        }
        tile
    }

    fn pixels(&self, fine: &FineGrid, width: usize) -> Vec<f64> {
        let n = fine.bins;
        let margin = (n / BINS - width) / 2;
        let mut tile = vec![0.0; width * width];
        if self.copies.is_empty() {
            for row in 0..width * BINS {
                for column in 0..width * BINS {
                    tile[row / BINS * width + column / BINS] +=
                        fine.light[(row + margin * BINS) * n + column + margin * BINS];
                }
            }
            return tile;
        }
        let sums = fine.summed_area();
        let stride = n + 1;
        // Bin and position in it of each pixel edge, for an image shifted by `shift`.
        let edges = |shift: f64| -> Vec<(usize, f64)> {
            (0..=width)
                .map(|edge| {
                    let at = ((edge + margin) as f64 - shift) * BINS as f64;
                    let at = at.clamp(0.0, n as f64);
                    let bin = (at as usize).min(n - 1);
                    (bin, at - bin as f64)
                })
                .collect()
        };
        let (mut upper, mut lower) = (vec![0.0; width + 1], vec![0.0; width + 1]);
        for [shift_x, shift_y, weight] in &self.copies {
            let (xs, ys) = (edges(*shift_x), edges(*shift_y));
            for (row, &(bin_y, part_y)) in ys.iter().enumerate() {
                for (at, &(bin_x, part_x)) in lower.iter_mut().zip(&xs) {
                    let i = bin_y * stride + bin_x;
                    let top = sums[i] + part_x * (sums[i + 1] - sums[i]);
                    let j = i + stride;
                    let bottom = sums[j] + part_x * (sums[j + 1] - sums[j]);
                    *at = top + part_y * (bottom - top);
                }
                if row > 0 {
                    for column in 0..width {
                        tile[(row - 1) * width + column] += weight
                            * (lower[column + 1] - lower[column] - upper[column + 1]
                                + upper[column]);
                    }
                }
                std::mem::swap(&mut upper, &mut lower);
            }
        }
        tile
    }
}

/// Returns `tile` with a share of the light of every pixel moved into its halo.
fn scatter(tile: &[f64], width: usize, halo: Halo) -> Vec<f64> {
    const PARTS: usize = 3;
    let density = |r: f64| {
        let s = r / halo.radius_px;
        let area = PI * halo.radius_px * halo.radius_px;
        match halo.profile {
            HaloProfile::Exponential => libm::exp(-s) / (2.0 * area),
            HaloProfile::Power => 1.0 / ((1.0 + s * s) * (1.0 + s * s) * area),
        }
    };
    // One quadrant of the kernel, averaged over pixels.
    let mut quadrant = vec![0.0; width * width];
    for row in 0..width {
        for column in 0..width {
            let mut sum = 0.0;
            for i in 0..PARTS * PARTS {
                let part = |k: usize| (k as f64 + 0.5) / PARTS as f64 - 0.5;
                let (x, y) = (
                    column as f64 + part(i % PARTS),
                    row as f64 + part(i / PARTS),
                );
                sum += density(x.hypot(y));
            }
            quadrant[row * width + column] = sum / (PARTS * PARTS) as f64;
        }
    }
    let full = 2 * width - 1;
    let lines: Vec<f64> = (0..width * full)
        .map(|i| quadrant[i / full * width + (i % full).abs_diff(width - 1)])
        .collect();
    let mut out: Vec<f64> = tile.iter().map(|t| t * (1.0 - halo.share)).collect();
    for from_row in 0..width {
        for from_column in 0..width {
            let light = halo.share * tile[from_row * width + from_column];
            if light == 0.0 {
                continue;
            }
            for row in 0..width {
                let start = row.abs_diff(from_row) * full + width - 1 - from_column;
                let line = &lines[start..start + width];
                for (o, k) in out[row * width..(row + 1) * width].iter_mut().zip(line) {
                    *o += light * k;
                }
            }
        }
    }
    out
}

/// Returns `tile` after an unsharp mask, tile + amount (tile - blurred tile), with negative lobes limited.
fn sharpen(tile: &[f64], width: usize, amount: f64, sigma: f64) -> Vec<f64> {
    let weights: Vec<f64> = (0..width)
        .map(|d| libm::exp(-((d * d) as f64) / (2.0 * sigma * sigma)))
        .collect();
    let total: f64 = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
    let pass = |from: &[f64], step: usize, stride: usize| -> Vec<f64> {
        let mut to = vec![0.0; from.len()];
        for line in 0..width {
            for i in 0..width {
                to[line * stride + i * step] = (0..width)
                    .map(|j| from[line * stride + j * step] * weights[i.abs_diff(j)] / total)
                    .sum();
            }
        }
        to
    };
    let soft = pass(&pass(tile, 1, width), width, 1);
    let sharp: Vec<f64> = tile
        .iter()
        .zip(&soft)
        .map(|(t, s)| t + amount * (t - s))
        .collect();
    let floor = -DEEPEST_LOBE * sharp.iter().copied().fold(0.0, f64::max);
    sharp.into_iter().map(|v| v.max(floor)).collect()
}
