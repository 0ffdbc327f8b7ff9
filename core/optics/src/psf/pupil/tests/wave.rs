//! Diffraction PSFs against the Airy pattern, direct summation of the diffraction integral, and rays.

use std::f64::consts::{PI, TAU};

use super::super::*;
use crate::field::FieldPoint;
use crate::lens::{ReducedNumbers, Transmission};

fn drawn(pupil: &LocalPupil, corner: (f64, f64), size: (usize, usize)) -> Vec<f64> {
    let mut out = PsfImage::default();
    let space = &mut Workspace::default();
    let grid = TileGrid {
        corner_px: [corner.0, corner.1],
        width: size.0,
        height: size.1,
    };
    draw(pupil, &grid, &[], Detail::FULL, space, &mut out);
    out.light
}

/// Returns `pupil` with diffraction of scale `q`.
fn diffracting(q: f64, mut pupil: LocalPupil) -> LocalPupil {
    pupil.wave_px = q;
    pupil
}

fn focused(q: f64) -> LocalPupil {
    diffracting(q, LocalPupil::circular(Wavefront::default(), 0.0))
}

/// Returns a pupil with all aberrations, two more stops, uneven transmission and a squeeze.
fn difficult(q: f64, size: f64) -> LocalPupil {
    let numbers = ReducedNumbers {
        alpha: size,
        beta: 0.3 * size,
        gamma: -0.5 * size,
        delta: 0.2 * size,
        phi: 0.25 * size,
    };
    let at = FieldPoint::new(0.8, 0.5);
    let mut pupil = LocalPupil::circular(Wavefront::third_order(&numbers, at), 0.0);
    pupil.clip(Stop {
        centre: [0.35, 0.2],
        radius: 1.02,
    });
    pupil.clip(Stop {
        centre: [-0.3, 0.25],
        radius: 0.95,
    });
    pupil.wave_px = q;
    pupil.transmission = Transmission {
        picture: None,
        square: 0.6,
        fourth: -0.2,
        centre: [0.2, -0.1],
    };
    pupil.squeeze = [1.0, 0.8];
    pupil
}

/// Returns the Bessel function J1, by its integral.
fn bessel(v: f64) -> f64 {
    let count = 200;
    let phase = |k: usize| PI * (k as f64 + 0.5) / count as f64;
    let sum: f64 = (0..count)
        .map(|k| (phase(k) - v * phase(k).sin()).cos())
        .sum();
    sum / count as f64
}

/// Abscissae and weights of the five-point Gauss-Legendre rule on a pixel.
const GAUSS: [(f64, f64); 5] = [
    (-0.453_089_922_969_332, 0.118_463_442_528_094_54),
    (-0.269_234_655_052_841_55, 0.239_314_335_249_683_24),
    (0.0, 0.284_444_444_444_444_4),
    (0.269_234_655_052_841_55, 0.239_314_335_249_683_24),
    (0.453_089_922_969_332, 0.118_463_442_528_094_54),
];

/// Returns the integral of `density` over the pixel about (`x`, `y`).
fn over_pixel(x: f64, y: f64, density: &dyn Fn(f64, f64) -> f64) -> f64 {
    let mut sum = 0.0;
    for (dx, a) in GAUSS {
        for (dy, b) in GAUSS {
            sum += a * b * density(x + dx, y + dy);
        }
    }
    sum
}

/// Returns the largest difference over the largest value.
fn off(got: &[f64], want: &[f64]) -> f64 {
    let peak = want.iter().copied().fold(0.0, f64::max);
    let pairs = got.iter().zip(want);
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / peak
}

/// Returns the squared difference over the squared light.
fn energy(got: &[f64], want: &[f64]) -> f64 {
    let pairs = got.iter().zip(want);
    let error: f64 = pairs.map(|(a, b)| (a - b).powi(2)).sum();
    error / want.iter().map(|v| v * v).sum::<f64>()
}

#[test]
fn a_point_in_focus_is_the_airy_pattern() {
    for q in [1.0, 1.7, 3.0, 9.0] {
        let side = 33;
        let corner = (-16.3, -16.6);
        let light = drawn(&focused(q), corner, (side, side));
        let airy = |x: f64, y: f64| {
            let v = TAU * x.hypot(y) / q;
            let size = if v < 1e-9 { 1.0 } else { 2.0 * bessel(v) / v };
            PI / (q * q) * size * size
        };
        let want: Vec<f64> = (0..side * side)
            .map(|k| {
                let at = |k: usize, corner: f64| k as f64 + 0.5 + corner;
                over_pixel(at(k % side, corner.0), at(k / side, corner.1), &airy)
            })
            .collect();
        assert!(off(&light, &want) < 2e-3, "{q}: {}", off(&light, &want));
        assert!(energy(&light, &want) < 1e-5);
    }
}

