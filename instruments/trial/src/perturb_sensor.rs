//! Effects of the sensor, one function for each effect.

use super::perturb::Change;
use super::rng::Rng;
use super::sensor::{Halo, HaloProfile, Tone};

/// Returns copies (x, y, weight) that form a centred line with the vector `along`, px.
pub(super) fn line(along: [f64; 2]) -> Vec<[f64; 3]> {
    let count = ((along[0].hypot(along[1]) / 0.15).ceil() as usize).clamp(2, 64);
    (0..count)
        .map(|i| {
            let part = (i as f64 + 0.5) / count as f64 - 0.5;
            [part * along[0], part * along[1], 1.0 / count as f64]
        })
        .collect()
}

pub(super) fn pixel_footprint(rng: &mut Rng) -> Change {
    if rng.chance(0.4) {
        return Change::new("pixel_footprint", [0.1, 0.9], |t, _, _, pencil| {
            let copies = [[-t, -t, 0.25], [t, -t, 0.25], [-t, t, 0.25], [t, t, 0.25]];
            pencil.sensor.spread(&copies);
        })
        .scaled("copies_apart_half", 1.0);
    }
    Change::new("pixel_footprint", [0.3, 2.5], |t, _, _, pencil| {
        let count = (t / 0.3).ceil();
        let steps = count as usize;
        let at = |i: usize| ((i as f64 + 0.5) / count - 0.5) * t;
        let copies: Vec<[f64; 3]> = (0..steps * steps)
            .map(|i| [at(i % steps), at(i / steps), 1.0 / (count * count)])
            .collect();
        pencil.sensor.spread(&copies);
    })
    .scaled("box", 1.0)
}

pub(super) fn motion(rng: &mut Rng) -> Change {
    let d = rng.direction();
    Change::new("motion", [0.3, 4.0], move |t, _, _, pencil| {
        pencil.sensor.spread(&line([t * d[0], t * d[1]]));
    })
    .scaled("x", d[0])
    .scaled("y", d[1])
}

pub(super) fn veiling_glare(rng: &mut Rng) -> Change {
    let radius = rng.between(3.0, 8.0);
    let profile = if rng.chance(0.5) {
        HaloProfile::Exponential
    } else {
        HaloProfile::Power
    };
    let by_channel = if rng.chance(0.4) {
        [1.0, rng.between(0.5, 1.0), rng.between(0.3, 0.9)]
    } else {
        [1.0; 3]
    };
    Change::new("veiling_glare", [0.01, 0.25], move |t, _, place, pencil| {
        pencil.sensor.halo = Some(Halo {
            share: t * by_channel[place.channel],
            radius_px: radius,
            profile,
        });
    })
    .scaled("share_r", by_channel[0])
    .scaled("share_g", by_channel[1])
    .scaled("share_b", by_channel[2])
    .fixed("radius", radius)
    .fixed(
        "power_not_exponential",
        f64::from(u8::from(profile == HaloProfile::Power)),
    )
}

pub(super) fn tone_curve(rng: &mut Rng) -> Change {
    match rng.below(4) {
        0 => Change::new("tone_curve", [0.01, 0.36], |t, _, _, pencil| {
            pencil.sensor.tone = Some(Tone::Power(libm::exp(-t)));
        })
        .scaled("log_power", -1.0),
        1 => Change::new("tone_curve", [0.01, 0.34], |t, _, _, pencil| {
            pencil.sensor.tone = Some(Tone::Power(libm::exp(t)));
        })
        .scaled("log_power", 1.0),
        2 => Change::new("tone_curve", [0.03, 3.0], |t, _, _, pencil| {
            pencil.sensor.tone = Some(Tone::Compress(t));
        })
        .scaled("compression", 1.0),
        _ => Change::new("tone_curve", [0.05, 0.5], |t, _, _, pencil| {
            pencil.sensor.tone = Some(Tone::Clip(1.0 - t));
        })
        .scaled("clipped_below_one", 1.0),
    }
}
