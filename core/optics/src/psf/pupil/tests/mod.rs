//! The pupil PSF against histograms of millions of rays, closed forms and numeric derivatives.

mod obstruction;
mod optical_psf;
mod wave;

use super::*;
use crate::field::FieldPoint;
use crate::lens::ReducedNumbers;
use crate::numeric::SplitMix64;

/// Returns the histogram over pixels of `count` evenly distributed rays; `shift` offsets the sequence.
fn histogram(
    pupil: &LocalPupil,
    corner: (f64, f64),
    side: usize,
    count: usize,
    shift: f64,
) -> Vec<f64> {
    // The R2 low-discrepancy sequence of the plastic number, mapped to the disc by area.
    let g: f64 = 1.324_717_957_244_746;
    let (a, b) = (1.0 / g, 1.0 / (g * g));
    let (mut s, mut t) = (shift, (shift * 7.3).fract());
    let mut bins = vec![0.0; side * side];
    let mut passed = 0.0;
    for _ in 0..count {
        (s, t) = ((s + a).fract(), (t + b).fract());
        let (sin, cos) = (std::f64::consts::TAU * t).sin_cos();
        let r = f64::sqrt(s);
        let u = [r * cos, r * sin];
        if !pupil.passes(u) {
            continue;
        }
        passed += 1.0;
        let p = pupil.wavefront.slope(u);
        let (x, y) = ((p[0] - corner.0).floor(), (p[1] - corner.1).floor());
        if x >= 0.0 && y >= 0.0 && x < side as f64 && y < side as f64 {
            bins[y as usize * side + x as usize] += 1.0;
        }
    }
    bins.iter_mut().for_each(|v| *v /= passed);
    bins
}

/// Returns the light over the error of `drawn`, dB, relative to two independent ray histograms.
///
/// The product of the two differences is free of the noise of the histograms.
fn decibels(counts: &[Vec<f64>; 2], drawn: &[f64]) -> f64 {
    let error: f64 = (0..drawn.len())
        .map(|k| (counts[0][k] - drawn[k]) * (counts[1][k] - drawn[k]))
        .sum();
    let light: f64 = counts[0].iter().zip(&counts[1]).map(|(a, b)| a * b).sum();
    10.0 * (light / error.abs().max(1e-30)).log10()
}

fn random_lens(random: &mut SplitMix64, radius: f64) -> (ReducedNumbers, FieldPoint) {
    let mut signed = |size: f64| (2.0 * random.unit() - 1.0) * size;
    let numbers = ReducedNumbers {
        alpha: signed(radius),
        beta: signed(radius / 2.0),
        gamma: signed(radius / 2.0),
        delta: signed(radius / 2.0),
        phi: signed(radius / 4.0),
    };
    (numbers, FieldPoint::new(signed(1.0), signed(0.7)))
}

fn clipped(numbers: &ReducedNumbers, at: FieldPoint, blur: f64) -> LocalPupil {
    let mut pupil = LocalPupil::circular(Wavefront::third_order(numbers, at), blur);
    pupil.clip(Stop {
        centre: [0.6 * at.x, 0.6 * at.y],
        radius: 1.05,
    });
    pupil.clip(Stop {
        centre: [-0.4 * at.x, -0.4 * at.y],
        radius: 0.95,
    });
    pupil
}

fn square(corner: (f64, f64), side: usize) -> TileGrid {
    TileGrid {
        corner_px: [corner.0, corner.1],
        width: side,
        height: side,
    }
}

fn drawn(pupil: &LocalPupil, corner: (f64, f64), side: usize) -> PsfImage {
    let mut out = PsfImage::default();
    let space = &mut Workspace::default();
    draw(
        pupil,
        &square(corner, side),
        &[],
        Detail::FULL,
        space,
        &mut out,
    );
    out
}

/// Returns the lowest signal-to-error ratio (dB) over random lenses on tiles of `side` px, for two histograms of `rays`.
fn against_rays(side: usize, lenses: usize, rays: usize) -> f64 {
    let mut random = SplitMix64::new(side as u64);
    let mut worst = f64::INFINITY;
    for _ in 0..lenses {
        let (numbers, at) = random_lens(&mut random, side as f64 / 5.0);
        let pupil = if random.unit() > 0.5 {
            clipped(&numbers, at, 0.0)
        } else {
            LocalPupil::circular(Wavefront::third_order(&numbers, at), 0.0)
        };
        let centroid = pupil.centroid();
        let half = side as f64 / 2.0 + random.unit() - 0.5;
        let corner = (centroid[0] - half, centroid[1] - half);
        let counts = [0.31, 0.77].map(|s| histogram(&pupil, corner, side, rays, s));
        let db = decibels(&counts, &drawn(&pupil, corner, side).light);
        worst = worst.min(db);
    }
    worst
}

