//! Band-limited resampling of planes by a similarity transform.

use rayon::prelude::*;
use seidel_optics::field::ImagePoint;

use super::similarity::Similarity;

/// Lobes of the Lanczos kernel where pixels keep their size. Three lobes would lower the contrast of fine texture by several
/// per cent, which looks like blur of the picture.
const LOBES: f64 = 8.0;
/// Least number of lobes where pixels grow, and the kernel with them.
const LEAST_LOBES: f64 = 3.0;
/// Samples of the kernel per pixel: linear interpolation between them is exact to 1e-6.
const TABLE_STEPS: f64 = 1024.0;
/// Distance from a clipped pixel, px, within which resampled values are unknown.
const CLIPPED_REACH: f64 = 2.0;
/// Distance from a sample at which a point lies on it, px.
const ON_SAMPLE: f64 = 1e-9;

/// Planes of one picture; samples that are not finite are unknown.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Planes<'a> {
    /// Columns.
    pub(crate) width: usize,
    /// Rows.
    pub(crate) height: usize,
    /// Samples of each plane, row-major.
    pub(crate) planes: &'a [Vec<f32>],
    /// Value from which samples are clipped.
    pub(crate) clip: Option<f32>,
}

impl Planes<'_> {
    /// Returns the planes moved by `transform` on the pixels of a picture of `size`. Values that depend on unknown samples, or
    /// lie beside clipped ones, are NaN.
    pub(crate) fn moved(&self, transform: &Similarity, size: (usize, usize)) -> Vec<Vec<f32>> {
        let back = transform.inverse();
        let kernel = Kernel::new(back.scale().max(1.0));
        let (width, height) = size;
        self.planes
            .iter()
            .map(|plane| {
                let rows = (0..height).into_par_iter().map_init(
                    || (Taps::default(), Taps::default()),
                    |(across, down), y| -> Vec<f32> {
                        let cells = (0..width).map(|x| {
                            let at = back.apply(ImagePoint::new(x as f64 + 0.5, y as f64 + 0.5));
                            kernel.fill(at.x_px - 0.5, self.width, across);
                            kernel.fill(at.y_px - 0.5, self.height, down);
                            self.sample(plane, across, down)
                        });
                        cells.collect()
                    },
                );
                rows.collect::<Vec<_>>().concat()
            })
            .collect()
    }

    fn sample(&self, plane: &[f32], across: &Taps, down: &Taps) -> f32 {
        let count = across.weights.len();
        let (mut sum, mut all) = (0.0, 0.0);
        for (row, down_weight) in (down.first..).zip(&down.weights) {
            let line = &plane[row * self.width + across.first..][..count];
            let of_row: f64 = (line.iter().zip(&across.weights))
                .map(|(value, weight)| weight * f64::from(*value))
                .sum();
            sum += down_weight * of_row;
            all += down_weight * across.sum;
        }
        // Unknown samples make the sum unknown; without taps it is 0 / 0.
        let value = (sum / all) as f32;
        match self.clip {
            Some(clip) if self.is_near_clipped(plane, clip, across, down) => f32::NAN,
            _ => value,
        }
    }

    fn is_near_clipped(&self, plane: &[f32], clip: f32, across: &Taps, down: &Taps) -> bool {
        down.near.clone().any(|row| {
            let line = &plane[row * self.width..][..self.width];
            line[across.near.clone()].iter().any(|v| *v >= clip)
        })
    }
}

/// A tabulated Lanczos kernel.
struct Kernel {
    table: Vec<f64>,
    /// Half its width, px.
    reach: f64,
    /// Size of a pixel of the result, px.
    stretch: f64,
}

/// Weights of the samples of one row or column about a point; none where the kernel leaves the plane.
#[derive(Default)]
struct Taps {
    first: usize,
    weights: Vec<f64>,
    sum: f64,
    /// The samples that clip the result.
    near: std::ops::Range<usize>,
}

impl Kernel {
    fn new(stretch: f64) -> Self {
        let lobes = (LOBES / stretch).round().max(LEAST_LOBES);
        let steps = (lobes * TABLE_STEPS) as usize + 2;
        let sinc = |x: f64| {
            let turn = std::f64::consts::PI * x;
            if turn == 0.0 { 1.0 } else { turn.sin() / turn }
        };
        let value = |x: f64| {
            if x < lobes {
                sinc(x) * sinc(x / lobes)
            } else {
                0.0
            }
        };
        Self {
            table: (0..steps).map(|k| value(k as f64 / TABLE_STEPS)).collect(),
            reach: lobes * stretch,
            stretch,
        }
    }

