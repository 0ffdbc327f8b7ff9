//! Highlights: lights so much brighter than the rest that errors of the lens model would draw rings around them, were
//! their blur removed.

use super::noise_estimate::haar_noise;
use super::winsorised::WinsorisedStatistics;
use crate::Plane;
use rayon::prelude::*;

/// Threshold as a multiple of the median of all lit samples.
const MEDIANS: f64 = 25.0;
/// Least threshold, standard deviations of the noise.
const DEVIATIONS: f64 = 400.0;
/// Samples below this share of the 99th percentile are not lit.
const LIT_SHARE: f64 = 1e-3;

/// The highlights of a plate.
///
/// Each pixel has an excess: its brightness over the threshold of highlights, in the plane where that ratio is largest.
/// It is 0 for pixels below the threshold.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Highlights(Vec<f32>);

impl Highlights {
    /// Finds the highlights of planes of one size, `width` samples wide. A highlight of one plane is one of all, so that
    /// colours are treated alike.
    pub(super) fn detect(planes: &[Plane], width: usize) -> Self {
        let mut excess = vec![0.0_f32; planes.first().map_or(0, |plane| plane.samples.len())];
        for plane in planes {
            let threshold = threshold(plane.samples, width);
            let pixels = excess.par_iter_mut().zip(plane.samples);
            pixels
                .filter(|(_, sample)| **sample > threshold)
                .for_each(|(excess, sample)| *excess = (sample / threshold).max(*excess));
        }
        Self(excess)
    }

    /// Returns the excess of a pixel: more than 1, or 0 if it is not a highlight.
    pub(super) fn excess(&self, pixel: usize) -> f32 {
        self.0.get(pixel).copied().unwrap_or(0.0)
    }
}

/// Returns the level above which the samples of `plane` are highlights.
fn threshold(plane: &[f32], width: usize) -> f32 {
    let light = WinsorisedStatistics::of_absolute(plane);
    let dark = (LIT_SHARE * light.percentile_99) as f32;
    let mut lit: Vec<f32> = plane.iter().copied().filter(|v| *v > dark).collect();
    if lit.is_empty() {
        return f32::INFINITY;
    }
    let middle = lit.len() / 2;
    let (_, median, _) = lit.select_nth_unstable_by(middle, f32::total_cmp);
    (MEDIANS * f64::from(*median)).max(DEVIATIONS * haar_noise(plane, width)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_highlight_of_one_colour_is_one_of_all() {
        let (mut red, green) = (vec![0.1; 400], vec![0.1; 400]);
        red[7] = 5.0;
        let weights = [1.0];
        let plane = |samples| Plane {
            samples,
            weights: &weights,
        };
        let highlights = Highlights::detect(&[plane(&red), plane(&green)], 20);
        assert!((highlights.excess(7) - 2.0).abs() < 1e-5);
        assert_eq!(highlights.excess(8), 0.0);
        let of_green = Highlights::detect(&[plane(&green)], 20);
        assert_eq!(of_green.excess(7), 0.0);
    }

    /// The median counts lit samples only, so the black surroundings of an object do not make it a highlight.
    #[test]
    fn an_evenly_lit_object_on_black_has_no_highlights() {
        let mut plane = vec![0.0; 10_000];
        plane[5000..6000].fill(0.8);
        let weights = [1.0];
        let highlights = Highlights::detect(
            &[Plane {
                samples: &plane,
                weights: &weights,
            }],
            100,
        );
        assert!((0..10_000).all(|k| highlights.excess(k) == 0.0));
    }
}
