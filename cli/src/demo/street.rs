//! A wet street at night: setts, house fronts, sky, and chains of lamps.
//!
//! World axes in m: x right, y up, z into the street; the ground is y = 0.

use super::noise::{cloudy, hash, smooth};
use super::ray::{Hit, Ray, V3, nearest, smooth_step, v3};

/// Distance of the sky, m; finite, as depth passes usually are.
pub(super) const SKY_M: f64 = 400.0;
/// Light of the sky, and of all lamps together, on surfaces in the street.
pub(super) const SKY_LIGHT: V3 = v3(0.020, 0.050, 0.062);
pub(super) const LAMP_LIGHT: V3 = v3(0.62, 0.36, 0.16);

/// The planes of the house fronts, m.
const LEFT_M: f64 = -3.3;
const RIGHT_M: f64 = 3.5;
/// Side of a sett, m.
const SETT_M: f64 = 0.085;
const CABLE_RADIUS_M: f64 = 0.002;

const WARM: V3 = v3(1.0, 0.56, 0.20);
const AMBER: V3 = v3(1.0, 0.38, 0.07);
const TEAL: V3 = v3(0.10, 0.80, 0.85);
const PINK: V3 = v3(1.0, 0.16, 0.42);
const RED: V3 = v3(3.0, 0.15, 0.09);
const WHITE: V3 = v3(12.0, 12.5, 13.0);

/// From before the focus to far behind it; three across the street; along both kerbs; lights of cars and
/// signs.
const CHAINS: [LampChain; 9] = [
    chain(v3(-0.22, 0.56, 1.36), v3(3.3, 1.08, 11.0), 22, &[WARM]),
    across(1.4, 8.0, &[AMBER, WARM, TEAL]),
    across(2.2, 14.0, &[WARM, PINK]),
    across(2.2, 26.0, &[WARM, WARM, TEAL]),
    chain(v3(-0.58, 0.01, 1.3), v3(-0.95, 0.01, 9.0), 5, &[AMBER]),
    chain(v3(0.58, 0.01, 1.3), v3(0.95, 0.01, 8.0), 6, &[TEAL]),
    chain(v3(-3.0, 0.7, 21.0), v3(-1.0, 0.7, 21.1), 2, &[WHITE]),
    chain(v3(1.2, 0.7, 14.0), v3(3.0, 0.7, 14.1), 2, &[RED]),
    chain(v3(3.4, 1.3, 9.0), v3(3.4, 0.5, 13.0), 3, &[TEAL, PINK]),
];

/// A cable that sags between two points, with lamps on it.
struct LampChain {
    from: V3,
    to: V3,
    count: u32,
    /// Colours of the lamps in turn.
    colours: &'static [V3],
}

const fn chain(from: V3, to: V3, count: u32, colours: &'static [V3]) -> LampChain {
    LampChain {
        from,
        to,
        count,
        colours,
    }
}

/// Returns a chain from house to house at height `y` and distance `z`.
const fn across(y: f64, z: f64, colours: &'static [V3]) -> LampChain {
    chain(v3(LEFT_M, y, z), v3(RIGHT_M, 1.1 * y, 1.1 * z), 13, colours)
}

/// A glowing ball.
struct Lamp {
    at: V3,
    radius: f64,
    /// Light at the middle of the ball.
    light: V3,
}

/// The street with all its lamps.
pub(super) struct Street {
    lamps: Vec<Lamp>,
}

impl LampChain {
    /// Returns the point of the cable at `share` of its span.
    fn point(&self, share: f64) -> V3 {
        let sag = self.from.y * 0.8 * share * (1.0 - share);
        self.from.lerp(&self.to, share) - V3::y() * sag
    }

    /// Returns the lamps, whose size and brightness grow with distance, so that far ones still show.
    fn lamps(&self) -> impl Iterator<Item = Lamp> {
        (0..self.count).map(|k| {
            let at = self.point((f64::from(k) + 0.5) / f64::from(self.count));
            let colour = self.colours[k as usize % self.colours.len()];
            let flicker = 0.75 + 0.5 * hash(k.into(), self.count.into(), 11);
            Lamp {
                at,
                radius: 0.008 * at.z.sqrt(),
                light: colour * (flicker * (30.0 + 5.5 * at.z)),
            }
        })
    }

    /// Hits the cable where the ray crosses the vertical plane that it hangs in.
    fn cable(&self, ray: &Ray) -> Option<Hit> {
        let run = self.to - self.from;
        let plane = ray.plane(self.from, v3(run.z, 0.0, -run.x))?;
        let share = (plane.at - self.from).z / run.z;
        let off = plane.at.y - self.point(share).y;
        let on = (0.0..1.0).contains(&share) && off.abs() < CABLE_RADIUS_M;
        on.then(|| plane.lit(v3(0.010, 0.013, 0.015)))
    }
}

