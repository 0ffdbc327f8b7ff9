//! Fits to edges of a lens that the tests trace themselves.

use seidel_optics::camera::Camera;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::edges::{Edge, EdgeSet, ProfileBin};
use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
use seidel_optics::no_progress;
use seidel_optics::numeric::SplitMix64;
use seidel_optics::psf::normal_cdf;

use super::{EdgeFitSettings, fit_edges};
use crate::fit::AxisChoice;

const WIDTH: u32 = 600;
const HEIGHT: u32 = 400;
/// Rays of a point.
const RAYS: usize = 500;
/// Variance of the symmetric blur, px².
const BLUR: f64 = 0.3;

/// A traced lens: third order, a cat's eye, and its axis.
#[derive(Clone, Copy)]
struct Traced {
    alpha: f64,
    beta: f64,
    gamma: f64,
    delta: f64,
    phi: f64,
    cut: f64,
    axis: [f64; 2],
}

const LENS: Traced = Traced {
    alpha: 2.4,
    beta: 1.4,
    gamma: -2.0,
    delta: 1.1,
    phi: 0.8,
    cut: 0.25,
    axis: [309.0, 195.0],
};

impl Traced {
    /// Returns the landing points of rays from their centroid for a point whose image is at `at`.
    fn rays(&self, at: [f64; 2]) -> Vec<[f64; 2]> {
        let half = f64::from(WIDTH) / 2.0;
        let h = [0, 1].map(|k| (at[k] - self.axis[k]) / half);
        let h2 = h[0] * h[0] + h[1] * h[1];
        let mut rays = Vec::new();
        for k in 0..RAYS {
            let radius = ((k as f64 + 0.5) / RAYS as f64).sqrt();
            let (sin, cos) = (2.399_963_229_728_653 * k as f64).sin_cos();
            let u = [radius * cos, radius * sin];
            // A second rim moves over the pupil.
            let rim = [0, 1].map(|a| u[a] + self.cut * h[a]);
            if rim[0].hypot(rim[1]) > 1.08 {
                continue;
            }
            let (u2, along) = (radius * radius, h[0] * u[0] + h[1] * u[1]);
            let round = self.alpha + self.beta * u2 + self.delta * h2;
            rays.push([0, 1].map(|a| {
                round * u[a] + self.gamma * h[a] * along
                    - self.phi * (u2 * h[a] + 2.0 * along * u[a])
            }));
        }
        let count = rays.len() as f64;
        let mean = [0, 1].map(|a| rays.iter().map(|r| r[a]).sum::<f64>() / count);
        rays.iter_mut()
            .for_each(|r| *r = [r[0] - mean[0], r[1] - mean[1]]);
        rays
    }

    /// Returns the second and third moments of the rays along `normal`, the blur included.
    fn moments(&self, at: [f64; 2], normal: [f64; 2]) -> [f64; 2] {
        let rays = self.rays(at);
        let mean = |n: i32| {
            let along = rays
                .iter()
                .map(|r| (r[0] * normal[0] + r[1] * normal[1]).powi(n));
            along.sum::<f64>() / rays.len() as f64
        };
        [mean(2) + BLUR, mean(3)]
    }
}

/// Returns edges of two orientations on a grid, measured in bins of half a pixel with noise.
fn edges(lens: Traced, distance: ObjectDistance, random: &mut SplitMix64) -> Vec<Edge> {
    let mut edges = Vec::new();
    for k in 0..12 * 8 * 2 {
        let place = k / 2;
        let at = [
            25.0 + 50.0 * f64::from(place % 12) + 4.0 * random.unit(),
            25.0 + 50.0 * f64::from(place / 12) + 4.0 * random.unit(),
        ];
        let angle = 0.15 + f64::from(k % 4) * std::f64::consts::FRAC_PI_2;
        let normal = [angle.cos(), angle.sin()];
        let rays = lens.rays(at);
        let sigma = 0.002;
        let profile = (-20..20).map(|bin| {
            let t = 0.5 * f64::from(bin) + 0.25;
            let spread = 1.0 / 48.0;
            let width = (BLUR + 1.0 / 12.0 + spread).sqrt();
            let level = rays.iter().map(|r| {
                let along = r[0] * normal[0] + r[1] * normal[1];
                normal_cdf((t - 0.1 - along) / width)
            });
            let radius = (-2.0 * (1.0 - random.unit()).ln()).sqrt();
            let noise = radius * (std::f64::consts::TAU * random.unit()).cos();
            ProfileBin {
                t_px: t,
                level: level.sum::<f64>() / rays.len() as f64 * (1.0 + 0.001 * t) + sigma * noise,
                sigma,
                spread_px2: spread,
            }
        });
        let profile = profile.collect();
        let [variance, third] = lens.moments(at, normal);
        edges.push(Edge {
            source: "traced".to_owned(),
            index: k as usize,
            channel: 0,
            distance,
            mid: ImagePoint::new(at[0], at[1]),
            normal,
            length_px: 20.0,
            levels: [0.0, 1000.0],
            variance_px2: variance + 0.02 * (random.unit() - 0.5),
            variance_sigma: 0.01,
            third_px3: third + 0.1 * (random.unit() - 0.5),
            third_sigma: 0.05,
            profile,
        });
    }
    edges
}

