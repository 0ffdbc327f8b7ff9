//! Designed lenses.

use super::super::assembly::{Assembly, GREEN, SensorPlane, View};
use super::super::beam::Beam;
use super::super::lens::surfaces;
use super::super::paraxial;
use super::super::prescription::{ALL, COOKE_TRIPLET, DOUBLE_GAUSS, Prescription, TESSAR};
use super::super::tiles::{Built, CELLS};
use super::published::PUBLISHED;
use super::{core, lens_of, spread};
use crate::expose::difference;
use crate::lens::{CHANNELS, Place};
use crate::mask::Mask;
use crate::rays;
use crate::sensor::{FineGrid, Sensor};

#[test]
fn focal_length_and_back_focus_are_the_published_ones() {
    for figures in &PUBLISHED {
        let found = paraxial::focus(&surfaces(figures.lens, 1.0, [figures.nm; 3]), GREEN);
        let focal = found.focal / figures.focal - 1.0;
        let back = (found.back - figures.back) / figures.focal;
        assert!(
            focal.abs() < figures.focal_accuracy,
            "{found:?} {figures:?}"
        );
        assert!(back.abs() < figures.back_accuracy, "{found:?} {figures:?}");
    }
}

/// Returns the root mean square radius of the spot of a lens of published size, mm: object at infinity, `pupil_mm` the
/// radius of the beam, `sensor_mm` the distance of the sensor from the last surface.
fn rms_radius(lens: &Prescription, degrees: f64, pupil_mm: f64, sensor_mm: f64) -> f64 {
    const RINGS: usize = 40;
    let surfaces = surfaces(lens, 1.0, [587.5618; 3]);
    let pupil = paraxial::entrance_pupil(&surfaces, lens.stop);
    let last = surfaces[surfaces.len() - 1].vertex[2];
    let built = Assembly {
        surfaces,
        stop: lens.stop,
        stop_mm: pupil_mm / pupil.growth,
        holes: Vec::new(),
        sensor: SensorPlane {
            centre: [0.0, 0.0, last + sensor_mm],
            normal: [0.0, 0.0, 1.0],
            pitch_mm: 1.0,
            axis_px: [0.0; 2],
        },
        view: View {
            pupil_z: pupil.z,
            pupil_mm,
            chief_mm: 1.0,
        },
        depth_factor: 1.0,
    };
    let object = built.object([0.0, degrees.to_radians().tan()], 1e6);
    let mut landings = Vec::new();
    for ring in 0..=RINGS {
        let count = (6 * ring).max(1);
        for i in 0..count {
            let angle = std::f64::consts::TAU * i as f64 / count as f64;
            let r = pupil_mm * ring as f64 / RINGS as f64;
            let aim = [r * libm::cos(angle), r * libm::sin(angle)];
            landings.push(built.follow(GREEN, object, aim).expect("it passes").at);
        }
    }
    let count = landings.len() as f64;
    let mean: [f64; 2] =
        std::array::from_fn(|k| landings.iter().map(|l| l[k]).sum::<f64>() / count);
    let square: f64 = landings
        .iter()
        .map(|l| (l[0] - mean[0]).powi(2) + (l[1] - mean[1]).powi(2))
        .sum();
    (square / count).sqrt()
}

#[test]
fn spot_sizes_are_those_of_another_program() {
    // RMS radii in mm by optiland 0.6.3: 40 hexapolar rings over the entrance pupil, object at infinity, 587.6 nm, the
    // indices at the d line.
    let spots = [
        (
            &DOUBLE_GAUSS,
            12.5,
            61.487_536,
            [0.0, 5.0, 10.0],
            [0.017_747_984, 0.021_260_576, 0.032_611_344],
        ),
        (
            &COOKE_TRIPLET,
            5.0,
            42.207_78,
            [0.0, 7.0, 14.0],
            [0.004_803_162, 0.006_641_967, 0.015_584_435],
        ),
    ];
    for (lens, pupil_mm, sensor_mm, fields, radii) in spots {
        for (degrees, radius) in fields.into_iter().zip(radii) {
            let found = rms_radius(lens, degrees, pupil_mm, sensor_mm);
            let apart = found / radius - 1.0;
            assert!(apart.abs() < 2e-4, "{degrees} degrees: {found} {radius}");
        }
    }
}

