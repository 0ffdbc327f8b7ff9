//! What stands in the street: at the focus a slate, three balls and a wire mesh, before it a bollard.

use super::lamps::Lamp;
use super::noise::{cloudy, smooth};
use super::patterns;
use super::street::{self, LAMP_LIGHT, SKY_LIGHT, lamp_glow};
use super::vector::{Hit, Ray, V3, nearer, smooth_step};

/// Where props stand on the ground: x, z, half width, half depth, m.
pub(super) const FOOTPRINTS: [(f64, f64, f64, f64); 4] = [
    (SLATE.0, SLATE.2, 0.16, 0.012),
    (CHROME.at.0, CHROME.at.2, 0.02, 0.02),
    (GREY.at.0, GREY.at.2, 0.02, 0.02),
    (CHECKER.at.0, CHECKER.at.2, 0.02, 0.02),
];

/// Direction towards the key light: warm, from the upper left, before the props.
const KEY: V3 = V3(-0.52, 0.62, -0.59);
const KEY_LIGHT: V3 = V3(2.3, 1.62, 1.02);
/// Direction towards the rim light: teal, from the right, behind them.
const RIM: V3 = V3(0.74, 0.30, 0.60);
const RIM_LIGHT: V3 = V3(0.25, 1.15, 1.35);

struct Ball {
    at: V3,
    radius: f64,
    /// Chequered under varnish; else plain 18 % grey.
    chequered: bool,
}

const CHROME: Ball = Ball {
    at: V3(-0.235, 0.078, 1.99),
    radius: 0.078,
    chequered: false,
};
const GREY: Ball = Ball {
    at: V3(-0.40, 0.058, 2.10),
    radius: 0.058,
    chequered: false,
};
const CHECKER: Ball = Ball {
    at: V3(0.335, 0.066, 1.96),
    radius: 0.066,
    chequered: true,
};

/// Foot of the slate's middle, and the tangent of its turn about the vertical.
const SLATE: V3 = V3(0.055, 0.0, 2.03);
const SLATE_TURN: f64 = 0.10;
const BOARD_WIDTH_M: f64 = 0.33;
const BOARD_HEIGHT_M: f64 = 0.264;
const STICK_M: f64 = 0.036;
/// How far the upper stick is open, rise over run.
const STICK_OPEN: f64 = 0.24;

/// The bollard's axis (x, z) and radius, m.
const BOLLARD: (f64, f64, f64) = (-0.337, 1.21, 0.047);

/// The nearest prop that `ray` meets. `lamps` are in world axes.
pub(super) fn meet(ray: &Ray, lamps: &[Lamp]) -> Option<Hit> {
    let still = nearer(nearer(slate(ray), bollard(ray, lamps)), mesh(ray));
    let balls = nearer(
        nearer(chrome(ray, lamps), matt(ray, &GREY, lamps)),
        matt(ray, &CHECKER, lamps),
    );
    nearer(still, balls)
}

/// Light from a matt surface of `reflectance` whose unit normal is `n`.
fn lit(reflectance: V3, n: V3) -> V3 {
    let key = KEY_LIGHT * n.dot(KEY).max(0.0);
    let rim = RIM_LIGHT * n.dot(RIM).max(0.0);
    let sky = SKY_LIGHT * (1.6 * (0.5 + 0.5 * n.1));
    let ground = LAMP_LIGHT * (0.10 * (0.5 - 0.5 * n.1));
    reflectance.times(key + rim + sky + ground)
}

/// The flat piece of the slate whose plane is met at `t`: the slate's own axes across and up, m.
fn slate_plane(ray: &Ray) -> Option<(f64, f64, f64, V3)> {
    let cos = 1.0 / (1.0 + SLATE_TURN * SLATE_TURN).sqrt();
    let normal = V3(SLATE_TURN * cos, 0.0, -cos);
    let across = V3(cos, 0.0, SLATE_TURN * cos);
    let foot = SLATE - ray.from;
    let t = foot.dot(normal) / ray.along.dot(normal);
    (t.is_finite() && t > 1e-6).then(|| {
        let off = ray.at(t) - SLATE;
        (t, off.dot(across), off.1, normal)
    })
}

fn slate(ray: &Ray) -> Option<Hit> {
    let (t, across, up, normal) = slate_plane(ray)?;
    let u = across / BOARD_WIDTH_M + 0.5;
    if !(0.0..1.0).contains(&u) || up < 0.0 {
        return None;
    }
    let wear = 0.88 + 0.16 * cloudy(across * 60.0, up * 60.0, 71);
    let hinge = BOARD_HEIGHT_M + STICK_M;
    let lower = up - BOARD_HEIGHT_M;
    let upper = up - hinge - 0.004 - STICK_OPEN * u * BOARD_WIDTH_M;
    let reflectance = if lower < 0.0 {
        patterns::board(u, -lower / BOARD_HEIGHT_M)
    } else if lower < STICK_M {
        patterns::stick(u, 1.0 - lower / STICK_M)
    } else if (0.0..STICK_M).contains(&upper) {
        patterns::stick(u, upper / STICK_M)
    } else {
        return None;
    };
    // Light falls off along the board, away from the key.
    let fall = 1.08 - 0.3 * u;
    Some(Hit {
        t,
        light: lit(reflectance * (wear * fall), normal),
    })
}

