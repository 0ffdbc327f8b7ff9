//! Compares renders of the plugin with those of the C ABI on the same samples, bit for bit.
//!
//! The host is a small one, because these tests are about images, not about the plugin's behaviour.

// Variadic arguments are passed on the stack on Apple's 64-bit Arm, where the host's getters would not find them.
#![cfg(not(all(target_vendor = "apple", target_arch = "aarch64")))]

mod abi;
mod host;
mod lenses;
mod picture;

use abi::Abi;
use host::Host;
use picture::Picture;
use seidel_c::{
    SEIDEL_ALPHA_UNPREMULTIPLIED, SEIDEL_DEPTH_DISTANCE, SEIDEL_DEPTH_INVERSE, SEIDEL_EDGES_BLACK,
    SEIDEL_QUALITY_EXACT,
};

const WIDTH: i32 = 56;
const HEIGHT: i32 = 40;
const WHOLE: [i32; 4] = [0, 0, WIDTH, HEIGHT];

/// Makes a grey plate with bright points, an edge, and a hole in its alpha.
fn plate() -> Picture {
    Picture::new(WHOLE, 4, |x, y, c| {
        let point = if (x * 7 + y * 13) % 61 == 0 { 4.0 } else { 0.0 };
        let edge = if x > 30 { 0.6 } else { 0.1 };
        match c {
            3 => f32::from(u8::from(!((10..16).contains(&x) && y < 12))),
            _ => point + edge + 0.002 * (y * (c + 1)) as f32,
        }
    })
}

/// Makes a pass of 1 / distance: a near card in front of a far background.
fn inverse_depth(channels: i32) -> Picture {
    Picture::new(WHOLE, channels, |x, y, _| {
        if (20..34).contains(&x) && y > 8 {
            0.9
        } else {
            0.05 + 0.001 * y as f32
        }
    })
}

fn assert_same(name: &str, host: &Picture, abi: &Picture) {
    assert_eq!(host.bounds, abi.bounds);
    let differs = host.samples.iter().zip(&abi.samples);
    let differs = differs.filter(|(a, b)| a.to_bits() != b.to_bits()).count();
    assert_eq!(differs, 0, "{name}: number of different samples");
}

#[test]
fn one_distance() {
    let (host, mut abi) = (Host::new(), Abi::new());
    host.set("distance", 6.0);
    abi.settings.distance = 6.0;
    let (rendered, expected) = (host.render(&plate(), WHOLE), abi.apply(&plate(), WHOLE));
    assert_same("one distance", &rendered, &expected);
    assert_ne!(rendered.samples, plate().samples, "it blurs");
    // A part of the frame, with rows from the top down.
    let part = [5, 3, 31, 22];
    let rendered = host.render(&plate().with_reversed_rows(), part);
    assert_same("a part", &rendered, &abi.apply(&plate(), part));
}

