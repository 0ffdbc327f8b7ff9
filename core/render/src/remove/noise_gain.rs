//! The noise gain of removal: the standard deviation of noise in the sharp image over that in the plate.
//!
//! It is measured by removing blur once more from the plate with other noise. Let b be the plate with noise of standard
//! deviation s, x(b) its sharp image, n the residual, e white noise of unit variance, and k = 4/5. The gain at a pixel is
//!
//! ```text
//! rms(x(b') - x(b)) / (sqrt(1 - k²) s),  b' = b - (1 - k) n + sqrt(1 - k²) s e
//! ```
//!
//! The noise of b' has nearly the variance k² s² + (1 - k²) s² = s², because the gain depends on it. The divisor is the noise
//! that is added: the sharp image takes the noise that it amplifies out of the residual, so that taking off the residual
//! changes next to nothing there. Where it does, the gain reported is up to 5 % too large. The rest of the excess
//! (docs/background/figures.md) is not explained; the filters adapt to the noise of each plate, which is not linear.

use super::deconvolver::{LIGHTS_SHARE, Variant};
use super::local_mean::average_locally;
use super::normal_deviate::normal_deviate;
use super::separation::{PlaneLights, PlateInputs};
use super::winsorised::WinsorisedStatistics;
use super::{Deconvolver, Saturation, SharpPlane};
use crate::{Plane, Scene};
use rayon::prelude::*;
use seidel_optics::Progress;
use seidel_optics::error::Result;

/// Least noise with which the gain is measured, as a share of the 99th percentile of the light.
const MIN_NOISE_SHARE: f64 = 1e-4;
/// k, the share of the plane's own noise that is kept.
const KEPT_SHARE: f64 = 0.8;

impl Deconvolver {
    /// Measures the noise gain at each pixel of the plate, as a root mean square over about 30 px. It is 0 for a black plane.
    ///
    /// `sharp` must be the result for this plane and its `lights`. Blur is removed once more, from a plane with other
    /// noise, with the same lights separated.
    ///
    /// # Errors
    /// Those of [`Deconvolver::remove`].
    pub fn noise_gain(
        &self,
        lights: &PlaneLights,
        scene: &Scene,
        plane: &Plane,
        sharp: &SharpPlane,
        progress: &Progress,
    ) -> Result<Vec<f32>> {
        scene.check(&[*plane])?;
        let light = WinsorisedStatistics::of_absolute(plane.samples);
        let least = MIN_NOISE_SHARE * light.percentile_99;
        let noise = sharp.noise.max(least);
        // A plane with less than the least noise keeps its residual, and that much is added.
        let kept: f64 = if sharp.noise < least { 1.0 } else { KEPT_SHARE };
        let deviation = if kept < 1.0 {
            noise * (1.0 - kept * kept).sqrt()
        } else {
            noise
        };
        if deviation == 0.0 {
            return Ok(vec![0.0; plane.samples.len()]);
        }
        let clip_level = sharp.clipping.map(|clipping| clipping.level);
        let samples = plane.samples.par_iter().zip(&sharp.residual).enumerate();
        let noisy: Vec<f32> = samples
            .map(|(k, (sample, residual))| {
                if clip_level.is_some_and(|level| f64::from(*sample) >= level) {
                    *sample
                } else {
                    let noise = deviation * normal_deviate(k as u64);
                    sample - (1.0 - kept) as f32 * residual + noise as f32
                }
            })
            .collect();
        let noisy = Plane {
            samples: &noisy,
            ..*plane
        };
        let deconvolver = Self {
            // The regularisation follows from it.
            noise: Some(sharp.noise),
            // Noise blurs the histogram from which the level was found.
            saturation: clip_level.map_or(Saturation::Never, Saturation::Level),
            ..*self
        };
        let variant = Variant::removal(self.lights);
        let plate = PlateInputs::new(scene, &lights.highlights, variant);
        let mut searched = plate.search(&deconvolver, &noisy, &|share| {
            progress(LIGHTS_SHARE * share)
        })?;
        // Noise must not change which lights are separated, or all of their light would count as noise.
        searched.found.keep_blur_of(&lights.sources.unexplained);
        searched.found.retain_lights_of(&lights.sources.explained);
        let lights = searched.lights(&lights.highlights, scene.width);
        let progress = |share: f64| progress(LIGHTS_SHARE + (1.0 - LIGHTS_SHARE) * share);
        let other = deconvolver.remove_around(&lights, scene, &noisy, &progress)?;
        let pairs = sharp.sharp.par_iter().zip(&other.sharp);
        let squares: Vec<f32> = pairs.map(|(a, b)| (a - b).powi(2)).collect();
        let mut squares = sharp.canvas.crop(&squares);
        average_locally(&mut squares, scene.width);
        let gain = |square: &f32| (f64::from(square.max(0.0)).sqrt() / deviation) as f32;
        Ok(squares.par_iter().map(gain).collect())
    }
}
