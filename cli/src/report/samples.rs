//! A diagnosis as test data: a lens that lacks vignetting, observed on a grid of places.

use seidel_core::calibrate::diagnose::{
    Cause, Diagnosis, Example, Gap, ModelShare, Order, OwnGapSource, Pair, Place, Shape, Shares,
    TileGap, Value, Verdict, Zone,
};
use seidel_core::distance::ObjectDistance;
use seidel_core::field::{Frame, ImagePoint};
use seidel_core::tile::Tile;

use super::Subject;
use crate::demo::lens::lens;

const FRAME: (u32, u32) = (1920, 1280);
const DISTANCES: [ObjectDistance; 3] = [
    ObjectDistance::Metres(1.2),
    ObjectDistance::Metres(2.5),
    ObjectDistance::Infinity,
];
const SIDE: usize = 41;

pub(crate) fn subject() -> Subject {
    Subject {
        lens: "fifty <mm> & co.json".to_owned(),
        observations: "set-\"b\"".to_owned(),
        frame: Frame::new(FRAME.0, FRAME.1, None).expect("a frame"),
        channels: ["R", "G", "B"].map(str::to_owned).to_vec(),
        count: 162,
        distances: DISTANCES.len(),
        plate_gap: None,
    }
}

/// Returns a deterministic pseudo-random number in -1..1.
fn scatter(seed: usize) -> f64 {
    ((seed as f64 * 12.9898).sin() * 43_758.545_3).fract()
}

fn tiles() -> Vec<TileGap> {
    let frame = subject().frame;
    let mut tiles = Vec::new();
    for (d, distance) in DISTANCES.into_iter().enumerate() {
        for (c, channel) in ["R", "G", "B"].into_iter().enumerate() {
            for place in 0..54 {
                let at = ImagePoint::new(
                    120.0 + 210.0 * (place % 9) as f64,
                    110.0 + 212.0 * (place / 9) as f64,
                );
                let h = frame.field_point(at).radius();
                let noisy = 1.0 + 0.4 * scatter(tiles.len());
                let before = (0.002 + 0.16 * h.powi(4)) * noisy / (1.0 + d as f64);
                tiles.push(TileGap {
                    observation: d * 54 + place,
                    channel: channel.to_owned(),
                    distance,
                    at,
                    before: before * (1.0 + 0.1 * c as f64),
                    after: 0.004 * noisy * h + 0.003 * scatter(7 * tiles.len() + 1),
                    noise: 0.004,
                });
            }
        }
    }
    tiles
}

/// Returns a disc of light of `radius` px, vignetted at one side by `cut`, with a little noise.
fn disc(radius: f64, cut: f64, noise: f64) -> Tile {
    let middle = SIDE as f64 / 2.0;
    let light: Vec<f64> = (0..SIDE * SIDE)
        .map(|i| {
            let x = (i % SIDE) as f64 + 0.5 - middle;
            let y = (i / SIDE) as f64 + 0.5 - middle;
            let edge = |inside: f64| (inside + 0.5).clamp(0.0, 1.0);
            let whole = edge(radius - x.hypot(y));
            let lens = edge(1.1 * radius - (x - cut * radius).hypot(y + 0.5 * cut * radius));
            whole * lens * (0.8 + 0.02 * x) + noise * scatter(i)
        })
        .collect();
    let sum: f64 = light.iter().sum();
    let unit = light.iter().map(|v| (v / sum) as f32).collect();
    Tile::new(SIDE, SIDE, unit).expect("finite")
}

fn examples() -> Vec<Example> {
    let cases = [
        (0, 12.0, 0.75),
        (8 + 54, 9.0, 0.6),
        (53 + 162, 6.0, 0.5),
        (22, 3.0, 0.1),
    ];
    cases
        .into_iter()
        .map(|(tile, radius, cut)| Example {
            tile,
            observed: disc(radius, cut, 0.02),
            predicted: disc(radius, 0.0, 0.0),
            corrected: disc(radius, 0.97 * cut, 0.0),
        })
        .collect()
}

fn value(name: &'static str, unit: &'static str, value: f64, sigma: f64) -> Value {
    Value {
        name,
        channel: None,
        unit,
        value,
        sigma,
    }
}

