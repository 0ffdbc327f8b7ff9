//! Bloom: a share of the light above a level spreads around highlights.
//!
//! The halo is a sum of four Gaussians whose standard deviations double: a bright core with a wide skirt. Each Gaussian is
//! three box filters of its variance (Wells, IEEE Transactions on Pattern Analysis and Machine Intelligence 8, 1986), with
//! fractional ends, over the mirrored plane: light is neither lost nor made.

use rayon::prelude::*;

/// Standard deviations of the Gaussians over the radius of the halo, which holds half of the light within 4 %.
const DEVIATIONS: [f64; 4] = [0.35, 0.7, 1.4, 2.8];
/// Box filters in a row that stand for a Gaussian.
const BOXES: usize = 3;
/// Share of the spread light that may lie beyond the reach on a side: of a highlight 10,000 times as bright as white, less than a half
/// float resolves beside white.
const BEYOND_REACH: f64 = 1e-8;
/// Rows of a plane that are filtered together.
const BAND: usize = 16;

/// A bloom of highlights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bloom {
    /// Share of the light above the level that spreads, 0 to 1.
    pub share: f64,
    /// Scene-linear value above which light spreads, at least 0.
    pub level: f64,
    /// Radius of the halo over the width of the frame, 0.0005 to 0.2: half of the spread light lies within it.
    pub radius: f64,
}

impl Default for Bloom {
    fn default() -> Self {
        Self {
            share: 0.0,
            level: 1.0,
            radius: 0.01,
        }
    }
}

impl Bloom {
    /// Smallest and largest radius over the width of the frame.
    pub const RADII: (f64, f64) = (0.0005, 0.2);

    /// Returns whether nothing spreads.
    pub fn is_neutral(&self) -> bool {
        self.share == 0.0
    }

    /// Spreads light of `plane`, which has rows of `width` pixels; `frame_px` is the width of the frame in pixels along x and
    /// along y. A plane without light above the level keeps its bits.
    pub fn spread(&self, plane: &mut [f32], width: usize, frame_px: [f64; 2]) {
        if self.is_neutral() || width == 0 {
            return;
        }
        let level = self.level as f32;
        if plane.iter().all(|v| *v <= level) {
            return;
        }
        let excess: Vec<f32> = (plane.par_iter())
            .map(|v| (self.share * (f64::from(*v) - self.level).max(0.0)) as f32)
            .collect();
        let radii = frame_px.map(|px| self.radius * px);
        let halo = halo(&excess, width, radii);
        (plane.par_iter_mut().zip(&excess).zip(&halo)).for_each(|((v, excess), halo)| {
            *v += (halo - f64::from(*excess)) as f32;
        });
    }

    /// Returns how far the light of a pixel spreads along x and along y, pixels, but for a hundred-millionth on each side; `frame_px` as
    /// for [`Self::spread`].
    pub fn reach_px(&self, frame_px: [f64; 2]) -> (f64, f64) {
        if self.is_neutral() {
            return (0.0, 0.0);
        }
        let stages = added_variances(frame_px.map(|px| self.radius * px));
        let along = |axis: usize| {
            let boxes = stages.map(|added| BoxFilter::of_variance(added[axis] / BOXES as f64));
            reach_of(&boxes) as f64
        };
        (along(0), along(1))
    }
}

/// Returns how far the halo of one pixel reaches along an axis on which its Gaussians are made of these `boxes`, but for
/// [`BEYOND_REACH`].
fn reach_of(boxes: &[BoxFilter]) -> usize {
    // Where the filters end; narrow halos fade long before.
    let end = BOXES * boxes.iter().map(BoxFilter::reach).sum::<usize>();
    let mut blurred = vec![0.0; 2 * end + 1];
    blurred[end] = 1.0;
    let mut halo = vec![0.0; end + 1];
    let mut line = Vec::new();
    for filter in boxes {
        for _ in 0..BOXES {
            filter.filter(&mut blurred, &mut line);
        }
        for (sum, value) in halo.iter_mut().zip(&blurred[end..]) {
            *sum += value / boxes.len() as f64;
        }
    }
    let mut beyond = 0.0;
    let faint = halo.iter().rev().take_while(|value| {
        beyond += **value;
        beyond <= BEYOND_REACH
    });
    end - faint.count().min(end)
}

/// Returns the variances along x and y that each Gaussian of halos of `radii_px` adds to the one before, px².
fn added_variances(radii_px: [f64; 2]) -> [[f64; 2]; DEVIATIONS.len()] {
    let mut before = [0.0; 2];
    DEVIATIONS.map(|deviation| {
        let variances = radii_px.map(|r| (r * deviation).powi(2));
        let added = [0, 1].map(|axis| variances[axis] - before[axis]);
        before = variances;
        added
    })
}

