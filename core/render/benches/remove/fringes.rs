//! Colour fringes at high-contrast edges of neutral pictures, before and after `match_blur`.

use crate::SIDE;
use crate::case::{self, psnr_db, timed};
use crate::lenses::SkewNormalLens;
use crate::noise::Noise;
use seidel_optics::error::Result;
use seidel_optics::field::{FieldPoint, Frame};
use seidel_render::remove::{Deconvolver, find_lights, match_blur, reference_colour};
use seidel_render::{
    BlurField, DisplacedBlur, Displacement, Gather, Plane, Renderer, Scatter, Scene,
};

/// Displacement of R and B in the corners, px: outwards and inwards.
const CORNER_DISPLACEMENT_PX: [f64; 3] = [1.2, 0.0, -1.5];
/// Share of the pixels that have the steepest gradients: those are high-contrast edges.
const EDGE_SHARE: f64 = 0.03;
/// Distance from such pixels that is looked at, px.
const REACH: usize = 4;
/// Border that is left out, px.
const BORDER: usize = 32;

/// The lens of the benchmark with lateral colour beside its axial colour.
pub(crate) struct FringingLens(SkewNormalLens);

impl FringingLens {
    pub(crate) fn new() -> Result<Self> {
        Ok(Self(case::lens()?))
    }
}

impl BlurField for FringingLens {
    fn frame(&self) -> Frame {
        self.0.frame()
    }

    fn channel_count(&self) -> usize {
        3
    }

    fn blur_at(&self, channel: usize, at: FieldPoint, vergence_per_m: f64) -> DisplacedBlur {
        let rho = at.radius() / self.frame().corner_radius();
        let meridian = at.meridian();
        let size = CORNER_DISPLACEMENT_PX[channel] * rho;
        DisplacedBlur {
            displacement_px: (size * meridian.cos, size * meridian.sin),
            ..self.0.blur_at(channel, at, vergence_per_m)
        }
    }
}

/// Prints the table of all `pictures` at all `noises`.
pub(crate) fn print(pictures: &[(String, Vec<f32>)], noises: &[f64], rounds: usize) -> Result<()> {
    let lens = FringingLens::new()?;
    let scene = Scene {
        displacement: Displacement::Lateral,
        ..case::scene(&lens.0)
    };
    let scene = Scene {
        lens: &lens,
        ..scene
    };
    let weights: Vec<Vec<f64>> = (0..3)
        .map(|channel| (0..3).map(|k| f64::from(u8::from(k == channel))).collect())
        .collect();
    let reference = reference_colour(&scene, &weights)?;
    println!(
        "| picture | noise | fringe R px | fringe B px | R against G dB | B against G dB | G against truth dB | blurs |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- |");
    for (name, truth) in pictures {
        let planes: Vec<Plane> = weights
            .iter()
            .map(|weights| Plane {
                samples: truth,
                weights,
            })
            .collect();
        let sharp = Scatter.render(&scene, &planes, &|_| true)?.planes;
        for noise in noises {
            let plate: Vec<Vec<f32>> = (sharp.iter().enumerate())
                .map(|(k, plane)| Noise::White.add_to(plane, *noise, k as u64))
                .collect();
            let planes: Vec<Plane> = (plate.iter().zip(&weights))
                .map(|(samples, weights)| Plane { samples, weights })
                .collect();
            let match_all = || {
                let own: Vec<_> = (planes.iter())
                    .map(|plane| (Deconvolver::default(), *plane))
                    .collect();
                let lights = find_lights(&scene, &own, &|_| true)?;
                let matched = planes.iter().zip(&lights).map(|(plane, lights)| {
                    match_blur(lights, &scene, plane, &weights[reference], &|_| true)
                });
                matched.collect::<Result<Vec<_>>>()
            };
            let matched = match_all()?;
            let (mut blurs, mut matches) = (Vec::new(), Vec::new());
            for _ in 0..rounds {
                let fast = Gather::default();
                blurs.push(timed(|| fast.render(&scene, &planes, &|_| true))?);
                matches.push(timed(match_all)?);
            }
            let edges = edges(&sharp[reference]);
            let fringe = |planes: &[Vec<f32>], k: usize| {
                fringe_width(&planes[k], &planes[reference], &edges)
            };
            let clean = |k: usize| {
                let target = &sharp[reference];
                (psnr_db(&plate[k], target), psnr_db(&matched[k], target))
            };
            let ((red, red_after), (blue, blue_after)) = (clean(0), clean(2));
            println!(
                "| {name} | {noise} | {:.2} -> {:.2} | {:.2} -> {:.2} | {red:.1} -> {red_after:.1} | {blue:.1} -> {blue_after:.1} | {:.1} -> {:.1} | {:.1} |",
                fringe(&plate, 0),
                fringe(&matched, 0),
                fringe(&plate, 2),
                fringe(&matched, 2),
                psnr_db(&plate[reference], truth),
                psnr_db(&matched[reference], truth),
                case::median(matches) / case::median(blurs),
            );
        }
    }
    Ok(())
}

/// Returns the norm of the gradient of each pixel.
fn gradients(plane: &[f32]) -> Vec<f32> {
    let at = |x: usize, y: usize| plane[y.min(SIDE - 1) * SIDE + x.min(SIDE - 1)];
    (0..SIDE * SIDE)
        .map(|k| {
            let (x, y) = (k % SIDE, k / SIDE);
            (at(x + 1, y) - at(x, y)).hypot(at(x, y + 1) - at(x, y))
        })
        .collect()
}

/// Returns the pixels within reach of the steepest gradients.
fn edges(plane: &[f32]) -> Vec<usize> {
    let gradients = gradients(plane);
    let mut sorted = gradients.clone();
    sorted.sort_by(f32::total_cmp);
    let least = sorted[((1.0 - EDGE_SHARE) * sorted.len() as f64) as usize];
    let near = |at: usize| at.saturating_sub(REACH)..(at + REACH + 1).min(SIDE);
    (0..SIDE * SIDE)
        .filter(|k| {
            let (x, y) = (k % SIDE, k / SIDE);
            let inside = BORDER..SIDE - BORDER;
            let steep = || near(y).any(|y| near(x).any(|x| gradients[y * SIDE + x] > least));
            inside.contains(&x) && inside.contains(&y) && steep()
        })
        .collect()
}

/// Returns the mean difference of two colours over the mean gradient of the second, on the `edges`: the width of a fringe
/// of full contrast, px.
fn fringe_width(colour: &[f32], reference: &[f32], edges: &[usize]) -> f64 {
    let gradients = gradients(reference);
    let sum = |of: &dyn Fn(usize) -> f32| edges.iter().map(|k| f64::from(of(*k))).sum::<f64>();
    sum(&|k| (colour[k] - reference[k]).abs()) / sum(&|k| gradients[k])
}
