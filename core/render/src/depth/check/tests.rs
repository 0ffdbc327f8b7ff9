//! Sound passes stay silent, wrong ones are named: over random scenes, every wrong convention.

use std::collections::BTreeMap;
use std::ops::Range;

use rayon::prelude::*;

use super::scenes::{MadeScene, SIZE};
use super::{CameraPerspective, DepthCheck, DepthFinding, DepthProblem, LensDistances, Severity};
use crate::DepthConvention;
use seidel_optics::numeric::SplitMix64;

const METRES: DepthConvention = DepthConvention::Distance {
    metres_per_unit: 1.0,
};
const INVERSE: DepthConvention = DepthConvention::Inverse {
    metres_per_unit: 1.0,
};
const RANGE: (f64, f64) = (0.05, 60.0);

/// What a made pass holds.
struct Made {
    samples: Vec<f32>,
    convention: DepthConvention,
    alpha: Option<Vec<f32>>,
}

fn findings(made: &Made, focal_px: Option<f64>) -> Vec<DepthFinding> {
    let reading = made
        .convention
        .read(&made.samples, SIZE.0)
        .expect("readable");
    let check = DepthCheck {
        samples: &made.samples,
        vergence: &reading.vergence,
        width: SIZE.0,
        height: SIZE.1,
        convention: made.convention,
        alpha: made.alpha.as_deref(),
        view: CameraPerspective {
            axis: MadeScene::axis(),
            focal_px,
            pixel_aspect: 1.0,
        },
        lens: LensDistances {
            measured_m: Some((0.5, 20.0)),
            focal_length_m: Some(0.035),
        },
    };
    check.findings().expect("valid")
}

/// How a pass is stored.
#[derive(Debug, Clone, Copy)]
enum Stored {
    Float,
    Half,
    /// Standard deviation as a share of depth.
    Noisy(f64),
}

/// Distance as `stored`, by pixel.
fn stored(samples: &mut [f32], how: Stored, seed: u64) {
    let mut random = SplitMix64::new(seed);
    for sample in samples {
        match how {
            Stored::Float => {}
            // Ten bits after the point, rounded to nearest.
            Stored::Half => {
                *sample = f32::from_bits((sample.to_bits() + 0x1000) & !0x1FFF);
            }
            Stored::Noisy(sigma) => {
                let normal = (0..12).map(|_| random.unit()).sum::<f64>() - 6.0;
                *sample *= (1.0 + sigma * normal) as f32;
            }
        }
    }
}

/// Distances along the axis, and lengths of rays for one unit along it, by pixel.
struct Seen {
    z: Vec<f64>,
    ray: Vec<f64>,
}

impl Seen {
    fn of(scene: &MadeScene) -> Self {
        Self {
            z: scene.pass(&|x, y| scene.depth(x, y)),
            ray: scene.pass(&|x, y| scene.ray_length(x, y)),
        }
    }

    /// A pass of `value` of distance and length of ray.
    fn made(&self, convention: DepthConvention, value: &dyn Fn(f64, f64) -> f64) -> Made {
        let pixels = self.z.iter().zip(&self.ray);
        Made {
            samples: pixels.map(|(z, ray)| value(*z, *ray) as f32).collect(),
            convention,
            alpha: None,
        }
    }

    /// Nearest and farthest distance but for the sky's.
    fn range(&self) -> (f64, f64) {
        let finite = || self.z.iter().copied().filter(|z| z.is_finite());
        (
            finite().fold(f64::INFINITY, f64::min),
            finite().fold(0.0, f64::max),
        )
    }
}

/// Passes as they should be.
fn sound(seen: &Seen) -> Vec<(&'static str, Made)> {
    let (near_m, far_m) = RANGE;
    let unit = |z: f64| ((z - near_m) / (far_m - near_m)).clamp(0.0, 1.0);
    let (far_one, far_zero) = (
        DepthConvention::FarOne { near_m, far_m },
        DepthConvention::FarZero { near_m, far_m },
    );
    let or_zero = |z: f64| if z.is_finite() { z } else { 0.0 };
    vec![
        ("metres", seen.made(METRES, &|z, _| z)),
        ("metres, sky 10000", seen.made(METRES, &|z, _| z.min(1e4))),
        ("metres, sky 0", seen.made(METRES, &|z, _| or_zero(z))),
        ("inverse", seen.made(INVERSE, &|z, _| 1.0 / z)),
        ("far one", seen.made(far_one, &|z, _| unit(z))),
        ("far zero", seen.made(far_zero, &|z, _| 1.0 - unit(z))),
    ]
}

