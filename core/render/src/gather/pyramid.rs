//! Between pyramid levels: halving the resolution and doubling it again.
//!
//! The same even low-pass of [`TAPS`] taps both ways, a sinc under a Kaiser window; what it takes from the
//! pass band the kernels give back (`passband`). A coarse pixel covers two fine ones along each axis, so
//! that its centre is where theirs meet. Coarse samples are light per fine pixel: an even plate keeps its
//! value.

use super::image::{Image, View};
use rayon::prelude::*;

/// Taps along one axis.
pub(super) const TAPS: usize = 12;
/// Edge of the band, cycles per fine pixel, and shape of the window: with the pass band given back, what
/// is lost and folded over under a Gaussian of 1.15 coarse pixels is least.
const BAND: f64 = 0.22;
const KAISER: f64 = 5.0;
const HALF: i32 = TAPS as i32 / 2;

/// The taps; they sum to one.
fn taps() -> [f32; TAPS] {
    exact_taps().map(|tap| tap as f32)
}

fn exact_taps() -> [f64; TAPS] {
    let mut taps = [0.0_f64; TAPS];
    for (k, tap) in taps.iter_mut().enumerate() {
        let at = k as f64 - f64::from(HALF) + 0.5;
        let angle = std::f64::consts::TAU * BAND * at;
        let rest = 1.0 - (at / f64::from(HALF)).powi(2);
        *tap = angle.sin() / angle * bessel(KAISER * rest.sqrt());
    }
    let sum: f64 = taps.iter().sum();
    taps.map(|tap| tap / sum)
}

/// What the low-pass leaves of a wave of `frequency`, cycles per fine pixel.
pub(super) fn response(frequency: f64) -> f64 {
    let taps = exact_taps();
    let waves = taps.iter().enumerate().map(|(k, tap)| {
        let at = k as f64 - f64::from(HALF) + 0.5;
        tap * (std::f64::consts::TAU * frequency * at).cos()
    });
    waves.sum()
}

/// The modified Bessel function of the first kind and order zero, by its power series; up to a dozen.
fn bessel(x: f64) -> f64 {
    let quarter = x * x / 4.0;
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..40 {
        term *= quarter / f64::from(k * k);
        sum += term;
    }
    sum
}

/// Pixels of the coarse level about a rectangle that doubling needs.
pub(super) const MARGIN: i32 = HALF / 2;

/// Half as many pixels along each axis, and those beyond the edges that light reaches.
pub(super) fn halved(fine: &View) -> Image {
    let range = |start: i32, size: usize| {
        let end = start + size as i32;
        // Coarse pixel i sees fine pixels 2 i - HALF + 1 to 2 i + HALF.
        let first = (start - HALF).div_euclid(2) + (start - HALF).rem_euclid(2);
        first..(end - 1 + HALF - 1).div_euclid(2) + 1
    };
    let (columns, rows) = (range(fine.left, fine.width), range(fine.top, fine.height));
    let mut coarse = Image::zeros((columns.start, rows.start), (columns.len(), rows.len()));
    let taps = taps();
    let width = coarse.width;
    // Slices of a plate are dark for the most part.
    let lit: Vec<bool> = fine
        .samples
        .par_chunks(fine.width.max(1))
        .map(|row| row.iter().any(|sample| *sample != 0.0))
        .collect();
    coarse
        .samples
        .par_chunks_mut(width)
        .zip(rows)
        .for_each_init(Halving::default, |space, (out, row)| {
            space.row((fine, &lit), (columns.start, row), &taps, out);
        });
    coarse
}

/// Buffers of one row.
#[derive(Default)]
struct Halving {
    line: Vec<f32>,
    even: Vec<f32>,
    odd: Vec<f32>,
}