#[test]
fn depth_maths_and_holdouts() {
    let (host, mut abi) = (Host::new(), Abi::new());
    abi.settings.depth_kind = SEIDEL_DEPTH_INVERSE;
    abi.depth = Some(inverse_depth(1));
    let expected = abi.apply(&plate(), WHOLE);
    // Nuke's convention, in pictures of one and of four channels.
    host.choose("math", 2);
    for channels in [1, 4] {
        host.connect("Depth", Some(inverse_depth(channels)));
        assert_same("far=0", &host.render(&plate(), WHOLE), &expected);
    }
    host.choose("depthChannel", 4);
    let mean = host.render(&plate(), WHOLE);
    let difference = mean.samples.iter().zip(&expected.samples);
    let difference = difference.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(difference < 1e-3, "luminance of grey is grey: {difference}");
    host.choose("depthChannel", 0);

    let matte = |channels| {
        Picture::new(WHOLE, channels, |x, _, c| match c {
            1 => 0.5,
            _ => f32::from(u8::from(x < 18)),
        })
    };
    host.connect("Holdout", Some(matte(4)));
    abi.matte = Some(matte(1));
    let held = host.render(&plate(), WHOLE);
    assert_same("a holdout", &held, &abi.apply(&plate(), WHOLE));
    assert_ne!(held.samples, expected.samples);
    // The depth of the holdout is in G.
    host.choose("holdoutDepth", 2);
    abi.matte_depth = Some(Picture::new(WHOLE, 1, |_, _, _| 0.5));
    assert_same(
        "a holdout at a depth",
        &host.render(&plate(), WHOLE),
        &abi.apply(&plate(), WHOLE),
    );
    host.connect("Holdout", None);
    (abi.matte, abi.matte_depth) = (None, None);

    // Negated centimetres.
    let signed_distance = |sign: f32| {
        let distance = inverse_depth(1);
        Picture::new(WHOLE, 1, |x, y, _| sign * 100.0 / distance.at(x, y, 0))
    };
    host.choose("math", 5);
    host.choose("worldScale", 1);
    host.connect("Depth", Some(signed_distance(-1.0)));
    abi.settings.depth_kind = SEIDEL_DEPTH_DISTANCE;
    abi.settings.depth_unit = 0.01;
    abi.depth = Some(signed_distance(1.0));
    assert_same(
        "-depth in cm",
        &host.render(&plate(), WHOLE),
        &abi.apply(&plate(), WHOLE),
    );

    // Focus at a value of the pass.
    host.choose("focus", 2);
    host.set("focusPlane", -150.0);
    abi.settings.focus_distance = 1.5;
    assert_same(
        "focus plane",
        &host.render(&plate(), WHOLE),
        &abi.apply(&plate(), WHOLE),
    );
}

#[test]
fn results_that_were_kept_are_those_of_their_inputs() {
    let host = Host::new();
    host.set("distance", 6.0);
    let source = plate();
    let blurred = host.render(&source, WHOLE);
    host.set("mix", 0.5);
    let mixed = host.render(&source, WHOLE);
    for (k, mixed) in mixed.samples.iter().enumerate() {
        let (before, after) = (source.samples[k], blurred.samples[k]);
        assert_eq!(*mixed, before + (after - before) * 0.5);
    }
    host.set("mix", 1.0);
    // Any other input is another render.
    let mut brighter = source.clone();
    brighter.samples[5] += 1.0;
    let of_brighter = host.render(&brighter, WHOLE);
    assert_ne!(of_brighter.samples, blurred.samples);
    host.set("amount", 0.5);
    assert_ne!(host.render(&source, WHOLE).samples, blurred.samples);
    host.set("amount", 1.0);
    host.connect("Depth", Some(inverse_depth(1)));
    host.choose("math", 2);
    assert_ne!(host.render(&source, WHOLE).samples, blurred.samples);
    host.connect("Depth", None);
    assert_same("again", &host.render(&source, WHOLE), &blurred);
}

#[test]
fn doubts_about_depth_and_focus_name_knobs() {
    let host = Host::new();
    let metres = Picture::new(WHOLE, 1, |x, y, _| 0.02 + (x + y) as f32 / 100.0);
    host.connect("Depth", Some(metres));
    host.render(&plate(), WHOLE);
    let doubts = host.messages();
    let doubt = doubts.last().expect("a warning");
    assert!(doubt.starts_with("Depth: "), "{doubt}");
    assert!(doubt.contains("set Depth Math to"), "{doubt}");
    host.connect("Depth", None);
    host.set("maxSize", 0.01);
    host.render(&plate(), WHOLE);
    let doubts = host.messages();
    let doubt = doubts.last().expect("a warning");
    assert!(doubt.contains("drawn as in focus"), "{doubt}");
}

