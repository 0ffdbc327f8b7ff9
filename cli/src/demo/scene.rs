//! The demo's plate: a wet street at night, drawn ray by ray from formulas, with its depth.
//!
//! It is made to show a lens: small bright lights behind the focus out to the corners, fine detail
//! on the plane that the built-in lens is focused on, a hard edge before it, ground from near to far, wire.

use rayon::prelude::*;

use super::lamps::{Cable, Lamp, cables, lamps};
use super::lens::{FOCAL_LENGTH_MM, SENSOR_WIDTH_MM};
use super::noise::hash;
use super::vector::{Hit, Ray, V3};
use super::{props, street};

/// Height of the camera above the ground, m.
pub(super) const CAMERA_M: f64 = 0.36;
/// Sine of how far the camera looks down.
pub(super) const LOOK_DOWN: f64 = 0.040;
/// Rays a pixel are this number squared.
const RAYS_ACROSS: u32 = 3;

/// A scene-linear plate with depth, all planes row-major from the top-left pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Width, pixels.
    pub width: usize,
    /// Height, pixels.
    pub height: usize,
    /// Scene-linear R, G and B; unpremultiplied, the plate being opaque everywhere.
    pub rgb: [Vec<f32>; 3],
    /// Distance along the optical axis of what the centre of each pixel sees, metres; finite, and
    /// not anti-aliased, as depth passes are delivered.
    pub depth_m: Vec<f32>,
}

/// Draws the scene at `width` x `height` pixels: the view of the built-in lens without any blur.
/// The same size gives the same plate.
pub fn scene(width: usize, height: usize) -> Scene {
    let view = View::new(width, height);
    let pixels: Vec<[f32; 4]> = (0..height)
        .into_par_iter()
        .flat_map_iter(|row| view.draw_row(row))
        .collect();
    let plane = |k: usize| pixels.iter().map(|p| p[k]).collect::<Vec<f32>>();
    Scene {
        width,
        height,
        rgb: [plane(0), plane(1), plane(2)],
        depth_m: plane(3),
    }
}

/// The camera and what is drawn in its image directly.
struct View {
    width: usize,
    height: usize,
    /// Image slope (x / z) per pixel.
    slope: f64,
    lamps: Vec<Lamp>,
    world_lamps: Vec<Lamp>,
    cables: Vec<Cable>,
}

impl View {
    fn new(width: usize, height: usize) -> Self {
        let lamps = lamps();
        let world_lamps = lamps
            .iter()
            .map(|lamp| Lamp {
                at: to_world(lamp.at) + V3(0.0, CAMERA_M, 0.0),
                ..*lamp
            })
            .collect();
        Self {
            width,
            height,
            slope: SENSOR_WIDTH_MM / FOCAL_LENGTH_MM / width.max(1) as f64,
            lamps,
            world_lamps,
            cables: cables(),
        }
    }

    /// Image slopes (x / z, y / z) of a place in the image, pixels.
    fn slopes(&self, x_px: f64, y_px: f64) -> (f64, f64) {
        (
            (x_px - self.width as f64 / 2.0) * self.slope,
            (y_px - self.height as f64 / 2.0) * self.slope,
        )
    }

    /// R, G, B and depth of one row.
    fn draw_row(&self, row: usize) -> Vec<[f32; 4]> {
        let (_, top) = self.slopes(0.0, row as f64 - 1.0);
        let (_, bottom) = self.slopes(0.0, row as f64 + 2.0);
        let near = |at: V3, radius: f64| {
            (at.1 + 1.1 * radius) / at.2 >= top && (at.1 - 1.1 * radius) / at.2 <= bottom
        };
        let lamps: Vec<&Lamp> = self.lamps.iter().filter(|l| near(l.at, l.radius)).collect();
        let cables: Vec<&Cable> = self
            .cables
            .iter()
            .filter(|c| {
                let [a, b] = c.ends.map(|p| p.1 / p.2);
                let reach = c.radius / c.ends[0].2.min(c.ends[1].2);
                a.max(b) + reach >= top && a.min(b) - reach <= bottom
            })
            .collect();
        (0..self.width)
            .map(|column| {
                let across = f64::from(RAYS_ACROSS);
                let mut sum = V3::ZERO;
                for k in 0..RAYS_ACROSS * RAYS_ACROSS {
                    let (i, j) = (f64::from(k % RAYS_ACROSS), f64::from(k / RAYS_ACROSS));
                    // Each ray somewhere in its own part of the pixel.
                    let shift = |salt| hash(column as i64, row as i64, salt + 2 * u64::from(k));
                    let (x, y) = ((i + shift(101)) / across, (j + shift(102)) / across);
                    let (u, v) = self.slopes(column as f64 + x, row as f64 + y);
                    sum = sum + self.look(u, v, &lamps, &cables).light;
                }
                let light = sum * (1.0 / (across * across));
                let (u, v) = self.slopes(column as f64 + 0.5, row as f64 + 0.5);
                let depth = self.look(u, v, &lamps, &cables).t;
                [light.0 as f32, light.1 as f32, light.2 as f32, depth as f32]
            })
            .collect()
    }

