//! Diffraction: the PSF is the squared modulus of the Fourier transform of the pupil function.
//!
//! W is the wavefront (its slope is the landing point of the ray, px), T the transmission and q twice the f-number
//! times the wavelength in px. The field at x is the integral over the pupil of `sqrt(T) exp(2 pi i (W(u) - x.u) / q)`,
//! whose phase is stationary where the ray through u lands on x.
//!
//! The pupil is sampled finely enough that the periodic field repeats outside the needed window, and the field finely
//! enough that its square does not alias. The spectrum of the PSF is then exact; pixels and blur are factors of it.

use std::f64::consts::{PI, TAU};

use super::extent::Extent;
use super::fourier::{C, Fourier, transpose};
use super::spectrum::{Spectrum, View, signed, sinc};
use crate::lens::{DEGREE, LocalPupil, Shadow, Stop, powers};
use seidel_fourier::fast_length;

/// Smallest distance between the rays and the next period of the tile, in q over the smallest half width of the pupil.
const SKIRT: f64 = 8.0;
/// Largest distance from the rays to which the PSF is drawn, in the unit of [`SKIRT`]: 0.25 % of the light of a round
/// pupil lies beyond.
const MOST_SKIRT: f64 = 40.0;
/// Largest number of field samples along an axis: enough for a window of 256 q.
///
/// For a wider window (rays over more than about 240 q, or a large tile and tiny q), q is raised until this many
/// samples suffice. The fringes of so small a q are hidden by pixels and blur; they only become coarser.
const MOST_SAMPLES: usize = 1024;
/// Largest period of the PSF, px, where the rays do not need more. The skirts of a narrow pupil may reach farther; they fold back.
const MOST_PERIOD_PX: f64 = 4096.0;

/// Sampling of pupil and field along one axis.
#[derive(Debug, Clone, Copy)]
struct Axis {
    /// Period of the PSF, pixels.
    pixels: usize,
    /// Tile pixel on whose centre the field is centred.
    pixel: i64,
    /// Position of that centre from the chief ray, px before the squeeze.
    centre: f64,
    /// Number of pupil samples.
    count: usize,
    /// Spacing of pupil samples, pupil radii.
    step: f64,
    /// Position of the first pupil sample.
    first: f64,
    /// Number of field samples.
    field: usize,
}

impl Axis {
    /// Plans the sampling along `axis` for diffraction of scale `q` px; `unit` is q over the smallest half width of the
    /// pupil.
    fn new(
        pupil: &LocalPupil,
        q: f64,
        unit: f64,
        extent: &Extent,
        view: &View,
        axis: usize,
    ) -> Self {
        let (low, high) = (extent.low[axis], extent.high[axis]);
        let corner = view.corner[axis];
        let pixel = ((low + high) / 2.0 - corner).floor();
        let centre = corner + pixel + 0.5;
        let half = (high - centre).max(centre - low).max(0.0);
        let room = view.room[axis];
        let end = corner + view.size[axis] as f64 + room;
        let far = (end - centre).abs().max((corner - room - centre).abs());
        let squeeze = pupil.squeeze[axis].abs();
        let unit = unit * squeeze;
        let alone = far.max(half) + half + SKIRT * unit;
        let asked = alone.max(2.0 * far);
        let rays = 2.0 * (half + room);
        let most = (rays + 2.0 * MOST_SKIRT * unit).min(MOST_PERIOD_PX.max(rays));
        let pixels = fast_length(asked.min(most).ceil() as usize + 1);
        let step = q * squeeze / pixels as f64;
        let stops = pupil.stops();
        let side = |sign: f64| {
            let ends = stops.iter().map(|s| sign * s.centre[axis] + s.radius);
            ends.fold(f64::INFINITY, f64::min)
        };
        let (left, right) = (-side(-1.0), side(1.0));
        // One more cell on either side for the edge correction.
        let count = ((right - left) / step).ceil() as usize + 2;
        Self {
            pixels,
            pixel: pixel as i64,
            centre: centre / pupil.squeeze[axis],
            count,
            step,
            first: (left + right) / 2.0 - (count - 1) as f64 / 2.0 * step,
            field: fast_length(2 * count),
        }
    }

