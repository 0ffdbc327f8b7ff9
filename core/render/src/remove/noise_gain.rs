//! How much of a plate's noise is in the picture without its blur, and where.

use super::sums::Typical;
use super::{Lights, Removal, Removed};
use crate::{Plane, Scene};
use rayon::prelude::*;
use seidel_optics::error::Result;
use std::f64::consts::TAU;

/// Noise that is added to a plane without any, as a share of what most samples are at most.
const LEAST_NOISE: f64 = 1e-3;
/// Share of the plane's own noise that is kept: what is changed for other noise is as strong as the noise.
const KEPT: f64 = 0.5;
/// How often sums of running squares are taken along each axis, and their half width, px.
const PASSES: usize = 3;
const HALF_WIDTH: usize = 8;

impl Removal {
    /// How many times as strong a plane's noise is in the picture found, at each pixel of the plate: half of the
    /// plate's own is changed for other noise, blur is removed again, and what has changed in `removed`, which came of
    /// these planes and `lights`, is compared with that. A root mean square over about 30 pixels across. Zero where nothing came of it.
    ///
    /// # Errors
    /// Those of [`Removal::remove`].
    pub fn noise_gain(
        &self,
        lights: &Lights,
        scene: &Scene,
        planes: &[Plane],
        removed: &[Removed],
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Vec<Vec<f32>>> {
        scene.check(planes)?;
        let one = |(index, (plane, removed)): (usize, (&Plane, &Removed))| {
            let most = Typical::of(plane.samples.iter().map(|v| v.abs()).collect()).most;
            let least = LEAST_NOISE * most;
            let added = removed.noise.max(least);
            if added == 0.0 {
                return Ok(vec![0.0; plane.samples.len()]);
            }
            // All in all there must not be more noise than before: how it is dealt with depends on that.
            let (kept, other) = if removed.noise < least {
                (1.0, 1.0)
            } else {
                (KEPT, (1.0 - KEPT * KEPT).sqrt())
            };
            let noisy: Vec<f32> = (plane.samples.par_iter().zip(&removed.rest).enumerate())
                .map(|(k, (sample, rest))| {
                    let deviate = other * added * deviate(k as u64);
                    sample - (1.0 - kept) as f32 * rest + deviate as f32
                })
                .collect();
            let again = Self {
                // The regularisation follows from it: it must not change.
                noise: Some(removed.noise),
                ..*self
            };
            let noisy = Plane {
                samples: &noisy,
                ..*plane
            };
            let share = |part: f64| progress((index as f64 + part) / planes.len() as f64);
            let other = (again.remove_about(lights, scene, &[noisy], &share)?).swap_remove(0);
            let (a, b) = (&removed.sharp, &other.sharp);
            let squares: Vec<f32> = a.par_iter().zip(b).map(|(a, b)| (a - b).powi(2)).collect();
            let mut squares = removed.canvas.cropped(&squares);
            smooth(&mut squares, scene.width);
            let gain = |square: &f32| (f64::from(square.max(0.0)).sqrt() / added) as f32;
            Ok(squares.par_iter().map(gain).collect())
        };
        planes.iter().zip(removed).enumerate().map(one).collect()
    }
}

/// Normal deviates by index (Box and Muller 1958, of numbers mixed as SplitMix64 does: Steele, Lea and Flood 2014).
fn deviate(index: u64) -> f64 {
    let mixed = |seed: u64| {
        let mut z = seed.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 + 0.5
    };
    let scale = (1_u64 << 53) as f64;
    let (a, b) = (mixed(2 * index) / scale, mixed(2 * index + 1) / scale);
    (-2.0 * a.ln()).sqrt() * (TAU * b).cos()
}

/// Running means along rows and columns, of what is there near the edges.
fn smooth(plane: &mut [f32], width: usize) {
    for _ in 0..PASSES {
        plane.par_chunks_mut(width).for_each(|row| {
            let mut line = row.to_vec();
            running_mean(&mut line);
            row.copy_from_slice(&line);
        });
        let height = plane.len() / width;
        let columns: Vec<Vec<f32>> = (0..width)
            .into_par_iter()
            .map(|x| {
                let mut line: Vec<f32> = (0..height).map(|y| plane[y * width + x]).collect();
                running_mean(&mut line);
                line
            })
            .collect();
        plane
            .par_chunks_mut(width)
            .enumerate()
            .for_each(|(y, row)| {
                for (out, column) in row.iter_mut().zip(&columns) {
                    *out = column[y];
                }
            });
    }
}

fn running_mean(line: &mut [f32]) {
    let mut sums = vec![0.0_f64];
    sums.extend(line.iter().scan(0.0, |sum, v| {
        *sum += f64::from(*v);
        Some(*sum)
    }));
    let count = line.len();
    for (k, out) in line.iter_mut().enumerate() {
        let (from, to) = (
            k.saturating_sub(HALF_WIDTH),
            (k + HALF_WIDTH + 1).min(count),
        );
        *out = ((sums[to] - sums[from]) / (to - from) as f64) as f32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deviates_are_normal_and_apart() {
        let all: Vec<f64> = (0..20_000).map(deviate).collect();
        let mean = |of: &dyn Fn(usize) -> f64| (0..19_999).map(of).sum::<f64>() / 19_999.0;
        assert!(mean(&|k| all[k]).abs() < 0.03);
        assert!((mean(&|k| all[k].powi(2)) - 1.0).abs() < 0.04);
        assert!((mean(&|k| all[k].powi(4)) - 3.0).abs() < 0.3);
        assert!(mean(&|k| all[k] * all[k + 1]).abs() < 0.03);
    }

    #[test]
    fn running_means_keep_what_is_even_and_the_sum_inside() {
        let mut even = vec![3.0; 70 * 50];
        smooth(&mut even, 70);
        assert!(even.iter().all(|v| (v - 3.0).abs() < 1e-5));
        let mut one = vec![0.0; 120 * 120];
        one[60 * 120 + 60] = 1.0;
        smooth(&mut one, 120);
        assert!((one.iter().sum::<f32>() - 1.0).abs() < 1e-4);
        assert!(one[60 * 120 + 60] < 0.01);
    }
}
