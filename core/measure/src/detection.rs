//! Detection of lights: a Gaussian matched filter over all channels at once, weighted by the inverse noise variance.
//!
//! The pixels of a mosaic are compared in the units of one channel: each is divided by the response of its channel, which
//! is estimated from the bright pixels of the photograph itself.

use rayon::prelude::*;

use crate::background::Background;
use crate::hot_pixels;
use crate::photograph::Photograph;

/// Light of a photograph above its background, with the channels equalised.
pub struct Signal {
    /// Columns and rows.
    pub size: (usize, usize),
    /// Equalised light of each plane.
    pub planes: Vec<Vec<f32>>,
    /// Standard deviation of the noise of each plane, in the same units.
    pub noise: Vec<Vec<f32>>,
    /// Hot pixels of each plane.
    pub hot: Vec<Vec<bool>>,
    /// Response of each channel relative to the reference channel.
    pub response: Vec<f64>,
}

/// The result of a matched filter.
pub struct Filtered {
    width: usize,
    /// Signal over noise of a light at each pixel.
    pub snr: Vec<f32>,
    /// Smoothed equalised light.
    pub smooth: Vec<f32>,
}

/// A local maximum of the matched filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak {
    /// Column.
    pub x: usize,
    /// Row.
    pub y: usize,
    /// Signal over noise.
    pub snr: f32,
    /// Smoothed equalised light, counts of the reference channel.
    pub height: f32,
}

/// Signal over noise above which pixels show the response of a channel.
const RESPONSE_SNR: f32 = 12.0;
/// Standard deviation of the smoothing for that, px.
const RESPONSE_SMOOTHING_PX: f32 = 2.0;

impl Signal {
    /// Subtracts the background, equalises the channels, and repairs hot pixels.
    pub fn new(photo: &Photograph, backgrounds: &[Background]) -> Self {
        let size = (photo.width, photo.height);
        let (width, pixels) = (photo.width, photo.width * photo.height);
        let mut planes = Vec::new();
        let mut noise = Vec::new();
        for (plane, samples) in photo.planes.iter().enumerate() {
            let pattern = photo.channel_pattern(plane);
            let at = |index: usize| {
                let (x, y) = (index % width, index / width);
                let channel = pattern[2 * (y % 2) + x % 2];
                let background = channel.map(|c| &backgrounds[c]);
                let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
                match background {
                    Some(b) => (
                        samples[index] - b.level_at(px, py) as f32,
                        b.sigma_at(px, py).max(1e-12) as f32,
                    ),
                    None => (0.0, f32::INFINITY),
                }
            };
            let (values, sigmas): (Vec<f32>, Vec<f32>) =
                (0..pixels).into_par_iter().map(at).unzip();
            planes.push(values);
            noise.push(sigmas);
        }
        let mut signal = Self {
            size,
            planes,
            noise,
            hot: Vec::new(),
            response: Vec::new(),
        };
        signal.equalise(photo);
        for plane in 0..signal.planes.len() {
            let hot = hot_pixels::find(&signal.planes[plane], &signal.noise[plane], width);
            signal.planes[plane] = hot_pixels::repaired(&signal.planes[plane], &hot, width);
            signal.hot.push(hot);
        }
        signal
    }

    /// Divides all channels by their response to the lights.
    fn equalise(&mut self, photo: &Photograph) {
        let filtered = self.filter(RESPONSE_SMOOTHING_PX);
        let width = photo.width;
        let mut sums = vec![(0.0, 0.0); photo.channels.len()];
        let patterns: Vec<[Option<usize>; 4]> = (0..self.planes.len())
            .map(|plane| photo.channel_pattern(plane))
            .collect();
        let bright = |index: usize| filtered.snr[index] > RESPONSE_SNR && !clipped(photo, index);
        for index in (0..filtered.snr.len()).filter(|k| bright(*k)) {
            for (plane, pattern) in self.planes.iter().zip(&patterns) {
                if let Some(c) = pattern[2 * (index / width % 2) + index % width % 2] {
                    sums[c].0 += f64::from(plane[index]);
                    sums[c].1 += 1.0;
                }
            }
        }
        let mean = |sum: &(f64, f64)| if sum.1 > 0.0 { sum.0 / sum.1 } else { 0.0 };
        let reference = mean(&sums[photo.reference_channel()]);
        self.response = sums
            .iter()
            .map(|sum| match mean(sum) / reference {
                ratio if ratio.is_finite() && ratio > 0.01 => ratio,
                _ => 1.0,
            })
            .collect();
        for (plane, pattern) in patterns.iter().enumerate() {
            let response = pattern.map(|c| c.map_or(1.0, |c| self.response[c] as f32));
            for index in 0..self.planes[plane].len() {
                let divisor = response[2 * (index / width % 2) + index % width % 2];
                self.planes[plane][index] /= divisor;
                self.noise[plane][index] /= divisor;
            }
        }
    }

