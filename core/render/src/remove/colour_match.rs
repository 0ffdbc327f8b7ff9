//! Removal of colour fringes alone: each colour gets the blur of a reference colour, with its place.
//!
//! A lens blurs and displaces colours differently. Where h is the transfer function of a colour and r that of the
//! reference, both with their displacement, the spectrum of the colour is multiplied by
//!
//! ```text
//! 1 + (r - h) h* / (|h|² + d |D|²)
//! ```
//!
//! This adds the Wiener estimate of the difference between the two images: frequencies below the noise stay as they are,
//! and where the two blurs are alike nothing changes. Here d |D|² is the ratio of noise to the power spectrum of pictures,
//! proportional to 1 / |D|². The filter works on local spectra. Lights are taken off before it, and come back blurred as the
//! reference is.

use super::deconvolver::{Lights, Variant, is_uniform};
use super::gradient::{LinkedPlane, sampled_norms};
use super::hole_filling::fill_holes;
use super::lens_operator::LensOperator;
use super::separation::{PlaneLights, PlateInputs};
use super::transfer_functions::Purpose;
use super::winsorised::WinsorisedStatistics;
use crate::{LocalKernels, Plane, Scene, VergencePass, cancelled};
use rayon::prelude::*;
use seidel_fourier::Complex;
use seidel_optics::Progress;
use seidel_optics::error::{Error, Result};

/// Share of the progress taken by the preparation of both lenses.
const PREPARED_SHARE: f64 = 0.3;
/// Largest gain of a frequency: a colour that is blurred much more than the reference stays a little softer.
const MAX_GAIN: f32 = 3.0;

/// Returns `plane` with the blur of channel weights `reference` in place of its own, on the plate.
///
/// The plane is one of those whose `lights` were found by [`find_lights`](super::find_lights). Lights that are not separated, and
/// depth edges within the reach of the kernels, keep their blur.
///
/// # Errors
/// Those of [`Deconvolver::remove`](super::Deconvolver::remove).
pub fn match_blur(
    lights: &PlaneLights,
    scene: &Scene,
    plane: &Plane,
    reference: &[f64],
    progress: &Progress,
) -> Result<Vec<f32>> {
    scene.check(&[*plane])?;
    if plane.weights == reference || is_uniform(plane.samples) {
        return Ok(plane.samples.to_vec());
    }
    let plate = PlateInputs::new(
        scene,
        &lights.highlights,
        Variant::removal(Lights::Separate),
    );
    let canvas = plate.canvas;
    let operator = LensOperator::for_purpose(Purpose::Local, scene, &canvas, plane.weights)?;
    let kept = plate.kept_blur(plane.samples, lights, &operator)?;
    let edges = canvas.crop(&operator.edge_shares());
    let kept: Vec<f32> = (kept.shares().zip(edges).map(|(kept, edge)| kept.max(edge))).collect();
    let (noise, lights) = (lights.noise, &lights.sources);
    let rest = lights.taken_off(plane.samples);
    let target = LensOperator::for_purpose(Purpose::Local, scene, &canvas, reference)?;
    if !progress(PREPARED_SHARE) {
        return Err(cancelled());
    }
    let known: Vec<bool> = kept.iter().map(|kept| *kept == 0.0).collect();
    let filled = fill_holes(&rest, scene.width, &known);
    let gradients =
        WinsorisedStatistics::new(sampled_norms(LinkedPlane::plain(&filled, scene.width)));
    let strength = 2.0 * gradients.root_mean_square.powi(2);
    let damping = (2.0 * noise * noise / strength.max(f64::MIN_POSITIVE)) as f32;
    let gain = |h: Complex<f32>, r: Complex<f32>, gradient_power: f32| {
        let power = h.norm_sqr() + damping * gradient_power;
        if power == 0.0 {
            return Complex::new(1.0, 0.0);
        }
        let gain = (r - h) * h.conj() / power + 1.0;
        gain * (MAX_GAIN / gain.norm().max(MAX_GAIN))
    };
    let filtered = operator.convert(&target, &canvas.extend_by_mirroring(&filled), gain)?;
    let mut out = canvas.crop(&filtered);
    add_blurred(&mut out, scene, reference, &lights.sources)?;
    let darkest = plane.samples.iter().fold(0.0_f32, |least, v| least.min(*v));
    let pixels = out.par_iter_mut().zip(plane.samples).zip(&kept);
    pixels.for_each(|((sample, before), kept)| {
        *sample = sample.max(darkest);
        *sample += kept * (before - *sample);
    });
    Ok(out)
}

/// Adds `sources`, pixels of a plate and their light, to `plane` as the lens of `scene` blurs them.
fn add_blurred(
    plane: &mut [f32],
    scene: &Scene,
    weights: &[f64],
    sources: &[(usize, f32)],
) -> Result<()> {
    for (pixel, light) in sources {
        let scene = Scene {
            vergence: VergencePass::Constant(scene.vergence_at(*pixel)),
            ..*scene
        };
        let kernels = LocalKernels::new(&scene, weights)?;
        let (x, y) = (pixel % scene.width, pixel / scene.width);
        let kernel = kernels.at((x as f64 + 0.5, y as f64 + 0.5))?;
        for (k, weight) in kernel.weights.iter().enumerate() {
            let at_x = x as i32 + kernel.left + (k % kernel.width) as i32;
            let at_y = y as i32 + kernel.top + (k / kernel.width) as i32;
            let on_plate =
                (0..scene.width as i32).contains(&at_x) && (0..scene.height as i32).contains(&at_y);
            if on_plate {
                plane[at_y as usize * scene.width + at_x as usize] += weight * light;
            }
        }
    }
    Ok(())
}

/// Returns the index of the plane whose blur is of middle size, of `weights` of all planes: the reference to which the
/// others are matched with the least change. Blur is compared in the middle of the plate and in its corners.
///
/// # Errors
/// A lens that cannot be drawn; no planes.
pub fn reference_colour(scene: &Scene, weights: &[Vec<f64>]) -> Result<usize> {
    let middle = scene.height / 2 * scene.width + scene.width / 2;
    let scene = Scene {
        vergence: VergencePass::Constant(scene.vergence_at(middle)),
        ..*scene
    };
    let mut sizes = Vec::with_capacity(weights.len());
    for (index, weights) in weights.iter().enumerate() {
        let kernels = LocalKernels::new(&scene, weights)?;
        let mut size = 0.0;
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.5, 0.5), (0.0, 1.0), (1.0, 1.0)] {
            let at = (x * scene.width as f64, y * scene.height as f64);
            size += kernels.at(at)?.variance_px2();
        }
        sizes.push((size, index));
    }
    sizes.sort_by(|a, b| a.0.total_cmp(&b.0));
    let middle = sizes.get(sizes.len() / 2).map(|(_, index)| *index);
    middle.ok_or_else(|| Error::new("plate", "has no colours", "give a plate with R, G and B"))
}
