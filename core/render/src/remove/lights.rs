//! Lights: so bright beside all else that what a lens gets wrong of them would be seen as rings, were their blur removed.

use super::noise::by_detail;
use super::sums::Typical;
use crate::Plane;
use rayon::prelude::*;

/// Lights are so many times as bright as the middle one of all samples that are not dark, and as noise, at least.
const TIMES: f64 = 25.0;
const TIMES_NOISE: f64 = 400.0;
/// Dark is less than this share of most samples.
const DARK: f64 = 1e-3;

/// How many times as bright as a light at least is each pixel is, in the plane in which it is brightest; 0 where it is none.
#[derive(Debug, Clone, PartialEq)]
pub struct Lights(Vec<f32>);

impl Lights {
    /// The lights of planes of one size, `width` samples wide: those of one are lights in all, that colours be treated alike.
    #[must_use]
    pub fn of(planes: &[Plane], width: usize) -> Self {
        let mut times = vec![0.0_f32; planes.first().map_or(0, |plane| plane.samples.len())];
        for plane in planes {
            let least = least(plane.samples, width);
            let both = times.par_iter_mut().zip(plane.samples);
            both.filter(|(_, sample)| **sample > least)
                .for_each(|(times, sample)| *times = (sample / least).max(*times));
        }
        Self(times)
    }

    pub(super) fn at(&self, pixel: usize) -> f32 {
        self.0.get(pixel).copied().unwrap_or(0.0)
    }
}

/// What is brighter than this is a light.
fn least(plane: &[f32], width: usize) -> f32 {
    let most = Typical::of(plane.iter().map(|v| v.abs()).collect()).most;
    let dark = (DARK * most) as f32;
    let mut lit: Vec<f32> = plane.iter().copied().filter(|v| *v > dark).collect();
    if lit.is_empty() {
        return f32::INFINITY;
    }
    let middle = lit.len() / 2;
    let (_, median, _) = lit.select_nth_unstable_by(middle, f32::total_cmp);
    (TIMES * f64::from(*median)).max(TIMES_NOISE * by_detail(plane, width)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_a_light_in_one_colour_is_one_in_all() {
        let (mut red, green) = (vec![0.1; 400], vec![0.1; 400]);
        red[7] = 5.0;
        let weights = [1.0];
        let plane = |samples| Plane {
            samples,
            weights: &weights,
        };
        let lights = Lights::of(&[plane(&red), plane(&green)], 20);
        assert!((lights.at(7) - 2.0).abs() < 1e-5);
        assert_eq!(lights.at(8), 0.0);
        assert_eq!(Lights::of(&[plane(&green)], 20).at(7), 0.0);
    }

    /// Nor are those of a plane that is black about what is in it.
    #[test]
    fn what_is_as_bright_as_most_is_no_light() {
        let mut plane = vec![0.0; 10_000];
        plane[5000..6000].fill(0.8);
        let weights = [1.0];
        let lights = Lights::of(
            &[Plane {
                samples: &plane,
                weights: &weights,
            }],
            100,
        );
        assert!((0..10_000).all(|k| lights.at(k) == 0.0));
    }
}
