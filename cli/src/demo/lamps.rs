//! The lights of the street and the cables they hang from: small, very bright, at many distances.

use super::noise::hash;
use super::scene::{CAMERA_M, LOOK_DOWN};
use super::vector::V3;

/// A glowing ball.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lamp {
    /// Centre in camera axes (x right, y down, z along the axis), m.
    pub(super) at: V3,
    /// Radius, m.
    pub(super) radius: f64,
    /// Scene-linear R, G, B at its middle.
    pub(super) light: V3,
}

/// A straight piece of cable.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cable {
    /// Its ends in camera axes, m.
    pub(super) ends: [V3; 2],
    /// Radius, m.
    pub(super) radius: f64,
}

const WARM: V3 = V3(1.0, 0.56, 0.20);
const AMBER: V3 = V3(1.0, 0.38, 0.07);
const TEAL: V3 = V3(0.10, 0.80, 0.85);
const WHITE: V3 = V3(0.95, 0.97, 1.0);
const RED: V3 = V3(1.0, 0.05, 0.03);
const PINK: V3 = V3(1.0, 0.16, 0.42);

/// A place as (x / z, y / z, z) in camera axes.
type Slopes = (f64, f64, f64);

/// A string of lamps between two places.
struct Festoon {
    ends: [Slopes; 2],
    /// How far its middle hangs below the straight line, m.
    sag: f64,
    lamps: u32,
    radius: f64,
    brightness: f64,
    colours: &'static [V3],
}

const FESTOONS: [Festoon; 4] = [
    // From before the focus to far behind it.
    Festoon {
        ends: [(-0.16, -0.186, 1.35), (0.30, -0.105, 11.0)],
        sag: 0.12,
        lamps: 22,
        radius: 0.013,
        brightness: 38.0,
        colours: &[WARM],
    },
    Festoon {
        ends: [(-0.42, -0.150, 8.0), (0.42, -0.185, 9.5)],
        sag: 0.42,
        lamps: 13,
        radius: 0.028,
        brightness: 60.0,
        colours: &[AMBER, WARM, TEAL],
    },
    Festoon {
        ends: [(-0.40, -0.200, 14.0), (0.40, -0.130, 15.0)],
        sag: 0.5,
        lamps: 15,
        radius: 0.035,
        brightness: 90.0,
        colours: &[WARM, PINK],
    },
    Festoon {
        ends: [(-0.30, -0.085, 26.0), (0.30, -0.110, 29.0)],
        sag: 0.6,
        lamps: 14,
        radius: 0.04,
        brightness: 190.0,
        colours: &[WARM, WARM, TEAL],
    },
];

/// Single lamps: (x / z, y / z, z), radius, colour, brightness.
const SINGLES: [(Slopes, f64, V3, f64); 11] = [
    // A car coming and one going.
    ((-0.142, -0.054, 21.0), 0.07, WHITE, 480.0),
    ((-0.076, -0.054, 21.0), 0.07, WHITE, 480.0),
    ((0.128, -0.061, 14.0), 0.05, RED, 120.0),
    ((0.212, -0.061, 14.0), 0.05, RED, 120.0),
    // Signals and signs.
    ((-0.236, -0.092, 12.0), 0.07, TEAL, 60.0),
    ((0.196, -0.060, 17.0), 0.08, RED, 75.0),
    ((-0.316, -0.060, 10.0), 0.05, AMBER, 60.0),
    ((-0.322, -0.030, 10.0), 0.05, AMBER, 60.0),
    ((0.321, -0.085, 10.5), 0.05, TEAL, 70.0),
    ((0.321, -0.052, 10.5), 0.05, PINK, 70.0),
    // Far down the street.
    ((-0.084, -0.066, 38.0), 0.10, WARM, 240.0),
];

/// Markers on the ground along both kerbs and in the lower corners: (x, z) in m. None right behind
/// the slate: a lens blur that knows only the plate lets its light spill over what hides it.
const MARKERS: [(f64, f64); 10] = [
    (0.615, 1.78),
    (0.90, 2.6),
    (0.90, 3.4),
    (0.90, 4.6),
    (0.90, 6.4),
    (-0.615, 1.78),
    (-0.92, 2.7),
    (-0.92, 4.9),
    (-0.92, 6.8),
    (-0.92, 9.6),
];

/// Every lamp.
pub(super) fn lamps() -> Vec<Lamp> {
    let mut lamps: Vec<Lamp> = SINGLES
        .iter()
        .map(|&((u, v, z), radius, colour, brightness)| Lamp {
            at: V3(u * z, v * z, z),
            radius,
            light: colour * brightness,
        })
        .collect();
    for (x, z) in MARKERS {
        let radius = 0.004 + 0.002 * z;
        let height = CAMERA_M - LOOK_DOWN * z - radius;
        lamps.push(Lamp {
            at: V3(x, height, z),
            radius,
            light: if x > 0.0 { TEAL } else { AMBER } * (50.0 + 6.0 * z),
        });
    }
    for (number, festoon) in FESTOONS.iter().enumerate() {
        for k in 0..festoon.lamps {
            let t = (f64::from(k) + 0.5) / f64::from(festoon.lamps);
            let colour = festoon.colours[k as usize % festoon.colours.len()];
            let flicker = 0.75 + 0.5 * hash(i64::from(k), number as i64, 11);
            let hang = V3(0.0, 1.8 * festoon.radius, 0.0);
            lamps.push(Lamp {
                at: festoon.point(t) + hang,
                radius: festoon.radius,
                light: colour * (festoon.brightness * flicker),
            });
        }
    }
    lamps
}

/// Every cable, as short straight pieces.
pub(super) fn cables() -> Vec<Cable> {
    const PIECES: u32 = 48;
    FESTOONS
        .iter()
        .flat_map(|festoon| {
            (0..PIECES).map(|k| {
                let at = |k: u32| festoon.point(f64::from(k) / f64::from(PIECES));
                Cable {
                    ends: [at(k), at(k + 1)],
                    radius: 0.0016,
                }
            })
        })
        .collect()
}

impl Festoon {
    /// The place on the cable at `t` of its length.
    fn point(&self, t: f64) -> V3 {
        let [a, b] = self.ends.map(|(u, v, z)| V3(u * z, v * z, z));
        a.mix(b, t) + V3(0.0, self.sag * 4.0 * t * (1.0 - t), 0.0)
    }
}
