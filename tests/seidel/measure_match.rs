//! `seidel measure match`: from a plate with sharp and soft edges to the lens that took it.

use std::path::Path;

use seidel_core::{ImagePoint, LensProfile};
use seidel_optics::numeric::SplitMix64;
use seidel_optics::psf::normal_cdf;

use crate::measure_lights::{BLACK, GAIN, PATTERN, WHITE, dng, json};
use crate::support::{must_refuse, succeeds};

const WIDTH: usize = 384;
const HEIGHT: usize = 264;
/// Distance between dark squares, and half their side, px.
const PITCH: f64 = 42.0;
const HALF: f64 = 13.5;
/// Mean variance that the scene adds to soft edges, px².
const SOFT: f64 = 1.5;
/// Index of green.
const GREEN: usize = 1;
/// Light of the paper and of the squares, electrons.
const PAPER: f64 = 24_000.0;
const INK: f64 = 2_500.0;

/// Returns the variance of the lens along any direction without the pixel's area, px².
fn variance(channel: usize, x: f64, y: f64) -> f64 {
    let half = WIDTH as f64 / 2.0;
    let r2 = ((x - half) / half).powi(2) + ((y - HEIGHT as f64 / 2.0) / half).powi(2);
    [1.5, 1.1, 1.7][channel] + 0.9 * r2
}

/// A dark square: its turn, and the variance that the scene adds to its sides, px².
struct Square {
    turn: f64,
    own: [f64; 4],
}

/// Writes a raw plate of squares on a grid; a share of their sides is `sharp`.
fn plate(path: &Path, sharp: f64, seed: u64) {
    let mut random = SplitMix64::new(seed);
    let columns = (WIDTH as f64 / PITCH) as usize;
    let rows = (HEIGHT as f64 / PITCH) as usize;
    let squares: Vec<Square> = (0..columns * rows)
        .map(|_| Square {
            turn: 0.1 + 1.3 * random.unit(),
            own: std::array::from_fn(|_| {
                let soft = 0.3 - SOFT * (1.0 - random.unit()).ln();
                if random.unit() < sharp { 0.0 } else { soft }
            }),
        })
        .collect();
    let mut normal = || {
        let radius = (-2.0 * (1.0 - random.unit()).ln()).sqrt();
        radius * (std::f64::consts::TAU * random.unit()).cos()
    };
    let mut counts = Vec::with_capacity(WIDTH * HEIGHT);
    for k in 0..WIDTH * HEIGHT {
        let (x, y) = ((k % WIDTH) as f64 + 0.5, (k / WIDTH) as f64 + 0.5);
        let channel = PATTERN[2 * (k / WIDTH % 2) + k % WIDTH % 2];
        let (column, row) = ((x / PITCH) as usize, (y / PITCH) as usize);
        let mut covered = 0.0;
        if column < columns && row < rows {
            let square = &squares[row * columns + column];
            let (dx, dy) = (
                x - (column as f64 + 0.5) * PITCH,
                y - (row as f64 + 0.5) * PITCH,
            );
            let (sin, cos) = square.turn.sin_cos();
            let (u, v) = (cos * dx + sin * dy, cos * dy - sin * dx);
            let lens = variance(channel, x, y) + 1.0 / 12.0;
            let inside = |depth: f64, own: f64| normal_cdf(depth / (lens + own).sqrt());
            let [left, right, top, bottom] = square.own;
            covered = inside(HALF + u, left)
                * inside(HALF - u, right)
                * inside(HALF + v, top)
                * inside(HALF - v, bottom);
        }
        let light = PAPER + (INK - PAPER) * covered;
        let electrons = light * [0.6, 1.0, 0.5][channel];
        let noisy = electrons + electrons.sqrt() * normal() + 3.0 * normal();
        let count = (noisy * GAIN + f64::from(BLACK)).round();
        counts.push(count.clamp(0.0, f64::from(WHITE)) as u16);
    }
    std::fs::write(path, dng(&counts, [WIDTH, HEIGHT])).expect("the folder is writable");
}

#[test]
fn a_plate_of_sharp_and_soft_edges_gives_the_lens_with_its_interval() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    plate(&folder.join("plate.dng"), 0.5, 1);
    let line = "measure match @plate.dng -o @lens.json --channels G --axis 192,132 --json";
    let report = json(&succeeds(folder, line).stdout);
    assert!(report["samples"].as_u64() >= Some(100), "{report}");
    assert!(report["scene_px2"].as_f64() > Some(0.8), "{report}");
    let text = std::fs::read_to_string(folder.join("lens.json")).expect("written");
    let lens = LensProfile::from_json(&text).expect("valid");
    assert!(lens.provenance.settings.contains("matched to a plate"));
    for own in lens.pupil_channels() {
        let relative = report["channels"][0]["relative"].as_f64();
        assert!(relative.is_some_and(|r| r < 0.15), "{report}");
        let (mut square, mut mean) = (0.0, 0.0);
        for k in 0..24 {
            let at = ImagePoint::new(
                (f64::from(k % 6) + 0.5) / 6.0 * WIDTH as f64,
                (f64::from(k / 6) + 0.5) / 4.0 * HEIGHT as f64,
            );
            let moments = own.moments_at(lens.frame.field_point(at), 0.0);
            let want = variance(GREEN, at.x_px, at.y_px);
            for got in [moments.mu20, moments.mu02] {
                square += (got - want).powi(2) / 48.0;
                mean += want / 48.0;
            }
        }
        let error = square.sqrt() / mean;
        assert!(error < 0.08, "{error} {report}");
    }
}

#[test]
fn plates_that_do_not_show_the_size_of_the_blur_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    plate(&folder.join("soft.dng"), 0.0, 2);
    let refused = "measure match @soft.dng -o @lens.json --channels R,G --axis 192,132";
    must_refuse(
        folder,
        refused,
        &["soft.dng", "no sharp edges stand out", "R less G"],
    );
    let few = "measure match @soft.dng -o @lens.json --channels G --min-contrast 1000";
    must_refuse(folder, few, &["edges"]);
    assert!(!folder.join("lens.json").exists());
    let two =
        crate::support::seidel_in(folder, "measure match @soft.dng -o @l.json --distance 1,2");
    assert_eq!(two.status, 2);
}
