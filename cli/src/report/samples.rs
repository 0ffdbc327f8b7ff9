//! Diagnoses as test data, one per verdict: a lens that lacks vignetting, observed on a grid of places. Their numbers agree
//! with each other as those of real diagnoses do.

use seidel_core::diagnosis::{
    Capture, Cause, Example, Gap, ModelShare, Order, OwnGapSource, Pair, Place, Shape, Shares,
    TileGap, Zone,
};
use seidel_core::{Diagnosis, Frame, ImagePoint, ObjectDistance, Tile, Verdict};
use seidel_optics::effects::FittedValue;

use super::Subject;
use crate::demo::lens::lens;

const FRAME: (u32, u32) = (1920, 1280);
const DISTANCES: [ObjectDistance; 3] = [
    ObjectDistance::Metres(1.2),
    ObjectDistance::Metres(2.5),
    ObjectDistance::Infinity,
];
const SIDE: usize = 41;

/// All verdicts.
pub(crate) const ALL: [Verdict; 5] = [
    Verdict::NoGap,
    Verdict::Explained,
    Verdict::Ambiguous,
    Verdict::Unexplained,
    Verdict::ModelTooSimple,
];

/// The mean gaps of a sample, and the largest one that would be missed.
#[derive(Clone, Copy)]
struct Gaps {
    before: f64,
    after: f64,
    limit: f64,
    own: f64,
}

impl Gaps {
    /// Returns the gaps of the sample of `verdict`. Where nothing is added, they are the same before and after.
    fn of(verdict: Verdict) -> Self {
        let [before, after, limit, own] = match verdict {
            Verdict::NoGap | Verdict::Bookkeeping => [0.0011, 0.0011, 0.002, 0.0006],
            Verdict::Explained => [0.0812, 0.0047, 0.003, 0.0009],
            Verdict::Ambiguous => [0.0812, 0.0021, 0.003, 0.0009],
            Verdict::Unexplained => [0.0812, 0.0447, 0.003, 0.0009],
            Verdict::ModelTooSimple => [0.0812, 0.0812, 0.005, 0.0612],
        };
        Self {
            before,
            after,
            limit,
            own,
        }
    }

    fn closed(self) -> f64 {
        1.0 - self.after / self.before
    }
}

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

/// Returns tiles with the mean gaps `gaps`.
fn tiles(gaps: Gaps) -> Vec<TileGap> {
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
    let count = tiles.len() as f64;
    let mean = |of: &dyn Fn(&TileGap) -> f64| tiles.iter().map(of).sum::<f64>() / count;
    let (before, after) = (
        gaps.before / mean(&|t| t.before),
        gaps.after / mean(&|t| t.after),
    );
    for tile in &mut tiles {
        tile.before *= before;
        tile.after = if gaps.after == gaps.before {
            tile.before
        } else {
            tile.after * after
        };
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

/// Returns examples of which the given lens has the share `given` of the clipping, and the corrected lens `corrected`.
fn examples(given: f64, corrected: f64) -> Vec<Example> {
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
            predicted: disc(radius, given * cut, 0.0),
            corrected: disc(radius, corrected * cut, 0.0),
        })
        .collect()
}

fn value(name: &'static str, unit: &'static str, value: f64, sigma: f64) -> FittedValue {
    FittedValue {
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
        amount: "a strength of 0.31 ± 0.12 px".to_owned(),
        parameters: vec![value("strength", "px", 0.31, 0.12)],
    }
}

/// Returns causes with the probabilities and closed shares of the sample of `verdict`, the likeliest first.
fn causes(verdict: Verdict) -> Vec<Cause> {
    // Vignetting, fifth order and the unknown cause: probabilities, and the closed shares of the first two.
    let ([vignetting, higher_order, unknown], [by_vignetting, by_order]) = match verdict {
        Verdict::NoGap | Verdict::Bookkeeping => ([0.36, 0.30, 0.31], [0.10, 0.08]),
        Verdict::Explained => ([0.91, 0.05, 0.02], [0.942, 0.61]),
        Verdict::Ambiguous => ([0.55, 0.39, 0.04], [0.974, 0.96]),
        Verdict::Unexplained => ([0.05, 0.02, 0.91], [0.45, 0.21]),
        Verdict::ModelTooSimple => ([0.30, 0.15, 0.53], [0.12, 0.09]),
    };
    let about = |share: f64| [share - 0.03, share + 0.02];
    let mut first = cause(
        "vignetting",
        vignetting,
        by_vignetting,
        about(by_vignetting),
    );
    first.amount =
        "34 % of the pupil is clipped at the side of the frame, 0 % in the middle".to_owned();
    first.parameters = vec![
        value("radius_1", "pupil radii", 1.043, 0.012),
        value("shift_1", "pupil radii per half frame width", 0.514, 0.007),
        FittedValue {
            channel: Some("R".to_owned()),
            ..value("tint", "px", -0.02, 0.004)
        },
    ];
    let mut none = cause("unknown", unknown, 0.0, [0.0; 2]);
    none.parameters.clear();
    none.amount.clear();
    let mut causes = vec![
        first,
        cause("higher_order", higher_order, by_order, about(by_order)),
        none,
        cause("decentre", 0.015, 0.08, [-0.02, 0.17]),
        cause("diffraction", 0.005, -0.01, [-0.04, 0.02]),
    ];
    causes.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    causes
}