#[test]
fn lengths_are_at_full_resolution_in_proxies() {
    let (host, mut abi) = (Host::new(), Abi::new());
    host.set("maxSize", 3.0);
    host.set("lensScale", 0.2);
    host.set_pair("axisOffset", 8.0, 4.0);
    abi.settings.distance = 10.0;
    abi.settings.maximum_size = 1.5;
    abi.settings.lens_scale = 0.1;
    (abi.settings.axis_offset_x, abi.settings.axis_offset_y) = (4.0, -2.0);
    let rendered = host.render_at(&plate(), WHOLE, 0.5);
    assert_same("half resolution", &rendered, &abi.apply(&plate(), WHOLE));
}

#[test]
fn unpremultiplied_alpha() {
    let (host, mut abi) = (Host::new(), Abi::new());
    abi.settings.distance = 10.0;
    abi.settings.alpha = SEIDEL_ALPHA_UNPREMULTIPLIED;
    host.choose("sourceAlpha", 2);
    assert_same(
        "unpremultiplied",
        &host.render(&plate(), WHOLE),
        &abi.apply(&plate(), WHOLE),
    );
}

#[test]
fn removal_relens_and_mix() {
    let (host, mut abi) = (Host::new(), Abi::new());
    abi.settings.distance = 10.0;
    host.choose("mode", 1);
    let removed = abi.remove(&plate(), WHOLE);
    assert_same("remove", &host.render(&plate(), WHOLE), &removed);
    host.choose("mode", 2);
    assert_same(
        "relens",
        &host.render(&plate(), WHOLE),
        &abi.relens(&plate(), WHOLE),
    );
    host.choose("mode", 1);
    host.set("mix", 0.25);
    let mixed = host.render(&plate(), WHOLE);
    for ((mixed, old), new) in mixed
        .samples
        .iter()
        .zip(plate().samples)
        .zip(removed.samples)
    {
        assert!((mixed - (old + (new - old) * 0.25)).abs() < 1e-6);
    }
}

#[test]
fn a_missing_lens_is_reported_and_the_next_render_works() {
    let host = Host::new();
    host.set_text("profile", "there is/no 100%s lens.json");
    let failed = host.try_render(&plate(), WHOLE);
    assert!(failed.is_err());
    let messages = host.messages();
    let is_reported = messages
        .iter()
        .any(|text| text.contains("no 100%s lens.json"));
    assert!(is_reported, "{messages:?}");
    host.choose("lens", 1);
    assert!(host.try_render(&plate(), WHOLE).is_ok());
}

#[test]
fn the_psf_grid_shows_blurred_points() {
    let (host, mut abi) = (Host::new(), Abi::new());
    host.set("lensScale", 2.0);
    host.set("distance", 2.0);
    abi.settings.lens_scale = 2.0;
    abi.settings.distance = 2.0;
    abi.settings.quality = SEIDEL_QUALITY_EXACT;
    // Mirrored points would add light from beyond the frame.
    abi.settings.edges = SEIDEL_EDGES_BLACK;
    host.choose("output", 4);
    let grid = host.render(&plate(), WHOLE);
    let mut expected = Picture::new(WHOLE, 4, |_, _, c| f32::from(u8::from(c == 3)));
    for (x, y) in (0..35).map(|k| (4 + 8 * (k % 7), 3 + 8 * (k / 7))) {
        // One point per plate, because the renderer may share a kernel between neighbours.
        let point = Picture::new(WHOLE, 4, |i, j, _| f32::from(u8::from((i, j) == (x, y))));
        let drawn = abi.apply(&point, WHOLE);
        let light = |k: &usize| k % 4 != 3;
        let samples = || (0..drawn.samples.len()).filter(light);
        let peak = samples().map(|k| drawn.samples[k]).fold(0.0, f32::max);
        assert!(peak > 0.0 && peak < 0.6, "it blurs: {peak}");
        for k in samples() {
            expected.samples[k] += drawn.samples[k] / peak;
        }
    }
    let difference = grid.samples.iter().zip(&expected.samples);
    let difference = difference.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(difference < 1e-5, "{difference}");
}
