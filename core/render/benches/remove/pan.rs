//! Flicker over a pan: a picture moves by one pixel a frame behind the lens, and each frame has noise of its own.

use crate::case::{WEIGHTS, blurred};
use crate::{Options, SIDE};
use seidel_optics::error::Result;
use seidel_render::remove::{Deconvolver, find_lights};
use seidel_render::{Plane, Scene};

/// Frames of the pan.
const FRAMES: usize = 24;
/// Border that is left out, px, beside the pixels that the pan moves out of it.
const BORDER: usize = 32;

/// The flicker of a pan: root mean squares over the pixels of the picture that all frames show.
struct Flicker {
    /// Standard deviation over the frames, of the plates and of the results.
    plate: f64,
    sharp: f64,
    /// The noise gain stated for the middle frame.
    reported: f64,
}

/// Prints the flicker of `pictures`, for each noise of the options.
pub(crate) fn print(
    scene: &Scene,
    pictures: &[(String, Vec<f32>)],
    options: &Options,
) -> Result<()> {
    println!(
        "| picture | noise | plate | result | noise gain stated | result / (noise x noise gain) |"
    );
    println!("| --- | --- | --- | --- | --- | --- |");
    for (name, picture) in pictures {
        let blurred: Vec<Vec<f32>> = (0..FRAMES)
            .map(|frame| blurred(scene, &moved(picture, frame)))
            .collect::<Result<_>>()?;
        for noise in options.noises.iter().filter(|noise| **noise > 0.0) {
            eprintln!("{name} {noise}");
            let flicker = flicker(scene, &blurred, *noise, options)?;
            println!(
                "| {name} | {noise} | {:.5} | {:.5} | {:.2} | {:.2} |",
                flicker.plate,
                flicker.sharp,
                flicker.reported,
                flicker.sharp / (noise * flicker.reported),
            );
        }
    }
    Ok(())
}

/// Returns the frame of the pan: the picture `frame` pixels to the left, mirrored at its right edge.
fn moved(picture: &[f32], frame: usize) -> Vec<f32> {
    let mirrored = |x: usize| if x < SIDE { x } else { 2 * SIDE - 1 - x };
    (0..SIDE * SIDE)
        .map(|k| picture[k / SIDE * SIDE + mirrored(k % SIDE + frame)])
        .collect()
}

fn flicker(scene: &Scene, blurred: &[Vec<f32>], noise: f64, options: &Options) -> Result<Flicker> {
    let deconvolver = Deconvolver::default();
    let (mut plates, mut results, mut reported) = (Vec::new(), Vec::new(), Vec::new());
    for (frame, samples) in blurred.iter().enumerate() {
        let plate = options.kind.add_to(samples, noise, frame as u64);
        let plane = Plane {
            samples: &plate,
            weights: &WEIGHTS,
        };
        let lights = find_lights(scene, &[(deconvolver, plane)], &|_| true)?;
        let sharp = deconvolver.remove_around(&lights[0], scene, &plane, &|_| true)?;
        if frame == FRAMES / 2 {
            reported = deconvolver.noise_gain(&lights[0], scene, &plane, &sharp, &|_| true)?;
        }
        results.push(sharp.canvas.crop(&sharp.sharp));
        plates.push(plate);
    }
    Ok(Flicker {
        plate: deviation_over_frames(&plates),
        sharp: deviation_over_frames(&results),
        reported: root_mean_square(|x, y| reported[y * SIDE + x - FRAMES / 2].into()),
    })
}

/// Returns the standard deviation of the pixels of the picture over the `frames`.
fn deviation_over_frames(frames: &[Vec<f32>]) -> f64 {
    let count = frames.len() as f64;
    root_mean_square(|x, y| {
        let values = || {
            let frames = frames.iter().enumerate();
            frames.map(|(frame, samples)| f64::from(samples[y * SIDE + x - frame]))
        };
        let mean = values().sum::<f64>() / count;
        (values().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0)).sqrt()
    })
}

/// Returns the root mean square of `value` over the pixels of the picture that all frames show.
fn root_mean_square(value: impl Fn(usize, usize) -> f64) -> f64 {
    let (mut squares, mut count) = (0.0, 0.0);
    for y in BORDER..SIDE - BORDER {
        for x in BORDER + FRAMES..SIDE - BORDER {
            squares += value(x, y).powi(2);
            count += 1.0;
        }
    }
    f64::sqrt(squares / count)
}
