//! Scenes in which removal may ring: lights, lines, windows, gradients, a step, and leaves before a wall.

use crate::SIDE;

/// Level of the ground.
pub(crate) const GROUND: f32 = 0.18;
/// Brightness of the lamps, discs of [`LAMP_RADIUS`] on the ground.
pub(crate) const LAMPS: [f32; 7] = [3.0, 10.0, 30.0, 100.0, 1e3, 1e4, 1e5];
/// Radius of a lamp, px.
pub(crate) const LAMP_RADIUS: f64 = 3.0;

/// A scene and its plate's noise.
pub(crate) struct RingingScene {
    pub(crate) name: &'static str,
    /// The sharp image.
    pub(crate) truth: Vec<f32>,
    /// Standard deviation of the noise.
    pub(crate) noise: f64,
    /// Level at which the plate is clipped.
    pub(crate) clip: f32,
    /// Bits of the plate's samples from 0 to 1, if it is quantised.
    pub(crate) bits: Option<u32>,
    /// Size of the blur that is removed, relative to that of the plate.
    pub(crate) too_wide: f64,
}

/// Returns the centre of a lamp, px.
pub(crate) fn lamp_centre(index: usize) -> (f64, f64) {
    let (column, row) = (index % 3, index / 3);
    (90.0 + 160.0 * column as f64, 90.0 + 160.0 * row as f64)
}

/// Returns the share of a pixel that lies inside a shape, from 4 x 4 samples.
fn covered(x: usize, y: usize, inside: impl Fn(f64, f64) -> bool) -> f32 {
    let at = |k: usize| (k as f64 + 0.5) / 4.0 - 0.5;
    let hits = (0..16).filter(|k| inside(x as f64 + at(k % 4), y as f64 + at(k / 4)));
    hits.count() as f32 / 16.0
}

fn drawn(pixel: impl Fn(usize, usize) -> f32) -> Vec<f32> {
    (0..SIDE * SIDE)
        .map(|k| pixel(k % SIDE, k / SIDE))
        .collect()
}

fn lamps() -> Vec<f32> {
    drawn(|x, y| {
        let lights = LAMPS.iter().enumerate().map(|(index, light)| {
            let (cx, cy) = lamp_centre(index);
            let disc = covered(x, y, |x, y| (x - cx).hypot(y - cy) < LAMP_RADIUS);
            disc * (light - GROUND)
        });
        GROUND + lights.sum::<f32>()
    })
}

/// Bright lines 1.5 px wide at three angles.
fn lines() -> Vec<f32> {
    drawn(|x, y| {
        let lines = [
            (5.0, 0.3_f64, 120.0),
            (20.0, 1.1, 250.0),
            (80.0, 2.2, 120.0),
        ];
        let light = lines.map(|(light, angle, offset)| {
            let inside = |x: f64, y: f64| {
                let (x, y) = (x - 256.0, y - 256.0);
                let (along, across) = (
                    x * angle.cos() + y * angle.sin(),
                    -x * angle.sin() + y * angle.cos() + offset - 160.0,
                );
                along.abs() < 70.0 && across.abs() < 0.75
            };
            covered(x, y, inside) * (light - GROUND)
        });
        GROUND + light.iter().sum::<f32>()
    })
}

/// Windows of 6 and a round one of 4.
fn windows() -> Vec<f32> {
    drawn(|x, y| {
        let wide = covered(x, y, |x, y| {
            (x - 150.0).abs() < 30.0 && (y - 160.0).abs() < 40.0
        });
        let small = covered(x, y, |x, y| {
            (x - 380.0).abs() < 8.0 && (y - 130.0).abs() < 12.0
        });
        let round = covered(x, y, |x, y| (x - 330.0).hypot(y - 360.0) < 12.0);
        GROUND + (wide + small) * (6.0 - GROUND) + round * (4.0 - GROUND)
    })
}

fn sky() -> Vec<f32> {
    drawn(|x, y| 0.15 + 0.5 * (y as f32 / SIDE as f32).powi(2) + 0.05 * (x as f32 / 90.0).sin())
}

fn step() -> Vec<f32> {
    drawn(|x, y| {
        let side = covered(x, y, |x, y| x - 256.0 > 0.17 * (y - 256.0));
        GROUND + side * (0.7 - GROUND)
    })
}

/// Returns the scenes of one depth.
pub(crate) fn all() -> Vec<RingingScene> {
    let scene = |name, truth, noise| RingingScene {
        name,
        truth,
        noise,
        clip: f32::INFINITY,
        bits: None,
        too_wide: 1.0,
    };
    let sky_with = |name, bits: u32| RingingScene {
        bits: Some(bits),
        ..scene(name, sky(), 1.0 / f64::from((1_u32 << bits) - 1))
    };
    vec![
        scene("lamps", lamps(), 0.001),
        scene("lamps, noise 0.01", lamps(), 0.01),
        RingingScene {
            clip: 1.0,
            ..scene("lamps clipped at 1", lamps(), 0.001)
        },
        scene("lines of 5, 20, 80", lines(), 0.001),
        scene("windows of 4 and 6", windows(), 0.001),
        RingingScene {
            clip: 1.0,
            ..scene("windows clipped at 1", windows(), 0.001)
        },
        scene("step", step(), 0.001),
        scene("step, noise 0.01", step(), 0.01),
        sky_with("sky of 8 bits", 8),
        sky_with("sky of 10 bits", 10),
        sky_with("sky of 12 bits", 12),
        RingingScene {
            too_wide: 1.05,
            ..scene("lamps, lens 5 % too wide", lamps(), 0.001)
        },
        RingingScene {
            too_wide: 1.3,
            ..scene("lamps, lens 30 % too wide", lamps(), 0.001)
        },
        RingingScene {
            too_wide: 2.0,
            ..scene("lamps, lens twice too wide", lamps(), 0.001)
        },
        RingingScene {
            too_wide: 1.3,
            clip: 1.0,
            ..scene("clipped lamps, lens 30 % too wide", lamps(), 0.001)
        },
        RingingScene {
            too_wide: 2.0,
            clip: 1.0,
            ..scene("clipped lamps, lens twice too wide", lamps(), 0.001)
        },
    ]
}