#[test]
fn histograms_of_a_million_rays_agree() {
    assert!(against_rays(17, 3, 1_000_000) > 68.0);
    assert!(against_rays(33, 2, 3_000_000) > 68.0);
}

#[test]
#[ignore = "a minute; the figures of docs/background/evaluation.md"]
fn ten_million_rays_agree() {
    for side in [33, 49, 65, 97, 129] {
        assert!(against_rays(side, 8, 10_000_000) > 70.0);
    }
}

#[test]
fn light_is_one_and_moments_are_those_of_the_closed_forms() {
    let mut random = SplitMix64::new(5);
    for blur in [0.0, 0.4] {
        for radius in [0.2, 3.0, 12.0] {
            let (numbers, at) = random_lens(&mut random, radius);
            let pupil = LocalPupil::circular(Wavefront::third_order(&numbers, at), blur);
            let side = (6.0 * radius) as usize + 21;
            let c = pupil.centroid();
            let corner = (c[0] - side as f64 / 2.0 - 0.3, c[1] - side as f64 / 2.0);
            let light = drawn(&pupil, corner, side).light;
            assert!((light.iter().sum::<f64>() - 1.0).abs() < 1e-6);
            let samples = light.iter().map(|v| *v as f32).collect();
            let tile = crate::tile::Tile::new(side, side, samples).expect("light");
            // The contribution of the pixel area holds on average over pixel phases, as in a wide PSF.
            if numbers.coefficients().moments(at).trace() < 3.0 {
                continue;
            }
            let got = crate::moments::pixels::TileMoments::optical(&tile, None).expect("light");
            let want = numbers.coefficients().moments(at).with_added_variance(blur);
            let size = want.trace();
            for (g, w) in got.central.to_array().iter().zip(want.to_array()) {
                assert!((g - w).abs() < 2e-3 * size.powf(1.5), "{g} {w} of {size}");
            }
            let fourth = numbers.fourth_coefficients().moments(at);
            if blur == 0.0 {
                for (g, w) in got.fourth.to_array().iter().zip(fourth.to_array()) {
                    assert!((g - w).abs() < 4e-3 * size * size, "{g} {w} of {size}");
                }
            }
            assert!((got.centroid_x - (c[0] - corner.0)).abs() < 2e-3 * radius);
            assert!((got.centroid_y - (c[1] - corner.1)).abs() < 2e-3 * radius);
        }
    }
}

/// Returns a transmission: square, fourth, centre (x, y).
fn transmission([square, fourth, x, y]: [f64; 4]) -> Transmission {
    Transmission {
        picture: None,
        square,
        fourth,
        centre: [x, y],
    }
}

/// Covers footprints of many cells, and ones smaller than a cell.
#[test]
fn derivatives_agree_with_finite_differences() {
    for scale in [1.0, 0.02] {
        compare_derivatives(scale);
    }
}