impl Halving {
    fn row(
        &mut self,
        (fine, lit): (&View, &[bool]),
        (first, row): (i32, i32),
        taps: &[f32; TAPS],
        out: &mut [f32],
    ) {
        // Two fine samples a coarse one, and the taps beyond.
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

/// Buffers of [`doubled`].
#[derive(Default)]
pub(super) struct Doubling {
    taps: Option<[f32; TAPS]>,
    window: Vec<f32>,
    tall: Vec<f32>,
    even: Vec<f32>,
    odd: Vec<f32>,
}

/// The tile of `side` (even) pixels from (`left`, `top`) (even) on, out of the level above, into `out`, row-major.
pub(super) fn doubled(
    coarse: &View,
    (left, top): (i32, i32),
    side: usize,
    space: &mut Doubling,
    out: &mut [f32],
) {
    let taps = *space.taps.get_or_insert_with(taps);
    let (width, height) = (side / 2 + HALF as usize, side / 2 + HALF as usize);
    let corner = (left.div_euclid(2) - MARGIN, top.div_euclid(2) - MARGIN);
    if !coarse.copy(corner, (width, height), width, &mut space.window) {
        out.fill(0.0);
        return;
    }
    space.tall.resize(width, 0.0);
    for (row, line) in out.chunks_exact_mut(side).enumerate() {
        // Fine pixel 2 m takes coarse m - 5 to m + 4 by the odd taps from the last on, 2 m + 1 takes
        // m - 4 to m + 5 by the even ones.
        let (m, odd) = (row / 2, row % 2);
        let mut sum = WeightedSum::new(&mut space.tall);
        for k in 0..HALF as usize {
            let source = &space.window[(m + k + odd) * width..][..width];
            sum.add(source, 2.0 * taps[TAPS - 1 - odd - 2 * k]);
        }
        sum.write();
        for (half, odd) in [(&mut space.even, 0), (&mut space.odd, 1)] {
            half.resize(side / 2, 0.0);
            let mut sum = WeightedSum::new(half);
            for k in 0..HALF as usize {
                let source = &space.tall[k + odd..k + odd + side / 2];
                sum.add(source, 2.0 * taps[TAPS - 1 - odd - 2 * k]);
            }
            sum.write();
        }
        let (pairs, _) = line.as_chunks_mut::<2>();
        for ((pair, even), odd) in pairs.iter_mut().zip(&space.even).zip(&space.odd) {
            *pair = [*even, *odd];
        }
    }
}

/// Lanes of sums that are kept in registers.
const LANES: usize = 16;

/// A sum of lines as long as `out`, each times its gain, at most [`TAPS`] of them, in the order added.
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
        let lines = &self.lines[..self.count];
        let (blocks, rest) = self.out.as_chunks_mut::<LANES>();
        let whole = blocks.len() * LANES;
        for (block, out) in blocks.iter_mut().enumerate() {
            let mut sum = [0.0_f32; LANES];
            for (line, gain) in lines {
                let line = &line[block * LANES..][..LANES];
                for (sum, sample) in sum.iter_mut().zip(line) {
                    *sum += gain * sample;
                }
            }
            *out = sum;
        }
        for (k, out) in rest.iter_mut().enumerate() {
            *out = lines
                .iter()
                .map(|(line, gain)| gain * line[whole + k])
                .sum();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: usize, height: usize, of: impl Fn(f64, f64) -> f64) -> Image {
        let mut image = Image::zeros((0, 0), (width, height));
        for (k, sample) in image.samples.iter_mut().enumerate() {
            *sample = of((k % width) as f64 + 0.5, (k / width) as f64 + 0.5) as f32;
        }
        image
    }

    /// All light of a point is on the coarse level, a quarter as many samples, and comes back.
    #[test]
    fn light_is_kept() {
        for (x, y) in [(0, 0), (7, 3), (20, 13)] {
            let point = image(21, 14, |u, v| {
                f64::from(u8::from(u as usize == x && v as usize == y))
            });
            let coarse = halved(&point.view());
            let sum: f32 = coarse.samples.iter().sum();
            assert!((sum - 0.25).abs() < 2e-3, "{sum}");
            let mut out = vec![0.0; 64 * 64];
            doubled(
                &coarse.view(),
                (-20, -20),
                64,
                &mut Doubling::default(),
                &mut out,
            );
            let sum: f32 = out.iter().sum();
            assert!((sum - 1.0).abs() < 1e-2, "{sum}");
        }
    }
}