/// Passes that are not what they are said to be.
fn wrong(seen: &Seen) -> Vec<(&'static str, Made)> {
    let (near_m, far_m) = (0.5, 300.0);
    let buffer = |z: f64| (1.0 / near_m - 1.0 / z) / (1.0 / near_m - 1.0 / far_m);
    let far_one = DepthConvention::FarOne { near_m, far_m };
    let (least, most) = seen.range();
    let unit = |z: f64| ((z - least) / (most - least)).min(1.0);
    let coarse = |z: f64| (40.0 * (255.0 * (z / 40.0).min(1.0)).round() / 255.0).max(1e-3);
    let sky = |z: f64| z.min(1e4);
    vec![
        ("along the ray", seen.made(METRES, &|z, s| sky(z) * s)),
        (
            "along the ray, inverse",
            seen.made(INVERSE, &|z, s| 1.0 / (z * s)),
        ),
        ("inverse as metres", seen.made(METRES, &|z, _| 1.0 / sky(z))),
        (
            "disparity as metres",
            seen.made(METRES, &|z, _| 3.0 + 200.0 / z),
        ),
        ("metres as inverse", seen.made(INVERSE, &|z, _| sky(z))),
        (
            "z-buffer as far one",
            seen.made(far_one, &|z, _| buffer(z).clamp(0.0, 1.0)),
        ),
        (
            "inverse along the ray as metres",
            seen.made(METRES, &|z, s| 1.0 / (sky(z) * s)),
        ),
        ("millimetres as metres", seen.made(METRES, &|z, _| 1e3 * z)),
        ("kilometres as metres", seen.made(METRES, &|z, _| 1e-3 * z)),
        ("normalised as metres", seen.made(METRES, &|z, _| unit(z))),
        ("8 bits", seen.made(METRES, &|z, _| coarse(z))),
        ("constant", seen.made(METRES, &|_, _| 3.0)),
    ]
}

fn name(problem: &DepthProblem) -> &'static str {
    match problem {
        DepthProblem::AlongRay { .. } => "along ray",
        DepthProblem::Inverted {
            along_ray: false, ..
        } => "inverted",
        DepthProblem::Inverted {
            along_ray: true, ..
        } => "inverted along ray",
        DepthProblem::ImplausibleRange { .. } => "range",
        DepthProblem::OffTheLens { .. } => "off the lens",
        DepthProblem::Normalised { .. } => "normalised",
        DepthProblem::Premultiplied { .. } => "premultiplied",
        DepthProblem::Quantised { .. } => "quantised",
        DepthProblem::Constant { .. } => "constant",
        DepthProblem::Empty { .. } => "empty",
    }
}

/// What must be said of each of [`wrong`], in how many of a hundred scenes at least, by store.
const WANTED: [(&str, &str, [u32; 2]); 12] = [
    ("along the ray", "along ray", [95, 70]),
    ("along the ray, inverse", "along ray", [95, 70]),
    ("inverse as metres", "inverted", [95, 90]),
    ("disparity as metres", "inverted", [95, 90]),
    ("metres as inverse", "inverted", [95, 90]),
    ("z-buffer as far one", "inverted", [90, 0]),
    (
        "inverse along the ray as metres",
        "inverted along ray",
        [95, 80],
    ),
    ("millimetres as metres", "off the lens", [85, 85]),
    ("kilometres as metres", "range", [95, 95]),
    ("normalised as metres", "normalised", [95, 0]),
    ("8 bits", "quantised", [50, 0]),
    ("constant", "constant", [100, 0]),
];