/// Returns the light of `excess` spread by halos of `radii_px` along x and y.
fn halo(excess: &[f32], width: usize, radii_px: [f64; 2]) -> Vec<f64> {
    let weight = 1.0 / DEVIATIONS.len() as f64;
    let mut sum = vec![0.0; excess.len()];
    let mut blurred: Vec<f64> = excess.iter().map(|v| f64::from(*v)).collect();
    for added in added_variances(radii_px) {
        // The blur of one Gaussian is the start of the next.
        blur(&mut blurred, width, added);
        (sum.par_iter_mut().zip(&blurred)).for_each(|(sum, v)| *sum += weight * v);
    }
    sum
}

/// Blurs a plane by box filters of these total variances along x and y, px².
fn blur(plane: &mut [f64], width: usize, variances_px2: [f64; 2]) {
    let [across, down] = variances_px2.map(|v| BoxFilter::of_variance(v / BOXES as f64));
    plane
        .par_chunks_mut(width * BAND)
        .for_each_init(Vec::new, |line, band| {
            for row in band.chunks_exact_mut(width) {
                for _ in 0..BOXES {
                    across.filter(row, line);
                }
            }
        });
    let height = plane.len() / width;
    let mut columns = vec![0.0; plane.len()];
    transpose(plane, width, &mut columns);
    columns
        .par_chunks_mut(height * BAND)
        .for_each_init(Vec::new, |line, band| {
            for column in band.chunks_exact_mut(height) {
                for _ in 0..BOXES {
                    down.filter(column, line);
                }
            }
        });
    transpose(&columns, height, plane);
}

/// Writes the columns of a plane with rows of `width` values as rows.
fn transpose(from: &[f64], width: usize, to: &mut [f64]) {
    let height = from.len() / width;
    to.par_chunks_mut(height * BAND)
        .enumerate()
        .for_each(|(band, rows)| {
            let first = band * BAND;
            let columns = rows.len() / height;
            for (y, line) in from.chunks_exact(width).enumerate() {
                for (k, value) in line[first..first + columns].iter().enumerate() {
                    rows[k * height + y] = *value;
                }
            }
        });
}

/// A box filter with fractional ends: equal weights up to `whole` values away, `end` of that one farther.
#[derive(Debug, Clone, Copy)]
struct BoxFilter {
    whole: usize,
    end: f64,
}

impl BoxFilter {
    fn of_variance(variance: f64) -> Self {
        // A box of 2 m + 1 values has the variance m (m + 1) / 3.
        let of = |m: f64| m * (m + 1.0) / 3.0;
        let whole = (((12.0 * variance + 1.0).sqrt() - 1.0) / 2.0)
            .floor()
            .max(0.0);
        // Solves the variance of the box with ends e: (of(m) (2 m + 1) + 2 e (m + 1)²) / (2 m + 1 + 2 e).
        let lacking = (2.0 * whole + 1.0) * (variance - of(whole));
        let end = lacking / (2.0 * ((whole + 1.0).powi(2) - variance));
        Self {
            whole: whole as usize,
            end: end.clamp(0.0, 1.0),
        }
    }

    /// Values on each side that the filter weights.
    fn reach(&self) -> usize {
        self.whole + usize::from(self.end > 0.0)
    }

