//! PSFs behind sensors against shifted PSFs, moments and densities.

use super::super::*;
use crate::field::FieldPoint;
use crate::lens::ReducedNumbers;
use crate::sensor::{Halo, Sensor};

const SIDE: usize = 33;
const CORNER: (f64, f64) = (-16.3, -16.7);

fn pupil(q: f64, blur: f64) -> LocalPupil {
    let numbers = ReducedNumbers {
        alpha: 4.0,
        beta: 1.0,
        gamma: -2.0,
        delta: 0.5,
        phi: -0.8,
    };
    let at = FieldPoint::new(0.8, 0.5);
    let mut pupil = LocalPupil::circular(Wavefront::third_order(&numbers, at), blur);
    pupil.wave_px = q;
    pupil
}

fn square(corner: (f64, f64), side: usize) -> TileGrid {
    TileGrid {
        corner_px: [corner.0, corner.1],
        width: side,
        height: side,
    }
}

fn drawn(pupil: &LocalPupil, corner: (f64, f64), side: usize) -> Vec<f64> {
    let (mut space, mut out) = (Workspace::default(), PsfImage::default());
    let grid = square(corner, side);
    draw(pupil, &grid, &[], Detail::FULL, &mut space, &mut out);
    out.light
}

fn behind(sensor: Sensor, q: f64, blur: f64) -> Vec<f64> {
    let mut pupil = pupil(q, blur);
    pupil.sensor = sensor;
    drawn(&pupil, CORNER, SIDE)
}

/// Returns the squared difference over the squared light.
fn energy(got: &[f64], want: &[f64]) -> f64 {
    let pairs = got.iter().zip(want);
    let error: f64 = pairs.map(|(a, b)| (a - b).powi(2)).sum();
    error / want.iter().map(|v| v * v).sum::<f64>()
}

/// Returns the mean of PSFs shifted to `places` (x, y).
fn mean_of_moved(places: &[(f64, f64)], q: f64, blur: f64) -> Vec<f64> {
    let mut mean = vec![0.0; SIDE * SIDE];
    for (x, y) in places {
        let moved = drawn(&pupil(q, blur), (CORNER.0 - x, CORNER.1 - y), SIDE);
        for (sum, value) in mean.iter_mut().zip(moved) {
            *sum += value / places.len() as f64;
        }
    }
    mean
}

#[test]
fn an_ideal_sensor_does_not_change_the_psf() {
    let (ideal, any) = (
        Sensor::default(),
        Sensor {
            box_px: [2.0, 1.0],
            halo: Halo {
                share: 0.2,
                ..Halo::default()
            },
            ..Sensor::default()
        },
    );
    for (q, blur) in [(0.0, 0.0), (0.0, 0.4), (1.4, 0.0), (1.4, 0.4)] {
        let space = &mut Workspace::default();
        let (lens, grid) = (pupil(q, blur), square(CORNER, SIDE));
        let picture = OpticalPsf::draw(&lens, &grid, &any, Detail::FULL, space);
        let off = energy(&picture.through(&ideal), &drawn(&lens, CORNER, SIDE));
        // The discrete Gaussian uses finer cells; diffraction uses another window.
        assert!(
            off < if q == 0.0 { 1e-4 } else { 1e-6 },
            "{q} {blur}: {off}"
        );
        let behind = behind(any, q, blur);
        assert!(energy(&picture.through(&any), &behind) < 1e-9);
    }
}

#[test]
fn streak_box_and_copies_add_their_moments_and_conserve_light() {
    let mut lens = pupil(0.0, 1.0);
    lens.sensor = Sensor {
        streak_px: [1.7, -1.1],
        box_px: [0.6, 1.3],
        copies_px: [1.2, 0.7],
        ..Sensor::default()
    };
    let light = drawn(&lens, CORNER, SIDE);
    let sum: f64 = light.iter().sum();
    assert!((sum - 1.0).abs() < 1e-9, "{sum}");
    let tile = light.iter().map(|v| *v as f32).collect();
    let tile = crate::tile::Tile::new(SIDE, SIDE, tile).expect("light");
    let got = crate::moments::pixels::TileMoments::optical(&tile, None).expect("light");
    let (want, centroid) = lens.moments();
    for (got, want) in got.central.to_array().iter().zip(want.to_array()) {
        assert!((got - want).abs() < 5e-3, "{got} {want}");
    }
    assert!((got.centroid_x + CORNER.0 - centroid[0]).abs() < 1e-4);
    assert!((got.centroid_y + CORNER.1 - centroid[1]).abs() < 1e-4);
}

