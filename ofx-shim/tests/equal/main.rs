//! What a host gets is what the C ABI gives on the same samples, to the bit; and so what the command gives.
//!
//! By a small host of its own, since what is asked here is not how a plugin behaves but whether its pictures are right.

// The host's getters of several values take their places by pointers, which lie on the stack on Apple's 64-bit Arm.
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

/// Grey with bright points, an edge, and a hole in its alpha.
fn plate() -> Picture {
    Picture::made(WHOLE, 4, |x, y, c| {
        let point = if (x * 7 + y * 13) % 61 == 0 { 4.0 } else { 0.0 };
        let edge = if x > 30 { 0.6 } else { 0.1 };
        match c {
            3 => f32::from(u8::from(!((10..16).contains(&x) && y < 12))),
            _ => point + edge + 0.002 * (y * (c + 1)) as f32,
        }
    })
}

/// One over distance: a near card before a far ground.
fn inverse_depth(channels: i32) -> Picture {
    Picture::made(WHOLE, channels, |x, y, _| {
        if (20..34).contains(&x) && y > 8 {
            0.9
        } else {
            0.05 + 0.001 * y as f32
        }
    })
}

fn same(of: &str, host: &Picture, abi: &Picture) {
    assert_eq!(host.bounds, abi.bounds);
    let differs = host.samples.iter().zip(&abi.samples);
    let differs = differs.filter(|(a, b)| a.to_bits() != b.to_bits()).count();
    assert_eq!(differs, 0, "{of}: samples that differ");
}

#[test]
fn one_distance() {
    let (host, mut abi) = (Host::new(), Abi::new());
    host.set("distance", 6.0);
    abi.settings.distance = 6.0;
    let (rendered, wanted) = (host.render(&plate(), WHOLE), abi.apply(&plate(), WHOLE));
    same("one distance", &rendered, &wanted);
    assert_ne!(rendered.samples, plate().samples, "it blurs");
    // A part of the frame, its rows from the top down.
    let part = [5, 3, 31, 22];
    let rendered = host.render(&plate().upside_down(), part);
    same("a part", &rendered, &abi.apply(&plate(), part));
}

#[test]
fn depth_maths_and_holdouts() {
    let (host, mut abi) = (Host::new(), Abi::new());
    abi.settings.depth_kind = SEIDEL_DEPTH_INVERSE;
    abi.depth = Some(inverse_depth(1));
    let wanted = abi.apply(&plate(), WHOLE);
    // Nuke's, of a picture with one channel and of one with four.
    for channels in [1, 4] {
        host.connect("Depth", Some(inverse_depth(channels)));
        same("far=0", &host.render(&plate(), WHOLE), &wanted);
    }
    host.choose("depthChannel", 4);
    let mean = host.render(&plate(), WHOLE);
    let far = mean.samples.iter().zip(&wanted.samples);
    let far = far.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(far < 1e-3, "luminance of grey is grey: {far}");
    host.choose("depthChannel", 0);

    let matte = |channels| {
        Picture::made(WHOLE, channels, |x, _, c| match c {
            1 => 0.5,
            _ => f32::from(u8::from(x < 18)),
        })
    };
    host.connect("Holdout", Some(matte(4)));
    abi.matte = Some(matte(1));
    let held = host.render(&plate(), WHOLE);
    same("a holdout", &held, &abi.apply(&plate(), WHOLE));
    assert_ne!(held.samples, wanted.samples);
    // Its depth is in G.
    host.choose("holdoutDepth", 2);
    abi.matte_depth = Some(Picture::made(WHOLE, 1, |_, _, _| 0.5));
    same(
        "a holdout at a depth",
        &host.render(&plate(), WHOLE),
        &abi.apply(&plate(), WHOLE),
    );
    host.connect("Holdout", None);
    (abi.matte, abi.matte_depth) = (None, None);

    // Centimetres counted backwards.
    let backwards = |sign: f32| {
        let distance = inverse_depth(1);
        Picture::made(WHOLE, 1, |x, y, _| sign * 100.0 / distance.at(x, y, 0))
    };
    host.choose("math", 5);
    host.choose("worldScale", 1);
    host.connect("Depth", Some(backwards(-1.0)));
    abi.settings.depth_kind = SEIDEL_DEPTH_DISTANCE;
    abi.settings.depth_unit = 0.01;
    abi.depth = Some(backwards(1.0));
    same(
        "-depth in cm",
        &host.render(&plate(), WHOLE),
        &abi.apply(&plate(), WHOLE),
    );

    // Focus at a depth of the pass.
    host.choose("focus", 2);
    host.set("focusPlane", -150.0);
    abi.settings.focus_distance = 1.5;
    same(
        "focus plane",
        &host.render(&plate(), WHOLE),
        &abi.apply(&plate(), WHOLE),
    );
}

