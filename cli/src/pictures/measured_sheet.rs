//! Lights and blocks of charts over their photographs: kept places with the ellipse of their second moments, others framed by
//! reason.

use image::RgbImage;
use seidel_measure::LightSet;
use seidel_measure::chart::ChartSet;

use super::photograph_panel::{KEPT, Panel, colour, stack};

/// Enlargement of the ellipses, which are too small to judge otherwise.
const ELLIPSE_SCALE: f64 = 3.0;
/// Least side of the frame of a light that was left out, px.
const MIN_OMITTED_PX: f64 = 6.0;
/// Colour of the frames of kept places.
const TILE: [u8; 3] = [50, 90, 60];

/// Draws the lights of every photograph, one below the other.
pub fn light_sheet(set: &LightSet) -> RgbImage {
    stack(&set.photographs, |photograph, panel| {
        let photo = &set.photographs[photograph];
        let lights = set.lights.iter().filter(|l| l.photograph == photograph);
        let lights: Vec<_> = lights.collect();
        let left_out = || set.left_out.iter().filter(|l| l.photograph == photograph);
        panel.legend(&photo.name, lights.len(), left_out().map(|l| l.why));
        let peaks = lights.iter().filter_map(|light| {
            let profile = light.profiles[light.reference].as_ref()?;
            Some(profile.model.iter().copied().fold(0.0, f64::max))
        });
        panel.photograph(photo, peaks.fold(1e-9, f64::max));
        for light in lights {
            let corner = [light.corner.0 as f64, light.corner.1 as f64];
            panel.outline(corner, [light.size.0 as f64, light.size.1 as f64], TILE);
            if let Some(profile) = &light.profiles[light.reference] {
                draw_ellipse(panel, profile.centroid, profile.covariance);
            }
        }
        let side = (set.tile_px as f64 / 2.0).max(MIN_OMITTED_PX);
        for light in left_out() {
            let corner = [light.x - side / 2.0, light.y - side / 2.0];
            panel.outline(corner, [side; 2], colour(light.why));
        }
    })
}

/// Draws the blocks of every photograph of a chart, one below the other.
pub fn chart_sheet(set: &ChartSet) -> RgbImage {
    stack(&set.photographs, |photograph, panel| {
        let photo = &set.photographs[photograph];
        let measured = &set.measurements[photograph];
        let reasons = measured.left_out.iter().map(|block| block.why);
        panel.legend(&photo.name, measured.blocks.len(), reasons);
        let channel = photo.reference_channel();
        let samples = photo.planes[photo.plane_of(channel)].iter().copied();
        let brightest = samples.filter(|v| *v < photo.white).fold(1e-9, f32::max);
        panel.photograph(photo, f64::from(brightest));
        for block in &measured.blocks {
            let half = block.size.map(|v| v as f64 / 2.0);
            let corner = [0, 1].map(|k| block.centre[k] as f64 + 0.5 - half[k]);
            panel.outline(corner, block.size.map(|v| v as f64), TILE);
            draw_ellipse(panel, block.centroid(channel), block.covariance(channel));
        }
        let side = 2.0 * measured.side as f64;
        for block in &measured.left_out {
            let corner = block.at.map(|v| v - side / 2.0);
            panel.outline(corner, [side; 2], colour(block.why));
        }
    })
}

/// Draws the ellipse of a covariance xx, xy, yy, px².
fn draw_ellipse(panel: &mut Panel, centre: [f64; 2], [xx, xy, yy]: [f64; 3]) {
    // Cholesky factor of the covariance.
    let a = xx.max(1e-6).sqrt();
    let b = xy / a;
    let c = (yy - b * b).max(0.0).sqrt();
    for step in 0..256 {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(step) / 256.0).sin_cos();
        let x = centre[0] + ELLIPSE_SCALE * a * cos;
        let y = centre[1] + ELLIPSE_SCALE * (b * cos + c * sin);
        panel.point([x, y], KEPT);
    }
}
