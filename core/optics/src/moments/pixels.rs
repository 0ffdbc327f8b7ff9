//! Central moments of a tile (Eqs 15-16), and the contribution of the pixel area to them.

use super::{CentralMoments, FourthMoments};
use crate::tile::Tile;

/// Variance of a unit pixel along one axis, px².
pub const PIXEL_VARIANCE_PX2: f64 = 1.0 / 12.0;

/// The total light, centroid and central moments of a tile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TileMoments {
    /// Sum of the samples.
    pub total: f64,
    /// Centroid in tile coordinates, px from the left edge.
    pub centroid_x: f64,
    /// Centroid in tile coordinates, px from the top edge.
    pub centroid_y: f64,
    /// Second and third central moments.
    pub central: CentralMoments,
    /// Fourth central moments.
    pub fourth: FourthMoments,
}

/// Returns the integral of t^p over the pixel centred on `x`: h_p of Eqs 15-16.
///
/// # Panics
/// If `p` is above 4.
pub fn pixel_power(p: usize, x: f64) -> f64 {
    let x2 = x * x;
    match p {
        0 => 1.0,
        1 => x,
        2 => x2 + 1.0 / 12.0,
        3 => x2 * x + x / 4.0,
        4 => x2 * x2 + x2 / 2.0 + 1.0 / 80.0,
        _ => panic!("moments are kept up to fourth order, not {p}"),
    }
}

impl TileMoments {
    /// Computes the plain moments: sums over pixel centres, for the pixels where `mask` (row-major) is true, or all.
    ///
    /// `None` if they hold no light.
    pub fn plain(tile: &Tile, mask: Option<&[bool]>) -> Option<Self> {
        Self::with_powers(tile, mask, |p, x| x.powi(p as i32))
    }

    /// Computes the moments of Eqs 15-16, with each sample spread evenly over its pixel.
    ///
    /// For samples that a sensor has integrated over its pixels, they exceed the optical variance by 1/6 px².
    pub fn spread(tile: &Tile, mask: Option<&[bool]>) -> Option<Self> {
        Self::with_powers(tile, mask, pixel_power)
    }

    /// Computes the moments of the light before integration over pixels: the plain moments minus those of the pixel
    /// (docs/background/model.md section 6).
    pub fn optical(tile: &Tile, mask: Option<&[bool]>) -> Option<Self> {
        Self::plain(tile, mask).map(|m| m.without_pixel_area())
    }

