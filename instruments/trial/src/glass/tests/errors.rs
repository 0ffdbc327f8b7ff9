//! The sign and the field dependence of every error of a lens.

use super::super::assembly::{Assembly, GREEN};
use super::super::change::GlassCause;
use super::super::errors::error;
use super::super::lens::GlassLens;
use super::super::prescription::{DOUBLE_GAUSS, TESSAR};
use super::super::tiles::Built;
use super::super::unknown::unknown;
use super::{core, lens_of, spread};
use crate::lens::Place;
use crate::rng::Rng;

const RED: usize = 0;
const BLUE: usize = 2;

/// Returns the assembly with the effect or family `id` at `strength`.
fn built_with(lens: &GlassLens, id: &str, strength: f64, seed: u64) -> Assembly {
    let mut rng = Rng::new(seed);
    let change = if super::super::EFFECTS.contains(&id) {
        error(id, lens, &mut rng)
    } else {
        unknown(id, lens, &mut rng)
    };
    let cause = GlassCause { change, strength };
    Built::new(lens, &[&cause]).assembly
}

/// Returns the change of defocus, px at the rim along x and y, at `field` half widths along x.
fn defocus(lens: &GlassLens, built: &Assembly, field: f64, depth_m: f64) -> [f64; 2] {
    let at = lens.position(field);
    let bare = core(&lens.design, GREEN, at, depth_m).growth;
    let found = core(built, GREEN, at, depth_m).growth;
    [found[0] - bare[0], found[1] - bare[1]]
}

#[test]
fn a_shift_of_the_sensor_is_the_same_defocus_everywhere() {
    let lens = lens_of(&DOUBLE_GAUSS, 4.0);
    let built = built_with(&lens, "defocus_offset", 1.0, 3);
    let first = defocus(&lens, &built, 0.0, 2.0)[1];
    assert!((first.abs() - 1.0).abs() < 0.03, "{first}");
    for (field, depth_m) in [(0.0, 1.5), (0.5, 2.0), (0.9, 3.0)] {
        let other = defocus(&lens, &built, field, depth_m)[1];
        assert!((other / first - 1.0).abs() < 0.06, "{other} {first}");
    }
}

#[test]
fn wrong_distances_defocus_near_points_most() {
    let lens = lens_of(&DOUBLE_GAUSS, 4.0);
    let built = built_with(&lens, "depth_scale", 0.05, 3);
    let at = |depth_m: f64| defocus(&lens, &built, 0.0, depth_m)[0];
    let (near, far) = (at(1.5), at(3.0));
    assert!((near / far - 2.0).abs() < 0.02, "{near} {far}");
    let place = lens.position(0.8);
    let moved = core(&built, GREEN, place, 2.0).chief[0];
    let bare = core(&lens.design, GREEN, place, 2.0).chief[0];
    // Only the aberration of the chief ray changes.
    assert!((moved - bare).abs() < 0.1, "{moved} {bare}");
}

#[test]
fn a_tilted_sensor_gives_defocus_linear_in_field() {
    let lens = lens_of(&DOUBLE_GAUSS, 4.0);
    let built = built_with(&lens, "sensor_tilt", 2.0, 5);
    let at = |field: f64| defocus(&lens, &built, field, 2.0)[1];
    let (half, full) = (at(0.4), at(0.8));
    assert!(at(0.0).abs() < 1e-3 * full.abs());
    assert!((full / half - 2.0).abs() < 0.05, "{half} {full}");
    assert!((at(-0.8) / full + 1.0).abs() < 0.05, "{} {full}", at(-0.8));
}

#[test]
fn the_stop_scales_defocused_discs() {
    let lens = lens_of(&DOUBLE_GAUSS, 5.6);
    let built = built_with(&lens, "pupil_scale", 0.2, 1);
    let factor = built.stop_mm / lens.design.stop_mm;
    assert!((libm::log(factor).abs() - 0.2).abs() < 1e-12);
    let mut larger = lens.clone();
    larger.design = built;
    let place = Place {
        ideal: lens.position(0.0),
        depth_m: 1.0,
        channel: GREEN,
    };
    let [bare, scaled] = [&lens, &larger].map(|l| spread(l, &place).rms_px);
    assert!(
        (scaled / bare / factor - 1.0).abs() < 0.03,
        "{bare} {scaled} {factor}"
    );
}

#[test]
fn a_hole_clips_the_corner_and_not_the_axis() {
    for seed in 0..4 {
        let lens = lens_of(&TESSAR, 4.5);
        let mut clipped = lens.clone();
        clipped.design = built_with(&lens, "vignetting", 0.9, seed);
        let rms = |lens: &GlassLens, field: f64| {
            let place = Place {
                ideal: lens.position(field),
                depth_m: 1.6,
                channel: GREEN,
            };
            spread(lens, &place).rms_px
        };
        let axis = rms(&clipped, 0.0) / rms(&lens, 0.0);
        let corner = rms(&clipped, 1.1) / rms(&lens, 1.1);
        assert!((axis - 1.0).abs() < 5e-3, "{axis}");
        assert!(corner < 0.99, "{corner}");
    }
}

/// Returns the difference between red and blue, less that of the design: of defocus, px, and of place, px.
fn colour(lens: &GlassLens, built: &Assembly, field: f64) -> [f64; 2] {
    let at = lens.position(field);
    let apart = |built: &Assembly| {
        let [red, blue] = [RED, BLUE].map(|channel| core(built, channel, at, 2.0));
        [red.growth[1] - blue.growth[1], red.chief[0] - blue.chief[0]]
    };
    let (bare, found) = (apart(&lens.design), apart(built));
    [found[0] - bare[0], found[1] - bare[1]]
}