    fn at(&self, distance: f64) -> f64 {
        let place = distance.abs() / self.stretch * TABLE_STEPS;
        let index = place as usize;
        let share = place - index as f64;
        match self.table.get(index..index + 2) {
            Some(&[low, high]) => low + share * (high - low),
            _ => 0.0,
        }
    }

    /// Fills `taps` with the weights of a line of `length` samples about the point `at`.
    fn fill(&self, at: f64, length: usize, taps: &mut Taps) {
        taps.weights.clear();
        let nearest = at.round();
        let is_on_sample = self.stretch == 1.0 && (at - nearest).abs() < ON_SAMPLE;
        let (first, last) = if is_on_sample {
            (nearest, nearest)
        } else {
            ((at - self.reach).ceil(), (at + self.reach).floor())
        };
        if first < 0.0 || last >= length as f64 {
            (taps.first, taps.sum, taps.near) = (0, 0.0, 0..0);
            return;
        }
        taps.first = first as usize;
        if is_on_sample {
            taps.weights.push(1.0);
        } else {
            let weights = (taps.first..=last as usize).map(|k| self.at(k as f64 - at));
            taps.weights.extend(weights);
        }
        taps.sum = taps.weights.iter().sum();
        let near = |offset: f64| (at + offset).clamp(first, last);
        taps.near = near(-CLIPPED_REACH).ceil() as usize..near(CLIPPED_REACH).floor() as usize + 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(at: ImagePoint) -> f64 {
        (1.9 * at.x_px + 0.4 * at.y_px).sin() + (2.1 * at.y_px).cos()
    }

    /// Returns a plane whose fine texture has a period of three pixels.
    fn plane(size: (usize, usize), of: impl Fn(ImagePoint) -> f64) -> Vec<f32> {
        (0..size.0 * size.1)
            .map(|k| {
                let (x, y) = ((k % size.0) as f64, (k / size.0) as f64);
                of(ImagePoint::new(x + 0.5, y + 0.5)) as f32
            })
            .collect()
    }

    #[test]
    fn fine_texture_keeps_its_contrast_and_moves_with_the_transform() {
        let size = (70, 60);
        let (sin, cos) = 0.01_f64.sin_cos();
        let turned = Similarity {
            a: 1.01 * cos,
            b: 1.01 * sin,
            shift_px: [0.4, -0.7],
        };
        for transform in [Similarity::shift(0.37, -0.61), turned] {
            let from = Planes {
                width: size.0,
                height: size.1,
                planes: &[plane(size, wave)],
                clip: None,
            };
            let moved = &from.moved(&transform, size)[0];
            let back = transform.inverse();
            let want = plane(size, |at| wave(back.apply(at)));
            let known: Vec<usize> = (0..moved.len()).filter(|k| moved[*k].is_finite()).collect();
            assert!(known.len() > 40 * 30, "{}", known.len());
            let worst = known.iter().map(|&k| (moved[k] - want[k]).abs());
            let worst = worst.fold(0.0, f32::max);
            assert!(worst < 0.01, "{worst} of 2 by {transform:?}");
        }
    }

    #[test]
    fn whole_shifts_copy_samples_and_clipped_ones_are_unknown() {
        let size = (30, 24);
        let mut samples = plane(size, |at| 0.3 + 0.1 * wave(at));
        let from = |planes: &[Vec<f32>], transform| -> Vec<f32> {
            let from = Planes {
                width: size.0,
                height: size.1,
                planes,
                clip: Some(0.9),
            };
            from.moved(&transform, size).swap_remove(0)
        };
        let moved = from(&[samples.clone()], Similarity::shift(3.0, -2.0));
        assert_eq!(moved[5 * 30 + 8], samples[7 * 30 + 5]);
        assert!(moved[5 * 30 + 2].is_nan() && moved[22 * 30 + 8].is_nan());
        samples[12 * 30 + 14] = 1.0;
        let moved = from(&[samples], Similarity::shift(0.5, 0.0));
        assert!(moved[12 * 30 + 13].is_nan() && moved[12 * 30 + 16].is_nan());
        assert!(moved[12 * 30 + 10].is_finite() && moved[13 * 30 + 14].is_finite());
    }
}
