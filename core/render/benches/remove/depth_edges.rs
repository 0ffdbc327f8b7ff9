//! Leaves before a picture: errors at depth edges after removal without the clean plate and with it.

use crate::case::{WEIGHTS, blurred, scene};
use crate::lenses::SkewNormalLens;
use crate::noise::Noise;
use crate::{Options, SIDE};
use seidel_optics::error::Result;
use seidel_optics::field::{FieldPoint, Frame};
use seidel_render::remove::{Deconvolver, DepthSplit, SharpPlane};
use seidel_render::{BlurField, DisplacedBlur, Plane, Scene, VergencePass};

/// Vergence of the leaves; that of the picture behind is zero.
const NEAR: f32 = 1.0;
/// Distance from edges up to which errors count, px.
const REACH: usize = 16;
/// Border that is left out, px.
const BORDER: usize = 32;
/// Number of leaves.
const LEAVES: usize = 40;
/// Levels of leaves and ground of one colour.
const FLAT: [f32; 2] = [0.1, 0.5];

/// A lens whose blur changes linearly with vergence, through zero where the leaves and the picture lie on two sides of the focus.
struct FocusedLens {
    frame: Frame,
    /// Standard deviations of kernels in the corners at leaves and picture, px, negative behind the focus.
    sizes: [f64; 2],
}

impl BlurField for FocusedLens {
    fn frame(&self) -> Frame {
        self.frame
    }

    fn channel_count(&self) -> usize {
        WEIGHTS.len()
    }

    fn blur_at(&self, channel: usize, at: FieldPoint, vergence_per_m: f64) -> DisplacedBlur {
        let [front, back] = self.sizes;
        let size = back + (front - back) * vergence_per_m / f64::from(NEAR);
        SkewNormalLens::new(self.frame, size.abs()).blur_at(channel, at, 0.0)
    }
}

/// Leaves before a picture, sharp and through the lens.
struct Shot {
    is_leaf: Vec<bool>,
    truth: Vec<f32>,
    plate: Vec<f32>,
    clean: Vec<f32>,
}

/// The errors of an image near the edges of the leaves.
struct EdgeErrors {
    /// Root mean square.
    deviation: f64,
    /// Largest distance of means over 3 x 3 px below and above all light of the truth, % of its mean.
    shoots: [f64; 2],
}

/// Prints the errors with leaves and ground of one colour, and with leaves of one picture before another.
pub(crate) fn print(pictures: &[(String, Vec<f32>)], options: &Options) -> Result<()> {
    println!(
        "| picture | corner blur of leaves, picture px | noise | plate | without clean plate | with it | undershoot, overshoot without | with |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- |");
    let flat = FLAT.map(|level| vec![level; SIDE * SIDE]);
    let mut shots = vec![("one colour", &flat[0], &flat[1])];
    for (index, (name, picture)) in pictures.iter().enumerate() {
        let leaves = &pictures[(index + 1) % pictures.len()].1;
        shots.push((name, leaves, picture));
    }
    for (name, leaves, picture) in shots {
        for sizes in [[6.0, 1.5], [1.5, 6.0], [6.0, -6.0]] {
            let lens = FocusedLens {
                frame: Frame::new(SIDE as u32, SIDE as u32, None)?,
                sizes,
            };
            for noise in options.noises.iter().filter(|noise| **noise > 0.0) {
                eprintln!("{name} {sizes:?} {noise}");
                let shot = Shot::new(&lens, [leaves, picture], *noise)?;
                let [plate, without, with] =
                    [shot.plate.clone(), shot.removed(&lens)?, shot.split(&lens)?]
                        .map(|image| shot.errors(&image));
                let [a, b] = sizes.map(f64::abs);
                println!(
                    "| {name} | {a}, {b} | {noise} | {:.4} | {:.4} | {:.4} | {:.0}, {:.0} % | {:.0}, {:.0} % |",
                    plate.deviation,
                    without.deviation,
                    with.deviation,
                    without.shoots[0],
                    without.shoots[1],
                    with.shoots[0],
                    with.shoots[1],
                );
            }
        }
    }
    Ok(())
}

/// Returns whether each pixel shows a leaf, an ellipse.
fn leaves() -> Vec<bool> {
    let mut state = 7_u64;
    let mut unit = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 33) as f64 / (1_u64 << 31) as f64
    };
    // Centre, half the logarithm of the ratio of the axes, and angle of each.
    let leaves: Vec<[f64; 4]> = (0..LEAVES)
        .map(|_| {
            let side = SIDE as f64;
            [
                side * unit(),
                side * unit(),
                0.4 + 0.8 * unit(),
                3.2 * unit(),
            ]
        })
        .collect();
    let inside = |k: usize| {
        let (x, y) = ((k % SIDE) as f64, (k / SIDE) as f64);
        leaves.iter().any(|[cx, cy, slim, angle]| {
            let (x, y) = (x - cx, y - cy);
            let along = x * angle.cos() + y * angle.sin();
            let across = y * angle.cos() - x * angle.sin();
            (along / slim.exp()).hypot(across * slim.exp()) < 20.0
        })
    };
    (0..SIDE * SIDE).map(inside).collect()
}

