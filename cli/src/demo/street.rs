//! The street: wet setts, house fronts on both sides, a night sky.

use super::lamps::Lamp;
use super::noise::{cloudy, hash, smooth};
use super::vector::{Hit, Ray, V3, nearer, smooth_step};

/// Distance of what is furthest away, m. Finite, as depth passes are usually delivered.
pub(super) const SKY_M: f64 = 400.0;

/// Light from the sky overhead.
pub(super) const SKY_LIGHT: V3 = V3(0.020, 0.050, 0.062);
/// Light from the lamps, all together.
pub(super) const LAMP_LIGHT: V3 = V3(0.62, 0.36, 0.16);

/// Half the width of the street, m.
const LEFT_M: f64 = -3.3;
const RIGHT_M: f64 = 3.5;
const FAR_END_M: f64 = 75.0;
/// Side of one sett, m.
const SETT_M: f64 = 0.085;

/// What a ray meets of ground, fronts and sky. World axes: x right, y up, z into the street, the
/// ground at y = 0. `lamps` are in these axes too.
pub(super) fn meet(ray: &Ray, lamps: &[Lamp]) -> Option<Hit> {
    let ground = ground(ray, lamps);
    nearer(ground, backdrop(ray))
}

/// What a ray meets of fronts and sky.
fn backdrop(ray: &Ray) -> Option<Hit> {
    let left = front(ray, LEFT_M, 3);
    let right = front(ray, RIGHT_M, 7);
    nearer(nearer(left, right), Some(sky(ray)))
}

fn ground(ray: &Ray, lamps: &[Lamp]) -> Option<Hit> {
    if ray.along.1 >= -1e-9 {
        return None;
    }
    let t = -ray.from.1 / ray.along.1;
    let at = ray.at(t);
    if t <= 1e-6 || at.2 > SKY_M {
        return None;
    }
    let view = ray.along.unit();
    let (sett, tint, joint) = sett(at);
    let wet = smooth_step(0.42, 0.66, cloudy(at.0 * 1.1 + 3.0, at.2 * 0.8, 21));
    // Water fills the joints and lies flat; setts stand out of it, each tilted a little.
    let flat = (wet * 0.75).max(joint * 0.3);
    let normal = (sett * (1.0 - flat) + V3(0.0, 1.0, 0.0) * flat).unit();
    let mut bounce = view.mirrored(normal);
    bounce.1 = bounce.1.abs().max(0.004);
    let cosine = (-view.dot(normal)).clamp(0.02, 1.0);
    let shine = (0.03 + 0.97 * (1.0 - cosine).powi(5)) * (0.34 + 0.5 * wet) * (1.0 - 0.75 * joint);
    let mirrored = Ray {
        from: at,
        along: bounce,
    };
    let mut reflected = backdrop(&mirrored).map_or(V3::ZERO, |hit| hit.light * 0.8);
    reflected = reflected + lamp_glow(&mirrored, lamps, 0.016 - 0.008 * wet);
    let dry = 0.075 * tint * (1.0 - 0.55 * wet) * (1.0 - 0.8 * joint);
    let pool = 0.35 + 0.65 * (-(at.0 * at.0 + (at.2 - 2.3).powi(2)) / 3.0).exp();
    let under = SKY_LIGHT + LAMP_LIGHT * pool;
    let light = under.times(V3(1.0, 0.95, 0.92)) * (dry * occlusion(at))
        + reflected * (shine * occlusion(at).sqrt());
    Some(Hit {
        t,
        light: hazy(light, t),
    })
}

/// How much of the sky the props leave to the ground at `at`.
fn occlusion(at: V3) -> f64 {
    super::props::FOOTPRINTS
        .iter()
        .map(|&(x, z, half_width, half_depth)| {
            let dx = ((at.0 - x).abs() - half_width).max(0.0);
            let dz = ((at.2 - z).abs() - half_depth).max(0.0);
            1.0 - 0.8 * (-dx.hypot(dz) / 0.035).exp()
        })
        .product()
}

/// Normal and tint of the sett at `at`, and 1 in the joints between setts.
fn sett(at: V3) -> (V3, f64, f64) {
    // Every row is shifted, and the courses wander.
    let wander = 0.35 * (smooth(at.0 * 1.3, at.2 * 1.3, 31) - 0.5);
    let z = at.2 / SETT_M + wander;
    let row = z.floor();
    let x = at.0 / (SETT_M * 1.15)
        + 0.5 * (row as i64).rem_euclid(2) as f64
        + 0.3 * hash(0, row as i64, 32);
    let column = x.floor();
    let (u, v) = (x - column - 0.5, z - row - 0.5);
    let (i, j) = (column as i64, row as i64);
    // Finer than a sample can show far away: fade to the mean.
    let fade = 1.0 / (1.0 + (at.2 / 9.0).powi(2));
    let edge = u.abs().max(v.abs());
    let joint = smooth_step(0.42, 0.47, edge) * fade;
    let rounding = smooth_step(0.20, 0.46, edge);
    let grain = smooth(at.0 * 160.0, at.2 * 160.0, 35);
    let tilt = |salt| hash(i, j, salt) - 0.5;
    let normal = V3(
        (0.05 * tilt(33) + 0.34 * u * rounding + 0.03 * (grain - 0.5)) * fade,
        1.0,
        (0.05 * tilt(34) + 0.34 * v * rounding) * fade,
    );
    let tint =
        0.55 + 0.9 * hash(i, j, 36) * fade + 0.45 * (1.0 - fade) + 0.5 * (grain - 0.5) * fade;
    (normal.unit(), tint, joint)
}

