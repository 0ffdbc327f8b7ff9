//! Pictures as the registration sees them: one plane, at several sizes.

/// One plane of a picture, row-major; samples that are not finite are unknown.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Samples.
    pub samples: Vec<f32>,
}

impl Picture {
    /// Returns the mean of `planes`, each `width` columns and `height` rows.
    pub fn mean_of(width: usize, height: usize, planes: &[Vec<f32>]) -> Self {
        let share = 1.0 / planes.len().max(1) as f32;
        let mut samples = vec![0.0; width * height];
        for plane in planes {
            for (sum, value) in samples.iter_mut().zip(plane) {
                *sum += share * value;
            }
        }
        Self {
            width,
            height,
            samples,
        }
    }

    /// Returns the picture reduced by `factor` along both axes, by area means.
    pub(super) fn reduced(&self, factor: usize) -> Self {
        let (width, height) = (self.width / factor, self.height / factor);
        let share = 1.0 / (factor * factor) as f32;
        let mut samples = vec![0.0; width * height];
        for (k, sum) in samples.iter_mut().enumerate() {
            let (left, top) = (k % width * factor, k / width * factor);
            for row in top..top + factor {
                let line = &self.samples[row * self.width + left..][..factor];
                *sum += share * line.iter().sum::<f32>();
            }
        }
        Self {
            width,
            height,
            samples,
        }
    }

    /// Returns the picture scaled by `scale`, by linear interpolation of its smooth version.
    pub(super) fn scaled(&self, scale: f64) -> Self {
        let size = |length: usize| ((length as f64 * scale).round() as usize).max(1);
        let (width, height) = (size(self.width), size(self.height));
        let last = |length: usize| length.saturating_sub(1) as f64;
        let sample = |x: f64, y: f64| -> f32 {
            let (x, y) = (
                x.clamp(0.0, last(self.width)),
                y.clamp(0.0, last(self.height)),
            );
            let (left, top) = (x.floor() as usize, y.floor() as usize);
            let (right, below) = (
                (left + 1).min(self.width - 1),
                (top + 1).min(self.height - 1),
            );
            let (u, v) = ((x - left as f64) as f32, (y - top as f64) as f32);
            let at = |x: usize, y: usize| self.samples[y * self.width + x];
            let upper = (1.0 - u) * at(left, top) + u * at(right, top);
            let lower = (1.0 - u) * at(left, below) + u * at(right, below);
            (1.0 - v) * upper + v * lower
        };
        let cells = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let samples = cells
            .map(|(x, y)| {
                sample(
                    (x as f64 + 0.5) / scale - 0.5,
                    (y as f64 + 0.5) / scale - 0.5,
                )
            })
            .collect();
        Self {
            width,
            height,
            samples,
        }
    }

    /// Returns the picture blurred by two box filters, with a standard deviation of two pixels. Where one picture is sharp and
    /// the other is not, their blocks then correlate.
    pub(super) fn smoothed(&self) -> Self {
        let mut samples = self.samples.clone();
        for _ in 0..2 {
            samples = box_filter(&samples, 1, self.width);
            samples = box_filter(&samples, self.width, self.height);
        }
        Self {
            samples,
            ..self.clone()
        }
    }

    /// Returns the samples less their mean, unknown ones as zero.
    pub(super) fn about_mean(&self) -> Vec<f64> {
        let known = || self.samples.iter().filter(|v| v.is_finite());
        let mean = known().map(|v| f64::from(*v)).sum::<f64>() / known().count().max(1) as f64;
        let centred = self.samples.iter().map(|v| {
            if v.is_finite() {
                f64::from(*v) - mean
            } else {
                0.0
            }
        });
        centred.collect()
    }
}

/// Half the side of a box filter less half a pixel, px.
const BOX_REACH: usize = 2;

/// Averages samples along lines of `length` whose neighbours lie `stride` apart. Boxes are cut at the ends.
fn box_filter(samples: &[f32], stride: usize, length: usize) -> Vec<f32> {
    (0..samples.len())
        .map(|k| {
            let at = k / stride % length;
            let (first, last) = (
                at.saturating_sub(BOX_REACH),
                (at + BOX_REACH).min(length - 1),
            );
            let start = k - at * stride;
            let sum: f32 = (first..=last).map(|i| samples[start + i * stride]).sum();
            sum / (last - first + 1) as f32
        })
        .collect()
}
