//! The picture of a chart: sums over rectangles, and its light in the pixels of a photograph.

use rayon::prelude::*;
use seidel_optics::error::{Error, Result};

use super::map::ChartMap;

/// Smallest side of a chart's picture, px.
const MIN_SIDE: usize = 16;

/// The picture of a chart, linear in light.
#[derive(Debug, Clone)]
pub struct ChartPicture {
    width: usize,
    height: usize,
    samples: Vec<f32>,
    /// Sums over all pixels left of and above a corner; (width + 1) x (height + 1).
    sums: Vec<f64>,
    /// Level beyond the picture's border, used where nothing else is known.
    white: f64,
    content: Content,
}

/// The meaning of the samples of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Content {
    /// Squares of constant light, as printed.
    Cells,
    /// Light that the pixels of a camera collected: interpolated, and not averaged over pixels again.
    Photograph,
}

/// A rectangle of photograph pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Region {
    /// Left column; may lie outside the photograph.
    pub(crate) left: i64,
    /// Top row.
    pub(crate) top: i64,
    pub(crate) width: usize,
    pub(crate) height: usize,
}

impl ChartPicture {
    /// Creates the picture of `width` x `height` samples.
    ///
    /// # Errors
    /// Another number of samples than stated, samples that are not finite, an even picture, and one that is too small.
    pub fn new(width: usize, height: usize, samples: Vec<f32>, content: Content) -> Result<Self> {
        let refuse = |problem: &str, remedy: &str| Err(Error::new("chart", problem, remedy));
        if width.min(height) < MIN_SIDE || samples.len() != width * height {
            return refuse("is smaller than 16 px", "give the picture that was printed");
        }
        if !samples.iter().all(|v| v.is_finite()) {
            return refuse("has samples that are not finite", "write it again");
        }
        let low = samples.iter().copied().fold(f32::INFINITY, f32::min);
        let high = samples.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        if high - low <= f32::EPSILON * high.abs() {
            return refuse("is of one tone", "give the picture that was printed");
        }
        let stride = width + 1;
        let mut sums = vec![0.0; stride * (height + 1)];
        for y in 0..height {
            let mut row = 0.0;
            for x in 0..width {
                row += f64::from(samples[y * width + x]);
                sums[(y + 1) * stride + x + 1] = sums[y * stride + x + 1] + row;
            }
        }
        Ok(Self {
            width,
            height,
            samples,
            sums,
            white: f64::from(high),
            content,
        })
    }

    /// Returns width and height, px.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// Returns what the samples are.
    pub fn content(&self) -> Content {
        self.content
    }

    /// Returns the samples, row by row.
    pub(crate) fn samples(&self) -> &[f32] {
        &self.samples
    }

    /// Returns the mean over the square of `side` about `at`.
    fn mean(&self, at: [f64; 2], side: f64) -> f64 {
        let half = side / 2.0;
        let clamp = |v: f64, most: usize| v.clamp(0.0, most as f64);
        let (x0, x1) = (
            clamp(at[0] - half, self.width),
            clamp(at[0] + half, self.width),
        );
        let (y0, y1) = (
            clamp(at[1] - half, self.height),
            clamp(at[1] + half, self.height),
        );
        let inside = (x1 - x0) * (y1 - y0);
        let sum = if inside > 0.0 {
            self.sum_to(x1, y1) - self.sum_to(x0, y1) - self.sum_to(x1, y0) + self.sum_to(x0, y0)
        } else {
            0.0
        };
        (sum + (side * side - inside) * self.white) / (side * side)
    }

    /// Returns the light at `at` by a Lanczos filter of three lobes; borders repeat.
    fn interpolated(&self, at: [f64; 2]) -> f64 {
        let [x, y] = at.map(|v| v - 0.5);
        let (left, top) = (x.floor() as i64 - 2, y.floor() as i64 - 2);
        let weights = |v: f64, first: i64| -> [f64; 6] {
            let raw: [f64; 6] = std::array::from_fn(|k| lanczos(v - (first + k as i64) as f64));
            let total: f64 = raw.iter().sum();
            raw.map(|w| w / total)
        };
        let (across, down) = (weights(x, left), weights(y, top));
        let near = |first: i64, k: usize, most: usize| {
            (first + k as i64).clamp(0, most as i64 - 1) as usize
        };
        let mut sum = 0.0;
        for (row, wy) in down.iter().enumerate() {
            let line = &self.samples[near(top, row, self.height) * self.width..][..self.width];
            let of_row: f64 = (across.iter().enumerate())
                .map(|(k, wx)| wx * f64::from(line[near(left, k, self.width)]))
                .sum();
            sum += wy * of_row;
        }
        sum
    }