    /// Returns the transfer of integration over pixels and a blur of `variance_px2` at frequency `k`.
    fn transfer(&self, k: i64, variance_px2: f64) -> f64 {
        let f = k as f64 / self.pixels as f64;
        sinc(f) * (-2.0 * PI * PI * f * f * variance_px2).exp()
    }
}

/// Returns the spectrum of the diffraction PSF, including pixels and symmetric blur.
///
/// `half_width` is that returned by [`half_width`](super::extent::half_width).
pub(super) fn spectrum(
    pupil: &LocalPupil,
    half_width: f64,
    extent: &Extent,
    view: &View,
    fourier: &mut Fourier,
) -> Spectrum {
    let mut q = pupil.wave_px;
    let lay = |q: f64| [0, 1].map(|axis| Axis::new(pupil, q, q / half_width, extent, view, axis));
    let mut axes = lay(q);
    for _ in 0..20 {
        let most = axes[0].field.max(axes[1].field);
        if most <= MOST_SAMPLES {
            break;
        }
        q *= (most as f64 / MOST_SAMPLES as f64).max(1.02);
        axes = lay(q);
    }
    let [x, y] = &axes;
    let mut wave = fourier.buffer(x.count * y.count);
    let light = fill_pupil_function(pupil, q, x, y, &mut wave);

    // Computes the field; its lines end up along x.
    let plan = fourier.line(y.field);
    let mut lines = fourier.buffer(x.count * y.field);
    for (line, from) in lines
        .chunks_exact_mut(y.field)
        .zip(wave.chunks_exact(y.count))
    {
        line[..y.count].copy_from_slice(from);
    }
    let mut scratch = vec![C::default(); plan.get_inplace_scratch_len()];
    plan.process_with_scratch(&mut lines, &mut scratch);
    let plan = fourier.line(x.field);
    let mut field = fourier.buffer(x.field * y.field);
    transpose(&lines, y.field, x.count, &mut field, x.field);
    scratch.resize(plan.get_inplace_scratch_len(), C::default());
    plan.process_with_scratch(&mut field, &mut scratch);

    let mut bright: Vec<f64> = field.iter().map(C::norm_sqr).collect();
    let grid = fourier.grid([x.field, y.field]);
    // The spectrum is zero beyond these frequencies.
    let kept = x.count;
    let mut values = grid.forward(&mut bright, kept, &mut field);
    for buffer in [wave, lines, field] {
        fourier.keep(buffer);
    }
    // Normalises by the energy in the pupil: light outside the window is lost, not moved into it.
    let share = 1.0 / (light * (x.field * y.field) as f64);
    let [along_x, along_y] = pupil.blur_variances_px2().map(|v| v.max(0.0));
    let down: Vec<f64> = (0..y.field)
        .map(|k| y.transfer(signed(k, y.field), along_y))
        .collect();
    for (k, line) in values.chunks_exact_mut(y.field).enumerate() {
        let across = share * x.transfer(k as i64, along_x);
        for (value, down) in line.iter_mut().zip(&down) {
            *value *= across * down;
        }
    }
    let first = axes.map(|a| a.pixel - (a.pixels / 2) as i64);
    Spectrum {
        values,
        columns: x.field,
        rows: y.field,
        pixels: [x.pixels, y.pixels],
        first,
        origin: [x.pixel, y.pixel],
    }
}