/// Compares derivatives with finite differences for a lens whose aberrations are scaled by `scale`.
fn compare_derivatives(scale: f64) {
    let numbers = ReducedNumbers {
        alpha: 5.0 * scale,
        beta: 1.5 * scale,
        gamma: -1.6 * scale,
        delta: 0.8 * scale,
        phi: -0.7 * scale,
    };
    let at = FieldPoint::new(0.7, 0.4);
    let mut pupil = clipped(&numbers, at, 0.2);
    let filter = [0.4, 0.1, 0.2, -0.1];
    pupil.transmission = transmission(filter);
    let mut derivatives = vec![
        PupilDerivative::from_wavefront(Wavefront::tilt(1.0, 0.0)),
        PupilDerivative::from_wavefront(Wavefront::tilt(0.0, 1.0)),
    ];
    for (round, along) in [(1, 0), (2, 0), (0, 2), (1, 1), (3, 0), (0, 3)] {
        let mut wavefront = Wavefront::default();
        wavefront.add(round, along, at.meridian(), 0.5);
        derivatives.push(PupilDerivative::from_wavefront(wavefront));
    }
    for stop in [1, 2] {
        for (x, y, radius) in [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)] {
            let mut derivative = PupilDerivative::from_wavefront(Wavefront::default());
            derivative.stops[stop] = Stop {
                centre: [x, y],
                radius,
            };
            derivatives.push(derivative);
        }
    }
    for numbers in [
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.3],
    ] {
        let mut derivative = PupilDerivative::from_wavefront(Wavefront::default());
        derivative.transmission = transmission(numbers);
        derivatives.push(derivative);
    }
    let (side, corner) = (25, (-12.3, -12.1));
    let mut out = PsfImage::default();
    let mut space = Workspace::default();
    let grid = square(corner, side);
    draw(
        &pupil,
        &grid,
        &derivatives,
        Detail::FULL,
        &mut space,
        &mut out,
    );
    let plain = |p: &LocalPupil| drawn(p, corner, side).light;
    let stride = PsfImage::stride(derivatives.len());
    let relative = |analytic: &dyn Fn(usize) -> f64, low: &[f64], high: &[f64], step: f64| {
        let numeric = |k: usize| (high[k] - low[k]) / (2.0 * step);
        let size: f64 = (0..side * side).map(|k| numeric(k).powi(2)).sum();
        let error: f64 = (0..side * side)
            .map(|k| (analytic(k) - numeric(k)).powi(2))
            .sum();
        (error / size).sqrt()
    };
    let step = 1e-3;
    for (which, derivative) in derivatives.iter().enumerate() {
        let moved = |by: f64| {
            let mut p =
                LocalPupil::circular(pupil.wavefront.add_scaled(by, &derivative.wavefront), 0.2);
            for (stop, rate) in pupil.stops().iter().zip(&derivative.stops).skip(1) {
                p.clip(Stop {
                    centre: [0, 1].map(|a| stop.centre[a] + by * rate.centre[a]),
                    radius: stop.radius + by * rate.radius,
                });
            }
            let rates = &derivative.transmission;
            let rates = [rates.square, rates.fourth, rates.centre[0], rates.centre[1]];
            p.transmission = transmission([0, 1, 2, 3].map(|k| filter[k] + by * rates[k]));
            p
        };
        // Moving cusps change the mesh; a larger step outweighs the effect.
        let step = if derivative.changes_light() {
            0.02
        } else {
            step
        };
        let (low, high) = (plain(&moved(-step)), plain(&moved(step)));
        let analytic = |k: usize| out.derivatives[k * stride + which];
        let error = relative(&analytic, &low, &high, step);
        // The mesh assigns half of a cusp to either stop, which limits the accuracy.
        let bound = if derivative.changes_light() {
            0.08
        } else {
            0.02
        };
        assert!(error < bound, "derivative {which} at {scale}: {error}");
    }
    let blurred = |by: f64| plain(&pupil.blurred_by(by));
    let error = relative(
        &|k| out.blur_derivative[k],
        &blurred(-step),
        &blurred(step),
        step,
    );
    assert!(error < 1e-3, "blur: {error}");
}

/// The error of centroid and variances (x, y) of a light distribution on a square tile, px and px².
fn moment_errors(
    light: &[f64],
    side: usize,
    centroid: [f64; 2],
    variances: [f64; 2],
) -> ([f64; 2], [f64; 2]) {
    let sum: f64 = light.iter().sum();
    let mean = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
        let terms = light.iter().enumerate();
        terms
            .map(|(k, v)| v * f((k % side) as f64 + 0.5, (k / side) as f64 + 0.5))
            .sum::<f64>()
            / sum
    };
    let place = [mean(&|x, _| x), mean(&|_, y| y)];
    let spread = [
        mean(&|x, _| (x - place[0]).powi(2)),
        mean(&|_, y| (y - place[1]).powi(2)),
    ];
    let pixel = crate::moments::pixels::PIXEL_VARIANCE_PX2;
    (
        [0, 1].map(|k| (place[k] - centroid[k]).abs()),
        [0, 1].map(|k| (spread[k] - pixel - variances[k]).abs()),
    )
}

#[test]
fn psfs_smaller_than_a_cell_keep_centroid_and_variance_at_any_place_in_a_pixel() {
    let side = 31;
    for (alpha, blur) in [(0.0, 0.4), (0.05, 2.5), (0.3, 0.4), (0.0, 5.0), (0.8, 5.0)] {
        let numbers = ReducedNumbers {
            alpha,
            ..ReducedNumbers::default()
        };
        let at = FieldPoint::new(0.0, 0.0);
        let rays = numbers.coefficients().moments(at);
        let pupil = LocalPupil::circular(Wavefront::third_order(&numbers, at), blur);
        for shift in [[0.0, 0.0], [0.1, -0.2], [0.37, 0.25], [-0.45, 0.5]] {
            let middle = [0, 1].map(|k| side as f64 / 2.0 + shift[k]);
            let corner = (-middle[0], -middle[1]);
            let by_spectrum = OpticalPsf::draw(
                &pupil,
                &square(corner, side),
                &pupil.sensor,
                Detail::FULL,
                &mut Workspace::default(),
            );
            let wanted = [rays.mu20 + blur, rays.mu02 + blur];
            for light in [
                drawn(&pupil, corner, side).light,
                by_spectrum.through(&pupil.sensor),
            ] {
                let (place, spread) = moment_errors(&light, side, middle, wanted);
                let found = format!("{alpha} {blur} {shift:?}: {place:?} px, {spread:?} px²");
                assert!(place.iter().all(|e| *e < 0.01), "{found}");
                assert!(spread.iter().all(|e| *e < 0.01), "{found}");
            }
        }
    }
}

