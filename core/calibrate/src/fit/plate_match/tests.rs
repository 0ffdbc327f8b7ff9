//! Matches to variances of edges that the tests draw themselves.

use seidel_optics::camera::Camera;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::edges::{Edge, EdgeSet, ProfileBin};
use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
use seidel_optics::numeric::SplitMix64;

use super::*;

const FRAME: [u32; 2] = [640, 420];
/// S1..S5 of the channels.
const LENS: [[f64; 5]; 2] = [[2.9, 0.8, -0.6, 0.4, 0.5], [3.6, 0.7, -0.4, 0.5, 0.4]];
/// Stated over true errors.
const OVERSTATED: f64 = 1.4;

/// The blur that the scene of a plate adds.
#[derive(Clone, Copy)]
struct SceneBlur {
    /// Share of sharp edges.
    sharp: f64,
    /// Mean and least variance of the others, px².
    mean: f64,
    least: f64,
}

/// Returns the variance along `normal` at `at`.
fn variance(s: &[f64; 5], at: FieldPoint, [nx, ny]: [f64; 2]) -> f64 {
    let (r2, along) = (at.x * at.x + at.y * at.y, at.x * nx + at.y * ny);
    s[0] + s[2] * r2 + s[4] * r2 * r2 + (s[1] + s[3] * r2) * along * along
}

fn plate(count: usize, scene: SceneBlur, seed: u64) -> EdgeSet {
    let mut random = SplitMix64::new(seed);
    let frame = Frame::new(FRAME[0], FRAME[1], None).expect("valid");
    let mut edges = Vec::new();
    for index in 0..count {
        let at = FRAME.map(|side| f64::from(side) * random.unit());
        let mid = ImagePoint::new(at[0], at[1]);
        let (sin, cos) = (std::f64::consts::TAU * random.unit()).sin_cos();
        let soft = scene.least - (scene.mean - scene.least) * (1.0 - random.unit()).ln();
        let own = if random.unit() < scene.sharp {
            0.0
        } else {
            soft
        };
        for (channel, s) in LENS.iter().enumerate() {
            let true_variance = variance(s, frame.field_point(mid), [cos, sin]) + own;
            let sigma = 0.05 * true_variance + 0.05 + 0.05 * random.unit();
            let radius = (-2.0 * (1.0 - random.unit()).ln()).sqrt();
            let noise = radius * (std::f64::consts::TAU * random.unit()).cos();
            let bin = |k: i32| ProfileBin {
                t_px: f64::from(k),
                level: 0.5,
                sigma: 0.01,
                spread_px2: 0.02,
            };
            edges.push(Edge {
                source: "plate.dng".to_owned(),
                index,
                channel,
                distance: ObjectDistance::Unknown,
                mid,
                normal: [cos, sin],
                length_px: 20.0,
                levels: [100.0, 900.0],
                variance_px2: true_variance + sigma * noise,
                variance_sigma: OVERSTATED * sigma,
                third_px3: 0.0,
                third_sigma: 1.0,
                profile: (-5..6).map(bin).collect(),
            });
        }
    }
    EdgeSet {
        frame,
        channels: vec!["G".to_owned(), "R".to_owned()],
        pixel_pitch_um: None,
        camera: Camera::default(),
        edges,
    }
}

const SETTINGS: MatchSettings = MatchSettings {
    axis: AxisChoice::AsObserved,
    reference: 0,
    shared_error_px2: 0.0,
    seed: 1,
};

/// Returns the moments of a plate and their intervals, without the rays.
fn matched(set: &EdgeSet) -> Result<(Matched, Vec<MatchedChannel>)> {
    let matched = Matched::new(set, &[], set.frame, &SETTINGS)?;
    let intervals =
        bootstrap::intervals(&matched.samples, &matched.moments, &set.frame, &SETTINGS)?;
    let channels = channels(set, &matched, &intervals);
    Ok((matched, channels))
}

