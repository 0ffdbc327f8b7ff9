//! Blur taken off, and changed for another lens's.

use std::ptr::null;

use seidel_c::*;

use crate::support::{Held, Picture, applied, doors, plate, rect, refused, settings, well};

const AREA: SeidelRect = SeidelRect {
    left: 0,
    top: 0,
    width: 150,
    height: 110,
};

fn sharp(channels: usize) -> Picture {
    Picture::of(AREA, channels, |x, y, channel| {
        let wave = |at: i32, period: f32| (std::f32::consts::TAU * at as f32 / period).sin();
        let shade = [1.0, 0.8, 0.6, 1.0][channel];
        let edge = if (x / 30 + y / 25) % 2 == 0 {
            0.35
        } else {
            0.0
        };
        shade * (0.4 + 0.1 * wave(x, 37.0) + 0.1 * wave(y, 29.0) + edge)
    })
}

fn error(a: &Picture, b: &Picture) -> f64 {
    let inner = rect(25, 25, 100, 60);
    let (a, b) = (a.cut(inner), b.cut(inner));
    let squares = a
        .samples
        .iter()
        .zip(&b.samples)
        .map(|(a, b)| f64::from(a - b).powi(2));
    (squares.sum::<f64>() / a.samples.len() as f64).sqrt()
}

fn findings() -> SeidelFindings {
    // SAFETY: zeros are NULL and numbers.
    let mut findings: SeidelFindings = unsafe { std::mem::zeroed() };
    findings.size = size_of::<SeidelFindings>() as u64;
    findings
}

fn removed(
    lens: &Held,
    settings: &SeidelSettings,
    plate: &SeidelPlate,
    (window, channels): (SeidelRect, usize),
    findings: &mut SeidelFindings,
) -> Picture {
    let mut out = Picture::black(window, channels);
    let output = out.output();
    // SAFETY: all pointers are good.
    let status =
        unsafe { (doors().remove)(lens.0, settings, plate, &output, null(), findings, null()) };
    well(status);
    out
}

#[test]
fn blur_that_was_put_on_comes_off() {
    let lens = Held::new(2.0);
    let truth = sharp(3);
    let image = truth.image();
    let settings = settings();
    let blurred = applied(&lens, &settings, &plate(&image, AREA), AREA);
    let image = blurred.image();
    let seen = plate(&image, AREA);
    let mut told = findings();
    let (mut confidence, mut gain) = (Picture::black(AREA, 3), Picture::black(AREA, 3));
    let maps = [confidence.output(), gain.output()];
    told.confidence = &maps[0];
    told.noise_gain = &maps[1];
    let found = removed(&lens, &settings, &seen, (AREA, 3), &mut told);
    let (before, after) = (error(&blurred, &truth), error(&found, &truth));
    assert!(after < 0.6 * before, "{before} {after}");
    assert!(
        told.noise.iter().all(|noise| (0.0..0.01).contains(noise)),
        "{:?}",
        told.noise
    );
    assert!(told.clip_level[0].is_nan() && told.clipped == [0; 3]);
    assert!(confidence.samples.iter().all(|c| (0.0..=1.0).contains(c)));
    assert!(confidence.samples.iter().any(|c| *c > 0.2));
    assert!(gain.samples.iter().any(|g| *g > 0.5));
    // What was found goes on beyond the plate; what lies beyond that is black.
    assert!(told.found.left < 0 && told.found.width == 150 - 2 * told.found.left);
    let wide = rect(told.found.left - 2, 40, 60, 1);
    let beyond = removed(&lens, &settings, &seen, (wide, 3), &mut told);
    assert_eq!(beyond.samples[..6], [0.0; 6]);
    assert!(beyond.samples[6..9].iter().all(|v| *v > 0.0));
    let inside = rect(0, 40, 50, 1);
    assert_eq!(
        beyond.cut(inside).bits()[..30],
        found.cut(inside).bits()[..30]
    );
    // Half the way is half the way.
    let mut half = settings;
    half.strength = 0.5;
    let middle = removed(&lens, &half, &seen, (AREA, 3), &mut findings());
    for ((middle, found), plate) in
        (middle.samples.iter().zip(&found.samples)).zip(&blurred.samples)
    {
        assert!((middle - 0.5 * (found + plate)).abs() < 1e-5);
    }
    half.strength = 0.0;
    let none = removed(&lens, &half, &seen, (AREA, 3), &mut findings());
    assert_eq!(none.bits(), blurred.bits());
}

#[test]
fn noise_clip_and_grain_are_followed() {
    let lens = Held::new(2.0);
    let image_of = |x: i32, y: i32| ((x * 7919 + y * 104_729) % 101) as f32 / 101.0 - 0.5;
    let source = Picture::of(AREA, 1, |x, y, _| {
        (0.5 + 0.01 * image_of(x, y) + if x > 70 { 0.6 } else { 0.0 }).min(1.0)
    });
    let image = source.image();
    let seen = plate(&image, AREA);
    let mut first = settings();
    first.noise[0] = 0.003;
    let mut told = findings();
    let base = removed(&lens, &first, &seen, (AREA, 1), &mut told);
    assert_eq!(told.noise[0], 0.003);
    assert!(told.clipped[0] > 100 && (told.clip_level[0] - 1.0).abs() < 0.01);
    for (name, change) in [
        (
            "noise",
            (|s: &mut SeidelSettings| s.noise[0] = 0.05) as fn(&mut SeidelSettings),
        ),
        ("clip", |s| s.clip = SEIDEL_CLIP_NONE),
        ("clip_level", |s| {
            s.clip = SEIDEL_CLIP_LEVEL;
            s.clip_level = 0.503;
        }),
        ("grain", |s| s.grain = SEIDEL_GRAIN_SOLVED),
    ] {
        let mut settings = first;
        change(&mut settings);
        let other = removed(&lens, &settings, &seen, (AREA, 1), &mut findings());
        assert_ne!(base.bits(), other.bits(), "{name}");
    }
}

#[test]
fn another_lens_takes_the_place_of_the_first() {
    let (from, to) = (Held::new(1.5), Held::new(3.0));
    let truth = sharp(4);
    let image = truth.image();
    let settings = settings();
    let [first, want] =
        [&from, &to].map(|lens| applied(lens, &settings, &plate(&image, AREA), AREA));
    let image = first.image();
    let seen = plate(&image, AREA);
    let mut out = Picture::black(AREA, 4);
    let output = out.output();
    // SAFETY: all pointers are good.
    unsafe {
        well((doors().relens)(
            from.0,
            to.0,
            &settings,
            &seen,
            &output,
            null(),
            null(),
        ));
        let mut outside = output;
        outside.rect.left = -1;
        let status = (doors().relens)(from.0, to.0, &settings, &seen, &outside, null(), null());
        refused(status, SeidelStatus::Argument, "output.rect");
    }
    let (before, after) = (error(&first, &want), error(&out, &want));
    assert!(after < 0.3 * before, "{before} {after}");
}
