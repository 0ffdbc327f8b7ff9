//! The lens check: the blur of pictures as a share of a lens's blur, for the right lens and for wrong ones.

use crate::Options;
use crate::case::{WEIGHTS, blurred, lens_of_size, scene};
use seidel_optics::error::Result;
use seidel_render::remove::{Deconvolver, estimate_blur_share};
use seidel_render::{Plane, Scene};

/// Blur of the lenses over that of the pictures.
const SIZES: [f64; 5] = [1.0, 1.3, 2.0, 0.77, 0.5];

/// Prints the share found with each lens; the right one is the reciprocal of the lens's size.
pub(crate) fn print(
    right: &Scene,
    pictures: &[(String, Vec<f32>)],
    options: &Options,
) -> Result<()> {
    println!("| picture | noise | right lens | 1.3 times | twice | 0.77 times | half |");
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    for (name, picture) in pictures {
        let blurred = blurred(right, picture)?;
        for noise in &options.noises {
            let plate = options.kind.add_to(&blurred, *noise, 0);
            let plane = Plane {
                samples: &plate,
                weights: &WEIGHTS,
            };
            let mut line = format!("| {name} | {noise} |");
            for size in SIZES {
                let lens = lens_of_size(size)?;
                let planes = [(Deconvolver::default(), plane)];
                let share = estimate_blur_share(&scene(&lens), &planes, &|_| true)?;
                line += &format!(" {share:.2} |");
            }
            println!("{line}");
        }
    }
    Ok(())
}