#[test]
fn plates_with_sharp_edges_give_the_lens_within_the_intervals() {
    let scene = SceneBlur {
        sharp: 0.4,
        mean: 2.0,
        least: 0.0,
    };
    let (mut inside, mut all) = (0, 0);
    for seed in 1..6 {
        let set = plate(300, scene, seed);
        let (matched, channels) = matched(&set).expect("enough edges");
        matched.refuse_uncertain(&channels).expect("sharp edges");
        let scale = matched.moments.mixture.noise_scale * OVERSTATED;
        assert!((scale - 1.0).abs() < 0.25, "{scale}");
        let sharp = matched.sharp() / 300.0;
        assert!((sharp - 0.4).abs() < 0.15, "{sharp}");
        let grid = bootstrap::Grid::of(&set.frame);
        for (k, channel) in channels.iter().enumerate() {
            let found = &matched.moments.s[k];
            let error = grid.rms(found, &LENS[k]) / grid.mean(&LENS[k]);
            assert!(error < 0.05, "{seed} {k}: {error}");
            let mut check = |estimate: Estimate, truth: f64| {
                all += 1;
                inside += i32::from((estimate.value - truth).abs() <= estimate.half_width);
            };
            check(channel.variance_px2, grid.mean(&LENS[k]));
            check(channel.field_px2, grid.corner_less_axis(&LENS[k]));
            let difference = grid.mean(&LENS[k]) - grid.mean(&LENS[0]);
            check(channel.difference_px2, difference);
        }
    }
    assert!(
        f64::from(inside) >= 0.85 * f64::from(all),
        "{inside} of {all}"
    );
}

#[test]
fn differences_between_channels_do_not_need_sharp_edges() {
    let scene = SceneBlur {
        sharp: 0.0,
        mean: 3.0,
        least: 0.8,
    };
    let set = plate(300, scene, 3);
    let (matched, channels) = matched(&set).expect("enough edges");
    let grid = bootstrap::Grid::of(&set.frame);
    let truth = grid.mean(&LENS[1]) - grid.mean(&LENS[0]);
    let Estimate { value, half_width } = channels[1].difference_px2;
    assert!(
        half_width < 0.2 && (value - truth).abs() < 0.2,
        "{value} {half_width} {truth}"
    );
    let error = matched
        .refuse_uncertain(&channels)
        .expect_err("no sharp edges");
    let text = error.to_string();
    assert!(
        text.contains("no sharp edges stand out") && text.contains("R less G: 0."),
        "{text}"
    );
}

#[test]
fn fewer_edges_than_a_match_needs_are_refused() {
    let scene = SceneBlur {
        sharp: 1.0,
        mean: 1.0,
        least: 0.0,
    };
    let set = plate(99, scene, 5);
    let error = match_plate(&set, &[], &SETTINGS, &seidel_optics::no_progress).expect_err("few");
    assert!(error.to_string().contains("99 edges and lights"), "{error}");
}

#[test]
fn lights_count_as_edges_of_all_directions() {
    let scene = SceneBlur {
        sharp: 0.5,
        mean: 2.0,
        least: 0.0,
    };
    let set = plate(90, scene, 7);
    let (mut random, mut noise) = (SplitMix64::new(9), SplitMix64::new(10));
    let lights: Vec<PlateLight> = (0..60)
        .map(|_| {
            let at = FRAME.map(|side| f64::from(side) * random.unit());
            let at = ImagePoint::new(at[0], at[1]);
            let mut of = |s: &[f64; 5]| {
                let place = set.frame.field_point(at);
                let sum: f64 = [[1.0, 0.0], [0.0, 1.0]]
                    .map(|n| variance(s, place, n))
                    .iter()
                    .sum();
                // Uniform errors of the stated standard deviation.
                Some([sum / 2.0 + 0.1 * 12_f64.sqrt() * (noise.unit() - 0.5), 0.1])
            };
            PlateLight {
                at,
                variances: LENS.iter().map(&mut of).collect(),
            }
        })
        .collect();
    let matched = Matched::new(&set, &lights, set.frame, &SETTINGS).expect("150 together");
    let grid = bootstrap::Grid::of(&set.frame);
    let error = grid.rms(&matched.moments.s[0], &LENS[0]) / grid.mean(&LENS[0]);
    assert!(matched.count == 150 && error < 0.05, "{error}");
}
