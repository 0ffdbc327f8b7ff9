//! The exact renderer at chosen pixels, as a [`Renderer`]: the reference for the error of faster ones, including
//! occlusion and replicated edges.

use crate::{
    Plane, PlateMap, RenderWindow, Rendered, Renderer, Scene, VergencePass, exact_at_pixels,
};
use seidel_optics::error::Result;

/// A renderer that is exact at chosen pixels of a plate and leaves the others at zero.
///
/// Compositing acts on each pixel alone, so a [`LayeredRenderer`](crate::LayeredRenderer) on top is exact there too.
#[derive(Debug, Clone, Copy)]
pub struct SpotRenderer<'p> {
    /// Position of the plate that `pixels` index. Scenes to render are crops or extensions of it, on the same grid.
    pub map: PlateMap,
    /// Pixels (column, row) of that plate.
    pub pixels: &'p [(usize, usize)],
    /// Side of the cells of source pixels that share one ray-traced kernel: see [`exact_at_pixels`]. Where depth
    /// varies within a scene, 1 is used.
    pub cell_px: usize,
}

/// Steps of the R2 low-discrepancy sequence: 1/x and 1/x^2, x being the plastic number, the real root of
/// x^3 = x + 1.
const R2_STEPS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];

/// Returns the first `count` points of the R2 low-discrepancy sequence as pixels of a `width` x `height` plate.
pub fn low_discrepancy_pixels(width: usize, height: usize, count: usize) -> Vec<(usize, usize)> {
    let at = |k: usize, step: f64, size: usize| {
        let share = (0.5 + k as f64 * step).fract();
        ((share * size as f64) as usize).min(size.saturating_sub(1))
    };
    let pixel = |k: usize| (at(k, R2_STEPS[0], width), at(k, R2_STEPS[1], height));
    (0..count).map(pixel).collect()
}

/// Returns the peak signal-to-noise ratio of `planes` against `exact` at `pixels`, dB.
///
/// Planes are `width` pixels wide. Infinite where the planes are equal; `None` without pixels or without a positive
/// finite `peak`.
pub fn psnr_at(
    planes: &[Vec<f32>],
    exact: &[Vec<f32>],
    width: usize,
    pixels: &[(usize, usize)],
    peak: f64,
) -> Option<f64> {
    let count = planes.len().min(exact.len()) * pixels.len();
    if count == 0 || !(peak > 0.0 && peak.is_finite()) {
        return None;
    }
    let mut sum = 0.0;
    for (plane, exact) in planes.iter().zip(exact) {
        for (column, row) in pixels {
            let index = row * width + column;
            sum += (f64::from(plane[index]) - f64::from(exact[index])).powi(2);
        }
    }
    Some(10.0 * (peak * peak * count as f64 / sum).log10())
}

impl SpotRenderer<'_> {
    /// Returns the chosen pixels that lie on `scene`'s plate, in its own columns and rows.
    fn pixels_on(&self, scene: &Scene) -> Vec<(usize, usize)> {
        let scale = scene.map.scale;
        let offset = |here: f64, whole: f64| ((whole - here) * scale).round() as i64;
        let left = offset(scene.map.origin.x_px, self.map.origin.x_px);
        let top = offset(scene.map.origin.y_px, self.map.origin.y_px);
        let moved = |at: usize, by: i64, size: usize| {
            let at = usize::try_from(at as i64 + by).ok()?;
            (at < size).then_some(at)
        };
        let pixels = self.pixels.iter();
        pixels
            .filter_map(|(column, row)| {
                let column = moved(*column, left, scene.width)?;
                Some((column, moved(*row, top, scene.height)?))
            })
            .collect()
    }
}

impl Renderer for SpotRenderer<'_> {
    fn id(&self) -> &'static str {
        "spots"
    }

    /// Rounding of 32-bit sums.
    fn overshoot(&self) -> f32 {
        1e-6
    }

    fn render_window(
        &self,
        scene: &Scene,
        planes: &[Plane],
        window: RenderWindow,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Rendered> {
        scene.check(planes)?;
        window.check(scene)?;
        let pixels = self.pixels_on(scene);
        let (cell_px, layers) = match scene.vergence {
            VergencePass::Constant(_) => (self.cell_px, 1),
            VergencePass::PerPixel(_) => (1, 0),
        };
        let mut out = Vec::with_capacity(planes.len());
        for (done, plane) in planes.iter().enumerate() {
            let mut samples = vec![0.0; scene.pixel_count()];
            let light = exact_at_pixels(scene, plane, &pixels, cell_px)?;
            for ((column, row), light) in pixels.iter().zip(light) {
                samples[row * scene.width + column] = light as f32;
            }
            out.push(samples);
            if !progress((done + 1) as f64 / planes.len() as f64) {
                return Err(crate::cancelled());
            }
        }
        Ok(Rendered::exact(window.cut_planes(scene, out), layers))
    }
}

#[cfg(test)]
mod tests;