fn cause(effect: &'static str, probability: f64, closed: f64, interval: [f64; 2]) -> Cause {
    Cause {
        effect,
        probability,
        gap_closed: closed,
        gap_closed_ci95: interval,
        parameters: vec![value("strength", "px", 0.31, 0.12)],
    }
}

fn causes() -> Vec<Cause> {
    let mut vignetting = cause("vignetting", 0.91, 0.942, [0.921, 0.958]);
    vignetting.parameters = vec![
        value("radius_1", "pupil radii", 1.043, 0.012),
        value("shift_1", "pupil radii per half frame width", 0.514, 0.007),
        Value {
            channel: Some("R".to_owned()),
            ..value("tint", "px", -0.02, 0.004)
        },
    ];
    let mut unknown = cause("unknown", 0.02, 0.0, [0.0; 2]);
    unknown.parameters.clear();
    vec![
        vignetting,
        cause("higher_order", 0.05, 0.61, [0.52, 0.68]),
        unknown,
        cause("decentre", 0.015, 0.08, [-0.02, 0.17]),
        cause("diffraction", 0.005, -0.01, [-0.04, 0.02]),
    ]
}

fn places() -> Vec<Place> {
    let place = |channel: &str, distance, angle_deg, excess, z| Place {
        channel: channel.to_owned(),
        distance,
        zone: Zone {
            radius: [0.66, 1.0],
            angle_deg,
        },
        tiles: 6,
        excess,
        z,
    };
    vec![
        place("R", ObjectDistance::Metres(1.2), [0.0, 90.0], 0.143, 31.2),
        place("G", ObjectDistance::Infinity, [90.0, 180.0], 0.051, 12.4),
        place("B", ObjectDistance::Unknown, [0.0, 360.0], 0.012, 4.1),
    ]
}

/// Returns a diagnosis with the given `verdict` and every other field filled.
pub(crate) fn diagnosis(verdict: Verdict) -> Diagnosis {
    let (added, equivalents) = match verdict {
        Verdict::NoGap => (vec![], vec![]),
        Verdict::Explained => (vec!["vignetting"], vec![]),
        Verdict::Ambiguous => (vec!["vignetting"], vec![vec!["vignetting", "higher_order"]]),
        Verdict::Unexplained => (vec!["vignetting"], vec![]),
        Verdict::ModelTooSimple => (vec![], vec![]),
    };
    let too_simple = verdict == Verdict::ModelTooSimple;
    let order = |name, share, z| Order { name, share, z };
    Diagnosis {
        verdict,
        added,
        gap: Gap {
            before: 0.0812,
            after: 0.0047,
            closed: 0.942,
            closed_ci95: [0.921, 0.958],
            noise_floor: 0.004,
        },
        explainable: 0.955,
        model: ModelShare {
            own_gap: if too_simple { 0.0612 } else { 0.0031 },
            measured_on: OwnGapSource::HeldOut,
            freedom: if too_simple { vec!["decentre"] } else { vec![] },
            freedom_closes: if too_simple { 0.97 } else { 0.0 },
        },
        shares: if too_simple {
            Shares {
                noise: 0.004,
                model: 0.0612,
                change: 0.02,
            }
        } else {
            Shares {
                noise: 0.004,
                model: 0.0031,
                change: 0.0781,
            }
        },
        detection_limit: 0.005,
        no_gap_probability: 0.0004,
        causes: causes(),
        pairs: vec![
            Pair {
                effects: ["vignetting", "decentre"],
                probability: 0.11,
                gap_closed: 0.945,
            },
            Pair {
                effects: ["vignetting", "diffraction"],
                probability: 0.03,
                gap_closed: 0.943,
            },
        ],
        equivalents,
        places: places(),
        shape: Shape {
            core: 0.38,
            skirt: 0.62,
            orders: vec![
                order("position", 0.02, 1.1),
                order("size", 0.31, 40.0),
                order("ellipticity", 0.36, 48.0),
                order("skew", 0.09, 17.0),
                order("finer", 0.22, 25.0),
            ],
        },
        next_capture: "repeat one corner PSF two stops down: vignetting goes away, fifth-order \
                       aberrations shrink but stay"
            .to_owned(),
        residual: "what is left lies in the skirt of the corners, R and B alike".to_owned(),
        remarks: vec!["2 tiles <saturated> took no part".to_owned()],
        corrected: lens(FRAME.0, FRAME.1).expect("a frame"),
        tiles: tiles(),
        examples: examples(),
    }
}