    /// Computes the moments with `power(p, x)` in place of x^p.
    fn with_powers(
        tile: &Tile,
        mask: Option<&[bool]>,
        power: impl Fn(usize, f64) -> f64,
    ) -> Option<Self> {
        let width = tile.width();
        let mut lit = Vec::with_capacity(tile.samples().len());
        let (mut total, mut sum_x, mut sum_y) = (0.0, 0.0, 0.0);
        for (index, &sample) in tile.samples().iter().enumerate() {
            if sample == 0.0 || mask.is_some_and(|m| !m[index]) {
                continue;
            }
            let (x, y) = ((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
            let light = f64::from(sample);
            total += light;
            sum_x += light * x;
            sum_y += light * y;
            lit.push((light, x, y));
        }
        if total <= 0.0 || !total.is_finite() {
            return None;
        }
        let (centroid_x, centroid_y) = (sum_x / total, sum_y / total);
        let mut sums = [[0.0; 5]; 5];
        for (light, x, y) in lit {
            let (x, y) = (x - centroid_x, y - centroid_y);
            let px = [0, 1, 2, 3, 4].map(|p| power(p, x));
            let py = [0, 1, 2, 3, 4].map(|q| power(q, y));
            for p in 0..5 {
                for q in 0..5 - p {
                    sums[p][q] += light * px[p] * py[q];
                }
            }
        }
        let mu = |p: usize, q: usize| sums[p][q] / total;
        Some(Self {
            total,
            centroid_x,
            centroid_y,
            central: CentralMoments {
                mu20: mu(2, 0),
                mu11: mu(1, 1),
                mu02: mu(0, 2),
                mu30: mu(3, 0),
                mu21: mu(2, 1),
                mu12: mu(1, 2),
                mu03: mu(0, 3),
            },
            fourth: FourthMoments {
                mu40: mu(4, 0),
                mu31: mu(3, 1),
                mu22: mu(2, 2),
                mu13: mu(1, 3),
                mu04: mu(0, 4),
            },
        })
    }

    /// Returns the moments of the light before integration over pixels.
    #[must_use]
    pub fn without_pixel_area(&self) -> Self {
        let central = self.central.with_added_variance(-PIXEL_VARIANCE_PX2);
        let f = &self.fourth;
        Self {
            central,
            fourth: FourthMoments {
                mu40: f.mu40 - central.mu20 / 2.0 - 1.0 / 80.0,
                mu31: f.mu31 - central.mu11 / 4.0,
                mu22: f.mu22 - central.trace() / 12.0 - 1.0 / 144.0,
                mu13: f.mu13 - central.mu11 / 4.0,
                mu04: f.mu04 - central.mu02 / 2.0 - 1.0 / 80.0,
            },
            ..*self
        }
    }

    /// Returns the standard deviations of the seven central moments due to pixel noise, to first order.
    ///
    /// The noise is independent between pixels, with standard deviation `noise_sigma` in the units of the tile. `mask`
    /// selects pixels. The noise of the centroid is included.
    pub fn noise(&self, tile: &Tile, mask: Option<&[bool]>, noise_sigma: f64) -> [f64; 7] {
        self.photon_noise(tile, mask, noise_sigma, 0.0)
    }

    /// Returns [`TileMoments::noise`] for pixels of variance `noise_sigma`² + `gain` x signal, with a positive `noise_sigma`.
    pub fn photon_noise(
        &self,
        tile: &Tile,
        mask: Option<&[bool]>,
        noise_sigma: f64,
        gain: f64,
    ) -> [f64; 7] {
        let width = tile.width();
        let m = &self.central;
        let mut squares = [0.0; 7];
        for (index, &sample) in tile.samples().iter().enumerate() {
            if mask.is_some_and(|mask| !mask[index]) {
                continue;
            }
            let photons = if gain > 0.0 {
                gain * f64::from(sample).max(0.0) / (noise_sigma * noise_sigma)
            } else {
                0.0
            };
            let x = (index % width) as f64 + 0.5 - self.centroid_x;
            let y = (index / width) as f64 + 0.5 - self.centroid_y;
            let influence = [
                x * x - m.mu20,
                x * y - m.mu11,
                y * y - m.mu02,
                x * x * x - m.mu30 - 3.0 * m.mu20 * x,
                x * x * y - m.mu21 - 2.0 * m.mu11 * x - m.mu20 * y,
                x * y * y - m.mu12 - m.mu02 * x - 2.0 * m.mu11 * y,
                y * y * y - m.mu03 - 3.0 * m.mu02 * y,
            ];
            for (square, influence) in squares.iter_mut().zip(influence) {
                *square += influence * influence * (1.0 + photons);
            }
        }
        squares.map(|square| noise_sigma * square.sqrt() / self.total)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lopsided() -> Tile {
        let samples = (0..63)
            .map(|i| {
                let (x, y) = ((i % 9) as f32 - 3.2, (i / 9) as f32 - 3.7);
                (-(x * x / 5.0 + y * y / 3.0 + x * y / 9.0)).exp() * (1.0 + 0.2 * x)
            })
            .map(|v| v.max(0.0))
            .collect();
        Tile::new(9, 7, samples).expect("valid")
    }

    #[test]
    fn spreading_over_pixels_adds_the_terms_of_model_section_6() {
        let tile = lopsided();
        let plain = TileMoments::plain(&tile, None).expect("lit");
        let spread = TileMoments::spread(&tile, None).expect("lit");
        assert!((spread.central.mu20 - plain.central.mu20 - 1.0 / 12.0).abs() < 1e-13);
        assert!((spread.central.mu11 - plain.central.mu11).abs() < 1e-13);
        assert!((spread.central.mu30 - plain.central.mu30).abs() < 1e-13);
        assert!((spread.central.mu12 - plain.central.mu12).abs() < 1e-13);
        // Removing the pixel area from the spread moments recovers the plain ones, up to fourth order.
        let back = spread.without_pixel_area();
        for (a, b) in back.fourth.to_array().iter().zip(plain.fourth.to_array()) {
            assert!((a - b).abs() < 1e-12, "{a} {b}");
        }
    }

    #[test]
    fn a_single_pixel_is_a_point_at_its_centre() {
        let mut samples = vec![0.0; 25];
        samples[13] = 4.0;
        let tile = Tile::new(5, 5, samples).expect("valid");
        let m = TileMoments::plain(&tile, None).expect("lit");
        assert_eq!((m.centroid_x, m.centroid_y), (3.5, 2.5));
        assert_eq!(m.central, CentralMoments::default());
        assert!(TileMoments::plain(&Tile::new(1, 1, vec![0.0]).expect("valid"), None).is_none());
    }

    #[test]
    fn noise_of_moments_agrees_with_perturbed_pixels() {
        let tile = lopsided();
        let sigma = 1e-4;
        let clean = TileMoments::plain(&tile, None).expect("lit");
        // Exact first-order propagation: perturb one pixel at a time.
        let mut squares = [0.0; 7];
        for index in 0..tile.samples().len() {
            let mut samples = tile.samples().to_vec();
            samples[index] += 1e-3;
            let moved = Tile::new(9, 7, samples).expect("valid");
            let m = TileMoments::plain(&moved, None).expect("lit");
            let pairs = m
                .central
                .to_array()
                .into_iter()
                .zip(clean.central.to_array());
            for (square, (moved, clean)) in squares.iter_mut().zip(pairs) {
                let slope = (moved - clean) / 1e-3;
                *square += slope * slope;
            }
        }
        let noise = clean.noise(&tile, None, sigma);
        for k in 0..7 {
            let want = sigma * f64::sqrt(squares[k]);
            assert!(
                (noise[k] / want - 1.0).abs() < 0.02,
                "{k}: {} {want}",
                noise[k]
            );
        }
    }
}