    /// Filters `values` mirrored at their ends; `line` is a buffer.
    fn filter(&self, values: &mut [f64], line: &mut Vec<f64>) {
        let margin = self.whole + 1;
        let count = values.len();
        let mirrored = |k: isize| {
            let k = k.rem_euclid(2 * count as isize) as usize;
            if k < count { k } else { 2 * count - 1 - k }
        };
        line.clear();
        line.extend((-(margin as isize)..0).map(|k| values[mirrored(k)]));
        line.extend_from_slice(values);
        line.extend((count..count + margin).map(|k| values[mirrored(k as isize)]));
        let scale = 1.0 / ((2 * self.whole + 1) as f64 + 2.0 * self.end);
        // The sum over the whole part about the first value.
        let mut sum: f64 = line[1..=2 * self.whole + 1].iter().sum();
        for (k, value) in values.iter_mut().enumerate() {
            let (left, right) = (line[k], line[k + 2 * margin]);
            // Running sums leave a trace of rounding beside bright light.
            *value = (scale * (sum + self.end * (left + right))).max(0.0);
            sum += right - line[k + 1];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 160;
    const HEIGHT: usize = 90;
    const FRAME: [f64; 2] = [160.0, 160.0];

    fn lamp(at: (usize, usize), value: f32) -> Vec<f32> {
        let mut plane = vec![0.18; WIDTH * HEIGHT];
        plane[at.1 * WIDTH + at.0] = value;
        plane
    }

    fn sum(plane: &[f32]) -> f64 {
        plane.iter().map(|v| f64::from(*v)).sum()
    }

    #[test]
    fn light_above_the_level_spreads_and_none_is_lost() {
        let bloom = Bloom {
            share: 0.4,
            level: 1.0,
            radius: 0.05,
        };
        for at in [(80, 45), (0, 0), (159, 40)] {
            let before = lamp(at, 1001.0);
            let mut after = before.clone();
            bloom.spread(&mut after, WIDTH, FRAME);
            let change = sum(&after) / sum(&before) - 1.0;
            assert!(change.abs() < 1e-5, "{at:?}: {change}");
            let own = after[at.1 * WIDTH + at.0];
            assert!(own < 700.0 && own > 601.0, "{own}");
            assert!(after.iter().zip(&before).all(|(a, b)| *a >= 0.18 || a < b));
        }
        // Half of the spread light lies within the radius of 8 px.
        let mut after = lamp((80, 45), 1001.0);
        bloom.spread(&mut after, WIDTH, FRAME);
        let near: f64 = (0..after.len())
            .filter(|k| ((k % WIDTH) as f64 - 80.0).hypot((k / WIDTH) as f64 - 45.0) <= 8.0)
            .map(|k| f64::from(after[k]) - if k == 45 * WIDTH + 80 { 601.0 } else { 0.18 })
            .sum();
        assert!((near / 400.0 - 0.5).abs() < 0.05, "{near}");
        let (beside, away) = (after[45 * WIDTH + 90], after[45 * WIDTH + 110]);
        assert!(beside > away && away > 0.18, "{beside} {away}");
    }

    #[test]
    fn light_ends_at_the_reach() {
        let (width, height) = (301, 201);
        let frame_px = [200.0, 100.0];
        for radius in [0.0005, 0.004, 0.04] {
            let bloom = Bloom {
                share: 0.4,
                level: 0.0,
                radius,
            };
            let mut plane = vec![0.0; width * height];
            plane[100 * width + 150] = 1e6;
            bloom.spread(&mut plane, width, frame_px);
            let (x, y) = bloom.reach_px(frame_px);
            // The light of whole columns and rows, whose sums a halo spreads as a line.
            let column = |x: usize| (0..height).map(|y| f64::from(plane[y * width + x])).sum();
            let row = |y: usize| (0..width).map(|x| f64::from(plane[y * width + x])).sum();
            let columns: Vec<f64> = (150..width).map(column).collect();
            let rows: Vec<f64> = (100..height).map(row).collect();
            for (lines, reach) in [(columns, x), (rows, y)] {
                let beyond = |reach: usize| lines[reach + 1..].iter().sum::<f64>() / 4e5;
                let reach = reach as usize;
                assert!(beyond(reach) < 2e-8, "{radius}: {reach}, {}", beyond(reach));
                assert!(beyond(reach - 1) > 5e-9, "{radius}: {reach} is too far");
            }
            let none = Bloom {
                share: 0.0,
                ..bloom
            };
            assert_eq!(none.reach_px(frame_px), (0.0, 0.0));
        }
    }

    #[test]
    fn narrow_halos_reach_a_few_pixels() {
        let reach = |radius_px: f64| {
            let bloom = Bloom {
                share: 1.0,
                level: 1.0,
                radius: 0.001,
            };
            bloom.reach_px([radius_px / bloom.radius; 2])
        };
        let reaches = [0.1, 0.5, 2.0, 10.0].map(|radius_px| reach(radius_px).0);
        assert_eq!(reaches, [3.0, 7.0, 23.0, 115.0]);
    }

    #[test]
    fn dark_planes_and_no_share_keep_their_bits() {
        let mut plane = lamp((80, 45), 0.9);
        let before = plane.clone();
        let bloom = |share, level| Bloom {
            share,
            level,
            radius: 0.02,
        };
        bloom(0.5, 1.0).spread(&mut plane, WIDTH, FRAME);
        bloom(0.0, 0.1).spread(&mut plane, WIDTH, FRAME);
        assert_eq!(plane, before);
        bloom(0.5, 0.5).spread(&mut plane, WIDTH, FRAME);
        assert_ne!(plane, before);
    }

    #[test]
    fn boxes_have_the_variance_asked_for() {
        for variance in [0.1, 0.7, 5.0, 40.0, 333.0] {
            let mut line = vec![0.0; 201];
            line[100] = 1.0;
            BoxFilter::of_variance(variance).filter(&mut line, &mut Vec::new());
            let got: f64 = (line.iter().enumerate())
                .map(|(k, v)| v * (k as f64 - 100.0).powi(2))
                .sum();
            assert!((got / variance - 1.0).abs() < 1e-9, "{variance} {got}");
        }
    }
}