    /// What is seen along image slopes (`u`, `v`): light, and depth along the axis as `t`.
    fn look(&self, u: f64, v: f64, lamps: &[&Lamp], cables: &[&Cable]) -> Hit {
        // A direction with one unit along the axis: lengths of it are depth.
        let ray = Ray {
            from: V3(0.0, CAMERA_M, 0.0),
            along: to_world(V3(u, v, 1.0)),
        };
        let mut nearest = Hit {
            t: street::SKY_M,
            light: V3::ZERO,
        };
        let world = [
            props::meet(&ray, &self.world_lamps),
            street::meet(&ray, &self.world_lamps),
        ];
        let drawn = lamps
            .iter()
            .map(|lamp| meet_lamp(lamp, u, v))
            .chain(cables.iter().map(|cable| meet_cable(cable, u, v)));
        let mut found = false;
        for hit in world.into_iter().chain(drawn).flatten() {
            if !found || hit.t < nearest.t {
                nearest = hit;
                found = true;
            }
        }
        nearest.t = nearest.t.min(street::SKY_M);
        nearest
    }
}

/// A direction or offset in camera axes (y down) turned into world axes (y up).
fn to_world(camera: V3) -> V3 {
    let cos = (1.0 - LOOK_DOWN * LOOK_DOWN).sqrt();
    V3(
        camera.0,
        -camera.1 * cos - camera.2 * LOOK_DOWN,
        camera.2 * cos - camera.1 * LOOK_DOWN,
    )
}

fn meet_lamp(lamp: &Lamp, u: f64, v: f64) -> Option<Hit> {
    let (dx, dy) = (u * lamp.at.2 - lamp.at.0, v * lamp.at.2 - lamp.at.1);
    let off = (dx * dx + dy * dy) / (lamp.radius * lamp.radius);
    (off < 1.0).then(|| Hit {
        t: lamp.at.2,
        light: lamp.light * (0.45 + 0.55 * (1.0 - off).sqrt()),
    })
}

fn meet_cable(cable: &Cable, u: f64, v: f64) -> Option<Hit> {
    let [a, b] = cable.ends;
    let (au, av) = (a.0 / a.2, a.1 / a.2);
    let (bu, bv) = (b.0 / b.2 - au, b.1 / b.2 - av);
    let share = (((u - au) * bu + (v - av) * bv) / (bu * bu + bv * bv)).clamp(0.0, 1.0);
    let off = (u - au - share * bu).hypot(v - av - share * bv);
    // Along a line in the image inverse depth is what runs evenly.
    let depth = 1.0 / ((1.0 - share) / a.2 + share / b.2);
    (off * depth < cable.radius).then_some(Hit {
        t: depth,
        light: V3(0.010, 0.013, 0.015),
    })
}

#[cfg(test)]
mod tests {
    use super::super::lens::FOCUS_M;
    use super::*;

    #[test]
    fn the_plate_shows_what_a_lens_does() {
        let plate = scene(320, 180);
        let all = || plate.rgb.iter().flatten().chain(&plate.depth_m);
        assert!(all().all(|v| v.is_finite() && *v >= 0.0));
        assert_eq!(plate.depth_m.len(), 320 * 180);
        let share = |wanted: &dyn Fn(f64) -> bool| {
            let count = plate
                .depth_m
                .iter()
                .filter(|&&z| wanted(f64::from(z)))
                .count();
            count as f64 / plate.depth_m.len() as f64
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
    fn the_plate_is_the_same_every_time() {
        let sum = |plate: &Scene| {
            plate
                .rgb
                .iter()
                .flatten()
                .chain(&plate.depth_m)
                .fold(0_u64, |sum, v| {
                    sum.wrapping_mul(31).wrapping_add(u64::from(v.to_bits()))
                })
        };
        let (a, b) = (scene(96, 54), scene(96, 54));
        assert_eq!(sum(&a), sum(&b));
        assert_ne!(sum(&a), sum(&scene(54, 96)));
    }
}
