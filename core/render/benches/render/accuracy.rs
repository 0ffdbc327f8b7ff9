//! How far renders are from the exact renderer's: over whole plates or at some of their pixels.

use crate::cases::Truth;
use seidel_optics::error::Result;
use seidel_render::{Plane, Renderer, Scatter, Scene, exact_at_pixels};

/// What is right.
pub(crate) struct Reference {
    /// Planes that are looked at, and in each the light at `pixels`.
    planes: Vec<(usize, Vec<f64>)>,
    /// Row-major indices.
    pixels: Vec<usize>,
}

impl Reference {
    /// The exact renderer's answer, or `None` where none is asked for.
    pub(crate) fn new(scene: &Scene, planes: &[Plane], truth: Truth) -> Result<Option<Self>> {
        match truth {
            Truth::None => Ok(None),
            Truth::Whole => {
                let exact = Scatter.render(scene, planes, &|_| true)?.planes;
                let wide = |plane: Vec<f32>| plane.into_iter().map(f64::from).collect();
                Ok(Some(Self {
                    planes: exact.into_iter().map(wide).enumerate().collect(),
                    pixels: (0..scene.pixel_count()).collect(),
                }))
            }
            Truth::Spots { count, cell_px } => {
                let spots = spots((scene.width, scene.height), count);
                let looked_at = if scene.model.needs_rays() {
                    1..2
                } else {
                    0..planes.len()
                };
                let light = looked_at.map(|plane| {
                    let light = exact_at_pixels(scene, &planes[plane], &spots, cell_px)?;
                    Ok((plane, light))
                });
                Ok(Some(Self {
                    planes: light.collect::<Result<_>>()?,
                    pixels: spots.iter().map(|(x, y)| y * scene.width + x).collect(),
                }))
            }
        }
    }

    /// Peak signal-to-noise ratio for a peak of one, dB.
    pub(crate) fn psnr_db(&self, found: &[Vec<f32>]) -> f64 {
        let mut squares = 0.0;
        for (plane, light) in &self.planes {
            for (pixel, light) in self.pixels.iter().zip(light) {
                squares += (f64::from(found[*plane][*pixel]) - light).powi(2);
            }
        }
        let count = self.planes.len() * self.pixels.len();
        -10.0 * (squares / count as f64).log10()
    }
}

/// About `count` pixels over the whole plate, one in each square of a grid, edges included.
fn spots((width, height): (usize, usize), count: usize) -> Vec<(usize, usize)> {
    let side = ((width * height) as f64 / count as f64).sqrt();
    let (columns, rows) = (width as f64 / side, height as f64 / side);
    let (columns, rows) = (
        columns.round().max(1.0) as usize,
        rows.round().max(1.0) as usize,
    );
    // Within their squares they lie by the plastic number, which fills them evenly.
    let within = |k: usize, step: f64| (k as f64 * step).fract();
    (0..columns * rows)
        .map(|k| {
            let along = |index: usize, step: f64, squares: usize, size: usize| {
                let at = (index as f64 + within(k + 1, step)) / squares as f64;
                ((at * size as f64) as usize).min(size - 1)
            };
            (
                along(k % columns, 0.754_877_666, columns, width),
                along(k / columns, 0.569_840_290, rows, height),
            )
        })
        .collect()
}