/// Counts by what was made and what was said.
type Table = BTreeMap<(&'static str, String), u32>;

/// What is said of the passes that `make` makes of some scenes.
fn tally(
    scenes: Range<u64>,
    make: fn(&Seen) -> Vec<(&'static str, Made)>,
    how: Stored,
    known: bool,
) -> Table {
    let of_scene = |seed: u64| {
        let scene = MadeScene::random(seed);
        let focal_px = known.then_some(scene.focal_px);
        let mut table = Table::new();
        for (what, mut made) in make(&Seen::of(&scene)) {
            stored(&mut made.samples, how, seed);
            for finding in findings(&made, focal_px) {
                let said = name(&finding.problem).to_owned();
                *table.entry((what, said)).or_default() += 1;
            }
        }
        table
    };
    let all: Vec<Table> = scenes.into_par_iter().map(of_scene).collect();
    let mut total = Table::new();
    for (key, count) in all.into_iter().flatten() {
        *total.entry(key).or_default() += count;
    }
    total
}

fn silent(scenes: Range<u64>, how: Stored, known: bool) {
    let said = tally(scenes, sound, how, known);
    assert!(said.is_empty(), "{how:?}, known {known}: {said:?}");
}

fn named(scenes: Range<u64>, how: Stored, known: bool, column: usize) {
    let count = (scenes.end - scenes.start) as u32;
    let said = tally(scenes, wrong, how, known);
    for (what, finding, least) in WANTED {
        let key = (what, finding.to_owned());
        let hits = said.get(&key).copied().unwrap_or(0);
        let wanted = least[column] * count / 100;
        assert!(
            hits >= wanted,
            "{how:?}, known {known}, {what}: {hits}; {said:?}"
        );
    }
}

#[test]
fn sound_passes_are_silent() {
    silent(0..7, Stored::Float, true);
    silent(7..9, Stored::Float, false);
}

#[test]
fn sound_half_floats_and_noise_are_silent() {
    for (first, how) in [
        (500, Stored::Half),
        (503, Stored::Noisy(0.001)),
        (506, Stored::Noisy(0.01)),
    ] {
        silent(first..first + 2, how, true);
        silent(first + 2..first + 3, how, false);
    }
}

#[test]
fn wrong_passes_are_named() {
    named(0..4, Stored::Float, true, 0);
    named(4..6, Stored::Float, false, 0);
    named(6..9, Stored::Half, true, 1);
}

#[test]
#[ignore = "minutes long: many scenes"]
fn many_scenes_are_told_right() {
    for (scenes, how, known, column) in [
        (0..200, Stored::Float, true, 0),
        (0..50, Stored::Float, false, 0),
        (0..50, Stored::Half, true, 1),
    ] {
        silent(scenes.clone(), how, known);
        named(scenes, how, known, column);
    }
    for how in [Stored::Half, Stored::Noisy(0.001), Stored::Noisy(0.01)] {
        for known in [true, false] {
            silent(500..520, how, known);
        }
    }
    coverage(0..20);
}

/// Coverage and depth of what stands before nothing, from 4 x 4 samples a pixel.
fn supersampled(scene: &MadeScene) -> [Vec<f32>; 3] {
    let samples = |x: f64, y: f64| -> Vec<f64> {
        (0..16)
            .map(|k| {
                let at = |i: i32| f64::from(i) / 4.0 - 0.375;
                scene.depth(x + at(k % 4), y + at(k / 4))
            })
            .filter(|z| z.is_finite())
            .collect()
    };
    let alpha = scene.pass(&|x, y| samples(x, y).len() as f32 / 16.0);
    let mixed = scene.pass(&|x, y| (samples(x, y).iter().sum::<f64>() / 16.0) as f32);
    let nearest = scene.pass(&|x, y| {
        let near = samples(x, y).into_iter().fold(f64::INFINITY, f64::min);
        if near.is_finite() { near as f32 } else { 0.0 }
    });
    [alpha, mixed, nearest]
}

#[test]
fn depth_times_coverage_is_named_and_clean_edges_are_not() {
    coverage(0..4);
}

fn coverage(scenes: Range<u64>) {
    for seed in scenes {
        let scene = MadeScene::balls(seed);
        let [alpha, mixed, nearest] = supersampled(&scene);
        let opaque = vec![1.0; alpha.len()];
        for (samples, is_mixed) in [(mixed, true), (nearest, false)] {
            for alpha in [Some(&alpha), None, Some(&opaque)] {
                let made = Made {
                    samples: samples.clone(),
                    convention: METRES,
                    alpha: alpha.cloned(),
                };
                let found = findings(&made, Some(scene.focal_px));
                let names: Vec<_> = found.iter().map(|f| name(&f.problem)).collect();
                let wanted: &[&str] = if is_mixed { &["premultiplied"] } else { &[] };
                assert_eq!(names, wanted, "scene {seed}, alpha {}", alpha.is_some());
            }
        }
    }
}

#[test]
fn rows_of_a_level_floor_are_not_levels_of_8_bits() {
    // One depth a row, evenly spaced in one over it, and cards of one depth: few levels, none of them a flaw.
    let (width, height) = SIZE;
    let samples = (0..width * height).map(|k| {
        let (x, y) = (k % width, k / width);
        let card = (x / 20) % 3 == 0;
        if card {
            2.0 + (x / 20) as f32
        } else {
            300.0 / (1.0 + y as f32)
        }
    });
    let made = Made {
        samples: samples.collect(),
        convention: METRES,
        alpha: None,
    };
    assert_eq!(findings(&made, Some(300.0)), []);
}

#[test]
fn empty_passes_are_named_and_other_sizes_refused() {
    let mut samples = vec![f32::INFINITY; SIZE.0 * SIZE.1];
    samples[7] = 2.0;
    let mut made = Made {
        samples,
        convention: METRES,
        alpha: None,
    };
    let found = findings(&made, None);
    assert!(matches!(found[0].problem, DepthProblem::Empty { share } if share < 1e-4));
    assert_eq!(found[0].severity, Severity::Warning);
    let reading = METRES.read(&made.samples, SIZE.0).expect("readable");
    made.samples.pop();
    let check = DepthCheck {
        samples: &made.samples,
        vergence: &reading.vergence,
        width: SIZE.0,
        height: SIZE.1,
        convention: METRES,
        alpha: None,
        view: CameraPerspective {
            axis: MadeScene::axis(),
            focal_px: None,
            pixel_aspect: 1.0,
        },
        lens: LensDistances::default(),
    };
    assert!(check.findings().is_err());
}