#[test]
fn the_airy_disc_holds_its_share() {
    let q = 40.0;
    let side = 65;
    let light = drawn(&focused(q), (-32.5, -32.5), (side, side));
    let ring = 0.609_834 * q;
    let inside = |k: &usize| {
        let (x, y) = ((k % side) as f64 - 32.0, (k / side) as f64 - 32.0);
        x.hypot(y) < ring
    };
    let sum: f64 = (0..side * side).filter(inside).map(|k| light[k]).sum();
    assert!((sum - 0.8378).abs() < 2e-3, "{sum}");
}

#[test]
fn light_outside_the_tile_is_that_of_the_skirts() {
    for (q, side) in [(0.3, 65), (1.0, 33), (3.0, 65), (2.0, 129)] {
        let half = side as f64 / 2.0;
        let light: f64 = drawn(&focused(q), (-half, -half), (side, side))
            .iter()
            .sum();
        // A box of half width r leaves out 0.0912 q / r of the light; nothing is drawn beyond 40 q.
        let lost = 0.0912 * q / half.min(40.0 * q);
        assert!((1.0 - light - lost).abs() < 0.1 * lost + 3e-4);
    }
}

/// Returns the light of the pixel about (`x`, `y`) px from the chief ray, by direct summation over the pupil.
fn summed(pupil: &LocalPupil, x: f64, y: f64) -> f64 {
    let (angles, radii) = (480, 160);
    let (centre, _) = pupil.inscribed_circle();
    let mut samples = Vec::new();
    let mut light = 0.0;
    for a in 0..angles {
        let (sin, cos) = (TAU * (f64::from(a) + 0.5) / f64::from(angles)).sin_cos();
        let reach = pupil.edge(centre, cos, sin).0;
        for r in 0..radii {
            let r = (f64::from(r) + 0.5) / f64::from(radii) * reach;
            let u = [centre[0] + r * cos, centre[1] + r * sin];
            let area = r * reach / f64::from(radii) * TAU / f64::from(angles);
            let passing = pupil.transmission.at(u);
            light += area * passing;
            samples.push((u, area * passing.sqrt(), pupil.wavefront.height(u)));
        }
    }
    let q = pupil.wave_px;
    let [sx, sy] = pupil.squeeze;
    over_pixel(x, y, &|x, y| {
        let mut field = [0.0; 2];
        for (u, size, height) in &samples {
            let phase = TAU * (height - u[0] * x / sx - u[1] * y / sy) / q;
            let (sin, cos) = phase.sin_cos();
            field[0] += size * cos;
            field[1] += size * sin;
        }
        (field[0] * field[0] + field[1] * field[1]) / (q * q * sx * sy * light)
    })
}

#[test]
fn direct_summation_of_the_integral_agrees() {
    for (q, size) in [(1.0, 3.0), (2.5, 5.0)] {
        let pupil = difficult(q, size);
        let side = 25;
        let corner = (-12.3, -12.8);
        let light = drawn(&pupil, corner, (side, side));
        let peak = light.iter().copied().fold(0.0, f64::max);
        let brightest = light.iter().position(|v| *v == peak).unwrap_or(0);
        let places = [
            brightest,
            brightest + 1,
            brightest + side,
            12 * side + 12,
            7 * side + 14,
            3 * side + 20,
        ];
        for k in places {
            let (x, y) = (
                (k % side) as f64 + 0.5 + corner.0,
                (k / side) as f64 + 0.5 + corner.1,
            );
            let want = summed(&pupil, x, y);
            assert!(
                (light[k] - want).abs() < 2e-3 * peak,
                "{k}: {} {want}",
                light[k]
            );
        }
    }
}