#[test]
fn melts_give_pure_axial_or_pure_lateral_colour() {
    for (seed, prescription) in [(0, &DOUBLE_GAUSS), (1, &DOUBLE_GAUSS), (2, &TESSAR)] {
        let lens = lens_of(prescription, 4.0);
        let axial = built_with(&lens, "axial_colour", 1.0, seed);
        let [middle, edge] = [0.0, 0.9].map(|field| colour(&lens, &axial, field));
        assert!((middle[0].abs() - 1.0).abs() < 0.05, "{middle:?}");
        assert!(
            (edge[0] / middle[0] - 1.0).abs() < 0.25,
            "{edge:?} {middle:?}"
        );
        assert!(edge[1].abs() < 0.25, "{edge:?}");
        let lateral = built_with(&lens, "lateral_colour", 1.0, seed);
        let [middle, half, edge] = [0.0, 0.5, 1.0].map(|field| colour(&lens, &lateral, field));
        assert!(
            middle[0].abs() < 0.1 && middle[1].abs() < 1e-6,
            "{middle:?}"
        );
        assert!((edge[1].abs() - 1.0).abs() < 0.25, "{edge:?}");
        assert!((edge[1] / half[1] - 2.0).abs() < 0.3, "{half:?} {edge:?}");
    }
}

#[test]
fn a_decentred_element_brings_coma_to_the_axis_and_keeps_its_place() {
    let mut comatic = 0;
    for seed in 0..6 {
        let lens = lens_of(&DOUBLE_GAUSS, 2.8);
        let mut bad = lens.clone();
        let mut rng = Rng::new(seed);
        let most = error("decentre", &lens, &mut rng).range[1];
        bad.design = built_with(&lens, "decentre", 0.3 * most, seed);
        let place = Place {
            ideal: lens.position(0.0),
            depth_m: 2.0,
            channel: GREEN,
        };
        let (bare, found) = (spread(&lens, &place), spread(&bad, &place));
        for i in 0..2 {
            assert!((found.centroid[i] - place.ideal[i]).abs() < 0.02 * found.rms_px);
        }
        // Coma moves the ray through the middle of the stop off the centroid.
        let chief = core(&bad.design, GREEN, place.ideal, 2.0).chief;
        let off = (chief[0] - place.ideal[0]).hypot(chief[1] - place.ideal[1]);
        comatic += usize::from(off > 0.3 && found.rms_px > bare.rms_px);
    }
    assert!(comatic >= 4, "{comatic} of 6");
}

#[test]
fn a_bowed_plate_moves_points_by_the_cube_of_the_field() {
    let lens = lens_of(&DOUBLE_GAUSS, 5.6);
    let built = built_with(&lens, "distortion", 2.0, 1);
    let shift = |field: f64| {
        let at = lens.position(field);
        core(&built, GREEN, at, 2.0).chief[0] - core(&lens.design, GREEN, at, 2.0).chief[0]
    };
    let (half, full) = (shift(0.5), shift(1.0));
    assert!((full.abs() - 2.0).abs() < 0.3, "{full}");
    assert!((full / half - 8.0).abs() < 0.5, "{half} {full}");
    let blur = defocus(&lens, &built, 1.0, 2.0);
    assert!(blur[0].abs() < 0.15 * full.abs(), "{blur:?} {full}");
}

#[test]
fn a_cylinder_defocuses_the_axes_of_the_frame_differently() {
    let lens = lens_of(&DOUBLE_GAUSS, 4.0);
    for seed in 0..6 {
        let built = built_with(&lens, "anamorphic", 1.0, seed);
        let [x, y] = defocus(&lens, &built, 0.0, 2.0);
        let (most, least) = (x.abs().max(y.abs()), x.abs().min(y.abs()));
        assert!((0.6..1.1).contains(&most), "{x} {y}");
        assert!((x - y).abs() > 0.8, "{x} {y} {least}");
    }
}

#[test]
fn a_zone_moves_the_rim_and_not_the_middle() {
    let lens = lens_of(&DOUBLE_GAUSS, 4.0);
    for seed in 0..6 {
        let built = built_with(&lens, "higher_order", 2.0, seed);
        let [x, y] = defocus(&lens, &built, 0.0, 2.0);
        assert!(x.abs() < 0.02 && y.abs() < 0.02, "{x} {y}");
        let rim = [0.0, 0.98 * lens.design.view.pupil_mm];
        let object = built.object(lens.position(0.0), 2.0);
        let at = |a: &Assembly| a.follow(GREEN, object, rim).expect("it passes").at[1];
        let moved = (at(&built) - at(&lens.design)).abs();
        assert!((1.2..2.4).contains(&moved), "{moved}");
    }
}

#[test]
fn wrong_spaces_and_melts_keep_focus_and_image_size_and_change_the_field() {
    let lens = lens_of(&DOUBLE_GAUSS, 2.8);
    for (id, strength) in [("air_space", 0.5), ("glass_index", 0.01)] {
        for seed in 0..3 {
            let built = built_with(&lens, id, strength, seed);
            let near = lens.position(0.05);
            let bare = core(&lens.design, GREEN, near, 2.0).chief[0];
            let found = core(&built, GREEN, near, 2.0).chief[0];
            assert!((found - bare).abs() < 0.15, "{id}: {found} {bare}");
            let place = |field: f64| Place {
                ideal: lens.position(field),
                depth_m: 2.0,
                channel: GREEN,
            };
            let mut other = lens.clone();
            other.design = built;
            let rms = |lens: &GlassLens, field: f64| spread(lens, &place(field)).rms_px;
            let change = |field: f64| (rms(&other, field) - rms(&lens, field)).abs();
            assert!(change(0.0) + change(0.9) > 0.02, "{id}: {}", change(0.9));
        }
    }
}