    /// Filters with a Gaussian of standard deviation `sigma_px`.
    pub fn filter(&self, sigma_px: f32) -> Filtered {
        let (width, height) = self.size;
        let pixels = width * height;
        let mut weights = vec![0.0; pixels];
        let mut weighted = vec![0.0; pixels];
        for (values, noise) in self.planes.iter().zip(&self.noise) {
            for index in 0..pixels {
                let weight = 1.0 / (noise[index] * noise[index]);
                weights[index] += weight;
                weighted[index] += weight * values[index];
            }
        }
        let sum = gaussian(&weighted, width, sigma_px);
        let norm = gaussian(&weights, width, sigma_px);
        // The square of a Gaussian is one narrower by the root of two.
        let squares = gaussian(&weights, width, sigma_px / std::f32::consts::SQRT_2);
        let scale = 1.0 / (4.0 * std::f32::consts::PI * sigma_px * sigma_px);
        let snr = sum.iter().zip(&squares);
        let smooth = sum.iter().zip(&norm);
        Filtered {
            width,
            snr: snr
                .map(|(s, q)| s / (q * scale).sqrt().max(f32::MIN_POSITIVE))
                .collect(),
            smooth: smooth.map(|(s, n)| s / n.max(f32::MIN_POSITIVE)).collect(),
        }
    }
}

fn clipped(photo: &Photograph, index: usize) -> bool {
    photo.is_clipped(index % photo.width, index / photo.width)
}

impl Filtered {
    /// Returns the maxima within `radius` px whose signal over noise exceeds `min_snr`, brightest first.
    pub fn peaks(&self, radius: usize, min_snr: f32) -> Vec<Peak> {
        let height = self.snr.len() / self.width.max(1);
        let mut peaks: Vec<Peak> = (0..self.snr.len())
            .into_par_iter()
            .filter(|&index| {
                let value = self.snr[index];
                if value <= min_snr {
                    return false;
                }
                let (column, row) = (index % self.width, index / self.width);
                let mut window = (row.saturating_sub(radius)..(row + radius + 1).min(height))
                    .flat_map(|y| {
                        let columns =
                            column.saturating_sub(radius)..(column + radius + 1).min(self.width);
                        columns.map(move |x| y * self.width + x)
                    });
                // Of equal neighbours the first is the maximum.
                window.all(|k| {
                    self.snr[k] < value || k == index || (self.snr[k] == value && k > index)
                })
            })
            .map(|index| Peak {
                x: index % self.width,
                y: index / self.width,
                snr: self.snr[index],
                height: self.smooth[index],
            })
            .collect();
        peaks.sort_by(|a, b| b.snr.total_cmp(&a.snr).then((a.y, a.x).cmp(&(b.y, b.x))));
        peaks
    }

    /// Returns the largest distance from `peak`, px, of the connected pixels brighter than `share` of it; at most `limit`.
    pub fn extent(&self, peak: &Peak, share: f32, limit: usize) -> f64 {
        let height = self.smooth.len() / self.width.max(1);
        let cut = share * peak.height;
        let side = 2 * limit + 1;
        let mut seen = vec![false; side * side];
        let mut frontier = vec![(peak.x, peak.y)];
        let mut largest: f64 = 0.0;
        while let Some((x, y)) = frontier.pop() {
            let (dx, dy) = (x as f64 - peak.x as f64, y as f64 - peak.y as f64);
            if dx.abs().max(dy.abs()) > limit as f64 {
                continue;
            }
            let place = (y + limit - peak.y) * side + x + limit - peak.x;
            if std::mem::replace(&mut seen[place], true) || self.smooth[y * self.width + x] < cut {
                continue;
            }
            largest = largest.max(dx.hypot(dy));
            let near = [
                (x > 0).then(|| (x - 1, y)),
                (x + 1 < self.width).then(|| (x + 1, y)),
                (y > 0).then(|| (x, y - 1)),
                (y + 1 < height).then(|| (x, y + 1)),
            ];
            frontier.extend(near.into_iter().flatten());
        }
        largest
    }
}

/// Convolves with a Gaussian of standard deviation `sigma_px`. Beyond the border the edge pixels repeat.
fn gaussian(values: &[f32], width: usize, sigma_px: f32) -> Vec<f32> {
    let reach = (4.0 * sigma_px).ceil() as usize;
    let mut taps: Vec<f32> = (0..=2 * reach)
        .map(|k| (-0.5 * ((k as f32 - reach as f32) / sigma_px).powi(2)).exp())
        .collect();
    let sum: f32 = taps.iter().sum();
    taps.iter_mut().for_each(|t| *t /= sum);
    let height = values.len() / width.max(1);
    let inside = |at: usize, k: usize, count: usize| (at + k).saturating_sub(reach).min(count - 1);
    let mut across = vec![0.0; values.len()];
    across
        .par_chunks_mut(width)
        .zip(values.par_chunks(width))
        .for_each(|(out, row)| {
            for (x, out) in out.iter_mut().enumerate() {
                let taps = taps.iter().enumerate();
                *out = taps.map(|(k, t)| t * row[inside(x, k, width)]).sum();
            }
        });
    let mut down = vec![0.0; values.len()];
    down.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        for (k, tap) in taps.iter().enumerate() {
            let row = &across[inside(y, k, height) * width..][..width];
            for (out, value) in out.iter_mut().zip(row) {
                *out += tap * value;
            }
        }
    });
    down
}
