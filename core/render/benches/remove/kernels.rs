//! Kernels of the lens over the plate, for competitors that take kernels.

use crate::pictures;
use crate::{SIDE, case};
use seidel_render::{LocalKernels, Scene};
use std::path::Path;

/// Columns and rows of points.
const PLACES: usize = 33;
/// Columns and rows of a kernel, centred on the source.
const KERNEL: usize = 65;

/// Writes the kernels at [`PLACES`] x [`PLACES`] points, edges included, row by row, each of unit sum.
pub(crate) fn write(scene: &Scene, path: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let kernels = LocalKernels::new(scene, &case::WEIGHTS)?;
    let mut all = Vec::with_capacity((PLACES * KERNEL).pow(2));
    let along = |k: usize| (k * SIDE) as f64 / (PLACES - 1) as f64;
    for row in 0..PLACES {
        for column in 0..PLACES {
            let kernel = kernels.at((along(column), along(row)))?;
            let mut square = vec![0.0; KERNEL * KERNEL];
            let middle = (KERNEL / 2) as i32;
            for (k, weight) in kernel.weights.iter().enumerate() {
                let x = kernel.left + (k % kernel.width) as i32 + middle;
                let y = kernel.top + (k / kernel.width) as i32 + middle;
                let inside = 0..KERNEL as i32;
                // Light beyond is less than rounding.
                if inside.contains(&x) && inside.contains(&y) {
                    square[y as usize * KERNEL + x as usize] = *weight;
                }
            }
            all.extend(square);
        }
    }
    Ok(pictures::write(path, &all)?)
}