impl Lamp {
    fn hit(&self, ray: &Ray) -> Option<Hit> {
        let off = self.at - ray.origin;
        // Most rays pass most lamps by far.
        if (off.x * ray.direction.z - off.z * ray.direction.x).abs() > 1.5 * self.radius {
            return None;
        }
        let surface = ray.sphere(self.at, self.radius)?;
        let facing = -surface.normal.dot(&ray.direction.normalize());
        Some(surface.lit(self.light * (0.45 + 0.55 * facing)))
    }

    /// Returns the light in a mirror that spreads reflections by `spread` rad, for a unit direction.
    fn glow(&self, ray: &Ray, spread: f64) -> V3 {
        let to = self.at - ray.origin;
        let along = to.dot(&ray.direction);
        let off2 = (to.norm_squared() - along * along).max(0.0);
        let size2 = self.radius * self.radius;
        let width2 = size2 + (spread * along).powi(2);
        if along <= 0.0 || off2 > 8.0 * width2 {
            return V3::zeros();
        }
        self.light * (size2 / width2 * (-off2 / width2).exp())
    }
}

impl Street {
    pub(super) fn new() -> Self {
        Self {
            lamps: CHAINS.iter().flat_map(LampChain::lamps).collect(),
        }
    }

    /// Returns what the ray hits first in the street, at the latest the sky.
    pub(super) fn look(&self, ray: &Ray) -> Option<Hit> {
        let lamps = self.lamps.iter().map(|lamp| lamp.hit(ray));
        let cables = CHAINS.iter().map(|chain| chain.cable(ray));
        nearest(lamps.chain(cables).chain([self.ground(ray), backdrop(ray)]))
    }

    /// Returns what a surface mirrors of the street, for a unit direction; lamps are spread by `spread`
    /// rad.
    pub(super) fn reflection(&self, ray: &Ray, spread: f64) -> V3 {
        let hit = nearest([self.ground(ray), backdrop(ray)]);
        hit.map_or(V3::zeros(), |hit| hit.light) + self.glow(ray, spread)
    }

    fn glow(&self, ray: &Ray, spread: f64) -> V3 {
        self.lamps.iter().map(|lamp| lamp.glow(ray, spread)).sum()
    }

    fn ground(&self, ray: &Ray) -> Option<Hit> {
        let mut surface = ray.plane(V3::zeros(), V3::y())?;
        let at = surface.at;
        if at.z > SKY_M || ray.direction.y >= 0.0 {
            return None;
        }
        let sett = Sett::at(at);
        let wet = smooth_step(0.42, 0.66, cloudy(at.x * 1.1 + 3.0, at.z * 0.8, 21));
        // Water fills the joints and lies flat; the setts stand out of it.
        let flat = (wet * 0.75).max(sett.joint * 0.3);
        surface.normal = sett.normal.lerp(&V3::y(), flat).normalize();
        let mut mirrored = ray.mirrored(&surface);
        mirrored.direction.y = mirrored.direction.y.abs().max(0.004);
        let cosine = -ray.direction.normalize().dot(&surface.normal);
        let fresnel = 0.03 + 0.97 * (1.0 - cosine.clamp(0.02, 1.0)).powi(5);
        let shine = fresnel * (0.34 + 0.5 * wet) * (1.0 - 0.75 * sett.joint);
        let houses = backdrop(&mirrored).map_or(V3::zeros(), |hit| hit.light * 0.8);
        let reflected = (houses + self.glow(&mirrored, 0.016 - 0.008 * wet)) * shine;
        let pool = 0.35 + 0.65 * (-(at.x * at.x + (at.z - 2.3).powi(2)) / 3.0).exp();
        let dry = 0.075 * sett.tint * (1.0 - 0.55 * wet) * (1.0 - 0.8 * sett.joint);
        let light = (SKY_LIGHT + LAMP_LIGHT * pool) * dry + reflected;
        Some(surface.lit(hazy(light * super::props::openness(at), surface.t)))
    }
}

/// The paving at a point of the ground.
struct Sett {
    normal: V3,
    /// Reflectance relative to the mean.
    tint: f64,
    /// 1 in the joints between setts, 0 elsewhere.
    joint: f64,
}

