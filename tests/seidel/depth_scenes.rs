//! Scenes with known geometry, for the tests of occlusion.

use crate::pinholes::{Card, ThinLens};

/// A scene, its lens, and the number of pinholes of its reference.
pub(crate) struct DepthScene {
    pub(crate) name: &'static str,
    pub(crate) lens: ThinLens,
    pub(crate) cards: Vec<Card>,
    pub(crate) pinholes: usize,
}

/// A fast lens whose discs have a radius of about 30 px times the distance from focus in 1/m.
fn lens(focus_per_m: f64) -> ThinLens {
    ThinLens {
        focal_mm: 50.0,
        f_number: 1.4,
        focus_per_m,
        pitch_mm: 0.03,
    }
}

const fn flat(vergence: f64, covers: fn(f64, f64) -> bool, light: fn(f64, f64) -> f64) -> Card {
    Card {
        vergence: [vergence, 0.0, 0.0],
        covers,
        light,
    }
}

fn everywhere(_: f64, _: f64) -> bool {
    true
}

/// A smooth periodic pattern around `mean`.
fn pattern(x: f64, y: f64, mean: f64, contrast: f64, period: f64) -> f64 {
    let k = std::f64::consts::TAU / period;
    let waves = (k * (x + 0.3 * y)).sin() * (k * (0.8 * y - 0.2 * x)).cos();
    mean * (1.0 + contrast * waves)
}

fn bright(x: f64, y: f64) -> f64 {
    pattern(x, y, 0.6, 0.6, 23.0)
}

fn dark(x: f64, y: f64) -> f64 {
    pattern(x, y, 0.12, 0.5, 11.0)
}

fn grey(x: f64, y: f64) -> f64 {
    pattern(x, y, 0.35, 0.8, 9.0)
}

fn left_card(x: f64, y: f64) -> bool {
    x + 0.25 * y < 84.0 && y > 28.0
}

/// Returns whether (x, y) is nearer than `radius` to the origin. Millions of rays ask, so no root is taken.
fn is_within(radius: f64, x: f64, y: f64) -> bool {
    x * x + y * y < radius * radius
}

fn disc(x: f64, y: f64) -> bool {
    is_within(36.0, x - 128.0, y - 70.0)
}

fn thick_wire(x: f64, y: f64) -> bool {
    (x - 60.0 - 0.4 * y).abs() < 1.6
}

fn wires(x: f64, y: f64) -> bool {
    thick_wire(x, y) || (y - 40.0 - 0.15 * x).abs() < 2.6
}

/// Point lights near the edge of [`left_card`].
fn lights(x: f64, y: f64) -> f64 {
    let lit = [
        (80.0, 40.0),
        (74.0, 64.0),
        (67.0, 90.0),
        (120.0, 52.0),
        (96.0, 84.0),
    ];
    if lit.iter().any(|(a, b)| is_within(2.0, x - a, y - b)) {
        30.0
    } else {
        dark(x, y)
    }
}

/// All scenes.
pub(crate) fn all() -> Vec<DepthScene> {
    let scene = |name, focus: f64, cards: &[Card]| DepthScene {
        name,
        lens: lens(focus),
        cards: cards.to_vec(),
        pinholes: 512,
    };
    let mut lit = vec![
        scene(
            "light-behind-sharp-card",
            0.6,
            &[flat(0.6, left_card, grey), flat(0.15, everywhere, lights)],
        ),
        scene(
            "light-behind-blurred-card",
            0.35,
            &[flat(0.7, left_card, grey), flat(0.1, everywhere, lights)],
        ),
    ];
    for scene in &mut lit {
        scene.pinholes = 3000;
    }
    let mut scenes = vec![
        scene(
            "near-card-blurred",
            0.2,
            &[flat(0.7, left_card, bright), flat(0.2, everywhere, grey)],
        ),
        scene(
            "dark-card-blurred",
            0.2,
            &[flat(0.7, left_card, dark), flat(0.2, everywhere, bright)],
        ),
        scene(
            "near-card-sharp",
            0.7,
            &[flat(0.7, left_card, bright), flat(0.2, everywhere, dark)],
        ),
        scene(
            "three-cards",
            0.4,
            &[
                flat(0.8, left_card, bright),
                flat(0.4, disc, grey),
                flat(0.05, everywhere, dark),
            ],
        ),
        scene(
            "card-on-floor",
            0.5,
            &[
                flat(0.6, disc, bright),
                Card {
                    vergence: [0.05, 0.0, 0.0065],
                    covers: everywhere,
                    light: grey,
                },
            ],
        ),
        scene(
            "slanted-plane",
            0.45,
            &[Card {
                vergence: [0.1, 0.0006, 0.005],
                covers: everywhere,
                light: grey,
            }],
        ),
        scene(
            "wires-blurred",
            0.2,
            &[flat(0.45, wires, bright), flat(0.2, everywhere, dark)],
        ),
        scene(
            "wires-sharp",
            0.7,
            &[flat(0.7, wires, bright), flat(0.2, everywhere, grey)],
        ),
    ];
    scenes.append(&mut lit);
    scenes
}
