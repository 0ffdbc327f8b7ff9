//! The data of one window in one channel.

use super::PairImage;
use seidel_optics::field::ImagePoint;

/// Share of a window's side over which weights rise from its edges.
const TAPER: f64 = 0.5;

/// The place of a window in both pictures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Window {
    /// First column and row in the sharp picture.
    pub(super) left: usize,
    pub(super) top: usize,
    /// Side, px.
    pub(super) side: usize,
    /// Side of the tile that is estimated from it, px.
    pub(super) tile: usize,
    /// Centroid of the texture, in pixels of the sharp picture. A PSF that changes linearly over the window is estimated as
    /// it is there.
    pub(super) centre: ImagePoint,
    /// Object vergence, 1/m, where it is not that of the whole scene.
    pub(super) vergence: Option<f64>,
}

impl Window {
    /// Returns the margin that convolution with a tile needs around the window, px.
    pub(super) fn margin(&self) -> usize {
        self.tile / 2
    }

    /// Returns the side of the window with its margins, px.
    pub(super) fn square(&self) -> usize {
        self.side + 2 * self.margin()
    }
}

/// Data of one window in one channel, as rows of the window with its margins.
#[derive(Debug, Clone)]
pub(super) struct Patch {
    /// The sharp picture.
    pub(super) sharp: Vec<f64>,
    /// The plate, stored half a tile below and right of its place as a convolution with a tile stores it.
    pub(super) plate: Vec<f64>,
    /// Weights of the plate's pixels; zero in the first rows and columns, whose light comes from outside the square.
    pub(super) weight: Vec<f64>,
}

impl Patch {
    /// Cuts `window` of `channel` out of both pictures, the plate `offset` (x, y) px away.
    pub(super) fn cut(
        sharp: &PairImage<'_>,
        plate: &PairImage<'_>,
        channel: usize,
        window: Window,
        offset: [isize; 2],
        clip: Option<f32>,
    ) -> Self {
        let (margin, square) = (window.margin(), window.square());
        let corner = [window.left, window.top].map(|v| v as isize - margin as isize);
        let of_sharp = samples(sharp, channel, corner, square);
        let there = [corner[0] + offset[0], corner[1] + offset[1]];
        let of_plate = samples(plate, channel, there, square);
        let is_lost = |v: f64| !v.is_finite() || clip.is_some_and(|clip| v >= f64::from(clip));
        // The value of a clipped pixel is unknown, and so is every plate pixel within its reach.
        let lost = of_sharp.iter().map(|&v| is_lost(v)).collect();
        let reached = spread(lost, square, margin);
        let known = |v: f64| if v.is_finite() { v } else { 0.0 };
        let mut patch = Self {
            plate: vec![0.0; square * square],
            weight: vec![0.0; square * square],
            sharp: of_sharp.into_iter().map(known).collect(),
        };
        for y in 0..window.side {
            for x in 0..window.side {
                // Index of the plate's pixel in the square, and its index after the convolution.
                let from = (y + margin) * square + x + margin;
                let to = (y + 2 * margin) * square + x + 2 * margin;
                if !is_lost(of_plate[from]) && !reached[from] {
                    patch.plate[to] = of_plate[from];
                    patch.weight[to] = taper(x, window.side) * taper(y, window.side);
                }
            }
        }
        patch
    }

    /// Returns the sum over pixels of weight times `f` of the pixel's index.
    pub(super) fn weighted(&self, f: impl Fn(usize) -> f64) -> f64 {
        let weights = self.weight.iter().enumerate();
        weights
            .filter(|(_, w)| **w > 0.0)
            .map(|(k, w)| w * f(k))
            .sum()
    }

    /// Returns the sum of weights.
    pub(super) fn pixels(&self) -> f64 {
        self.weight.iter().sum()
    }

    /// Returns the weighted mean of `f` of the plate's samples.
    pub(super) fn plate_mean(&self, f: impl Fn(f64) -> f64) -> f64 {
        self.weighted(|k| f(self.plate[k])) / self.pixels().max(f64::MIN_POSITIVE)
    }

    /// Returns the mean of `f` of the sharp picture's samples.
    pub(super) fn sharp_mean(&self, f: impl Fn(f64) -> f64) -> f64 {
        self.sharp.iter().map(|v| f(*v)).sum::<f64>() / self.sharp.len() as f64
    }

    /// Returns the standard deviation of the sharp picture relative to its mean light.
    pub(super) fn contrast(&self) -> f64 {
        let mean = self.sharp_mean(|v| v);
        let variance = self.sharp_mean(|v| (v - mean).powi(2));
        variance.sqrt() / self.sharp_mean(f64::abs).max(f64::MIN_POSITIVE)
    }
}

/// Returns a square of `side` px at `corner`; samples outside the picture are unknown (NaN).
fn samples(picture: &PairImage<'_>, channel: usize, corner: [isize; 2], side: usize) -> Vec<f64> {
    let plane = &picture.planes[channel];
    let cell = |k: usize| {
        let x = usize::try_from(corner[0] + (k % side) as isize).ok();
        let y = usize::try_from(corner[1] + (k / side) as isize).ok();
        match (x, y) {
            (Some(x), Some(y)) if x < picture.width && y < picture.height => {
                f64::from(plane[y * picture.width + x])
            }
            _ => f64::NAN,
        }
    };
    (0..side * side).map(cell).collect()
}

/// Window function: 1 in the middle, falling smoothly to 0 at the edges.
pub(super) fn taper(at: usize, window: usize) -> f64 {
    let in_from_edge = (at as f64 + 0.5).min(window as f64 - at as f64 - 0.5) / window as f64;
    let rise = (in_from_edge / TAPER).min(1.0);
    0.5 - 0.5 * (std::f64::consts::PI * rise).cos()
}

/// Dilates a mask on a square of side `side` by `reach` pixels along both axes.
fn spread(mut set: Vec<bool>, side: usize, reach: usize) -> Vec<bool> {
    // Along rows, then along columns: steps between neighbours, and between lines.
    for (near, line) in [(1, side), (side, 1)] {
        let before: Vec<usize> = (0..set.len()).filter(|&k| set[k]).collect();
        for k in before {
            let at = k / near % side;
            let start = k / line % side * line;
            for other in at.saturating_sub(reach)..(at + reach + 1).min(side) {
                set[start + other * near] = true;
            }
        }
    }
    set
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_spread_both_ways() {
        let mut set = vec![false; 49];
        set[2 * 7 + 1] = true;
        let spread = spread(set, 7, 2);
        let want = |k: usize| (0..=4).contains(&(k / 7)) && (0..=3).contains(&(k % 7));
        assert!((0..49).all(|k| spread[k] == want(k)), "{spread:?}");
    }
}
