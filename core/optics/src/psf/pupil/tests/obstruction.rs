//! PSFs of pupils with an opaque disc, against histograms of rays and closed forms.

use super::*;
use crate::psf::LocalBlur;

fn obstructed(pupil: LocalPupil, x: f64, radius: f64) -> LocalPupil {
    let mut pupil = pupil;
    pupil.obstruct(Stop {
        centre: [x, 0.0],
        radius,
    });
    pupil
}

fn drawn(pupil: &LocalPupil, grid: &TileGrid, detail: Detail) -> PsfImage {
    let (mut space, mut image) = (Workspace::default(), PsfImage::default());
    draw(pupil, grid, &[], detail, &mut space, &mut image);
    image
}

#[test]
fn defocused_discs_are_even_rings_with_a_dark_middle() {
    const SIDE: usize = 64;
    let grid = square((-32.0, -32.0), SIDE);
    let mut wavefront = Wavefront::default();
    wavefront.add_monomial(2, 0, 10.0);
    wavefront.add_monomial(0, 2, 10.0);
    for radius in [0.02, 0.4, 0.8, 0.9] {
        let pupil = obstructed(LocalPupil::circular(wavefront, 0.0), 0.0, radius);
        for detail in [Detail::FULL, Detail::RENDER, Detail::INTERPOLATED] {
            let image = drawn(&pupil, &grid, detail);
            let (inner, outer) = (20.0 * radius, 20.0);
            let even = 1.0 / (std::f64::consts::PI * (outer * outer - inner * inner));
            let sum: f64 = image.light.iter().sum();
            assert!((sum - 1.0).abs() < 1e-9, "{radius}: {sum}");
            for (k, light) in image.light.iter().enumerate() {
                let (x, y) = ((k % SIDE) as f64 - 31.5, (k / SIDE) as f64 - 31.5);
                let r = x.hypot(y);
                if r < inner - 0.9 || r > outer + 0.9 {
                    assert!(*light < 1e-12, "{radius} {r}: {light}");
                } else if (inner + 0.9..outer - 0.9).contains(&r) {
                    // The area of the polygons of coarse meshes is right to a few thousandths.
                    let ratio = light / even;
                    assert!((ratio - 1.0).abs() < 0.02, "{radius} {r}: {ratio}");
                }
            }
        }
    }
}

#[test]
fn aberrated_and_clipped_pupils_agree_with_rays() {
    const SIDE: usize = 60;
    let corner = (-30.0, -30.0);
    let mut random = SplitMix64::new(20);
    for (x, radius) in [(0.0, 0.45), (0.15, 0.3), (-0.3, 0.75)] {
        let (numbers, at) = random_lens(&mut random, 12.0);
        let pupil = obstructed(clipped(&numbers, at, 0.0), x, radius);
        let counts = [0.1, 0.6].map(|s| histogram(&pupil, corner, SIDE, 1_500_000, s));
        let image = drawn(&pupil, &square(corner, SIDE), Detail::FULL);
        let decibels = decibels(&counts, &image.light);
        assert!(decibels > 45.0, "{x} {radius}: {decibels}");
    }
}

#[test]
fn a_disc_beside_the_axis_of_a_clipped_pupil_darkens_a_part_of_it() {
    const SIDE: usize = 48;
    let corner = (-24.0, -24.0);
    let mut pupil = disc_of(12.0);
    pupil.clip(Stop {
        centre: [1.3, 0.0],
        radius: 1.0,
    });
    let pupil = obstructed(pupil, 0.0, 0.6);
    let counts = [0.1, 0.6].map(|s| histogram(&pupil, corner, SIDE, 1_500_000, s));
    let image = drawn(&pupil, &square(corner, SIDE), Detail::FULL);
    let decibels = decibels(&counts, &image.light);
    // The inner edge is as wide as a triangle of the mesh.
    assert!(decibels > 15.0, "{decibels}");
}

#[test]
fn diffraction_keeps_the_middle_of_a_defocused_disc_dark() {
    let mut pupil = obstructed(disc_of(14.0), 0.0, 0.5);
    pupil.wave_px = 0.6;
    let image = drawn(&pupil, &square((-20.0, -20.0), 40), Detail::FULL);
    let sum: f64 = image.light.iter().sum();
    assert!((sum - 1.0).abs() < 0.03, "{sum}");
    let even = 1.0 / (std::f64::consts::PI * 14.0 * 14.0 * 0.75);
    let near = |x: usize| image.light[20 * 40 + x] / even;
    assert!(
        near(23) < 0.1 && near(30) > 0.6,
        "{} {}",
        near(23),
        near(30)
    );
}

#[test]
fn bounds_and_moments_hold_the_light() {
    let pupil = obstructed(disc_of(9.0), 0.2, 0.5);
    let blur = LocalBlur::from_pupil(pupil.clone(), crate::field::Meridian::X);
    let bounds = Pupil.kernel_bounds(&blur);
    let (moments, centroid) = pupil.moments();
    let image = drawn(&pupil, &square((-20.0, -20.0), 40), Detail::FULL);
    let mut x = 0.0;
    for (k, light) in image.light.iter().enumerate() {
        x += light * ((k % 40) as f64 - 19.5);
    }
    assert!((x - centroid[0]).abs() < 0.02, "{x} {centroid:?}");
    assert!(bounds.left_px > 9.0 && bounds.right_px > 9.0 && moments.mu20 > 0.0);
}

fn disc_of(alpha: f64) -> LocalPupil {
    let mut wavefront = Wavefront::default();
    wavefront.add_monomial(2, 0, alpha / 2.0);
    wavefront.add_monomial(0, 2, alpha / 2.0);
    LocalPupil::circular(wavefront, 0.0)
}
