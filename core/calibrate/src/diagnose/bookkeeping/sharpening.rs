//! Tiles that were sharpened: an unsharp mask adds the difference between a picture and its Gaussian blur.

use seidel_optics::tile::Tile;

/// Radius of the blur in standard deviations.
const REACH_SIGMAS: f64 = 3.0;
/// Steps of the fixed-point iteration that takes the mask off; each leaves at most amount / (1 + amount) of the error.
const STEPS: usize = 40;

/// An unsharp mask.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct UnsharpMask {
    pub(super) amount: f64,
    /// Standard deviation of its blur, px.
    pub(super) sigma_px: f64,
}

impl UnsharpMask {
    /// Returns `tile` without the mask: the t for which t + amount (t - blurred t) is the tile.
    pub(super) fn taken_off(self, tile: &Tile) -> Option<Tile> {
        let (width, height) = (tile.width(), tile.height());
        let stored: Vec<f64> = tile.samples().iter().map(|v| f64::from(*v)).collect();
        let mut light = stored.clone();
        for _ in 0..STEPS {
            let soft = blurred(&light, width, height, self.sigma_px);
            for ((light, stored), soft) in light.iter_mut().zip(&stored).zip(soft) {
                *light = (stored + self.amount * soft) / (1.0 + self.amount);
            }
        }
        let samples = light.into_iter().map(|v| v as f32).collect();
        Tile::new(width, height, samples).ok()
    }
}

/// Returns `pixels` of a picture `width` x `height`, dark around, blurred by a Gaussian.
pub(super) fn blurred(pixels: &[f64], width: usize, height: usize, sigma_px: f64) -> Vec<f64> {
    let reach = (REACH_SIGMAS * sigma_px).ceil() as i64;
    let weight = |k: i64| (-0.5 * (k as f64 / sigma_px).powi(2)).exp();
    let sum: f64 = (-reach..=reach).map(weight).sum();
    let kernel: Vec<(i64, f64)> = (-reach..=reach).map(|k| (k, weight(k) / sum)).collect();
    let pass = |pixels: &[f64], count: usize, stride: usize, k: usize| {
        let at = (k / stride) % count;
        let terms = kernel.iter().filter_map(|(step, weight)| {
            let there = at as i64 + step;
            let is_within = (0..count as i64).contains(&there);
            is_within.then(|| weight * pixels[(k as i64 + step * stride as i64) as usize])
        });
        terms.sum::<f64>()
    };
    let rows: Vec<f64> = (0..pixels.len())
        .map(|k| pass(pixels, width, 1, k))
        .collect();
    (0..rows.len())
        .map(|k| pass(&rows, height, width, k))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mask_that_was_put_on_is_taken_off() {
        let (width, height) = (15, 13);
        let light: Vec<f64> = (0..width * height)
            .map(|k| {
                let (x, y) = ((k % width) as f64 - 7.0, (k / width) as f64 - 6.0);
                (-(x * x + 2.0 * y * y) / 6.0).exp()
            })
            .collect();
        let mask = UnsharpMask {
            amount: 1.2,
            sigma_px: 1.0,
        };
        let soft = blurred(&light, width, height, mask.sigma_px);
        let stored = light.iter().zip(&soft);
        let stored = stored.map(|(l, s)| (l + mask.amount * (l - s)) as f32);
        let tile = Tile::new(width, height, stored.collect()).expect("finite");
        assert!(tile.samples().iter().any(|v| *v < 0.0), "negative lobes");
        let back = mask.taken_off(&tile).expect("finite");
        for (got, want) in back.samples().iter().zip(&light) {
            assert!((f64::from(*got) - want).abs() < 1e-5, "{got} {want}");
        }
    }
}
