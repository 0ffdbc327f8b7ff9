//! Straight segments of edges, by line support regions (Burns, Hanson and Riseman 1986; Grompone von Gioi et al. 2010).
//!
//! A region grows from the pixel of the largest gradient over neighbours whose gradient has about the same direction. Unlike
//! line detectors for sharp images, regions may be many pixels wide, as blurred edges are, and the direction is that from dark
//! to bright: the edges that meet at a corner of a checkerboard stay apart.

use rayon::prelude::*;

use seidel_optics::numeric::{median, quantile};

/// Largest angle between the gradient of a pixel and that of its region, rad.
const MAX_ANGLE: f64 = 0.35;
/// Gradient of a pixel over its noise that a region needs to start, and to grow.
const START_SIGMAS: f32 = 8.0;
const GROW_SIGMAS: f32 = 5.0;
/// Pixels that a region needs.
const MIN_PIXELS: usize = 20;
/// Share of the gradient in the middle of a segment at which it ends: half of it, at the corner of a square.
const END_SHARE: f64 = 0.5;
/// Step along a segment, px.
const STEP_PX: f64 = 0.5;
/// Length below which a region is noise or texture, px.
const MIN_LENGTH_PX: f64 = 8.0;

/// A straight segment between a dark and a bright side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Segment {
    /// Middle, frame px.
    pub(super) mid: [f64; 2],
    /// Unit normal, from dark to bright.
    pub(super) normal: [f64; 2],
    /// Length, px.
    pub(super) length: f64,
    /// Standard deviation of the gradient across the segment without that of the smoothing, px.
    pub(super) sigma: f64,
}

impl Segment {
    /// Returns the unit vector along the segment.
    pub(super) fn along(&self) -> [f64; 2] {
        [-self.normal[1], self.normal[0]]
    }

    /// Returns the coordinates of a frame position along the segment and along its normal, px from the middle.
    pub(super) fn coordinates(&self, x: f64, y: f64) -> [f64; 2] {
        let (dx, dy) = (x - self.mid[0], y - self.mid[1]);
        let [ux, uy] = self.along();
        [dx * ux + dy * uy, dx * self.normal[0] + dy * self.normal[1]]
    }

    /// Returns the frame position `s` px along the segment.
    pub(super) fn point(&self, s: f64) -> [f64; 2] {
        let [ux, uy] = self.along();
        [self.mid[0] + s * ux, self.mid[1] + s * uy]
    }
}

/// An image of light for the detection, smoothed.
pub(super) struct DetectionImage {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Smoothed samples.
    pub(super) samples: Vec<f32>,
    /// Standard deviation of the Gaussian of the smoothing, px.
    pub(super) smoothing: f64,
    /// Standard deviation of the gradient's noise, per px.
    pub(super) noise: f32,
}

/// Returns `samples` convolved with a Gaussian of standard deviation `sigma`; borders are extended.
pub(super) fn smooth(samples: &[f32], width: usize, sigma: f64) -> Vec<f32> {
    let height = samples.len() / width.max(1);
    let reach = (4.0 * sigma).ceil() as i64;
    let kernel: Vec<f32> = (-reach..=reach)
        .map(|k| (-(k as f64).powi(2) / (2.0 * sigma * sigma)).exp() as f32)
        .collect();
    let sum: f32 = kernel.iter().sum();
    let kernel: Vec<f32> = kernel.iter().map(|k| k / sum).collect();
    let mut rows = vec![0.0_f32; samples.len()];
    rows.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        let row = &samples[y * width..][..width];
        for (x, value) in out.iter_mut().enumerate() {
            *value = (kernel.iter().zip(-reach..))
                .map(|(k, dx)| k * row[(x as i64 + dx).clamp(0, width as i64 - 1) as usize])
                .sum();
        }
    });
    let mut result = vec![0.0_f32; samples.len()];
    result
        .par_chunks_mut(width)
        .enumerate()
        .for_each(|(y, out)| {
            for (k, dy) in kernel.iter().zip(-reach..) {
                let row = (y as i64 + dy).clamp(0, height as i64 - 1) as usize * width;
                for (value, sample) in out.iter_mut().zip(&rows[row..][..width]) {
                    *value += k * sample;
                }
            }
        });
    result
}