#[test]
fn points_in_focus_and_large_discs_are_exact() {
    // A perfect point stays in its pixel.
    let sharp = LocalPupil::circular(Wavefront::default(), 0.0);
    let light = drawn(&sharp, (-2.5, -2.5), 5).light;
    assert!((light[12] - 1.0).abs() < 1e-12);
    // A large even disc has the density 1 / (pi r²).
    let numbers = ReducedNumbers {
        alpha: 300.0,
        ..ReducedNumbers::default()
    };
    let disc = LocalPupil::circular(
        Wavefront::third_order(&numbers, FieldPoint::new(0.0, 0.0)),
        0.0,
    );
    let light = drawn(&disc, (-310.0, -310.0), 620).light;
    let density = 1.0 / (std::f64::consts::PI * 9e4);
    assert!((light[310 * 620 + 310] / density - 1.0).abs() < 1e-3);
    assert!((light[310 * 620 + 600] / density - 1.0).abs() < 1e-3);
    assert!(light[310 * 620 + 611] == 0.0);
    assert!((light.iter().sum::<f64>() - 1.0).abs() < 1e-9);
}

/// Light drawn edge by edge equals light drawn triangle by triangle, which derivatives need.
#[test]
fn edges_and_triangles_draw_the_same_light() {
    let random = &mut SplitMix64::new(77);
    for (case, radius) in [0.4, 2.0, 7.0, 30.0, 110.0]
        .into_iter()
        .cycle()
        .take(40)
        .enumerate()
    {
        let (numbers, at) = random_lens(random, radius);
        let blur = if case % 2 == 0 { 0.3 } else { 5.0 };
        let pupil = clipped(&numbers, at, blur);
        let still = PupilDerivative::from_wavefront(Wavefront::default());
        // Some grids cut the light at every side.
        let side = [9, 31, 64][case % 3];
        let grid = square((-0.37 * side as f64, -0.61 * side as f64), side);
        let (mut edges, mut triangles) = (PsfImage::default(), PsfImage::default());
        let mut space = Workspace::default();
        draw(&pupil, &grid, &[], Detail::FIT, &mut space, &mut edges);
        draw(
            &pupil,
            &grid,
            &[still],
            Detail::FIT,
            &mut space,
            &mut triangles,
        );
        for (k, (a, b)) in edges.light.iter().zip(&triangles.light).enumerate() {
            assert!((a - b).abs() < 1e-9, "case {case}, pixel {k}: {a} {b}");
        }
    }
}

#[test]
fn a_kernel_within_a_reach_is_that_part_of_the_whole() {
    let numbers = ReducedNumbers {
        alpha: 40.0,
        beta: 6.0,
        gamma: 5.0,
        delta: 7.0,
        phi: 2.0,
    };
    let at = FieldPoint::new(0.5, -0.3);
    let blur = LocalBlur::from_pupil(clipped(&numbers, at, 1.3), at.meridian());
    let weights = |rows: &KernelRows| -> std::collections::BTreeMap<(i32, i32), f64> {
        let spans = rows.spans().flat_map(|span| {
            let weights = span.weights.iter().zip(span.column..);
            weights.map(move |(w, column)| ((span.row, column), f64::from(*w)))
        });
        spans.map(|(at, w)| (at, w / rows.sum())).collect()
    };
    let (mut whole, mut part) = (KernelRows::default(), KernelRows::default());
    for shift in [(0.3, -0.6), (30.2, 4.0), (-300.0, 0.0)] {
        Pupil.draw_interpolated_rows(&blur, shift, None, &mut whole);
        let whole = weights(&whole);
        let peak = whole.values().copied().fold(0.0, f64::max);
        for reach in [[9, 4], [0, 0], [25, 900], [900, 900]] {
            Pupil.draw_interpolated_rows(&blur, shift, Some(reach), &mut part);
            let part = weights(&part);
            let near =
                |&(row, column): &(i32, i32)| row.abs() <= reach[1] && column.abs() <= reach[0];
            let wanted = whole.keys().filter(|at| near(at)).count();
            assert!(part.len() >= wanted, "{shift:?} {reach:?}");
            for at in whole.keys().chain(part.keys()).filter(|at| near(at)) {
                let [a, b] = [&whole, &part].map(|w| w.get(at).copied().unwrap_or(0.0));
                assert!(
                    (a - b).abs() < 1e-5 * peak,
                    "{shift:?} {reach:?} {at:?}: {a} {b}"
                );
            }
        }
    }
}
