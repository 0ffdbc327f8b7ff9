//! The kernel of a lens at one point of a plate, as an array.

use super::sources::Sources;
use super::{Plane, Scene};
use crate::error::Result;
use crate::psf::KernelRows;

/// Where the light of one source pixel lands: weights of unit sum, row-major.
#[derive(Debug, Clone, PartialEq)]
pub struct LocalKernel {
    /// First column and row, from the source pixel.
    pub left: i32,
    pub top: i32,
    pub width: usize,
    pub height: usize,
    pub weights: Vec<f32>,
}

/// The kernel of a source at plate point `at` (px from the outer corner) at `vergence_per_m`, of a plane with
/// these channel `weights`, which sum to one.
///
/// # Errors
/// A scene or weights that cannot be, and a lens that cannot be drawn there.
pub fn kernel_at(
    scene: &Scene,
    weights: &[f64],
    at: (f64, f64),
    vergence_per_m: f64,
) -> Result<LocalKernel> {
    let dark = vec![0.0; scene.pixel_count()];
    scene.check(&[Plane {
        samples: &dark,
        weights,
    }])?;
    let (sources, mut found) = (Sources::new(scene), Vec::new());
    sources.at(at, vergence_per_m, |k| weights[k] != 0.0, &mut found)?;
    let drawn: Vec<(KernelRows, f64)> = found
        .iter()
        .zip(weights)
        .filter_map(|(source, weight)| source.as_ref().map(|s| (s, *weight)))
        .map(|(source, weight)| {
            let mut rows = KernelRows::default();
            scene
                .model
                .draw_rows(&source.blur, source.shift_px, &mut rows);
            (rows, weight)
        })
        .collect();
    let ends = |of: &dyn Fn(&KernelRows) -> std::ops::Range<i32>| {
        let ranges = drawn.iter().map(|(rows, _)| of(rows));
        ranges
            .reduce(|a, b| a.start.min(b.start)..a.end.max(b.end))
            .unwrap_or(0..0)
    };
    let (columns, lines) = (ends(&|rows| rows.columns()), ends(&|rows| rows.rows()));
    let (width, height) = (columns.len(), lines.len());
    let mut kernel = LocalKernel {
        left: columns.start,
        top: lines.start,
        width,
        height,
        weights: vec![0.0; width * height],
    };
    for (rows, weight) in &drawn {
        let gain = (weight / rows.sum()) as f32;
        for (row, column, stretch) in rows.stretches() {
            let start = (row - kernel.top) as usize * width + (column - kernel.left) as usize;
            for (out, w) in kernel.weights[start..].iter_mut().zip(stretch) {
                *out += gain * w;
            }
        }
    }
    Ok(kernel)
}