/// Finds the segments of `image`, the strongest first.
pub(super) fn find(image: &DetectionImage) -> Vec<Segment> {
    let (width, height) = (image.width, image.height);
    let mut gradients = vec![[0.0_f32; 2]; width * height];
    gradients
        .par_chunks_mut(width)
        .enumerate()
        .for_each(|(y, row)| {
            if y == 0 || y + 1 == height {
                return;
            }
            let inner = row.iter_mut().enumerate().skip(1);
            for (x, gradient) in inner.take(width.saturating_sub(2)) {
                let at = |x: usize, y: usize| image.samples[y * width + x];
                *gradient = [
                    (at(x + 1, y) - at(x - 1, y)) / 2.0,
                    (at(x, y + 1) - at(x, y - 1)) / 2.0,
                ];
            }
        });
    let sizes: Vec<f32> = gradients.par_iter().map(|[x, y]| x.hypot(*y)).collect();
    let (start, grow) = (START_SIGMAS * image.noise, GROW_SIGMAS * image.noise);
    let mut order: Vec<u32> = (0..sizes.len() as u32)
        .filter(|k| sizes[*k as usize] > start)
        .collect();
    order.par_sort_unstable_by(|a, b| {
        (sizes[*b as usize].total_cmp(&sizes[*a as usize])).then(a.cmp(b))
    });
    let mut regions = Regions {
        width,
        height,
        gradients: &gradients,
        sizes: &sizes,
        least: grow,
        used: vec![false; sizes.len()],
    };
    let found = order.into_iter().filter_map(|seed| {
        let seed = seed as usize;
        if regions.used[seed] {
            return None;
        }
        let region = regions.grow(seed);
        regions.segment(&region, image.smoothing)
    });
    found.collect()
}

/// The gradients that regions share among them.
struct Regions<'a> {
    width: usize,
    height: usize,
    gradients: &'a [[f32; 2]],
    sizes: &'a [f32],
    least: f32,
    used: Vec<bool>,
}