pub(crate) fn places() -> Vec<Place> {
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

/// Returns the zone of the remaining gap of the sample of `verdict`; none where too little remains.
fn places_left(gaps: Gaps) -> Vec<Place> {
    if gaps.after <= gaps.limit {
        return Vec::new();
    }
    vec![Place {
        channel: "B".to_owned(),
        excess: 2.3 * gaps.after,
        z: 5.2,
        ..places().swap_remove(0)
    }]
}

/// Returns a diagnosis with the given `verdict` and every other field filled as such a diagnosis fills it.
pub(crate) fn diagnosis(verdict: Verdict) -> Diagnosis {
    let gaps = Gaps::of(verdict);
    let (added, equivalents) = match verdict {
        Verdict::NoGap | Verdict::ModelTooSimple | Verdict::Bookkeeping => (vec![], vec![]),
        Verdict::Explained | Verdict::Unexplained => (vec!["vignetting"], vec![]),
        Verdict::Ambiguous => (vec!["vignetting"], vec![vec!["vignetting", "higher_order"]]),
    };
    // Shares of the clipping that the given and the corrected lens have in the pictures.
    let (given, corrected) = match verdict {
        Verdict::NoGap | Verdict::Bookkeeping => (0.99, 0.99),
        Verdict::Explained | Verdict::Ambiguous => (0.0, 0.97),
        Verdict::Unexplained => (0.0, 0.4),
        Verdict::ModelTooSimple => (0.2, 0.2),
    };
    let closed_ci95 = match verdict {
        Verdict::NoGap | Verdict::ModelTooSimple => [0.0; 2],
        _ => [gaps.closed() - 0.021, gaps.closed() + 0.016],
    };
    let residual = if gaps.after > gaps.limit {
        "The remaining residual lies in the skirts of the PSFs, and grows towards the edge of the field."
    } else {
        ""
    };
    let (next_capture_id, next_capture) = match verdict {
        Verdict::NoGap => (
            Capture::None,
            "none needed: the lens explains these observations",
        ),
        Verdict::ModelTooSimple => (Capture::None, "none needed yet: fit the lens again"),
        Verdict::Unexplained => (
            Capture::StoppedDownAndTurned,
            "repeat three PSFs two stops down, and with the camera turned",
        ),
        _ => (
            Capture::FarOutOfFocus,
            "photograph one point far out of focus: with vignetting, only the disc in the corner is cut",
        ),
    };
    let too_simple = verdict == Verdict::ModelTooSimple;
    let order = |name, share, z| Order { name, share, z };
    let scaled = |place: Place| Place {
        excess: place.excess * gaps.before / 0.0812,
        ..place
    };
    Diagnosis {
        verdict,
        bookkeeping: None,
        added,
        gap: Gap {
            before: gaps.before,
            after: gaps.after,
            closed: gaps.closed(),
            closed_ci95,
            noise_floor: 0.004,
        },
        explainable: (gaps.closed() + 0.01).max(0.1),
        model: ModelShare {
            own_gap: gaps.own,
            measured_on: OwnGapSource::HeldOut,
            freedom: if too_simple { vec!["decentre"] } else { vec![] },
            freedom_closes: if too_simple { 0.97 } else { 0.0 },
        },
        shares: Shares {
            noise: 0.004,
            model: gaps.own,
            change: gaps.before - gaps.own,
        },
        detection_limit: gaps.limit,
        no_gap_probability: if verdict == Verdict::NoGap {
            0.97
        } else {
            0.0004
        },
        causes: causes(verdict),
        pairs: vec![
            Pair {
                effects: vec!["vignetting", "decentre"],
                probability: 0.012,
                gap_closed: gaps.closed() + 0.003,
            },
            Pair {
                effects: vec!["vignetting", "diffraction"],
                probability: 0.006,
                gap_closed: gaps.closed() + 0.001,
            },
        ],
        equivalents,
        places: places().into_iter().map(scaled).collect(),
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
        next_capture: next_capture.to_owned(),
        next_capture_id,
        residual: residual.to_owned(),
        places_left: places_left(gaps),
        remarks: vec!["2 tiles <saturated> took no part".to_owned()],
        corrected: lens(FRAME.0, FRAME.1).expect("a frame"),
        tiles: tiles(gaps),
        examples: examples(given, corrected),
    }
}