/// Fills `wave` with the pupil function and returns its energy.
///
/// Samples along y for each sample along x, tilted so that the first field sample lies at the centres of the axes.
fn fill_pupil_function(pupil: &LocalPupil, q: f64, x: &Axis, y: &Axis, wave: &mut [C]) -> f64 {
    let mut open = vec![0.0; x.count * y.count];
    let cell = [x.step, y.step];
    let shadow = pupil.shadow();
    // The outermost cells are opaque.
    for column in 1..x.count - 1 {
        let ux = x.first + column as f64 * x.step;
        for row in 1..y.count - 1 {
            let u = [ux, y.first + row as f64 * y.step];
            let shares = pupil.stops().iter().map(|stop| share_within(stop, u, cell));
            let mut share = shares.fold(1.0, f64::min);
            if let Some(Shadow::Ring(disc) | Shadow::Part(disc)) = &shadow {
                share *= 1.0 - share_within(disc, u, cell);
            }
            open[column * y.count + row] = share;
        }
    }
    let mut light = 0.0;
    let even = pupil.transmission.is_uniform();
    for (column, line) in wave.chunks_exact_mut(y.count).enumerate() {
        let ux = x.first + column as f64 * x.step;
        // The wavefront along this line, in waves: a polynomial of u_y.
        let mut along = [0.0; DEGREE + 1];
        for ((i, j), c) in powers().zip(pupil.wavefront.coefficients()) {
            along[j] += c * ux.powi(i as i32) / q;
        }
        along[0] -= x.centre * ux / q;
        along[1] -= y.centre / q;
        let at = |column: usize, row: usize| open[column * y.count + row];
        for (row, sample) in line.iter_mut().enumerate() {
            let here = at(column, row);
            // Cell coverage is the pupil blurred by a cell, which dims the far field. The second
            // difference removes the variance of that blur, to fourth order in the cell size.
            let (before, above) = (column.saturating_sub(1), row.saturating_sub(1));
            let (after, below) = ((column + 1).min(x.count - 1), (row + 1).min(y.count - 1));
            let around = at(before, row) + at(after, row) + at(column, above) + at(column, below);
            let size = here - (around - 4.0 * here) / 24.0;
            if size == 0.0 {
                continue;
            }
            let u = [ux, y.first + row as f64 * y.step];
            let waves = along.iter().rev().fold(0.0, |sum, c| sum * u[1] + c);
            let (sin, cos) = (TAU * (waves - waves.round())).sin_cos();
            let passing = if even { 1.0 } else { pupil.transmission.at(u) };
            light += here * passing;
            let size = size * passing.sqrt();
            *sample = C::new(size * cos, size * sin);
        }
    }
    light
}

/// Returns the share of the `cell` (sides along x and y) about `u` that lies within `stop`, with its edge as a line.
fn share_within(stop: &Stop, u: [f64; 2], cell: [f64; 2]) -> f64 {
    let (dx, dy) = (u[0] - stop.centre[0], u[1] - stop.centre[1]);
    let far2 = dx * dx + dy * dy;
    let most = cell[0] + cell[1];
    let inner = (stop.radius - most).max(0.0);
    if far2 < inner * inner {
        return 1.0;
    }
    let far = far2.sqrt();
    let depth = stop.radius - far;
    if depth < -most {
        return 0.0;
    }
    if far == 0.0 {
        return 1.0;
    }
    // Projections of the sides on the normal of the edge: depths in the cell are distributed as the sum
    // of two uniform distributions of these widths.
    let (a, b) = ((dx / far).abs() * cell[0], (dy / far).abs() * cell[1]);
    let (wide, narrow) = (a.max(b), a.min(b));
    let half = (wide + narrow) / 2.0;
    if depth.abs() >= half {
        f64::from(u8::from(depth > 0.0))
    } else if depth.abs() <= (wide - narrow) / 2.0 {
        0.5 + depth / wide
    } else {
        let rest = (half - depth.abs()).powi(2) / (2.0 * wide * narrow);
        if depth > 0.0 { 1.0 - rest } else { rest }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cell_coverage_sums_to_the_area_of_the_stop() {
        let stop = Stop {
            centre: [0.1, -0.2],
            radius: 0.7,
        };
        let cell = [0.03, 0.02];
        let mut sum = 0.0;
        for i in 0..80 {
            for j in 0..120 {
                let u = [-1.1 + 0.03 * f64::from(i), -1.4 + 0.02 * f64::from(j)];
                sum += share_within(&stop, u, cell) * cell[0] * cell[1];
            }
        }
        // The straight edge loses a sagitta of about cell² / (24 radius).
        let area = PI * 0.49;
        assert!((sum / area - 1.0).abs() < 4e-4, "{}", sum / area);
    }
}
