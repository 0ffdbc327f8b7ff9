//! Collaborative Wiener filtering of groups of similar patches: the second stage of BM3D.
//!
//! A pilot image gives each group its spectrum. The group's patches are transformed by a cosine transform in their plane and
//! a Walsh-Hadamard transform across the group. Each coefficient of the noisy image is multiplied by
//!
//! ```text
//! |p|² / (|p|² + v)
//! ```
//!
//! with p the pilot's coefficient and v the variance of the noise. Filtered patches return to their places, and are averaged
//! with weights inverse to the noise that the filter of their group leaves.
//!
//! K. Dabov, A. Foi, V. Katkovnik and K. Egiazarian, "Image denoising by sparse 3-D transform-domain collaborative
//! filtering", IEEE Transactions on Image Processing 16 (2007). Here the sizes of patches and groups are smaller
//! (`block_matching`), and the transform across a group is that of Walsh and Hadamard, not of Haar.

use super::block_matching::{GROUP, GroupBand, PATCH, PatchGroups};
use rayon::prelude::*;
use std::f64::consts::PI;

const PIXELS: usize = PATCH * PATCH;

/// The patches of a group side by side: for each pixel or coefficient, the value of each patch.
type Group = [[f32; GROUP]; PIXELS];

/// Removes white noise of this `deviation` from the plane `noisy`, with the spectra of `pilot` and its `groups`.
pub(super) fn collaborative_filter(
    noisy: &[f32],
    pilot: &[f32],
    groups: &PatchGroups,
    deviation: f32,
) -> Vec<f32> {
    let width = groups.size.0;
    let filter = GroupFilter {
        noisy,
        pilot,
        width,
        transform: CosineTransform::new(),
        // The transform across a group is not normalised.
        noise_scale: (deviation * (GROUP as f32).sqrt())
            .max(f32::MIN_POSITIVE)
            .recip(),
    };
    let bands: Vec<WeightedSum> = (groups.bands.par_iter())
        .map(|band| filter.run(band))
        .collect();
    let mut out = vec![0.0; noisy.len()];
    out.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        let mut weights = vec![0.0; width];
        // In order, so that the sum does not depend on the number of threads.
        for (band, sum) in groups.bands.iter().zip(&bands) {
            if band.rows.contains(&y) {
                let start = (y - band.rows.start) * width;
                let own = sum.values[start..].iter().zip(&sum.weights[start..]);
                for ((out, weight), (value, own)) in out.iter_mut().zip(&mut weights).zip(own) {
                    *out += value;
                    *weight += own;
                }
            }
        }
        for (out, weight) in out.iter_mut().zip(&weights) {
            *out /= weight;
        }
    });
    out
}

/// Weighted sums of the patches of a band, on its rows.
struct WeightedSum {
    values: Vec<f32>,
    weights: Vec<f32>,
}

struct GroupFilter<'a> {
    noisy: &'a [f32],
    pilot: &'a [f32],
    width: usize,
    transform: CosineTransform,
    /// One over the standard deviation of the noise of a coefficient.
    noise_scale: f32,
}

impl GroupFilter<'_> {
    fn run(&self, band: &GroupBand) -> WeightedSum {
        let count = band.rows.len() * self.width;
        let mut sum = WeightedSum {
            values: vec![0.0; count],
            weights: vec![0.0; count],
        };
        let first = band.rows.start * self.width;
        for patches in &band.groups {
            let mut group = self.spectrum(self.noisy, patches);
            let pilot = self.spectrum(self.pilot, patches);
            let mut squares = [0.0; GROUP];
            for (values, pilot) in group.iter_mut().zip(&pilot) {
                for k in 0..GROUP {
                    let power = (self.noise_scale * pilot[k]).powi(2);
                    // Infinite powers give 1.
                    let gain = 1.0 - 1.0 / (power + 1.0);
                    values[k] *= gain;
                    squares[k] += gain * gain;
                }
            }
            self.transform.inverse(&mut group);
            let weight = 1.0 / squares.iter().sum::<f32>().max(1.0);
            let scale = weight / GROUP as f32;
            for values in &mut group {
                walsh_hadamard(values);
            }
            for (k, patch) in patches.iter().enumerate() {
                for y in 0..PATCH {
                    let start = *patch as usize - first + y * self.width;
                    let rows = (sum.values[start..][..PATCH].iter_mut())
                        .zip(&mut sum.weights[start..][..PATCH]);
                    for ((value, sum_weight), pixel) in rows.zip(&group[y * PATCH..]) {
                        *value += scale * pixel[k];
                        *sum_weight += weight;
                    }
                }
            }
        }
        sum
    }

    /// Returns the coefficients of a group of patches of `plane`.
    fn spectrum(&self, plane: &[f32], patches: &[u32; GROUP]) -> Group {
        let mut group = [[0.0; GROUP]; PIXELS];
        for (k, patch) in patches.iter().enumerate() {
            for y in 0..PATCH {
                let row = &plane[*patch as usize + y * self.width..][..PATCH];
                for (pixel, sample) in group[y * PATCH..].iter_mut().zip(row) {
                    pixel[k] = *sample;
                }
            }
        }
        self.transform.forward(&mut group);
        for values in &mut group {
            walsh_hadamard(values);
        }
        group
    }
}