/// The house fronts in the plane x = `x_m`: piers, shop windows below, windows above.
fn front(ray: &Ray, x_m: f64, salt: u64) -> Option<Hit> {
    let t = (x_m - ray.from.0) / ray.along.0;
    let at = ray.at(t);
    if !t.is_finite() || t <= 1e-6 || at.1 < 0.0 || at.2 < 4.0 || at.2 > FAR_END_M {
        return None;
    }
    let house = (at.2 / 9.0).floor() as i64;
    let height = 7.0 + 6.0 * hash(house, 1, salt);
    if at.1 > height {
        return None;
    }
    let plaster = 0.8 + 0.4 * cloudy(at.2 * 0.7, at.1 * 0.7, salt + 2);
    let warm = hash(house, 2, salt);
    let wall = V3(0.020, 0.034, 0.042).mix(V3(0.050, 0.030, 0.020), warm) * plaster;
    // Light climbs the wall from the street.
    let mut light = wall * (0.35 + 1.2 * (-at.1 / 2.2).exp());
    let shop = at.1 < 2.7;
    let (wide, tall, foot) = if shop {
        (3.0, 2.7, 0.0)
    } else {
        (1.5, 2.4, 2.7)
    };
    let (column, row) = ((at.2 / wide).floor(), ((at.1 - foot) / tall).floor());
    let u = at.2 / wide - column - 0.5;
    let v = (at.1 - foot) / tall - row - 0.5;
    let pane = |half_u: f64, half_v: f64| u.abs() < half_u && v.abs() < half_v;
    let chance = hash(column as i64, row as i64, salt + 3);
    if shop && pane(0.40, 0.30) {
        let glow = match (chance * 5.0) as u32 {
            0 => V3(0.05, 0.42, 0.46),
            1 => V3(0.03, 0.04, 0.05),
            2 => V3(1.5, 0.46, 0.10),
            _ => V3(1.25, 0.62, 0.22),
        };
        let shelf = ((at.1 * 3.2).fract() > 0.16) as u32 as f64;
        let goods = 0.45
            + 0.8
                * hash(
                    (at.2 * 9.0).floor() as i64,
                    (at.1 * 3.2).floor() as i64,
                    salt + 4,
                );
        light = glow * (goods * (0.35 + 0.65 * shelf));
    } else if shop && v > 0.34 && v < 0.46 && u.abs() < 0.46 {
        // The sign above the window.
        let sign = if chance < 0.4 {
            V3(0.08, 2.2, 2.4)
        } else {
            V3(2.8, 0.75, 0.12)
        };
        let stroke = hash((at.2 * 14.0).floor() as i64, 0, salt + 5) > 0.45;
        light = sign * if stroke && chance > 0.2 { 1.0 } else { 0.06 };
    } else if !shop && pane(0.26, 0.33) {
        light = if chance > 0.62 {
            V3(0.95, 0.50, 0.18) * (0.3 + 0.9 * hash(column as i64, row as i64, salt + 6))
        } else {
            V3(0.012, 0.022, 0.030)
        };
    }
    Some(Hit {
        t,
        light: hazy(light, t),
    })
}

fn sky(ray: &Ray) -> Hit {
    let d = ray.along.unit();
    let rise = d.1.max(0.0);
    let glow = (-rise * 14.0).exp();
    let above = V3(0.006, 0.022, 0.034).mix(V3(0.020, 0.085, 0.105), (-rise * 5.0).exp());
    let cloud = 0.75 + 0.5 * cloudy(d.0 * 9.0, rise * 34.0, 51);
    let light = above * cloud + V3(0.42, 0.17, 0.055) * (glow * 0.55);
    Hit {
        t: SKY_M / ray.along.length(),
        light,
    }
}

/// The night air between the camera and something `distance_m` away.
fn hazy(light: V3, distance_m: f64) -> V3 {
    light.mix(V3(0.055, 0.060, 0.058), 1.0 - (-distance_m / 110.0).exp())
}

/// Lamps seen in a surface that spreads a reflection by `spread` radians.
pub(super) fn lamp_glow(ray: &Ray, lamps: &[Lamp], spread: f64) -> V3 {
    let d = ray.along.unit();
    lamps.iter().fold(V3::ZERO, |sum, lamp| {
        let to = lamp.at - ray.from;
        let along = to.dot(d);
        if along <= 0.0 {
            return sum;
        }
        let off2 = (to.dot(to) - along * along).max(0.0);
        let size2 = lamp.radius * lamp.radius;
        let width2 = size2 + (spread * along).powi(2);
        if off2 > 8.0 * width2 {
            return sum;
        }
        sum + lamp.light * (size2 / width2 * (-off2 / width2).exp())
    })
}