#[test]
fn large_aberrations_agree_with_rays() {
    let side = 49;
    let corner = (-24.2, -24.7);
    for (q, blur, most) in [(0.3, 0.5, 6e-3), (0.15, 0.5, 3e-3)] {
        let numbers = ReducedNumbers {
            alpha: 12.0,
            phi: 1.0,
            ..ReducedNumbers::default()
        };
        let at = FieldPoint::new(0.6, 0.3);
        let rays = LocalPupil::circular(Wavefront::third_order(&numbers, at), blur);
        let waves = diffracting(q, rays.clone());
        let (a, b) = (
            drawn(&waves, corner, (side, side)),
            drawn(&rays, corner, (side, side)),
        );
        assert!(energy(&a, &b) < most, "{q}: {}", energy(&a, &b));
        let mut hard = difficult(q, 12.0);
        hard.blur_variance_px2 = blur;
        let rays = diffracting(0.0, hard.clone());
        let (a, b) = (
            drawn(&hard, corner, (side, side)),
            drawn(&rays, corner, (side, side)),
        );
        assert!(energy(&a, &b) < 2.0 * most, "{q}: {}", energy(&a, &b));
    }
}

#[test]
fn finer_pixels_sum_to_coarse_ones() {
    // Four pixels at twice the resolution sum to one pixel.
    let pupil = difficult(1.3, 4.0).blurred_by(0.1);
    let corner = (-11.37, -9.81);
    let coarse = drawn(&pupil, corner, (23, 21));
    let fine = drawn(
        &pupil.rescaled(2.0),
        (2.0 * corner.0, 2.0 * corner.1),
        (46, 42),
    );
    let sums: Vec<f64> = (0..23 * 21)
        .map(|k| {
            let (x, y) = (2 * (k % 23), 2 * (k / 23));
            let row = |y: usize| fine[y * 46 + x] + fine[y * 46 + x + 1];
            row(y) + row(y + 1)
        })
        .collect();
    assert!(off(&sums, &coarse) < 1e-3, "{}", off(&sums, &coarse));
    // A shift of the grid by one pixel shifts the samples.
    let moved = drawn(&pupil, (corner.0 + 1.0, corner.1), (22, 21));
    for (k, v) in moved.iter().enumerate() {
        let before = coarse[k / 22 * 23 + k % 22 + 1];
        assert!((v - before).abs() < 3e-5, "{k}: {v} {before}");
    }
}

#[test]
fn the_centroid_is_that_of_the_rays() {
    let numbers = ReducedNumbers {
        alpha: 4.0,
        phi: 2.5,
        gamma: 2.0,
        ..ReducedNumbers::default()
    };
    let at = FieldPoint::new(0.6, 0.3);
    let rays = LocalPupil::circular(Wavefront::third_order(&numbers, at), 0.0);
    let waves = diffracting(1.5, rays.clone());
    let c = rays.centroid();
    let side = 161;
    let half = side as f64 / 2.0;
    let light = drawn(&waves, (c[0] - half, c[1] - half), (side, side));
    let mean = |place: &dyn Fn(usize) -> usize| -> f64 {
        let sum: f64 = light.iter().sum();
        let moment = |(k, v): (usize, &f64)| v * (place(k) as f64 + 0.5 - half);
        light.iter().enumerate().map(moment).sum::<f64>() / sum
    };
    let (x, y) = (mean(&|k| k % side), mean(&|k| k / side));
    assert!(x.abs() < 0.02 && y.abs() < 0.02, "{x} {y}");
}

#[test]
#[should_panic(expected = "derivatives")]
fn diffraction_has_no_derivatives() {
    let derivative = PupilDerivative::from_wavefront(Wavefront::tilt(1.0, 0.0));
    let (mut space, mut out) = (Workspace::default(), PsfImage::default());
    let grid = TileGrid {
        corner_px: [-2.5, -2.5],
        width: 5,
        height: 5,
    };
    draw(
        &focused(1.0),
        &grid,
        &[derivative],
        Detail::FIT,
        &mut space,
        &mut out,
    );
}

/// A period that holds such rays would take gigabytes.
#[test]
fn rays_over_thousands_of_pixels_do_not_diffract() {
    let numbers = ReducedNumbers {
        alpha: 20_000.0,
        ..ReducedNumbers::default()
    };
    let at = FieldPoint::new(0.8, 0.5);
    let disc = LocalPupil::circular(Wavefront::third_order(&numbers, at), 0.0);
    let of_rays = drawn(&disc, (-4.0, -4.0), (8, 8));
    let of_waves = drawn(&diffracting(2.0, disc), (-4.0, -4.0), (8, 8));
    assert!(of_rays[0] > 0.0);
    assert!(off(&of_waves, &of_rays) < 0.02 * of_rays[0]);
}
