//! One picture blurred by the lens with some noise, and the result of removal.

use crate::Options;
use crate::SIDE;
use crate::lenses::SkewNormalLens;
use seidel_optics::error::Result;
use seidel_optics::field::{Frame, ImagePoint};
use seidel_optics::psf::SkewNormal;
use seidel_render::remove::Deconvolver;
use seidel_render::{
    BlurField, Displacement, Edges, Gather, Plane, PlateMap, Renderer, Scatter, Scene, VergencePass,
};
use std::time::Instant;

/// The green channel of the lens.
pub(crate) const WEIGHTS: [f64; 3] = [0.0, 1.0, 0.0];
/// Standard deviation of kernels in the corners along the meridian, px.
const CORNER_SIGMA_PX: f64 = 6.0;
/// Pixels at each edge excluded from errors, as in published comparisons.
const BORDER: usize = 32;

/// The measurements of one picture; times are medians, s.
pub(crate) struct Measurement {
    name: String,
    noise: f64,
    noise_estimate: f64,
    before_db: f64,
    after_db: f64,
    /// PSNR of the blurred result against the plate, without the border.
    back_db: f64,
    misfit: f64,
    blur_seconds: f64,
    seconds: f64,
    pub(crate) plate: Vec<f32>,
    pub(crate) sharp: Vec<f32>,
}

/// The lens of docs/background/performance.md, part B.
pub(crate) fn lens() -> Result<SkewNormalLens> {
    lens_of_size(1.0)
}

/// Returns that lens with its blur `size` times as large.
pub(crate) fn lens_of_size(size: f64) -> Result<SkewNormalLens> {
    let frame = Frame::new(SIDE as u32, SIDE as u32, None)?;
    Ok(SkewNormalLens::new(frame, size * CORNER_SIGMA_PX))
}

pub(crate) fn scene(lens: &dyn BlurField) -> Scene<'_> {
    Scene {
        lens,
        model: &SkewNormal,
        width: SIDE,
        height: SIDE,
        map: PlateMap {
            origin: ImagePoint::new(0.0, 0.0),
            scale: 1.0,
        },
        vergence: VergencePass::Constant(0.0),
        edges: Edges::Mirror,
        displacement: Displacement::None,
    }
}

fn plane(samples: &[f32]) -> [Plane<'_>; 1] {
    let weights = &WEIGHTS;
    [Plane { samples, weights }]
}

/// Blurs the picture with the exact renderer.
pub(crate) fn blurred(scene: &Scene, truth: &[f32]) -> Result<Vec<f32>> {
    Ok(Scatter
        .render(scene, &plane(truth), &|_| true)?
        .planes
        .swap_remove(0))
}

/// Removes blur from `blurred` with noise of standard deviation `noise`, and compares with the picture `truth`.
pub(crate) fn measure(
    scene: &Scene,
    name: &str,
    truth: &[f32],
    blurred: &[f32],
    noise: f64,
    options: &Options,
) -> Result<Measurement> {
    eprintln!("{name} {noise}");
    let plate = options.kind.add_to(blurred, noise, 0);
    let fast = Gather::default();
    let blur = |samples: &[f32]| fast.render(scene, &plane(samples), &|_| true);
    let deconvolver = Deconvolver::default();
    let remove = || deconvolver.remove(scene, &plane(&plate), &|_| true);
    let removed = remove()?.swap_remove(0);
    let sharp = removed.canvas.crop(&removed.sharp);
    // With the margin around the plate, as EXR files keep it.
    let whole = removed.canvas.scene(scene, None);
    let back = fast.render(&whole, &plane(&removed.sharp), &|_| true)?;
    let back = removed.canvas.crop(&back.planes[0]);
    let (mut blurs, mut removals) = (Vec::new(), Vec::new());
    for _ in 0..options.rounds {
        blurs.push(timed(|| blur(truth))?);
        removals.push(timed(remove)?);
    }
    Ok(Measurement {
        name: name.to_owned(),
        noise,
        noise_estimate: removed.noise,
        before_db: psnr_db(&plate, truth),
        after_db: psnr_db(&sharp, truth),
        back_db: psnr_db(&back, &plate),
        misfit: removed.misfit,
        blur_seconds: median(blurs),
        seconds: median(removals),
        plate,
        sharp,
    })
}

pub(crate) fn timed<T>(work: impl FnOnce() -> Result<T>) -> Result<f64> {
    let start = Instant::now();
    work()?;
    Ok(start.elapsed().as_secs_f64())
}

pub(crate) fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    let middle = times.len() / 2;
    times.get(middle).copied().unwrap_or(f64::NAN)
}

/// Returns the peak signal-to-noise ratio for a peak of one within the border, dB.
pub(crate) fn psnr_db(found: &[f32], truth: &[f32]) -> f64 {
    let inside = BORDER..SIDE - BORDER;
    let (mut squares, mut count) = (0.0, 0);
    for row in inside.clone() {
        for column in inside.clone() {
            let k = row * SIDE + column;
            squares += f64::from(found[k] - truth[k]).powi(2);
            count += 1;
        }
    }
    -10.0 * (squares / f64::from(count)).log10()
}

impl Measurement {
    pub(crate) fn head() -> &'static str {
        "| picture | noise | noise estimate | plate dB | sharp dB | gain dB | there and back dB | misfit | one blur s | seconds | blurs |\n\
         | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |"
    }

    pub(crate) fn line(&self) -> String {
        format!(
            "| {} | {} | {:.5} | {:.2} | {:.2} | {:+.2} | {:.1} | {:.2} | {:.3} | {:.3} | {:.1} |",
            self.name,
            self.noise,
            self.noise_estimate,
            self.before_db,
            self.after_db,
            self.after_db - self.before_db,
            self.back_db,
            self.misfit,
            self.blur_seconds,
            self.seconds,
            self.seconds / self.blur_seconds,
        )
    }
}