fn set(edges: Vec<Edge>) -> EdgeSet {
    EdgeSet {
        frame: Frame::new(WIDTH, HEIGHT, None).expect("valid"),
        channels: vec!["Y".to_owned()],
        pixel_pitch_um: None,
        camera: Camera::default(),
        edges,
    }
}

/// Returns the largest error of second moments over the field, relative to the mean variance, of a fit against `lens`.
fn worst_error(fit: &super::EdgeFit, lens: Traced, vergence: f64) -> f64 {
    let (mut worst, mut mean) = (0.0_f64, 0.0);
    let frame = fit.lens.frame;
    for k in 0..15 {
        let at = [
            60.0 + 120.0 * f64::from(k % 5),
            65.0 + 130.0 * f64::from(k / 5),
        ];
        let place: FieldPoint = frame.field_point(ImagePoint::new(at[0], at[1]));
        let got = fit.lens.pupil_channels()[0].moments_at(place, vergence);
        let [xx, _] = lens.moments(at, [1.0, 0.0]);
        let [yy, _] = lens.moments(at, [0.0, 1.0]);
        worst = worst.max((got.mu20 - xx).abs()).max((got.mu02 - yy).abs());
        mean += (xx + yy) / 30.0;
    }
    worst / mean
}

#[test]
fn edges_of_two_orientations_give_the_lens_its_axis_and_its_cats_eye() {
    let mut random = SplitMix64::new(5);
    let set = set(edges(LENS, ObjectDistance::Unknown, &mut random));
    let settings = EdgeFitSettings {
        axis: AxisChoice::Free,
    };
    let fit = fit_edges(&set, &settings, &no_progress).expect("determined");
    let axis = fit.lens.frame.axis();
    let off = (axis.x_px - LENS.axis[0]).hypot(axis.y_px - LENS.axis[1]);
    assert!(off < 2.0, "{axis:?}");
    let error = worst_error(&fit, LENS, 0.0);
    assert!(error < 0.02, "{error} {fit:?}");
    assert!(fit.chi2 < 1.3, "{}", fit.chi2);
}

#[test]
fn two_distances_give_defocus_on_both_sides_of_focus() {
    let mut random = SplitMix64::new(6);
    let far = Traced {
        alpha: -1.6,
        cut: 0.0,
        ..LENS
    };
    let near = Traced { cut: 0.0, ..LENS };
    let mut all = edges(near, ObjectDistance::Metres(1.0), &mut random);
    all.extend(edges(far, ObjectDistance::Metres(4.0), &mut random));
    let settings = EdgeFitSettings {
        axis: AxisChoice::At(ImagePoint::new(LENS.axis[0], LENS.axis[1])),
    };
    let fit = fit_edges(&set(all), &settings, &no_progress).expect("determined");
    for (lens, vergence) in [(near, 1.0), (far, 0.25)] {
        let error = worst_error(&fit, lens, vergence);
        assert!(error < 0.02, "{vergence}: {error} {fit:?}");
    }
    let alpha = &fit.lens.pupil_channels()[0].alpha;
    assert!((alpha.at(1.0) - 2.4).abs() < 0.1 && (alpha.at(0.25) + 1.6).abs() < 0.1);
}

#[test]
fn too_few_edges_and_mixed_distances_are_refused() {
    let mut random = SplitMix64::new(7);
    let mut some = edges(LENS, ObjectDistance::Metres(2.0), &mut random);
    some[3].distance = ObjectDistance::Unknown;
    let settings = EdgeFitSettings::default();
    let error = fit_edges(&set(some.clone()), &settings, &no_progress).expect_err("mixed");
    assert!(error.to_string().contains("depth_m"), "{error}");
    some.truncate(3);
    let error = fit_edges(&set(some), &settings, &no_progress).expect_err("few");
    assert!(error.to_string().contains("channel Y"), "{error}");
}
