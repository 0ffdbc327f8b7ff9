//! The demo's plate: a wet street at night, ray-traced from formulas, with its depth.
//!
//! It is composed to show what a lens does: small bright lights behind the focus out to the corners,
//! fine detail on the focused plane, a hard edge in front of it, ground from near to far, and thin wires.

use rayon::prelude::*;

use super::lens::{FOCAL_LENGTH_MM, SENSOR_WIDTH_MM};
use super::noise::hash;
use super::props;
use super::ray::{Hit, Ray, V3, nearest};
use super::street::{SKY_M, Street};

/// Height of the camera above the ground, m.
const CAMERA_M: f64 = 0.36;
/// Sine of the angle by which the camera looks down.
const LOOK_DOWN: f64 = 0.040;
/// Antialiasing: each pixel takes the square of this number of rays.
const RAYS_ACROSS: u32 = 3;

/// A scene-linear plate with depth, all planes row-major from the top-left pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Width, pixels.
    pub width: usize,
    /// Height, pixels.
    pub height: usize,
    /// Scene-linear R, G and B; the plate is opaque everywhere.
    pub rgb: [Vec<f32>; 3],
    /// Distance along the optical axis at the centre of each pixel, m; finite, and not antialiased, as
    /// depth passes are delivered.
    pub depth_m: Vec<f32>,
}

/// Renders the scene at `width` x `height` pixels through the built-in lens without any blur.
/// The same size gives the same plate.
pub fn scene(width: usize, height: usize) -> Scene {
    let street = Street::new();
    // Image slope (x / z) per pixel.
    let scale = SENSOR_WIDTH_MM / FOCAL_LENGTH_MM / width.max(1) as f64;
    let look = |x_px: f64, y_px: f64| {
        let (u, v) = (x_px - width as f64 / 2.0, y_px - height as f64 / 2.0);
        look(&street, u * scale, v * scale)
    };
    let pixel = |index: usize| {
        let (column, row) = (index % width, index / width);
        let mut light = V3::zeros();
        for k in 0..RAYS_ACROSS * RAYS_ACROSS {
            // Each ray takes a random position in its own part of the pixel.
            let offset = |part: u32, salt| {
                let random = hash(column as i64, row as i64, salt + 2 * u64::from(k));
                (f64::from(part) + random) / f64::from(RAYS_ACROSS)
            };
            let (x, y) = (offset(k % RAYS_ACROSS, 101), offset(k / RAYS_ACROSS, 102));
            light += look(column as f64 + x, row as f64 + y).light;
        }
        light /= f64::from(RAYS_ACROSS * RAYS_ACROSS);
        let depth = look(column as f64 + 0.5, row as f64 + 0.5).t;
        [light.x, light.y, light.z, depth].map(|v| v as f32)
    };
    let pixels: Vec<[f32; 4]> = (0..width * height).into_par_iter().map(pixel).collect();
    let plane = |k: usize| pixels.iter().map(|p| p[k]).collect();
    Scene {
        width,
        height,
        rgb: [plane(0), plane(1), plane(2)],
        depth_m: plane(3),
    }
}

/// Returns the light along image slopes `u` and `v` (down), and the depth along the axis as `t`.
fn look(street: &Street, u: f64, v: f64) -> Hit {
    let cos = (1.0 - LOOK_DOWN * LOOK_DOWN).sqrt();
    let ray = Ray {
        origin: V3::new(0.0, CAMERA_M, 0.0),
        // One unit along the optical axis, so that t is depth.
        direction: V3::new(u, -v * cos - LOOK_DOWN, cos - v * LOOK_DOWN),
    };
    let hit = nearest([props::look(&ray, street), street.look(&ray)]);
    hit.map_or(
        Hit {
            t: SKY_M,
            light: V3::zeros(),
        },
        |hit| Hit {
            t: hit.t.min(SKY_M),
            ..hit
        },
    )
}

#[cfg(test)]
mod tests {
    use super::super::lens::FOCUS_M;
    use super::*;

    #[test]
    fn the_plate_has_focus_depth_and_highlights() {
        let plate = scene(320, 180);
        let all = || plate.rgb.iter().flatten().chain(&plate.depth_m);
        assert!(all().all(|v| v.is_finite() && *v >= 0.0));
        assert_eq!(plate.depth_m.len(), 320 * 180);
        let share = |wanted: &dyn Fn(f64) -> bool| {
            let depths = plate.depth_m.iter().map(|&z| f64::from(z));
            depths.filter(|&z| wanted(z)).count() as f64 / plate.depth_m.len() as f64
        };
        assert!(share(&|z| (z - FOCUS_M).abs() < 0.15) > 0.08, "in focus");
        assert!(share(&|z| z < 1.3) > 0.05, "before the focus");
        assert!(share(&|z| z > 8.0) > 0.3, "behind the focus");
        let hdr = |from: usize, to: usize| {
            plate.rgb[0]
                .iter()
                .zip(&plate.rgb[2])
                .enumerate()
                .any(|(index, (r, b))| (from..to).contains(&(index % 320)) && r.max(*b) > 20.0)
        };
        assert!(hdr(0, 80) && hdr(80, 240) && hdr(240, 320));
        assert!(plate.rgb.iter().flatten().any(|&v| v > 80.0));
    }

    #[test]
    fn the_plate_is_deterministic() {
        assert_eq!(scene(96, 54), scene(96, 54));
        assert_ne!(scene(96, 54).depth_m, scene(54, 96).depth_m);
    }
}