#[test]
fn the_axis_point_in_focus_is_small_and_grows_to_both_sides() {
    for prescription in ALL {
        let f_number = prescription.f_numbers[prescription.f_numbers.len() - 1];
        let lens = lens_of(prescription, f_number);
        let rms_at = |depth_m: f64| {
            let place = Place {
                ideal: lens.position(0.0),
                depth_m,
                channel: GREEN,
            };
            spread(&lens, &place).rms_px
        };
        let sharp = rms_at(lens.camera.focus_m);
        assert!(sharp < 1.0, "{sharp} px");
        let [far, near] = [2.6, 1.6].map(rms_at);
        assert!(
            far > 3.0 * sharp && near > 3.0 * sharp,
            "{far} {sharp} {near}"
        );
    }
}

#[test]
fn defocus_is_that_of_the_thin_lens_and_places_near_the_axis_are_ideal() {
    let lens = lens_of(&DOUBLE_GAUSS, 4.0);
    let ideal = lens.position(0.02);
    for depth_m in [1.2, 2.0, 7.0] {
        let found = core(&lens.design, GREEN, ideal, depth_m);
        assert!((found.chief[0] - ideal[0]).abs() < 2e-3, "{found:?}");
        let bare = core(&lens.design, GREEN, ideal, 2.0);
        let expected = lens.camera.alpha(1.0 / depth_m);
        let grown = found.growth[0] - bare.growth[0];
        // Of either sign: the image is inverted, so a far object converges in front of the sensor.
        let apart = (grown.abs() - expected.abs()).abs();
        assert!(apart < 0.06 * expected.abs() + 1e-6, "{grown} {expected}");
    }
}

#[test]
fn a_designed_lens_has_rotational_symmetry() {
    let lens = lens_of(&TESSAR, 4.5);
    let axis = lens.position(0.0);
    let far = 0.9 * lens.camera.frame.half_width_px();
    let spread_at = |angle: f64| {
        let ideal = [
            axis[0] + far * libm::cos(angle),
            axis[1] + far * libm::sin(angle),
        ];
        let place = Place {
            ideal,
            depth_m: 2.6,
            channel: 2,
        };
        spread(&lens, &place)
    };
    let first = spread_at(0.0);
    for angle in [0.6, 1.9, 4.0] {
        let turned = spread_at(angle);
        let along = [turned.centroid[0] - axis[0], turned.centroid[1] - axis[1]];
        let radial = along[0] * libm::cos(angle) + along[1] * libm::sin(angle);
        let across = along[1] * libm::cos(angle) - along[0] * libm::sin(angle);
        assert!((radial - (first.centroid[0] - axis[0])).abs() < 2e-3);
        assert!(across.abs() < 2e-3);
        assert!((turned.rms_px / first.rms_px - 1.0).abs() < 2e-3);
    }
}

#[test]
fn light_is_conserved_and_more_rays_change_nothing() {
    const TILE: usize = 33;
    for prescription in ALL {
        let lens = lens_of(prescription, 5.6);
        let built = Built::new(&lens, &[]);
        let mask = Mask::default();
        for channel in 0..CHANNELS.len() {
            let object = built.assembly.object(lens.position(0.7), 2.6);
            let beam = Beam::new(&built.assembly, channel, object, &mask).expect("light passes");
            let centre = beam.centroid().map(|c| c.floor() + 0.5);
            let tile_with = |cells: usize| {
                let sensor = Sensor::default();
                let mut fine = FineGrid::new(TILE, &sensor);
                rays::trace(&beam, centre, cells, &mut fine);
                sensor.integrate(&fine, TILE)
            };
            let (drawn, finer) = (tile_with(CELLS), tile_with(3 * CELLS));
            let light: f64 = drawn.iter().sum();
            assert!((light - 1.0).abs() < 1e-9, "{light}");
            let apart = difference(&finer, &drawn);
            assert!(apart < 1e-5, "{apart:e}");
        }
    }
}