/// Transforms the values of a group's patches; twice, it multiplies them by their number.
fn walsh_hadamard(values: &mut [f32; GROUP]) {
    let mut half = 1;
    while half < GROUP {
        for start in (0..GROUP).step_by(2 * half) {
            for k in start..start + half {
                let (a, b) = (values[k], values[k + half]);
                (values[k], values[k + half]) = (a + b, a - b);
            }
        }
        half *= 2;
    }
}

/// The orthonormal cosine transform of patches along both axes.
struct CosineTransform {
    /// Row u has the wave of u half periods.
    waves: [[f32; PATCH]; PATCH],
}

impl CosineTransform {
    fn new() -> Self {
        let mut waves = [[0.0; PATCH]; PATCH];
        for (u, wave) in waves.iter_mut().enumerate() {
            let norm = if u == 0 { 1.0 } else { 2.0 } / PATCH as f64;
            for (x, value) in wave.iter_mut().enumerate() {
                let phase = PI * (x as f64 + 0.5) * u as f64 / PATCH as f64;
                *value = (norm.sqrt() * phase.cos()) as f32;
            }
        }
        Self { waves }
    }

    fn forward(&self, group: &mut Group) {
        self.multiply(group, |u, x| self.waves[u][x]);
    }

    fn inverse(&self, group: &mut Group) {
        self.multiply(group, |x, u| self.waves[u][x]);
    }

    /// Multiplies rows and columns of the patches by the matrix `element(to, from)`.
    fn multiply(&self, group: &mut Group, element: impl Fn(usize, usize) -> f32) {
        for (line_step, step) in [(PATCH, 1), (1, PATCH)] {
            for line in 0..PATCH {
                let at = |k: usize| line * line_step + k * step;
                let mut out = [[0.0; GROUP]; PATCH];
                for (to, out) in out.iter_mut().enumerate() {
                    for from in 0..PATCH {
                        let (factor, values) = (element(to, from), &group[at(from)]);
                        for k in 0..GROUP {
                            out[k] += factor * values[k];
                        }
                    }
                }
                for (k, out) in out.iter().enumerate() {
                    group[at(k)] = *out;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_scenes::{HEIGHT, NormalDeviates, WIDTH, discs, psnr_db};
    use super::*;

    /// The transforms are orthogonal, so a filter without noise changes nothing.
    #[test]
    fn images_without_noise_are_unchanged() {
        let image = discs(WIDTH, HEIGHT);
        let groups = PatchGroups::find(&image, WIDTH).expect("a plane larger than a patch");
        let found = collaborative_filter(&image, &image, &groups, 1e-6);
        for (found, sample) in found.iter().zip(&image) {
            assert!((found - sample).abs() < 1e-5, "{found} {sample}");
        }
    }

    /// An ideal pilot shows what the filter can remove.
    #[test]
    fn white_noise_is_removed_and_edges_are_kept() {
        let image = discs(WIDTH, HEIGHT);
        let mut deviates = NormalDeviates(4);
        let noisy: Vec<f32> = (image.iter())
            .map(|sample| sample + 0.05 * deviates.next() as f32)
            .collect();
        let groups = PatchGroups::find(&image, WIDTH).expect("a plane larger than a patch");
        let found = collaborative_filter(&noisy, &image, &groups, 0.05);
        let (before, after) = (psnr_db(&noisy, &image), psnr_db(&found, &image));
        assert!(after > before + 9.0, "{before} {after}");
    }
}
