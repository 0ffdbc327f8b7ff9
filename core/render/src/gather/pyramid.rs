//! The image pyramid: downsampling by two and upsampling again.
//!
//! Both use the same symmetric low-pass of [`TAPS`] taps, a sinc under a Kaiser window. The kernels of a level
//! compensate its attenuation in the pass band (`passband`). A coarse pixel covers two fine ones along each axis; its
//! centre is where theirs meet. Coarse samples are light per fine pixel, so an even plate keeps its value.

use super::image::{Image, Rect, View};
use rayon::prelude::*;
use std::sync::LazyLock;

/// Taps along one axis.
pub(super) const TAPS: usize = 12;
/// Cut-off frequency, cycles per fine pixel, and shape parameter of the Kaiser window. Chosen to minimise loss and
/// aliasing under a Gaussian of 1.15 coarse pixels, with the pass band compensated.
const CUTOFF: f64 = 0.22;
const KAISER: f64 = 5.0;
const HALF: i32 = TAPS as i32 / 2;

/// The taps, of unit sum.
static EXACT_TAPS: LazyLock<[f64; TAPS]> = LazyLock::new(computed_taps);

/// Returns the taps as they are applied to samples.
fn taps() -> [f32; TAPS] {
    EXACT_TAPS.map(|tap| tap as f32)
}

fn computed_taps() -> [f64; TAPS] {
    let mut taps = [0.0_f64; TAPS];
    for (k, tap) in taps.iter_mut().enumerate() {
        let at = k as f64 - f64::from(HALF) + 0.5;
        let angle = std::f64::consts::TAU * CUTOFF * at;
        let rest = 1.0 - (at / f64::from(HALF)).powi(2);
        *tap = angle.sin() / angle * bessel(KAISER * rest.sqrt());
    }
    let sum: f64 = taps.iter().sum();
    taps.map(|tap| tap / sum)
}

/// Returns the frequency response of the low-pass at `frequency`, cycles per fine pixel.
pub(super) fn response(frequency: f64) -> f64 {
    let waves = EXACT_TAPS.iter().enumerate().map(|(k, tap)| {
        let at = k as f64 - f64::from(HALF) + 0.5;
        tap * (std::f64::consts::TAU * frequency * at).cos()
    });
    waves.sum()
}

/// Returns the modified Bessel function of the first kind and order zero by its power series, for arguments up to
/// about 12.
fn bessel(x: f64) -> f64 {
    let quarter = x * x / 4.0;
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..40 {
        term *= quarter / f64::from(k * k);
        sum += term;
    }
    sum
}

/// Margin of coarse pixels that upsampling reads around a rectangle.
pub(super) const MARGIN: i32 = HALF / 2;

/// Downsamples by two along each axis. The result extends to all coarse pixels that receive light.
pub(super) fn downsample(fine: &View) -> Image {
    let range = |start: i32, size: usize| {
        let end = start + size as i32;
        // Coarse pixel i reads fine pixels 2 i - HALF + 1 to 2 i + HALF.
        let first = (start - HALF).div_euclid(2) + (start - HALF).rem_euclid(2);
        first..(end - 1 + HALF - 1).div_euclid(2) + 1
    };
    let (columns, rows) = (range(fine.left, fine.width), range(fine.top, fine.height));
    let mut coarse = Image::zeros(Rect {
        left: columns.start,
        top: rows.start,
        width: columns.len(),
        height: rows.len(),
    });
    let taps = taps();
    let width = coarse.width;
    // Most rows of a depth layer are black.
    let lit: Vec<bool> = fine
        .samples
        .par_chunks(fine.width.max(1))
        .map(|row| row.iter().any(|sample| *sample != 0.0))
        .collect();
    coarse
        .samples
        .par_chunks_mut(width)
        .zip(rows)
        .for_each_init(DownsampleBuffers::default, |buffers, (out, row)| {
            buffers.row(fine, &lit, columns.start, row, &taps, out);
        });
    coarse
}

/// Buffers of one row.
#[derive(Default)]
struct DownsampleBuffers {
    line: Vec<f32>,
    even: Vec<f32>,
    odd: Vec<f32>,
}

impl DownsampleBuffers {
    /// Computes the coarse pixels of `row` from column `first` on. Rows of `fine` that are not `lit` are skipped.
    fn row(
        &mut self,
        fine: &View,
        lit: &[bool],
        first: i32,
        row: i32,
        taps: &[f32; TAPS],
        out: &mut [f32],
    ) {
        // Two fine samples per coarse one, and the taps beyond.
        let left = 2 * first - HALF + 1;
        self.line.clear();
        self.line.resize(2 * (out.len() + HALF as usize), 0.0);
        let place = (fine.left - left) as usize;
        let mut sum = WeightedSum::new(&mut self.line[place..place + fine.width]);
        for (k, tap) in taps.iter().enumerate() {
            let y = 2 * row + k as i32 - HALF + 1 - fine.top;
            if (0..fine.height as i32).contains(&y) && lit[y as usize] {
                let start = y as usize * fine.width;
                sum.add(&fine.samples[start..start + fine.width], *tap);
            }
        }
        if sum.count == 0 {
            return;
        }
        sum.write();
        let (pairs, _) = self.line.as_chunks::<2>();
        self.even.clear();
        self.even.extend(pairs.iter().map(|p| p[0]));
        self.odd.clear();
        self.odd.extend(pairs.iter().map(|p| p[1]));
        let width = out.len();
        let mut sum = WeightedSum::new(out);
        for (k, pair) in taps.as_chunks::<2>().0.iter().enumerate() {
            sum.add(&self.even[k..k + width], pair[0]);
            sum.add(&self.odd[k..k + width], pair[1]);
        }
        sum.write();
    }
}