#[test]
fn proxies_count_lengths_at_full_resolution() {
    let (host, mut abi) = (Host::new(), Abi::new());
    host.set("maxSize", 3.0);
    host.set("lensScale", 0.2);
    host.set_pair("axisOffset", (8.0, 4.0));
    abi.settings.distance = 10.0;
    abi.settings.maximum_size = 1.5;
    abi.settings.lens_scale = 0.1;
    (abi.settings.axis_offset_x, abi.settings.axis_offset_y) = (4.0, -2.0);
    let rendered = host.render_at(&plate(), WHOLE, 0.5);
    same("half resolution", &rendered, &abi.apply(&plate(), WHOLE));
}

#[test]
fn alpha_that_is_not_multiplied_in() {
    let (host, mut abi) = (Host::new(), Abi::new());
    abi.settings.distance = 10.0;
    abi.settings.alpha = SEIDEL_ALPHA_UNPREMULTIPLIED;
    host.choose("sourceAlpha", 2);
    same(
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
    same("remove", &host.render(&plate(), WHOLE), &removed);
    host.choose("mode", 2);
    same(
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
fn a_missing_lens_is_told_of_and_the_next_render_works() {
    let host = Host::new();
    host.set_text("profile", "there is/no 100%s lens.json");
    let failed = host.try_render(&plate(), WHOLE);
    assert!(failed.is_err());
    let said = host.said();
    assert!(
        said.iter().any(|text| text.contains("no 100%s lens.json")),
        "{said:?}"
    );
    host.choose("lens", 1);
    assert!(host.try_render(&plate(), WHOLE).is_ok());
}

#[test]
fn the_psf_grid_is_what_the_lens_makes_of_points() {
    let (host, mut abi) = (Host::new(), Abi::new());
    host.set("lensScale", 2.0);
    host.set("distance", 2.0);
    abi.settings.lens_scale = 2.0;
    abi.settings.distance = 2.0;
    abi.settings.quality = SEIDEL_QUALITY_EXACT;
    // No light of points beyond the frame.
    abi.settings.edges = SEIDEL_EDGES_BLACK;
    host.choose("output", 4);
    let grid = host.render(&plate(), WHOLE);
    let mut wanted = Picture::made(WHOLE, 4, |_, _, c| f32::from(u8::from(c == 3)));
    for (x, y) in (0..35).map(|k| (4 + 8 * (k % 7), 3 + 8 * (k / 7))) {
        // Alone in its row, or it shares a kernel with its neighbours.
        let point = Picture::made(WHOLE, 4, |i, j, _| f32::from(u8::from((i, j) == (x, y))));
        let drawn = abi.apply(&point, WHOLE);
        let light = |k: &usize| k % 4 != 3;
        let samples = || (0..drawn.samples.len()).filter(light);
        let peak = samples().map(|k| drawn.samples[k]).fold(0.0, f32::max);
        assert!(peak > 0.0 && peak < 0.6, "it blurs: {peak}");
        for k in samples() {
            wanted.samples[k] += drawn.samples[k] / peak;
        }
    }
    let apart = grid.samples.iter().zip(&wanted.samples);
    let apart = apart.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(apart < 1e-5, "{apart}");
}
