//! Causes that are not in the effect library, one function for each family.

use std::f64::consts::TAU;

use super::pencil::{Ripple, Warp};
use super::perturb::Change;
use super::perturb_sensor::line;
use super::rng::Rng;

/// Draws a cause of the family `id`.
///
/// # Panics
/// If `id` is not a family of [`super::third_order::UNKNOWN`].
pub(super) fn unknown(id: &str, rng: &mut Rng) -> Change {
    match id {
        "central_obstruction" => central_obstruction(),
        "trefoil" => trefoil(rng),
        "ripple" => ripple(rng),
        "ghost" => ghost(rng),
        "sharpening" => sharpening(rng),
        "bleeding" => bleeding(rng),
        "zone_warp" => zone_warp(rng),
        "radial_smear" => radial_smear(rng),
        _ => panic!("`{id}` is not on the list of unknown causes"),
    }
}

fn central_obstruction() -> Change {
    Change::new("central_obstruction", [0.15, 0.5], |t, _, _, pencil| {
        pencil.mask.obstruction = t;
    })
    .scaled("radius", 1.0)
}

fn trefoil(rng: &mut Rng) -> Change {
    let d = rng.direction();
    Change::new("trefoil", [0.05, 4.0], move |t, _, _, pencil| {
        pencil.trefoil = [t * d[0], t * d[1]];
    })
    .scaled("re", d[0])
    .scaled("im", d[1])
}

fn ripple(rng: &mut Rng) -> Change {
    let (cycles, d) = (rng.between(2.0, 5.0), rng.direction());
    let (phase, rings) = (rng.between(0.0, TAU), rng.chance(0.5));
    Change::new("ripple", [0.05, 3.0], move |t, _, _, pencil| {
        let k = TAU * cycles / 2.0;
        pencil.ripple = Some(Ripple {
            slope: t,
            wave_number: [k * d[0], k * d[1]],
            phase,
            rings,
        });
    })
    .scaled("slope", 1.0)
    .fixed("cycles_across", cycles)
    .fixed("rings", f64::from(u8::from(rings)))
}

fn ghost(rng: &mut Rng) -> Change {
    let (d, far) = (rng.direction(), rng.between(3.0, 6.0));
    Change::new("ghost", [0.01, 0.35], move |t, _, _, pencil| {
        let second = [far * d[0], far * d[1], t];
        pencil.sensor.spread(&[[0.0, 0.0, 1.0 - t], second]);
    })
    .scaled("share", 1.0)
    .fixed("x", far * d[0])
    .fixed("y", far * d[1])
}

fn sharpening(rng: &mut Rng) -> Change {
    let radius = rng.between(0.8, 2.0);
    Change::new("sharpening", [0.05, 2.5], move |t, _, _, pencil| {
        pencil.sensor.sharpen = Some([t, radius]);
    })
    .scaled("amount", 1.0)
    .fixed("radius", radius)
}

fn bleeding(rng: &mut Rng) -> Change {
    let length = rng.between(1.5, 4.0);
    let (way, along_x) = (rng.sign(), rng.chance(0.5));
    // The tail is a set of copies at the quantiles of an exponential distribution.
    const COPIES: usize = 40;
    Change::new("bleeding", [0.02, 0.7], move |t, _, _, pencil| {
        let tail = (0..COPIES).map(|i| {
            let part = (i as f64 + 0.5) / COPIES as f64;
            let far = -way * length * libm::log(1.0 - part);
            let weight = t / COPIES as f64;
            if along_x {
                [far, 0.0, weight]
            } else {
                [0.0, far, weight]
            }
        });
        let copies: Vec<[f64; 3]> = std::iter::once([0.0, 0.0, 1.0 - t]).chain(tail).collect();
        pencil.sensor.spread(&copies);
    })
    .scaled("share", 1.0)
    .fixed("length", way * length)
    .fixed("along_x", f64::from(u8::from(along_x)))
}

/// Number of field zones along x and y, each with its own warp.
const ZONES: [usize; 2] = [4, 3];

fn zone_warp(rng: &mut Rng) -> Change {
    let warps: Vec<Warp> = (0..ZONES[0] * ZONES[1])
        .map(|_| Warp {
            linear: std::array::from_fn(|_| rng.normal()),
            square: std::array::from_fn(|_| 0.7 * rng.normal()),
            cross: std::array::from_fn(|_| 0.7 * rng.normal()),
        })
        .collect();
    Change::new("zone_warp", [0.03, 1.5], move |t, _, _, pencil| {
        let zone = |at: f64, half: f64, count: usize| {
            (((at / half + 1.0) / 2.0 * count as f64).max(0.0) as usize).min(count - 1)
        };
        let column = zone(pencil.field[0], 1.0, ZONES[0]);
        let row = zone(pencil.field[1], 0.5625, ZONES[1]);
        let warp = &warps[row * ZONES[0] + column];
        pencil.warp = Some(Warp {
            linear: warp.linear.map(|w| w * t),
            square: warp.square.map(|w| w * t),
            cross: warp.cross.map(|w| w * t),
        });
    })
    .scaled("rms", 1.0)
}

fn radial_smear(rng: &mut Rng) -> Change {
    let by_channel: [f64; 3] = std::array::from_fn(|_| rng.between(0.7, 1.3));
    Change::new("radial_smear", [0.4, 9.0], move |t, _, place, pencil| {
        let length = t * by_channel[place.channel];
        let [x, y] = pencil.field;
        pencil.sensor.spread(&line([length * x, length * y]));
    })
    .scaled("length_r", by_channel[0])
    .scaled("length_g", by_channel[1])
    .scaled("length_b", by_channel[2])
}
