//! `seidel_remove`, `seidel_match_colours` and `seidel_relens`.

use std::ptr::null;

use seidel_c::*;

use crate::support::{
    LensHandle, TestImage, apply, assert_ok, assert_refused, exports, max_difference, plate, rect,
    settings,
};

const AREA: SeidelRect = SeidelRect {
    left: 0,
    top: 0,
    width: 150,
    height: 110,
};

/// Returns the brightness of a pixel of a sharp image: waves and squares.
fn brightness(x: i32, y: i32) -> f32 {
    let wave = |at: i32, period: f32| (std::f32::consts::TAU * at as f32 / period).sin();
    let edge = if (x / 30 + y / 25) % 2 == 0 {
        0.35
    } else {
        0.0
    };
    0.4 + 0.1 * wave(x, 37.0) + 0.1 * wave(y, 29.0) + edge
}

/// Returns a sharp image whose channels differ.
fn sharp(channels: usize) -> TestImage {
    let shades = [1.0, 0.8, 0.6, 1.0];
    TestImage::from_fn(AREA, channels, |x, y, channel| {
        shades[channel] * brightness(x, y)
    })
}

/// Returns the root mean square difference of two images away from their edges.
fn error(a: &TestImage, b: &TestImage) -> f64 {
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
    // SAFETY: all bytes zero are a valid value: NULL and 0.
    let mut findings: SeidelFindings = unsafe { std::mem::zeroed() };
    findings.size = size_of::<SeidelFindings>() as u64;
    findings
}

/// Calls `seidel_remove` for the `window` of a plate; returns the result.
fn remove(
    lens: &LensHandle,
    settings: &SeidelSettings,
    plate: &SeidelPlate,
    window: SeidelRect,
    findings: &mut SeidelFindings,
) -> TestImage {
    // SAFETY: every plate of these tests has a source.
    let channels = unsafe { (*plate.source).channels };
    let mut out = TestImage::black(window, channels as usize);
    let output = out.output();
    // SAFETY: all pointers are valid.
    let status =
        unsafe { (exports().remove)(lens.0, settings, plate, &output, null(), findings, null()) };
    assert_ok(status);
    out
}

#[test]
fn blur_that_was_applied_is_removed() {
    let lens = LensHandle::new(2.0);
    let truth = sharp(3);
    let input = truth.input();
    let settings = settings();
    let blurred = apply(&lens, &settings, &plate(&input, AREA), AREA);
    let input = blurred.input();
    let plate = plate(&input, AREA);
    let mut results = findings();
    let (mut confidence, mut gain) = (TestImage::black(AREA, 3), TestImage::black(AREA, 3));
    let maps = [confidence.output(), gain.output()];
    results.confidence = &maps[0];
    results.noise_gain = &maps[1];
    let found = remove(&lens, &settings, &plate, AREA, &mut results);
    let (before, after) = (error(&blurred, &truth), error(&found, &truth));
    assert!(after < 0.6 * before, "{before} {after}");
    assert!(
        (results.noise.iter()).all(|noise| (0.0..0.01).contains(noise)),
        "{:?}",
        results.noise
    );
    assert!(results.clip_level[0].is_nan() && results.clipped == [0; 3]);
    assert!(confidence.samples.iter().all(|c| (0.0..=1.0).contains(c)));
    assert!(confidence.samples.iter().any(|c| *c > 0.2));
    assert!(gain.samples.iter().any(|g| *g > 0.5));
    // The result goes on beyond the plate, and is black beyond `found`.
    let margin = -results.found.left;
    assert!(margin > 0 && results.found.width == 150 + 2 * margin);
    let wide = rect(-margin - 2, 40, 60 + margin, 1);
    let beyond = remove(&lens, &settings, &plate, wide, &mut results);
    assert_eq!(beyond.samples[..6], [0.0; 6]);
    assert!(beyond.samples[6..9].iter().all(|v| *v > 0.0));
    let inside = rect(0, 40, 50, 1);
    assert_eq!(
        beyond.cut(inside).bits()[..30],
        found.cut(inside).bits()[..30]
    );
    // A strength of 0.5 is the mean of plate and result.
    let mut half = settings;
    half.strength = 0.5;
    let middle = remove(&lens, &half, &plate, AREA, &mut findings());
    for ((middle, found), plate) in
        (middle.samples.iter().zip(&found.samples)).zip(&blurred.samples)
    {
        assert!((middle - 0.5 * (found + plate)).abs() < 1e-5);
    }
    half.strength = 0.0;
    let none = remove(&lens, &half, &plate, AREA, &mut findings());
    assert_eq!(none.bits(), blurred.bits());
}

