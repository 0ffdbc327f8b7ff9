//! The lights of a photograph over its frame: kept ones with the ellipse of their second moments, others framed by reason.

use image::RgbImage;
use seidel_measure::{LightSet, MeasuredLight};

use super::photograph_panel::{KEPT, Panel, colour, stack};

/// Enlargement of the ellipses, which are too small to judge otherwise.
const ELLIPSE_SCALE: f64 = 3.0;
/// Colour of the tiles of kept lights.
const TILE: [u8; 3] = [50, 90, 60];

/// Draws the lights of every photograph, one below the other.
pub fn light_sheet(set: &LightSet) -> RgbImage {
    stack(&set.photographs, |photograph, panel| {
        let left_out = || {
            let all = set.left_out.iter();
            all.filter(move |l| l.photograph == photograph)
        };
        let lights: Vec<&MeasuredLight> = (set.lights.iter())
            .filter(|light| light.photograph == photograph)
            .collect();
        let photo = &set.photographs[photograph];
        panel.legend(&photo.name, lights.len(), left_out());
        let peaks = lights.iter().filter_map(|light| {
            let profile = light.profiles[light.reference].as_ref()?;
            Some(profile.model.iter().copied().fold(0.0, f64::max))
        });
        panel.photograph(photo, peaks.fold(1e-9, f64::max));
        for light in lights {
            let (left, top) = light.corner;
            let (width, height) = light.size;
            let size = [width as f64, height as f64];
            panel.outline([left as f64, top as f64], size, TILE);
            draw_ellipse(panel, light);
        }
        for light in left_out() {
            let half = (set.tile_px as f64 / 4.0).max(3.0);
            let corner = [light.x - half, light.y - half];
            panel.outline(corner, [2.0 * half; 2], colour(light.why));
        }
    })
}

fn draw_ellipse(panel: &mut Panel, light: &MeasuredLight) {
    let Some(profile) = &light.profiles[light.reference] else {
        return;
    };
    let [xx, xy, yy] = profile.covariance;
    // Cholesky factor of the covariance.
    let a = xx.max(1e-6).sqrt();
    let b = xy / a;
    let c = (yy - b * b).max(0.0).sqrt();
    for step in 0..256 {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(step) / 256.0).sin_cos();
        let x = profile.centroid[0] + ELLIPSE_SCALE * a * cos;
        let y = profile.centroid[1] + ELLIPSE_SCALE * (b * cos + c * sin);
        panel.point([x, y], KEPT);
    }
}
