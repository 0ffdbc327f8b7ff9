//! The Wiener filter: ten lines of NumPy, and the yardstick of blur removal.

use seidel_core::Tile;
use seidel_fourier::{Complex, Planner, fast_length};

use crate::picture::Picture;

/// Ratios of the power of noise to that of the picture that are tried.
const RATIOS: [f32; 9] = [1e-7, 1e-6, 1e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 1e-1];

/// Returns the peak signal-to-noise ratio of the Wiener filter O conj(H) / (|H|² + K) against `truth`, dB, without `border` pixels
/// on each side. O is the spectrum of `blurred`, continued by reflection over its borders, and H that of `psf`. K is the best of
/// [`RATIOS`], which no user can know.
pub(crate) fn best_psnr(blurred: &Picture, psf: &Tile, truth: &Picture, border: usize) -> f64 {
    let side = blurred.side;
    // Reflected up to a period of twice the side, so that no edge is cut.
    let period = fast_length(2 * side);
    let reflect = |at: usize| match at % period {
        at if at < side => at,
        at if at < side + (period - side) / 2 => side - 1 - (at - side).min(side - 1),
        at => (period - 1 - at).min(side - 1),
    };
    let mut spectrum = vec![Complex::default(); period * period];
    for row in 0..period {
        for column in 0..period {
            let sample = blurred.samples[reflect(row) * side + reflect(column)];
            spectrum[row * period + column] = Complex::new(sample, 0.0);
        }
    }
    let mut transfer = vec![Complex::default(); period * period];
    let (centre_x, centre_y) = (psf.width() / 2, psf.height() / 2);
    let sum: f32 = psf.samples().iter().sum();
    for (k, light) in psf.samples().iter().enumerate() {
        let column = (k % psf.width() + period - centre_x) % period;
        let row = (k / psf.width() + period - centre_y) % period;
        transfer[row * period + column] += light / sum;
    }
    transform(&mut spectrum, period, true);
    transform(&mut transfer, period, true);
    let scores = RATIOS.map(|ratio| {
        let pairs = spectrum.iter().zip(&transfer);
        let mut restored: Vec<Complex<f32>> = pairs
            .map(|(o, h)| o * h.conj() / (h.norm_sqr() + ratio))
            .collect();
        transform(&mut restored, period, false);
        let scale = 1.0 / (period * period) as f32;
        let rows = (0..side).map(|row| row * period);
        let samples = rows.flat_map(|first| restored[first..first + side].iter());
        let samples = samples.map(|c| c.re * scale).collect();
        Picture { side, samples }.psnr(truth, border)
    });
    scores.into_iter().fold(f64::NEG_INFINITY, f64::max)
}

/// Transforms a square of `side` x `side` samples in place, without normalisation.
fn transform(square: &mut [Complex<f32>], side: usize, forward: bool) {
    let mut planner = Planner::<f32>::new();
    let plan = if forward {
        planner.forward(side)
    } else {
        planner.inverse(side)
    };
    // Rows, columns as rows of the transposed square, and back.
    for _ in 0..2 {
        plan.process(square);
        for row in 0..side {
            for column in 0..row {
                square.swap(row * side + column, column * side + row);
            }
        }
    }
}