#[test]
fn noise_clip_and_grain_have_an_effect() {
    let lens = LensHandle::new(2.0);
    let noise = |x: i32, y: i32| ((x * 7919 + y * 104_729) % 101) as f32 / 101.0 - 0.5;
    let source = TestImage::from_fn(AREA, 1, |x, y, _| {
        (0.5 + 0.01 * noise(x, y) + if x > 70 { 0.6 } else { 0.0 }).min(1.0)
    });
    let input = source.input();
    let plate = plate(&input, AREA);
    let mut first = settings();
    first.noise[0] = 0.003;
    let mut results = findings();
    let base = remove(&lens, &first, &plate, AREA, &mut results);
    assert_eq!(results.noise[0], 0.003);
    assert!(results.clipped[0] > 100 && (results.clip_level[0] - 1.0).abs() < 0.01);
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
        let other = remove(&lens, &settings, &plate, AREA, &mut findings());
        assert_ne!(base.bits(), other.bits(), "{name}");
    }
}

#[test]
fn relens_replaces_the_lens() {
    let (from, to) = (LensHandle::new(1.5), LensHandle::new(3.0));
    let truth = sharp(4);
    let input = truth.input();
    let settings = settings();
    let [first, want] = [&from, &to].map(|lens| apply(lens, &settings, &plate(&input, AREA), AREA));
    let input = first.input();
    let plate = plate(&input, AREA);
    let mut out = TestImage::black(AREA, 4);
    let output = out.output();
    // SAFETY: all pointers are valid.
    unsafe {
        assert_ok((exports().relens)(
            from.0,
            to.0,
            &settings,
            &plate,
            &output,
            null(),
            null(),
        ));
        let mut outside = output;
        outside.rect.left = -1;
        let status = (exports().relens)(from.0, to.0, &settings, &plate, &outside, null(), null());
        assert_refused(status, SeidelStatus::Argument, "output.rect");
    }
    let (before, after) = (error(&first, &want), error(&out, &want));
    assert!(after < 0.3 * before, "{before} {after}");
}

#[test]
fn colours_are_matched_without_sharpening() {
    let lens = LensHandle::new(2.5);
    let settings = settings();
    let grey = TestImage::from_fn(AREA, 3, |x, y, _| brightness(x, y));
    let input = grey.input();
    let fringed = apply(&lens, &settings, &plate(&input, AREA), AREA);
    let input = fringed.input();
    let mut clean = TestImage::black(AREA, 3);
    let output = clean.output();
    let call = |source: &SeidelPlate, output: &SeidelImage| {
        // SAFETY: all pointers are valid.
        unsafe { (exports().match_colours)(lens.0, &settings, source, output, null(), null()) }
    };
    assert_ok(call(&plate(&input, AREA), &output));
    // G has the blur of middle size.
    assert_eq!(clean.plane(1), fringed.plane(1));
    for channel in [0, 2] {
        let fringe = |image: &TestImage| {
            let inner = image.cut(rect(25, 25, 100, 60));
            max_difference(&inner.plane(channel), &inner.plane(1))
        };
        let (before, after) = (fringe(&fringed), fringe(&clean));
        assert!(after < 0.3 * before, "{channel}: {before} {after}");
    }
    let one_colour = TestImage::from_fn(AREA, 1, |x, y, _| brightness(x, y));
    let (input, mut black) = (one_colour.input(), TestImage::black(AREA, 1));
    let status = call(&plate(&input, AREA), &black.output());
    assert_refused(status, SeidelStatus::Argument, "one colour");
}
