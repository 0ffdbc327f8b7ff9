//! Objects in the street: a slate, three balls and a wire mesh at the focus, a post in front of it.

use super::noise::cloudy;
use super::ray::{Hit, Ray, Surface, V3, nearest, smooth_step, v3};
use super::slate;
use super::street::{LAMP_LIGHT, SKY_LIGHT, Street};

/// Directions towards the key light (warm, upper left, in front) and the rim light (teal, right, behind).
const KEY: V3 = v3(-0.52, 0.62, -0.59);
const KEY_LIGHT: V3 = v3(2.3, 1.62, 1.02);
const RIM: V3 = v3(0.74, 0.30, 0.60);
const RIM_LIGHT: V3 = v3(0.25, 1.15, 1.35);

/// Foot of the middle of the slate, and its direction across.
const SLATE: V3 = v3(0.055, 0.0, 2.03);
const SLATE_ACROSS: V3 = v3(0.995, 0.0, 0.0995);
/// Lower left corner of the mesh and its side, m.
const MESH: V3 = v3(0.285, 0.0, 2.08);
const MESH_M: f64 = 0.24;
/// Foot and radius of the post, m.
const POST: V3 = v3(-0.337, 0.0, 1.21);
const POST_RADIUS_M: f64 = 0.047;

const BLACK: V3 = v3(0.030, 0.034, 0.038);
const GREY: V3 = v3(0.18, 0.18, 0.18);
const WHITE: V3 = v3(0.72, 0.71, 0.68);
const ORANGE: V3 = v3(0.80, 0.20, 0.018);

/// A chequered ball on the ground: its radius is the height of its centre.
struct Ball {
    centre: V3,
    /// Reflectances of the squares.
    squares: [V3; 2],
    /// Share of the surroundings that it mirrors.
    gloss: f64,
}

const BALLS: [Ball; 3] = [
    ball(v3(-0.235, 0.078, 1.99), [BLACK; 2], 0.75),
    ball(v3(-0.40, 0.058, 2.10), [GREY; 2], 0.0),
    ball(v3(0.335, 0.066, 1.96), [ORANGE, BLACK], 0.05),
];

const fn ball(centre: V3, squares: [V3; 2], gloss: f64) -> Ball {
    Ball {
        centre,
        squares,
        gloss,
    }
}

/// Returns the nearest object that `ray` hits.
pub(super) fn look(ray: &Ray, street: &Street) -> Option<Hit> {
    let balls = BALLS.iter().map(|ball| ball.hit(ray, street));
    nearest(balls.chain([slate(ray), mesh(ray), post(ray, street)]))
}

/// Returns how open a point of the ground is: 1 away from the objects, less in their contact shadows.
pub(super) fn openness(ground: V3) -> f64 {
    let shadow = |foot: V3, half_width: f64| {
        let dx = ((ground.x - foot.x).abs() - half_width).max(0.0);
        let dz = ((ground.z - foot.z).abs() - 0.015).max(0.0);
        1.0 - 0.8 * (-dx.hypot(dz) / 0.035).exp()
    };
    let balls = BALLS.iter().map(|ball| shadow(ball.centre, 0.02));
    balls.product::<f64>() * shadow(SLATE, 0.16)
}

/// Returns the light that a matte surface of `reflectance` scatters.
fn diffuse(reflectance: V3, normal: V3) -> V3 {
    let key = KEY_LIGHT * normal.dot(&KEY).max(0.0);
    let rim = RIM_LIGHT * normal.dot(&RIM).max(0.0);
    let sky = SKY_LIGHT * (0.8 + 0.8 * normal.y);
    let ground = LAMP_LIGHT * (0.05 - 0.05 * normal.y);
    reflectance.component_mul(&(key + rim + sky + ground))
}

/// Returns what a polished surface mirrors: the street, and two soft boxes behind the camera.
fn polish(ray: &Ray, surface: &Surface, street: &Street, spread: f64) -> V3 {
    let mirrored = ray.mirrored(surface);
    let d = mirrored.direction;
    let key = smooth_step(0.965, 0.975, d.dot(&KEY));
    let strip = smooth_step(0.13, 0.10, (d.x - 0.62).abs())
        * smooth_step(0.0, 0.1, -d.z)
        * smooth_step(0.05, 0.1, d.y);
    street.reflection(&mirrored, spread) + KEY_LIGHT * (5.0 * key) + RIM_LIGHT * (0.9 * strip)
}

fn slate(ray: &Ray) -> Option<Hit> {
    let surface = ray.plane(SLATE, v3(SLATE_ACROSS.z, 0.0, -SLATE_ACROSS.x))?;
    let (x, y) = ((surface.at - SLATE).dot(&SLATE_ACROSS), surface.at.y);
    let wear = 0.88 + 0.16 * cloudy(x * 60.0, y * 60.0, 71);
    Some(surface.lit(diffuse(slate::reflectance(x, y)? * wear, surface.normal)))
}

/// A square of fine wire, leaning back behind the chequered ball.
fn mesh(ray: &Ray) -> Option<Hit> {
    const WIRE_RADIUS_M: f64 = 0.0007;
    const PITCH_M: f64 = 0.017;
    let surface = ray.plane(MESH, v3(-0.2, 0.4, -0.9))?;
    let (x, y) = (surface.at.x - MESH.x, surface.at.y);
    let rim = x.min(MESH_M - x).min(y).min(MESH_M - y);
    let off = |a: f64| (a / PITCH_M - (a / PITCH_M).round()).abs() * PITCH_M;
    let wire = rim < 0.005 || off(x).min(off(y)) < WIRE_RADIUS_M;
    (rim > 0.0 && wire).then(|| surface.lit(diffuse(V3::repeat(0.42), surface.normal)))
}

/// A post in bands of orange and white.
fn post(ray: &Ray, street: &Street) -> Option<Hit> {
    let surface = ray.cylinder(POST, POST_RADIUS_M)?;
    let paint = match surface.at.y {
        ..0.0 => return None,
        0.31..0.36 => WHITE,
        0.24..0.43 => ORANGE,
        _ => BLACK * 0.6,
    };
    let polish = polish(ray, &surface, street, 0.06) * 0.05;
    Some(surface.lit(diffuse(paint, surface.normal) + polish))
}

impl Ball {
    fn hit(&self, ray: &Ray, street: &Street) -> Option<Hit> {
        let surface = ray.sphere(self.centre, self.centre.y)?;
        let n = surface.normal;
        // The poles of the squares point up and towards the camera.
        let (y, z) = (0.8 * n.y - 0.6 * n.z, 0.6 * n.y + 0.8 * n.z);
        let squares = [n.x.atan2(-z), y.clamp(-1.0, 1.0).asin()].map(|a| (a * 4.6).floor() as i64);
        let paint = self.squares[(squares[0] + squares[1]).rem_euclid(2) as usize];
        let shade = 0.35 + 0.65 * smooth_step(-1.0, -0.2, n.y);
        let mut light = diffuse(paint * shade, n);
        if self.gloss > 0.0 {
            light += polish(ray, &surface, street, 0.004 / self.gloss) * self.gloss;
        }
        Some(surface.lit(light))
    }
}