impl Regions<'_> {
    /// Returns the pixels of the region about `seed`.
    fn grow(&mut self, seed: usize) -> Vec<usize> {
        let mut pixels = vec![seed];
        self.used[seed] = true;
        // A flank is far below the ridge: the gradient of the region is that of its strong pixels.
        let least = self.least.max(0.08 * self.sizes[seed]);
        let mut sum = self.gradients[seed].map(f64::from);
        let cos_limit = MAX_ANGLE.cos();
        let mut next = 0;
        while next < pixels.len() {
            let (x, y) = (pixels[next] % self.width, pixels[next] / self.width);
            next += 1;
            for ny in y.saturating_sub(1)..(y + 2).min(self.height) {
                for nx in x.saturating_sub(1)..(x + 2).min(self.width) {
                    let index = ny * self.width + nx;
                    if self.used[index] || self.sizes[index] < least {
                        continue;
                    }
                    let [gx, gy] = self.gradients[index].map(f64::from);
                    let product = gx * sum[0] + gy * sum[1];
                    let norm = f64::from(self.sizes[index]) * sum[0].hypot(sum[1]);
                    if product >= cos_limit * norm {
                        self.used[index] = true;
                        pixels.push(index);
                        sum = [sum[0] + gx, sum[1] + gy];
                    }
                }
            }
        }
        pixels
    }

    /// Returns the segment of a region; `None` for a small one.
    fn segment(&self, pixels: &[usize], smoothing: f64) -> Option<Segment> {
        if pixels.len() < MIN_PIXELS {
            return None;
        }
        let (mut total, mut sum, mut middle) = (0.0, [0.0; 2], [0.0; 2]);
        for &pixel in pixels {
            let weight = f64::from(self.sizes[pixel]);
            let [gx, gy] = self.gradients[pixel].map(f64::from);
            let [x, y] = self.place(pixel);
            total += weight;
            sum = [sum[0] + gx, sum[1] + gy];
            middle = [middle[0] + weight * x, middle[1] + weight * y];
        }
        let norm = sum[0].hypot(sum[1]);
        let mut segment = Segment {
            mid: middle.map(|m| m / total),
            normal: sum.map(|s| s / norm),
            length: 0.0,
            sigma: 0.0,
        };
        let placed: Vec<(f64, f64, f64)> = (pixels.iter())
            .map(|&pixel| {
                let [x, y] = self.place(pixel);
                let [s, t] = segment.coordinates(x, y);
                (s, t, f64::from(self.sizes[pixel]))
            })
            .collect();
        let first = placed.iter().map(|p| p.0).fold(f64::INFINITY, f64::min);
        let last = placed.iter().map(|p| p.0).fold(f64::NEG_INFINITY, f64::max);
        if last - first < MIN_LENGTH_PX {
            return None;
        }
        // Regions end before corners, where the gradient turns. Its part along the normal falls to half at the corner itself.
        let ridge = |s: f64| {
            let [gx, gy] = self.gradient_at(segment.point(s));
            gx * segment.normal[0] + gy * segment.normal[1]
        };
        let (start, end) = (0.75 * first + 0.25 * last, 0.25 * first + 0.75 * last);
        let count = ((end - start) / STEP_PX).ceil();
        let mut inner: Vec<f64> = (0..=count as usize)
            .map(|k| ridge(start + (end - start) * k as f64 / count))
            .collect();
        let limit = END_SHARE * median(&mut inner);
        let walk = |from: f64, step: f64| {
            let mut at = from;
            while (at - from).abs() < 2.0 * (last - first) && ridge(at + step) >= limit {
                at += step;
            }
            at
        };
        let (low, high) = (walk(start, -STEP_PX), walk(end, STEP_PX));
        let shift = (low + high) / 2.0;
        let mut spread: Vec<f64> = Vec::new();
        let (mut moment, mut weights) = (0.0, 0.0);
        for (s, t, weight) in &placed {
            if (s - shift).abs() < (high - low) / 2.0 {
                moment += weight * t * t;
                weights += weight;
                spread.push(t.abs());
            }
        }
        // Regions leave out the far flanks of gradients, so the second moment is a little low.
        let variance = moment / weights.max(f64::MIN_POSITIVE) - smoothing * smoothing;
        segment.sigma = variance.max(0.3).sqrt();
        segment.mid = segment.point(shift);
        segment.length = high - low;
        // A ribbon far wider than its gradient is a curve or a texture.
        (quantile(&mut spread, 0.95) < segment.length.max(8.0)).then_some(segment)
    }

    /// Returns the gradient at a frame position, interpolated linearly.
    fn gradient_at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (x, y) = (x - 0.5, y - 0.5);
        let inside =
            x >= 0.0 && y >= 0.0 && x < (self.width - 1) as f64 && y < (self.height - 1) as f64;
        if !inside {
            return [0.0; 2];
        }
        let (left, top) = (x as usize, y as usize);
        let (tx, ty) = (x - left as f64, y - top as f64);
        let at = |dx: usize, dy: usize| self.gradients[(top + dy) * self.width + left + dx];
        [0, 1].map(|k| {
            let row =
                |dy: usize| (1.0 - tx) * f64::from(at(0, dy)[k]) + tx * f64::from(at(1, dy)[k]);
            (1.0 - ty) * row(0) + ty * row(1)
        })
    }

    fn place(&self, pixel: usize) -> [f64; 2] {
        [
            (pixel % self.width) as f64 + 0.5,
            (pixel / self.width) as f64 + 0.5,
        ]
    }
}
