//! Subpixel shifts of small images by cubic B-spline interpolation.
//!
//! As in the reference study the image is mirrored about the centres of its outer pixels for the prefilter,
//! and zero beyond those centres.

/// Cubic B-spline through the samples of a square image.
#[derive(Debug, Clone)]
pub(super) struct Spline {
    side: usize,
    coefficients: Vec<f64>,
}

/// Pole of the prefilter, sqrt(3) - 2.
const POLE: f64 = -0.267_949_192_431_122_7;
/// Gain of the prefilter, (1 - z)(1 - 1 / z), which preserves constants.
const GAIN: f64 = 6.0;

impl Spline {
    /// Interpolates `samples`, row-major, `side` per row.
    pub(super) fn through(samples: &[f64], side: usize) -> Self {
        debug_assert_eq!(samples.len(), side * side);
        let mut coefficients = samples.to_vec();
        if side > 1 {
            let mut line = vec![0.0; side];
            for row in coefficients.chunks_exact_mut(side) {
                filter(row);
            }
            for column in 0..side {
                for (row, value) in line.iter_mut().enumerate() {
                    *value = coefficients[row * side + column];
                }
                filter(&mut line);
                for (row, value) in line.iter().enumerate() {
                    coefficients[row * side + column] = *value;
                }
            }
        }
        Self { side, coefficients }
    }

    /// Returns the image shifted by (`dx`, `dy`) px, with zeros shifted in.
    pub(super) fn shifted(&self, dx: f64, dy: f64) -> Vec<f64> {
        let across = taps(self.side, dx);
        let down = taps(self.side, dy);
        let mut out = vec![0.0; self.side * self.side];
        let mut line = vec![0.0; self.side];
        for (row, tap) in out.chunks_exact_mut(self.side).zip(&down) {
            let Some(tap) = tap else { continue };
            line.fill(0.0);
            for (index, weight) in tap.iter() {
                let source = &self.coefficients[index * self.side..][..self.side];
                for (sum, value) in line.iter_mut().zip(source) {
                    *sum += weight * value;
                }
            }
            for (sample, tap) in row.iter_mut().zip(&across) {
                if let Some(tap) = tap {
                    *sample = tap.iter().map(|(index, weight)| weight * line[index]).sum();
                }
            }
        }
        out
    }
}

/// Indices and weights of the four coefficients under one sample.
struct Tap([usize; 4], [f64; 4]);

impl Tap {
    fn iter(&self) -> impl Iterator<Item = (usize, f64)> {
        self.0.into_iter().zip(self.1)
    }
}

/// Returns the taps of every sample of a line shifted by `shift` px; `None` outside.
fn taps(side: usize, shift: f64) -> Vec<Option<Tap>> {
    let last = side as i64 - 1;
    (0..side)
        .map(|index| {
            let at = index as f64 - shift;
            if !(at >= 0.0 && at <= last as f64) {
                return None;
            }
            let start = at.floor();
            let t = at - start;
            let u = 1.0 - t;
            let weights = [
                u * u * u / 6.0,
                (4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0,
                (4.0 - 6.0 * u * u + 3.0 * u * u * u) / 6.0,
                t * t * t / 6.0,
            ];
            // Mirrored about the outer samples; only one or two steps outside occur.
            let inside = |k: i64| {
                let k = k.abs();
                let k = if k > last { 2 * last - k } else { k };
                k.clamp(0, last) as usize
            };
            let start = start as i64;
            Some(Tap(
                [start - 1, start, start + 1, start + 2].map(inside),
                weights,
            ))
        })
        .collect()
}

/// Converts samples to B-spline coefficients in place, by a causal and an anticausal recursive filter (Unser
/// 1999). The line has at least two samples.
fn filter(line: &mut [f64]) {
    let count = line.len();
    let far = POLE.powi(count as i32 - 1);
    // Exact initial value for the mirrored, periodic line.
    let mut power = POLE;
    let mut first = GAIN * (line[0] + far * line[count - 1]);
    for index in 1..count - 1 {
        first += GAIN * power * (line[index] + far * line[count - 1 - index]);
        power *= POLE;
    }
    line[0] = first / (1.0 - far * far);
    for index in 1..count {
        line[index] = GAIN * line[index] + POLE * line[index - 1];
    }
    line[count - 1] = (POLE * line[count - 2] + line[count - 1]) * POLE / (POLE * POLE - 1.0);
    for index in (0..count - 1).rev() {
        line[index] = POLE * (line[index + 1] - line[index]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bumpy(side: usize) -> Vec<f64> {
        (0..side * side)
            .map(|k| ((k * k % 97) as f64 * 0.31).sin())
            .collect()
    }

    #[test]
    fn a_whole_shift_moves_samples() {
        let side = 11;
        let samples = bumpy(side);
        let out = Spline::through(&samples, side).shifted(2.0, -3.0);
        for y in 0..side {
            for x in 0..side {
                let want = if x >= 2 && y + 3 < side {
                    samples[(y + 3) * side + x - 2]
                } else {
                    0.0
                };
                let got = out[y * side + x];
                assert!((got - want).abs() < 1e-13, "({x}, {y}): {got} {want}");
            }
        }
    }

    #[test]
    fn a_smooth_function_is_interpolated() {
        // A cosine that matches the mirrored border; the error of a cubic spline is about (2 pi f)^4 / 400.
        let side = 33;
        let turn = std::f64::consts::TAU / 32.0;
        let wave = |x: f64, y: f64| (turn * x).cos() * (1.0 + 0.5 * (2.0 * turn * y).cos());
        let samples: Vec<f64> = (0..side * side)
            .map(|k| wave((k % side) as f64, (k / side) as f64))
            .collect();
        let (dx, dy) = (0.37, -1.61);
        let out = Spline::through(&samples, side).shifted(dx, dy);
        for y in 2..side - 2 {
            for x in 2..side - 2 {
                let want = wave(x as f64 - dx, y as f64 - dy);
                assert!((out[y * side + x] - want).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn one_pixel_is_its_own_spline() {
        assert_eq!(Spline::through(&[3.0], 1).shifted(0.0, 0.0), [3.0]);
    }
}