#[test]
fn boxes_streaks_and_copies_are_means_of_shifted_psfs() {
    let count = 24;
    let steps: Vec<f64> = (0..count)
        .map(|k| (f64::from(k) + 0.5) / f64::from(count) - 0.5)
        .collect();
    let wide = Sensor {
        box_px: [1.0, 0.0],
        ..Sensor::default()
    };
    let wide = (wide, steps.iter().map(|s| (*s, 0.0)).collect::<Vec<_>>());
    let moving = Sensor {
        streak_px: [2.3, -1.4],
        ..Sensor::default()
    };
    let moving = (moving, steps.iter().map(|s| (2.3 * s, -1.4 * s)).collect());
    let split = Sensor {
        copies_px: [1.1, 0.6],
        ..Sensor::default()
    };
    let signs = [(0.55, 0.3), (0.55, -0.3), (-0.55, 0.3), (-0.55, -0.3)];
    let split = (split, signs.to_vec());
    for (sensor, places) in [wide, moving, split] {
        for (q, blur) in [(0.0, 0.0), (0.0, 0.2), (1.4, 0.0)] {
            let want = mean_of_moved(&places, q, blur);
            let got = behind(sensor, q, blur);
            let least = got.iter().copied().fold(0.0, f64::min);
            assert!(energy(&got, &want) < 3e-4, "{q} {blur} {sensor:?}");
            // Undersampled detail rings.
            let peak = got.iter().copied().fold(0.0, f64::max);
            assert!(least > -0.01 * peak, "{q} {blur}: {least}");
        }
    }
}

#[test]
fn a_halo_holds_its_share() {
    let halo = Halo {
        share: 0.3,
        radius_px: 2.5,
        steepness: 2.2,
        ..Halo::default()
    };
    let sensor = Sensor {
        halo,
        ..Sensor::default()
    };
    let density = |x: f64, y: f64| {
        let r2 = (x * x + y * y) / 6.25;
        1.2 / (std::f64::consts::PI * 6.25) * (1.0 + r2).powf(-2.2)
    };
    // A point at the centre of a pixel.
    let mut point = LocalPupil::circular(Wavefront::default(), 0.0);
    point.sensor = sensor;
    let light = drawn(&point, (-16.5, -16.5), SIDE);
    let parts = 15;
    for (k, value) in light.iter().enumerate() {
        let at = |k: usize| k as f64 - 16.0;
        let part = |k: usize| (k as f64 + 0.5) / parts as f64 - 0.5;
        let places = (0..parts * parts).map(|p| {
            density(
                at(k % SIDE) + part(p % parts),
                at(k / SIDE) + part(p / parts),
            )
        });
        let mean = places.sum::<f64>() / (parts * parts) as f64;
        let sharp = if k == SIDE * SIDE / 2 { 0.7 } else { 0.0 };
        let want = 0.3 * mean + sharp;
        assert!(
            (value - want).abs() < 1e-3 * 0.3 * mean,
            "{k}: {value} {want}"
        );
    }
    // A wide tile holds all light except that of the halo outside.
    let side = 201;
    point.wavefront = Wavefront::tilt(0.3, 0.2);
    let sum: f64 = drawn(&point, (-100.0, -100.0), side).iter().sum();
    let lost = 0.3 * (1.0 + 1e4_f64 / 6.25).powf(-1.2);
    assert!(1.0 - sum < lost && 1.0 - sum > 0.7 * lost);
}

#[test]
fn a_halo_brings_in_light_from_outside_the_tile() {
    for q in [0.0, 1.4] {
        let mut lens = pupil(q, 0.2);
        lens.sensor.halo.share = 0.4;
        lens.sensor.streak_px = [1.0, 0.5];
        let whole = drawn(&lens, CORNER, SIDE);
        let (left, top, side) = (19, 18, 9);
        let corner = (CORNER.0 + left as f64, CORNER.1 + top as f64);
        let part = drawn(&lens, corner, side);
        for (k, value) in part.iter().enumerate() {
            let want = whole[(top + k / side) * SIDE + left + k % side];
            assert!(
                (value - want).abs() < 2e-3 * want.abs() + 1e-6,
                "{q} {k}: {value} {want}"
            );
        }
    }
}

#[test]
fn kernels_cover_diffraction_and_halo() {
    use crate::psf::{Kernel, LocalBlur, draw_kernel};
    let meridian = FieldPoint::new(0.8, 0.5).meridian();
    for (q, share, size) in [
        (0.0, 0.0, 21),
        (1.4, 0.0, 73),
        (0.0, 0.1, 52),
        (1.4, 0.1, 101),
    ] {
        let mut lens = pupil(q, 0.1);
        lens.sensor.halo.share = share;
        let blur = LocalBlur::from_pupil(lens, meridian);
        let reach = Pupil.kernel_bounds(&blur);
        let window = SampleGrid {
            first_x_px: -reach.left_px.floor(),
            first_y_px: -reach.up_px.floor(),
            width: (reach.left_px.floor() + reach.right_px.floor()) as usize + 1,
            height: (reach.up_px.floor() + reach.down_px.floor()) as usize + 1,
        };
        let mut light = vec![0.0; window.len()];
        Pupil.sample(&blur, &window, &mut light);
        let sum: f64 = light.iter().sum();
        assert!(sum > 0.9895 && sum < 1.0 + 1e-9, "{q} {share}: {sum}");
        assert!(window.width < size, "{}", window.width);
        let mut kernel = Kernel::default();
        draw_kernel(&Pupil, &blur, (0.3, 0.0), &mut kernel);
        let sum: f64 = kernel.weights.iter().map(|w| f64::from(*w)).sum();
        assert!((sum - 1.0).abs() < 1e-5);
    }
}
