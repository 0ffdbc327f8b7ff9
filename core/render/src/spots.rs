//! The exact renderer at a few pixels, as a renderer: what faster ones are measured against in whatever they
//! are part of, occlusion and extended edges included.

use crate::{Plane, PlateMap, Renderer, Scene, at_pixels};
use seidel_optics::error::Result;

/// Renders exactly at some pixels of a plate and leaves the others at zero. What is put together pixel by pixel
/// of such planes, as by [`Layered`](crate::Layered), is right at those pixels.
#[derive(Debug, Clone, Copy)]
pub struct Spots<'p> {
    /// Where the plate lies: scenes are parts of it, or go beyond, on the same grid.
    pub map: PlateMap,
    /// The pixels (column, row) of that plate.
    pub pixels: &'p [(usize, usize)],
    /// Side of the cells of source pixels that share a kernel of rays: [`at_pixels`]. Where depth varies within a
    /// scene it is one, whatever is said here.
    pub cell_px: usize,
}

/// Steps of the sequence that fills a square most evenly: powers of the inverse of the root of x³ = x + 1.
const STEPS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];

/// `count` pixels spread over a plate of `width` x `height`, the same every time.
pub fn spread_pixels(width: usize, height: usize, count: usize) -> Vec<(usize, usize)> {
    let at = |k: usize, step: f64, size: usize| {
        let share = (0.5 + k as f64 * step).fract();
        ((share * size as f64) as usize).min(size.saturating_sub(1))
    };
    let pixel = |k: usize| (at(k, STEPS[0], width), at(k, STEPS[1], height));
    (0..count).map(pixel).collect()
}

/// Peak signal-to-noise ratio of `planes` at `pixels` of a plate `width` pixels wide against `exact` ones, dB;
/// infinite where they are the same, none where there is nothing to compare or no peak.
pub fn psnr_at(
    (planes, exact): (&[Vec<f32>], &[Vec<f32>]),
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

impl Spots<'_> {
    /// The pixels as `scene` counts them, as far as they are on it.
    fn on(&self, scene: &Scene) -> Vec<(usize, usize)> {
        let scale = scene.map.scale;
        let before = |here: f64, whole: f64| ((whole - here) * scale).round() as i64;
        let left = before(scene.map.origin.x_px, self.map.origin.x_px);
        let top = before(scene.map.origin.y_px, self.map.origin.y_px);
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

impl Renderer for Spots<'_> {
    fn id(&self) -> &'static str {
        "spots"
    }

    fn render(
        &self,
        scene: &Scene,
        planes: &[Plane],
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Vec<Vec<f32>>> {
        scene.check(planes)?;
        let pixels = self.on(scene);
        let cell_px = match scene.vergence {
            crate::VergencePass::Constant(_) => self.cell_px,
            crate::VergencePass::PerPixel(_) => 1,
        };
        let mut out = Vec::with_capacity(planes.len());
        for (done, plane) in planes.iter().enumerate() {
            let mut samples = vec![0.0; scene.pixel_count()];
            for ((column, row), light) in pixels
                .iter()
                .zip(at_pixels(scene, plane, &pixels, cell_px)?)
            {
                samples[row * scene.width + column] = light as f32;
            }
            out.push(samples);
            if !progress((done + 1) as f64 / planes.len() as f64) {
                return Err(crate::cancelled());
            }
        }
        Ok(out)
    }
}

#[cfg(test)]
mod tests;
