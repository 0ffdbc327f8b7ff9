//! PSFs from a sampled wave: U(x) = integral over the pupil of exp(2 pi i (W(u) - x.u) / q), computed by one matrix
//! product for each axis, with |U|² summed over pixels.

use std::f64::consts::TAU;

use super::pencil::Pencil;
use super::sensor::{BINS, FineGrid};

/// A complex number.
type Complex = [f64; 2];

/// Returns the phase factor exp(i angle).
fn phase(angle: f64) -> Complex {
    let (sin, cos) = libm::sincos(angle);
    [cos, sin]
}

/// Adds the light of `pencil` with q = `wave_px` pixels to a fine grid centred on the frame position `centre`.
///
/// The pencil's light sums to 1.
pub(super) fn diffract(pencil: &Pencil, wave_px: f64, centre: [f64; 2], fine: &mut FineGrid) {
    // Sampling repeats the PSF at distances of q samples / 2, far outside the grid.
    let samples =
        ((3.6 * pencil.mask.pupil_scale * fine.width_px() / wave_px) as usize).clamp(64, 160);
    let cell = 2.0 / samples as f64;
    let bins = fine.bins();
    let at = |index: usize| (index as f64 + 0.5) * cell - 1.0;
    // The factors exp(-2 pi i x u / q) of bins and samples along an axis (0 x, 1 y).
    let kernel = |along: usize, squeeze: f64| -> (Vec<f64>, Vec<f64>) {
        let offset = centre[along] - pencil.chief[along];
        let stretch = if along == 0 { pencil.squeeze_blur } else { 1.0 };
        let mut real = Vec::with_capacity(bins * samples);
        let mut imaginary = Vec::with_capacity(bins * samples);
        for sample in 0..samples {
            for bin in 0..bins {
                let x = (offset + fine.bin_px(bin)) / stretch;
                let [c, s] = phase(-TAU * x * at(sample) * squeeze / wave_px);
                real.push(c);
                imaginary.push(s);
            }
        }
        (real, imaginary)
    };
    let [scale_x, scale_y] = pencil.pupil_axes();
    let (ex_re, ex_im) = kernel(0, scale_x);
    let (ey_re, ey_im) = kernel(1, scale_y);
    let mut field = vec![[0.0; 2]; bins * bins];
    let (mut row_re, mut row_im) = (vec![0.0; bins], vec![0.0; bins]);
    let mut light = 0.0;
    for row in 0..samples {
        row_re.fill(0.0);
        row_im.fill(0.0);
        let mut any = false;
        for column in 0..samples {
            let m = [at(column), at(row)];
            let open = pencil.mask.open(m, cell);
            if open == 0.0 {
                continue;
            }
            any = true;
            let amplitude = open * pencil.mask.transmission(m).sqrt();
            light += amplitude * amplitude;
            let [c, s] = phase(TAU * pencil.wavefront(m) / wave_px);
            let (re, im) = (amplitude * c, amplitude * s);
            let span = column * bins..(column + 1) * bins;
            let sums = row_re.iter_mut().zip(row_im.iter_mut());
            let factors = ex_re[span.clone()].iter().zip(&ex_im[span]);
            for ((sum_re, sum_im), (kr, ki)) in sums.zip(factors) {
                *sum_re += re * kr - im * ki;
                *sum_im += re * ki + im * kr;
            }
        }
        if !any {
            continue;
        }
        for y in 0..bins {
            let (kr, ki) = (ey_re[row * bins + y], ey_im[row * bins + y]);
            let line = &mut field[y * bins..(y + 1) * bins];
            for ((sum, re), im) in line.iter_mut().zip(&row_re).zip(&row_im) {
                sum[0] += kr * re - ki * im;
                sum[1] += kr * im + ki * re;
            }
        }
    }
    // Parseval: the integral of |U|² over x, in px², is q² times the light, with cells of area cell². Size and
    // squeeze of the pupil scale the field.
    let bin_area = 1.0 / (BINS * BINS) as f64;
    let squeeze = scale_x * scale_y / pencil.squeeze_blur;
    let scale = bin_area * cell * cell * squeeze / (light * wave_px * wave_px);
    fine.fill_from_points(|index| {
        let [re, im] = field[index];
        scale * (re * re + im * im)
    });
}