/// Buffers of [`upsample_tile`].
#[derive(Default)]
pub(super) struct UpsampleBuffers {
    taps: Option<[f32; TAPS]>,
    window: Vec<f32>,
    tall: Vec<f32>,
    even: Vec<f32>,
    odd: Vec<f32>,
}

/// Upsamples the tile of `side` x `side` pixels at (`left`, `top`) from the next coarser level into `out`, row-major.
///
/// Side, left and top are even.
pub(super) fn upsample_tile(
    coarse: &View,
    left: i32,
    top: i32,
    side: usize,
    buffers: &mut UpsampleBuffers,
    out: &mut [f32],
) {
    let taps = *buffers.taps.get_or_insert_with(taps);
    let (width, height) = (side / 2 + HALF as usize, side / 2 + HALF as usize);
    let window = Rect {
        left: left.div_euclid(2) - MARGIN,
        top: top.div_euclid(2) - MARGIN,
        width,
        height,
    };
    buffers.window.resize(height * width, 0.0);
    if !coarse.copy(window, width, &mut buffers.window) {
        out.fill(0.0);
        return;
    }
    buffers.tall.resize(width, 0.0);
    for (row, line) in out.chunks_exact_mut(side).enumerate() {
        // Fine pixel 2 m reads coarse m - 5 to m + 4 with the odd taps from the last on; 2 m + 1 reads m - 4 to
        // m + 5 with the even ones.
        let (m, odd) = (row / 2, row % 2);
        let mut sum = WeightedSum::new(&mut buffers.tall);
        for k in 0..HALF as usize {
            let source = &buffers.window[(m + k + odd) * width..][..width];
            sum.add(source, 2.0 * taps[TAPS - 1 - odd - 2 * k]);
        }
        sum.write();
        for (half, odd) in [(&mut buffers.even, 0), (&mut buffers.odd, 1)] {
            half.resize(side / 2, 0.0);
            let mut sum = WeightedSum::new(half);
            for k in 0..HALF as usize {
                let source = &buffers.tall[k + odd..k + odd + side / 2];
                sum.add(source, 2.0 * taps[TAPS - 1 - odd - 2 * k]);
            }
            sum.write();
        }
        let (pairs, _) = line.as_chunks_mut::<2>();
        for ((pair, even), odd) in pairs.iter_mut().zip(&buffers.even).zip(&buffers.odd) {
            *pair = [*even, *odd];
        }
    }
}

/// A weighted sum of up to [`TAPS`] lines as long as `out`, in the order added.
struct WeightedSum<'a> {
    out: &'a mut [f32],
    lines: [(&'a [f32], f32); TAPS],
    count: usize,
}

impl<'a> WeightedSum<'a> {
    fn new(out: &'a mut [f32]) -> Self {
        Self {
            out,
            lines: [(&[], 0.0); TAPS],
            count: 0,
        }
    }

    fn add(&mut self, line: &'a [f32], gain: f32) {
        self.lines[self.count] = (&line[..self.out.len()], gain);
        self.count += 1;
    }

    fn write(self) {
        pulp::Arch::new().dispatch(self);
    }
}

impl pulp::WithSimd for WeightedSum<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { out, lines, count } = self;
        out.fill(0.0);
        // Some lines at a time: with all of them in one loop, the compiler makes it a scalar one.
        let (groups, rest) = lines[..count].as_chunks::<4>();
        for [(a, ga), (b, gb), (c, gc), (d, gd)] in groups {
            let samples = a.iter().zip(*b).zip(c.iter().zip(*d));
            for (out, ((a, b), (c, d))) in out.iter_mut().zip(samples) {
                *out = *out + ga * a + gb * b + gc * c + gd * d;
            }
        }
        for (line, gain) in rest {
            for (out, sample) in out.iter_mut().zip(*line) {
                *out += gain * sample;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: usize, height: usize, of: impl Fn(f64, f64) -> f64) -> Image {
        let mut image = Image::zeros(Rect {
            left: 0,
            top: 0,
            width,
            height,
        });
        for (k, sample) in image.samples.iter_mut().enumerate() {
            *sample = of((k % width) as f64 + 0.5, (k / width) as f64 + 0.5) as f32;
        }
        image
    }

    /// The light of a point survives downsampling, where it counts a quarter, and upsampling.
    #[test]
    fn the_pyramid_keeps_light() {
        for (x, y) in [(0, 0), (7, 3), (20, 13)] {
            let point = image(21, 14, |u, v| {
                f64::from(u8::from(u as usize == x && v as usize == y))
            });
            let coarse = downsample(&point.view());
            let sum: f32 = coarse.samples.iter().sum();
            assert!((sum - 0.25).abs() < 2e-3, "{sum}");
            let mut out = vec![0.0; 64 * 64];
            upsample_tile(
                &coarse.view(),
                -20,
                -20,
                64,
                &mut UpsampleBuffers::default(),
                &mut out,
            );
            let sum: f32 = out.iter().sum();
            assert!((sum - 1.0).abs() < 1e-2, "{sum}");
        }
    }
}