/// A square of fine wire, standing behind the balls on the right.
fn mesh(ray: &Ray) -> Option<Hit> {
    const WIRE_M: f64 = 0.0007;
    const PITCH_M: f64 = 0.017;
    let t = (2.08 - ray.from.2) / ray.along.2;
    let at = ray.at(t);
    let (x, y) = (at.0 - 0.285, at.1);
    if !t.is_finite() || t <= 1e-6 || !(0.0..0.24).contains(&x) || !(0.0..0.24).contains(&y) {
        return None;
    }
    let frame = x.min(0.24 - x).min(0.24 - y) < 0.005;
    let near = |a: f64| (a / PITCH_M - (a / PITCH_M).round()).abs() * PITCH_M;
    if !frame && near(x) > WIRE_M && near(y) > WIRE_M {
        return None;
    }
    let round = if frame {
        V3(-0.2, 0.3, -0.93)
    } else {
        V3(-0.45, 0.35, -0.82)
    };
    Some(Hit {
        t,
        light: lit(V3(0.42, 0.42, 0.44), round),
    })
}

fn bollard(ray: &Ray, lamps: &[Lamp]) -> Option<Hit> {
    let (x, z, radius) = BOLLARD;
    let (ox, oz) = (ray.from.0 - x, ray.from.2 - z);
    let (dx, dz) = (ray.along.0, ray.along.2);
    let (a, b, c) = (
        dx * dx + dz * dz,
        ox * dx + oz * dz,
        ox * ox + oz * oz - radius * radius,
    );
    let root = (b * b - a * c).max(-1.0);
    if root < 0.0 {
        return None;
    }
    let t = (-b - root.sqrt()) / a;
    let at = ray.at(t);
    if t <= 1e-6 || at.1 < 0.0 {
        return None;
    }
    let n = V3((at.0 - x) / radius, 0.0, (at.2 - z) / radius);
    let band = |low: f64, high: f64| (low..high).contains(&at.1);
    let (paint, gloss) = if band(0.36, 0.43) || band(0.24, 0.31) {
        (V3(0.80, 0.20, 0.018), 0.05)
    } else if band(0.31, 0.36) {
        (V3(0.72, 0.71, 0.68), 0.05)
    } else {
        (V3(0.016, 0.022, 0.026), 0.10)
    };
    let mirrored = Ray {
        from: at,
        along: ray.along.unit().mirrored(n),
    };
    let glow = street::meet(&mirrored, lamps).map_or(V3::ZERO, |hit| hit.light)
        + lamp_glow(&mirrored, lamps, 0.06);
    Some(Hit {
        t,
        light: lit(paint, n) + glow * gloss,
    })
}

fn meet_ball(ray: &Ray, ball: &Ball) -> Option<(f64, V3)> {
    let off = ray.from - ball.at;
    let (a, b) = (ray.along.dot(ray.along), off.dot(ray.along));
    let root = b * b - a * (off.dot(off) - ball.radius * ball.radius);
    if root < 0.0 {
        return None;
    }
    let t = (-b - root.sqrt()) / a;
    (t > 1e-6).then(|| (t, (ray.at(t) - ball.at) * (1.0 / ball.radius)))
}

fn chrome(ray: &Ray, lamps: &[Lamp]) -> Option<Hit> {
    let (t, n) = meet_ball(ray, &CHROME)?;
    let view = ray.along.unit();
    let mirrored = Ray {
        from: ray.at(t),
        along: view.mirrored(n),
    };
    let still = nearer(slate(&mirrored), matt(&mirrored, &GREY, lamps));
    let seen = nearer(street::meet(&mirrored, lamps), still).map_or(V3::ZERO, |hit| hit.light);
    // The soft boxes behind the camera: the key and a strip at the right.
    let d = mirrored.along;
    let key = smooth_step(0.965, 0.975, d.dot(KEY));
    let strip = smooth_step(0.13, 0.10, (d.0 - 0.62).abs())
        * smooth_step(0.0, 0.1, -d.2)
        * smooth_step(0.05, 0.1, d.1);
    let boxes = KEY_LIGHT * (5.0 * key) + V3(0.3, 1.2, 1.4) * (0.8 * strip);
    let edge = 0.72 + 0.25 * (1.0 - (-view.dot(n)).clamp(0.0, 1.0)).powi(5);
    let light = (seen + boxes + lamp_glow(&mirrored, lamps, 0.004)) * edge;
    Some(Hit { t, light })
}

/// The grey ball, or the chequered one, under a thin varnish.
fn matt(ray: &Ray, ball: &Ball, lamps: &[Lamp]) -> Option<Hit> {
    let (t, n) = meet_ball(ray, ball)?;
    let reflectance = if ball.chequered {
        // Turned so that a pole shows.
        let (y, z) = (0.80 * n.1 - 0.60 * n.2, 0.60 * n.1 + 0.80 * n.2);
        patterns::checker(n.0.atan2(-z), y.clamp(-1.0, 1.0).asin())
    } else {
        V3(0.18, 0.18, 0.18)
    };
    let shade = 0.35 + 0.65 * smooth_step(-1.0, -0.2, n.1);
    let speckle = 0.96 + 0.08 * smooth(n.0 * 90.0, n.1 * 90.0, 72);
    let mut light = lit(reflectance * (shade * speckle), n);
    if ball.chequered {
        let mirrored = Ray {
            from: ray.at(t),
            along: ray.along.unit().mirrored(n),
        };
        let key = smooth_step(0.95, 0.985, mirrored.along.dot(KEY));
        light = light + lamp_glow(&mirrored, lamps, 0.03) * 0.05 + KEY_LIGHT * (0.5 * key);
    }
    Some(Hit { t, light })
}