impl Sett {
    fn at(at: V3) -> Self {
        // The courses wander, and every other one is shifted by half a sett.
        let z = at.z / SETT_M + 0.35 * smooth(at.x * 1.3, at.z * 1.3, 31);
        let row = z.floor() as i64;
        let x = at.x / (SETT_M * 1.15) + 0.5 * row.rem_euclid(2) as f64 + 0.3 * hash(0, row, 32);
        let column = x.floor() as i64;
        let (u, v) = (x - column as f64 - 0.5, z - row as f64 - 0.5);
        let edge = u.abs().max(v.abs());
        // Detail finer than a pixel fades to its mean.
        let fade = 1.0 / (1.0 + (at.z / 9.0).powi(2));
        let slope = 0.34 * smooth_step(0.20, 0.46, edge);
        let grain = smooth(at.x * 160.0, at.z * 160.0, 35) - 0.5;
        let tilt = |salt| 0.05 * (hash(column, row, salt) - 0.5);
        let (x, z) = (tilt(33) + slope * u + 0.03 * grain, tilt(34) + slope * v);
        Self {
            normal: v3(x * fade, 1.0, z * fade).normalize(),
            tint: 1.0 + (0.9 * (hash(column, row, 36) - 0.5) + 0.5 * grain) * fade,
            joint: smooth_step(0.42, 0.47, edge) * fade,
        }
    }
}

/// Returns the house fronts on both sides and the sky.
fn backdrop(ray: &Ray) -> Option<Hit> {
    let fronts = [house_front(ray, LEFT_M, 3), house_front(ray, RIGHT_M, 7)];
    nearest(fronts).or_else(|| Some(sky(ray)))
}

/// House fronts in the plane x = `x_m`: shop windows under signs, then storeys of smaller windows.
fn house_front(ray: &Ray, x_m: f64, salt: u64) -> Option<Hit> {
    let surface = ray.plane(V3::x() * x_m, V3::x())?;
    let at = surface.at;
    let house = (at.z / 9.0).floor() as i64;
    let height = 7.0 + 6.0 * hash(house, 1, salt);
    if !(0.0..height).contains(&at.y) || !(4.0..75.0).contains(&at.z) {
        return None;
    }
    let shop = at.y < 2.7;
    let (x, y) = (at.z / if shop { 3.0 } else { 1.5 }, at.y / 2.7);
    let (u, v) = (x - x.floor() - 0.5, y - y.floor() - 0.5);
    let lit = hash(x as i64, y as i64, salt + 3);
    let strip = |per_m: f64| hash((at.z * per_m) as i64, (at.y * 3.2) as i64, salt + 4);
    let glow = match lit {
        ..0.2 => TEAL * 0.5,
        ..0.35 => TEAL * 0.05,
        _ => AMBER.lerp(&WARM, 0.5 * lit),
    };
    let light = if shop && u.abs() < 0.40 && v.abs() < 0.30 {
        let shelf = if (at.y * 3.2).fract() > 0.16 {
            1.0
        } else {
            0.35
        };
        glow * (shelf * (0.45 + 0.8 * strip(9.0)))
    } else if shop && u.abs() < 0.46 && v > 0.34 {
        glow * if strip(14.0) > 0.45 { 2.2 } else { 0.06 }
    } else if !shop && u.abs() < 0.26 && v.abs() < 0.33 && lit > 0.62 {
        WARM * (2.4 * lit - 1.2)
    } else {
        // Light from the street climbs the plaster.
        let paint = v3(0.020, 0.034, 0.042).lerp(&v3(0.050, 0.030, 0.020), hash(house, 2, salt));
        let plaster = 0.8 + 0.4 * cloudy(at.z * 0.7, at.y * 0.7, salt + 5);
        paint * (plaster * (0.35 + 1.2 * (-at.y / 2.2).exp()))
    };
    Some(surface.lit(hazy(light, surface.t)))
}

fn sky(ray: &Ray) -> Hit {
    let d = ray.direction.normalize();
    let rise = d.y.max(0.0);
    let above = v3(0.006, 0.022, 0.034).lerp(&v3(0.020, 0.085, 0.105), (-rise * 5.0).exp());
    let cloud = 0.75 + 0.5 * cloudy(d.x * 9.0, rise * 34.0, 51);
    Hit {
        t: SKY_M / ray.direction.norm(),
        light: above * cloud + v3(0.23, 0.094, 0.03) * (-rise * 14.0).exp(),
    }
}

/// Returns `light` after `distance_m` of night air.
fn hazy(light: V3, distance_m: f64) -> V3 {
    light.lerp(&v3(0.055, 0.060, 0.058), 1.0 - (-distance_m / 110.0).exp())
}