impl Shot {
    /// Renders leaves and picture by themselves with the exact renderer, one over the other.
    fn new(lens: &FocusedLens, [front, back]: [&Vec<f32>; 2], noise: f64) -> Result<Self> {
        let is_leaf = leaves();
        let at = |vergence| Scene {
            vergence: VergencePass::Constant(vergence),
            ..scene(lens)
        };
        let cover: Vec<f32> = is_leaf
            .iter()
            .map(|leaf| f32::from(u8::from(*leaf)))
            .collect();
        let light: Vec<f32> = cover
            .iter()
            .zip(front)
            .map(|(c, light)| c * light)
            .collect();
        let light = blurred(&at(NEAR.into()), &light)?;
        let cover = blurred(&at(NEAR.into()), &cover)?;
        let clean = blurred(&at(0.0), back)?;
        let plate: Vec<f32> = (0..clean.len())
            .map(|k| light[k] + (1.0 - cover[k]) * clean[k])
            .collect();
        Ok(Self {
            truth: (0..clean.len())
                .map(|k| if is_leaf[k] { front[k] } else { back[k] })
                .collect(),
            plate: Noise::White.add_to(&plate, noise, 0),
            clean: Noise::White.add_to(&clean, noise, 1),
            is_leaf,
        })
    }

    fn pass(&self) -> Vec<f32> {
        let leaves = self.is_leaf.iter();
        leaves.map(|leaf| if *leaf { NEAR } else { 0.0 }).collect()
    }

    fn plane(&self) -> Plane<'_> {
        Plane {
            samples: &self.plate,
            weights: &WEIGHTS,
        }
    }

    /// Returns the plate without its blur, edges apart.
    fn removed(&self, lens: &FocusedLens) -> Result<Vec<f32>> {
        let pass = self.pass();
        let scene = Scene {
            vergence: VergencePass::PerPixel(&pass),
            ..scene(lens)
        };
        let removed = remove(&scene, Deconvolver::default(), &self.plate)?;
        Ok(removed.canvas.crop(&removed.sharp))
    }

    /// Returns the plate without its blur, split by the clean plate.
    fn split(&self, lens: &FocusedLens) -> Result<Vec<f32>> {
        let pass = self.pass();
        let scene = Scene {
            vergence: VergencePass::PerPixel(&pass),
            ..scene(lens)
        };
        let Some(split) = DepthSplit::new(&scene, VergencePass::Constant(0.0))? else {
            return self.removed(lens);
        };
        let parts = split.split(&Deconvolver::default(), &self.plane(), &self.clean)?;
        let solve = |(deconvolver, samples): &(Deconvolver, Vec<f32>), scene: &Scene| {
            remove(scene, *deconvolver, samples)
        };
        let front = solve(&parts.foreground, &split.foreground_scene())?;
        let back = solve(&parts.background, &split.background_scene())?;
        let joined = split.join(&parts, &front, &back);
        Ok(joined.canvas.crop(&joined.sharp))
    }

    fn errors(&self, image: &[f32]) -> EdgeErrors {
        let ends = |(low, high): (f32, f32), v: &f32| (low.min(*v), high.max(*v));
        let (darkest, brightest) = self.truth.iter().fold((f32::INFINITY, 0.0), ends);
        let middle = self.truth.iter().sum::<f32>() / self.truth.len() as f32;
        let (mut squares, mut count, mut shoots) = (0.0, 0.0, [0.0_f64; 2]);
        for y in BORDER..SIDE - BORDER {
            for x in BORDER..SIDE - BORDER {
                let k = y * SIDE + x;
                if !self.is_near_edge(x, y) {
                    continue;
                }
                squares += f64::from(image[k] - self.truth[k]).powi(2);
                count += 1.0;
                let rows = (y - 1..y + 2).map(|y| &image[y * SIDE + x - 1..y * SIDE + x + 2]);
                let mean = rows.flatten().sum::<f32>() / 9.0;
                let below = (darkest - mean) / middle;
                let above = (mean - brightest) / middle;
                shoots[0] = shoots[0].max(100.0 * f64::from(below));
                shoots[1] = shoots[1].max(100.0 * f64::from(above));
            }
        }
        EdgeErrors {
            deviation: f64::sqrt(squares / count),
            shoots,
        }
    }

    /// Returns whether leaf and picture meet within [`REACH`] along the row or the column of a pixel.
    fn is_near_edge(&self, x: usize, y: usize) -> bool {
        let own = self.is_leaf[y * SIDE + x];
        let differs = |x: usize, y: usize| self.is_leaf[y * SIDE + x] != own;
        (x - REACH..=x + REACH).any(|x| differs(x, y))
            || (y - REACH..=y + REACH).any(|y| differs(x, y))
    }
}

fn remove(scene: &Scene, deconvolver: Deconvolver, samples: &[f32]) -> Result<SharpPlane> {
    let plane = Plane {
        samples,
        weights: &WEIGHTS,
    };
    Ok(deconvolver
        .remove(scene, &[plane], &|_| true)?
        .swap_remove(0))
}
