//! Valid passes give no finding, and wrong ones the right finding, over random scenes and all wrong conventions.

use std::collections::BTreeMap;
use std::ops::Range;

use rayon::prelude::*;

use super::scenes::{SIZE, TestScene};
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

/// A synthetic depth pass.
struct TestPass {
    samples: Vec<f32>,
    convention: DepthConvention,
    alpha: Option<Vec<f32>>,
}

fn findings(made: &TestPass, focal_px: Option<f64>) -> Vec<DepthFinding> {
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
        colours: &[],
        alpha: made.alpha.as_deref(),
        view: CameraPerspective {
            axis: TestScene::axis(),
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

/// The precision of a pass.
#[derive(Debug, Clone, Copy)]
enum Precision {
    Float,
    Half,
    /// Standard deviation as a share of depth.
    Noisy(f64),
}

/// Reduces `samples` to a precision.
fn degrade(samples: &mut [f32], precision: Precision, seed: u64) {
    let mut random = SplitMix64::new(seed);
    for sample in samples {
        match precision {
            Precision::Float => {}
            // A mantissa of ten bits, rounded to nearest.
            Precision::Half => {
                *sample = f32::from_bits((sample.to_bits() + 0x1000) & !0x1FFF);
            }
            Precision::Noisy(sigma) => {
                let normal = (0..12).map(|_| random.unit()).sum::<f64>() - 6.0;
                *sample *= (1.0 + sigma * normal) as f32;
            }
        }
    }
}

/// Distances along the axis, and lengths of rays per unit along it, by pixel.
struct SceneDepth {
    z: Vec<f64>,
    ray: Vec<f64>,
}

impl SceneDepth {
    fn new(scene: &TestScene) -> Self {
        Self {
            z: scene.pass(&|x, y| scene.depth(x, y)),
            ray: scene.pass(&|x, y| scene.ray_length(x, y)),
        }
    }

    /// Returns a pass of `value` of distance and length of ray.
    fn pass(&self, convention: DepthConvention, value: &dyn Fn(f64, f64) -> f64) -> TestPass {
        let pixels = self.z.iter().zip(&self.ray);
        TestPass {
            samples: pixels.map(|(z, ray)| value(*z, *ray) as f32).collect(),
            convention,
            alpha: None,
        }
    }

    /// Returns the nearest and farthest distance without the sky.
    fn range(&self) -> (f64, f64) {
        let finite = || self.z.iter().copied().filter(|z| z.is_finite());
        (
            finite().fold(f64::INFINITY, f64::min),
            finite().fold(0.0, f64::max),
        )
    }
}

/// Passes that match their convention.
fn valid_passes(depth: &SceneDepth) -> Vec<(&'static str, TestPass)> {
    let (near_m, far_m) = RANGE;
    let unit = |z: f64| ((z - near_m) / (far_m - near_m)).clamp(0.0, 1.0);
    let (far_one, far_zero) = (
        DepthConvention::FarOne { near_m, far_m },
        DepthConvention::FarZero { near_m, far_m },
    );
    let or_zero = |z: f64| if z.is_finite() { z } else { 0.0 };
    vec![
        ("metres", depth.pass(METRES, &|z, _| z)),
        ("metres, sky 10000", depth.pass(METRES, &|z, _| z.min(1e4))),
        ("metres, sky 0", depth.pass(METRES, &|z, _| or_zero(z))),
        ("inverse", depth.pass(INVERSE, &|z, _| 1.0 / z)),
        ("far one", depth.pass(far_one, &|z, _| unit(z))),
        ("far zero", depth.pass(far_zero, &|z, _| 1.0 - unit(z))),
    ]
}

/// Passes that do not match their convention.
fn wrong_passes(depth: &SceneDepth) -> Vec<(&'static str, TestPass)> {
    let (near_m, far_m) = (0.5, 300.0);
    let buffer = |z: f64| (1.0 / near_m - 1.0 / z) / (1.0 / near_m - 1.0 / far_m);
    let far_one = DepthConvention::FarOne { near_m, far_m };
    let (least, most) = depth.range();
    let unit = |z: f64| ((z - least) / (most - least)).min(1.0);
    let coarse = |z: f64| (40.0 * (255.0 * (z / 40.0).min(1.0)).round() / 255.0).max(1e-3);
    let sky = |z: f64| z.min(1e4);
    vec![
        ("along the ray", depth.pass(METRES, &|z, s| sky(z) * s)),
        (
            "along the ray, inverse",
            depth.pass(INVERSE, &|z, s| 1.0 / (z * s)),
        ),
        (
            "inverse as metres",
            depth.pass(METRES, &|z, _| 1.0 / sky(z)),
        ),
        (
            "disparity as metres",
            depth.pass(METRES, &|z, _| 3.0 + 200.0 / z),
        ),
        ("metres as inverse", depth.pass(INVERSE, &|z, _| sky(z))),
        (
            "z-buffer as far one",
            depth.pass(far_one, &|z, _| buffer(z).clamp(0.0, 1.0)),
        ),
        (
            "inverse along the ray as metres",
            depth.pass(METRES, &|z, s| 1.0 / (sky(z) * s)),
        ),
        ("millimetres as metres", depth.pass(METRES, &|z, _| 1e3 * z)),
        ("kilometres as metres", depth.pass(METRES, &|z, _| 1e-3 * z)),
        ("normalised as metres", depth.pass(METRES, &|z, _| unit(z))),
        ("8 bits", depth.pass(METRES, &|z, _| coarse(z))),
        ("constant", depth.pass(METRES, &|_, _| 3.0)),
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
        DepthProblem::Colour => "colour",
        DepthProblem::Premultiplied { .. } => "premultiplied",
        DepthProblem::Averaged { .. } => "averaged",
        DepthProblem::Misplaced { .. } => "misplaced",
        DepthProblem::Quantised { .. } => "quantised",
        DepthProblem::Constant { .. } => "constant",
        DepthProblem::Empty { .. } => "empty",
    }
}

/// The finding expected of each of [`wrong_passes`], with its least share of scenes in per cent: in floats, and in half
/// floats.
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

/// Knowledge of the focal length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Camera {
    Known,
    Unknown,
}

/// Counts by pass and finding.
type Table = BTreeMap<(&'static str, String), u32>;

/// Counts the findings of the passes that `make` derives from `scenes`.
fn tally(
    scenes: Range<u64>,
    make: fn(&SceneDepth) -> Vec<(&'static str, TestPass)>,
    precision: Precision,
    camera: Camera,
) -> Table {
    let of_scene = |seed: u64| {
        let scene = TestScene::random(seed);
        let focal_px = (camera == Camera::Known).then_some(scene.focal_px);
        let mut table = Table::new();
        for (what, mut made) in make(&SceneDepth::new(&scene)) {
            degrade(&mut made.samples, precision, seed);
            for finding in findings(&made, focal_px) {
                let found = name(&finding.problem).to_owned();
                *table.entry((what, found)).or_default() += 1;
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

fn expect_no_finding(scenes: Range<u64>, precision: Precision, camera: Camera) {
    let found = tally(scenes, valid_passes, precision, camera);
    assert!(found.is_empty(), "{precision:?}, {camera:?}: {found:?}");
}

fn expect_findings(scenes: Range<u64>, precision: Precision, camera: Camera, column: usize) {
    let count = (scenes.end - scenes.start) as u32;
    let found = tally(scenes, wrong_passes, precision, camera);
    for (what, finding, least) in WANTED {
        let key = (what, finding.to_owned());
        let hits = found.get(&key).copied().unwrap_or(0);
        let wanted = least[column] * count / 100;
        assert!(
            hits >= wanted,
            "{precision:?}, {camera:?}, {what}: {hits}; {found:?}"
        );
    }
}

#[test]
fn valid_passes_give_no_finding() {
    expect_no_finding(0..7, Precision::Float, Camera::Known);
    expect_no_finding(7..9, Precision::Float, Camera::Unknown);
}

#[test]
fn valid_half_floats_and_noise_give_no_finding() {
    for (first, precision) in [
        (500, Precision::Half),
        (503, Precision::Noisy(0.001)),
        (506, Precision::Noisy(0.01)),
    ] {
        expect_no_finding(first..first + 2, precision, Camera::Known);
        expect_no_finding(first + 2..first + 3, precision, Camera::Unknown);
    }
}

#[test]
fn wrong_passes_give_their_finding() {
    expect_findings(0..4, Precision::Float, Camera::Known, 0);
    expect_findings(4..6, Precision::Float, Camera::Unknown, 0);
    expect_findings(6..9, Precision::Half, Camera::Known, 1);
}

#[test]
#[ignore = "minutes long: many scenes"]
fn many_scenes_give_the_right_findings() {
    for (scenes, precision, camera, column) in [
        (0..200, Precision::Float, Camera::Known, 0),
        (0..50, Precision::Float, Camera::Unknown, 0),
        (0..50, Precision::Half, Camera::Known, 1),
    ] {
        expect_no_finding(scenes.clone(), precision, camera);
        expect_findings(scenes, precision, camera, column);
    }
    for precision in [
        Precision::Half,
        Precision::Noisy(0.001),
        Precision::Noisy(0.01),
    ] {
        for camera in [Camera::Known, Camera::Unknown] {
            expect_no_finding(500..520, precision, camera);
        }
    }
    coverage(0..20);
}

/// Returns coverage, filtered depth and nearest depth of objects before an empty background, from 4 x 4 samples per
/// pixel.
fn supersampled(scene: &TestScene) -> [Vec<f32>; 3] {
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
fn depth_times_coverage_is_found_at_edges_and_clean_depth_is_not() {
    coverage(0..4);
}

fn coverage(scenes: Range<u64>) {
    for seed in scenes {
        let scene = TestScene::balls(seed);
        let [alpha, mixed, nearest] = supersampled(&scene);
        let opaque = vec![1.0; alpha.len()];
        for (samples, is_mixed) in [(mixed, true), (nearest, false)] {
            for alpha in [Some(&alpha), None, Some(&opaque)] {
                let made = TestPass {
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
    // One depth per row, evenly spaced in its reciprocal, and flat cards: few levels without a flaw.
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
    let made = TestPass {
        samples: samples.collect(),
        convention: METRES,
        alpha: None,
    };
    assert_eq!(findings(&made, Some(300.0)), []);
}

#[test]
fn empty_passes_are_found_and_wrong_sizes_refused() {
    let mut samples = vec![f32::INFINITY; SIZE.0 * SIZE.1];
    samples[7] = 2.0;
    let mut made = TestPass {
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
        colours: &[],
        alpha: None,
        view: CameraPerspective {
            axis: TestScene::axis(),
            focal_px: None,
            pixel_aspect: 1.0,
        },
        lens: LensDistances::default(),
    };
    assert!(check.findings().is_err());
}

#[test]
fn a_constant_depth_is_named_with_the_digits_of_its_samples() {
    let problem = DepthProblem::Constant {
        value: f64::from(1.4_f32),
    };
    let text = problem.to_string();
    assert_eq!(text, "is constant: 1.4 in every pixel that has a depth");
}
