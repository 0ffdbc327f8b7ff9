//! Errors against the exact renderer, over whole plates or at some of their pixels.

use crate::cases::Truth;
use seidel_optics::error::Result;
use seidel_render::{Plane, Renderer, Scatter, Scene, exact_at_pixels};

/// The exact light to compare with.
pub(crate) struct Reference {
    /// Indices of the compared planes, each with its light at `pixels`.
    planes: Vec<(usize, Vec<f64>)>,
    /// Row-major indices of the compared pixels.
    pixels: Vec<usize>,
}

impl Reference {
    /// Renders exactly as far as `truth` asks for; `None` for [`Truth::None`].
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
                let spots = spots(scene.width, scene.height, count);
                let compared = if scene.model.needs_rays() {
                    1..2
                } else {
                    0..planes.len()
                };
                let light = compared.map(|plane| {
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

    /// Returns the peak signal-to-noise ratio for a peak of one, dB.
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

/// Returns about `count` pixels spread over the whole plate, one in each square of a grid.
fn spots(width: usize, height: usize, count: usize) -> Vec<(usize, usize)> {
    let side = ((width * height) as f64 / count as f64).sqrt();
    let (columns, rows) = (width as f64 / side, height as f64 / side);
    let (columns, rows) = (
        columns.round().max(1.0) as usize,
        rows.round().max(1.0) as usize,
    );
    // Within the squares they follow the R2 low-discrepancy sequence.
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