    /// Returns the sum left of `x` and above `y`. Bilinear interpolation of the table is exact for constant pixels.
    fn sum_to(&self, x: f64, y: f64) -> f64 {
        let stride = self.width + 1;
        let (column, row) = (
            (x as usize).min(self.width - 1),
            (y as usize).min(self.height - 1),
        );
        let (tx, ty) = (x - column as f64, y - row as f64);
        let at = row * stride + column;
        let top = self.sums[at] * (1.0 - tx) + self.sums[at + 1] * tx;
        let bottom = self.sums[at + stride] * (1.0 - tx) + self.sums[at + stride + 1] * tx;
        top * (1.0 - ty) + bottom * ty
    }

    /// Returns the chart averaged over squares of `step` photograph pixels, whose centres are `step` apart from `origin`
    /// on: `columns` x `rows` values.
    pub(crate) fn rendered(&self, map: &ChartMap, grid: &Grid, aperture: Aperture) -> Vec<f64> {
        let mut values = vec![0.0; grid.columns * grid.rows];
        values
            .par_chunks_mut(grid.columns)
            .enumerate()
            .for_each(|(row, line)| {
                // Corners of the squares above and below the row.
                let corners = |down: f64| -> Vec<[f64; 2]> {
                    let at = |column: usize| {
                        let [x, y] = grid.position(column, row);
                        map.chart_of([x - grid.step / 2.0, y + down * grid.step])
                    };
                    (0..=grid.columns).map(at).collect()
                };
                let (above, below) = (corners(-0.5), corners(0.5));
                for (column, value) in line.iter_mut().enumerate() {
                    let corners = [
                        above[column],
                        above[column + 1],
                        below[column],
                        below[column + 1],
                    ];
                    *value = self.over_square(corners, aperture);
                }
            });
        values
    }

    /// Returns the mean over the quadrilateral with corners top left, top right, bottom left and bottom right: that of squares
    /// of a quarter of its area, which have the second moments of the quadrilateral where the map does not shear.
    fn over_square(&self, [a, b, c, d]: [[f64; 2]; 4], aperture: Aperture) -> f64 {
        let side = |k: usize| {
            [
                (b[k] + d[k] - a[k] - c[k]) / 2.0,
                (c[k] + d[k] - a[k] - b[k]) / 2.0,
            ]
        };
        let (x, y) = (side(0), side(1));
        let centre = [0, 1].map(|k| (a[k] + b[k] + c[k] + d[k]) / 4.0);
        let edge = (x[0] * y[1] - x[1] * y[0]).abs().sqrt() / 2.0;
        if self.content == Content::Photograph {
            return self.interpolated(centre);
        }
        let mut sum = 0.0;
        for (v, down) in aperture.places() {
            for (u, across) in aperture.places() {
                let at = [
                    centre[0] + x[0] * u + x[1] * v,
                    centre[1] + y[0] * u + y[1] * v,
                ];
                sum += down * across * self.mean(at, edge);
            }
        }
        sum
    }
}

/// The area over which a chart is averaged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Aperture {
    /// That of a pixel.
    Pixel,
    /// The mean of four pixels, a quarter of a pixel off along both axes. It has little light at frequencies above half a cycle
    /// per pixel, which samples of whole pixels would show at wrong frequencies.
    Soft,
}

/// Variance that [`Aperture::Soft`] adds to that of a pixel along either axis, px².
pub(crate) const SOFT_VARIANCE: f64 = 1.0 / 16.0;

impl Aperture {
    /// Returns the centres of half pixels along an axis, px, and their weights.
    fn places(self) -> &'static [(f64, f64)] {
        match self {
            Self::Pixel => &[(-0.25, 0.5), (0.25, 0.5)],
            Self::Soft => &[(-0.5, 0.25), (0.0, 0.5), (0.5, 0.25)],
        }
    }
}

/// Returns sinc(x) sinc(x / 3) within three samples.
fn lanczos(x: f64) -> f64 {
    let sinc = |v: f64| {
        let v = std::f64::consts::PI * v;
        if v.abs() < 1e-9 { 1.0 } else { v.sin() / v }
    };
    if x.abs() < 3.0 {
        sinc(x) * sinc(x / 3.0)
    } else {
        0.0
    }
}

/// Places on a photograph, evenly spaced.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Grid {
    /// Photograph position of the first place.
    pub(crate) origin: [f64; 2],
    /// Distance between places, px.
    pub(crate) step: f64,
    pub(crate) columns: usize,
    pub(crate) rows: usize,
}

impl Grid {
    /// Returns the pixel centres of `region`.
    pub(crate) fn of(region: Region) -> Self {
        Self {
            origin: [region.left as f64 + 0.5, region.top as f64 + 0.5],
            step: 1.0,
            columns: region.width,
            rows: region.height,
        }
    }

    /// Returns the photograph position of a place.
    pub(crate) fn position(&self, column: usize, row: usize) -> [f64; 2] {
        [
            self.origin[0] + column as f64 * self.step,
            self.origin[1] + row as f64 * self.step,
        ]
    }
}
