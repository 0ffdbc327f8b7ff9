//! What holds for every effect; lenses and points for the tests of each.

use super::*;
use crate::lens::{ReducedNumbers, Stop, Wavefront};
use crate::psf::pupil::{Detail, PsfImage, TileGrid, Workspace, draw};

pub(crate) fn point() -> ScenePoint {
    ScenePoint {
        at: FieldPoint::new(0.6, -0.5),
        vergence_per_m: 0.5,
        stop_lever_m: 0.0,
        defocus_px_m: 20.0,
        focus_vergence_per_m: 0.4,
        wavelength_px: 0.12,
    }
}

/// The same at another place of the field.
pub(crate) fn place(x: f64, y: f64) -> ScenePoint {
    ScenePoint {
        at: FieldPoint::new(x, y),
        ..point()
    }
}

/// A lens of defocus alone, in the middle of its field, without blur.
pub(crate) fn disc(alpha: f64) -> LocalPupil {
    let numbers = ReducedNumbers {
        alpha,
        beta: 0.0,
        gamma: 0.0,
        delta: 0.0,
        phi: 0.0,
    };
    LocalPupil::circular(
        Wavefront::third_order(&numbers, FieldPoint::new(0.0, 0.0)),
        0.0,
    )
}

/// `pupil` behind `effect`.
pub(crate) fn behind(
    effect: &dyn Effect,
    values: &[f64],
    point: ScenePoint,
    mut pupil: LocalPupil,
) -> LocalPupil {
    effect.apply(values, point, &mut pupil);
    pupil
}

/// All aberrations of third order.
fn lens() -> LocalPupil {
    let numbers = ReducedNumbers {
        alpha: 3.0,
        beta: 1.0,
        gamma: 2.0,
        delta: -1.0,
        phi: 0.5,
    };
    LocalPupil::circular(Wavefront::third_order(&numbers, point().at), 0.1)
}

/// Pupil and chief ray of that lens behind `effect`.
fn all_of(effect: &dyn Effect, values: &[f64]) -> (LocalPupil, [f64; 2]) {
    (
        behind(effect, values, point(), lens()),
        effect.chief_ray(values, point()),
    )
}

/// Values with no parameter neutral, counted ones apart.
fn strong(effect: &dyn Effect) -> Vec<f64> {
    let start = effect.starts().pop().expect("there is a start");
    let each = start.values.iter().zip(effect.parameters());
    each.map(|(value, p)| {
        if *value == p.neutral && p.step < 1.0 {
            value - p.step * (value - p.least).signum() * 3.0
        } else {
            *value
        }
    })
    .collect()
}

#[test]
fn identifiers_and_parameters_are_sound() {
    for (index, effect) in ALL.iter().enumerate() {
        assert!(ALL[..index].iter().all(|e| e.id() != effect.id()));
        assert_eq!(by_id(effect.id()).expect("listed").id(), effect.id());
        for (k, p) in effect.parameters().iter().enumerate() {
            let name = format!("{} {}", effect.id(), p.name);
            assert!(p.least <= p.neutral && p.neutral <= p.most, "{name}");
            assert!(p.step > 0.0 && p.step <= p.most - p.least, "{name}");
            let before = &effect.parameters()[..k];
            assert!(before.iter().all(|q| q.name != p.name), "{name}");
        }
    }
    assert!(by_id("fog").is_err());
}

#[test]
fn effects_do_nothing_at_neutral() {
    for effect in ALL {
        let still = all_of(*effect, &neutral(*effect));
        assert_eq!(still, (lens(), [0.0; 2]), "{}", effect.id());
    }
}

#[test]
fn neutral_effects_leave_alone_what_the_same_effect_did_before() {
    for effect in ALL {
        let (once, _) = all_of(*effect, &strong(*effect));
        let twice = behind(*effect, &neutral(*effect), point(), once);
        assert_eq!(twice, once, "{}", effect.id());
    }
}

#[test]
fn searches_start_off_neutral_and_every_free_parameter_counts() {
    for effect in ALL {
        let parameters = effect.parameters();
        let mut freed = vec![false; parameters.len()];
        for start in effect.starts() {
            let here = all_of(*effect, &start.values);
            assert_ne!(here, (lens(), [0.0; 2]), "{}", effect.id());
            for (k, p) in parameters.iter().enumerate() {
                let value = start.values[k];
                assert!(p.least <= value && value <= p.most, "{}", p.name);
                let mut values = start.values.clone();
                values[k] += if value + p.step > p.most {
                    -p.step
                } else {
                    p.step
                };
                if start.free[k] {
                    assert_ne!(all_of(*effect, &values), here, "{} {}", effect.id(), p.name);
                }
                freed[k] |= start.free[k];
            }
        }
        for (p, freed) in parameters.iter().zip(freed) {
            let counted = ["blades", "pivot"].contains(&p.name);
            assert!(freed != counted, "{} {}", effect.id(), p.name);
        }
    }
}

#[test]
fn light_is_kept() {
    const SIDE: usize = 96;
    let grid = TileGrid {
        corner_px: [-(SIDE as f64) / 2.0; 2],
        width: SIDE,
        height: SIDE,
    };
    for effect in ALL.iter().filter(|e| e.id() != "tone_curve") {
        for start in effect.starts() {
            let (pupil, _) = all_of(*effect, &start.values);
            let (mut space, mut drawn) = (Workspace::default(), PsfImage::default());
            draw(&pupil, &grid, &[], Detail::FIT, &mut space, &mut drawn);
            // Wide skirts end beyond the window.
            let light: f64 = drawn.light.iter().sum();
            assert!((light - 1.0).abs() < 0.02, "{} {light}", effect.id());
        }
    }
}

fn rescale(effect: &dyn Effect, values: &[f64], to: ControlRatios) -> Vec<f64> {
    let series: Vec<_> = values
        .iter()
        .copied()
        .map(VergenceSeries::constant)
        .collect();
    effect
        .rescale(&series, to)
        .iter()
        .map(|s| s.at(0.3))
        .collect()
}

fn assert_close(a: [f64; 2], b: [f64; 2], what: &str) {
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() < 1e-12 * (1.0 + b.abs()), "{what}: {a} {b}");
    }
}

/// Points of the pupil at which rays are compared.
const RAYS: [[f64; 2]; 3] = [[0.3, -0.4], [-0.8, 0.1], [0.0, 0.9]];

#[test]
fn a_narrower_pupil_sees_the_same_effect() {
    let to = ControlRatios {
        pupil: 0.5,
        image_distance: 1.0,
    };
    // The iris is what narrows; its own tests say how.
    for effect in ALL.iter().filter(|e| e.id() != "aperture_polygon") {
        let (id, values) = (effect.id(), strong(*effect));
        let narrow = ScenePoint {
            defocus_px_m: point().defocus_px_m * to.pupil,
            ..point()
        };
        let now = rescale(*effect, &values, to);
        let got = behind(*effect, &now, narrow, lens().with_pupil(to.pupil));
        let (was, chief) = all_of(*effect, &values);
        let want = was.with_pupil(to.pupil);
        for u in RAYS {
            assert_close(got.landing(u), want.landing(u), id);
            let (a, b) = (got.transmission.at(u), want.transmission.at(u));
            assert!((a - b).abs() < 1e-12, "{id}");
        }
        assert_eq!(
            (got.squeeze, got.sensor),
            (want.squeeze, want.sensor),
            "{id}"
        );
        assert!((got.wave_px - want.wave_px).abs() < 1e-12, "{id}");
        let stops = |p: &LocalPupil| -> Vec<Stop> { p.stops().to_vec() };
        assert_eq!(stops(&got).len(), stops(&want).len(), "{id}");
        for (a, b) in stops(&got).iter().zip(stops(&want)) {
            assert_close(a.centre, b.centre, id);
            assert!((a.radius - b.radius).abs() < 1e-12, "{id}");
        }
        assert_close(effect.chief_ray(&now, narrow), chief, id);
    }
}

#[test]
fn a_sensor_further_off_spreads_angles_and_narrows_cones() {
    let k = 1.25;
    let to = ControlRatios {
        pupil: 1.0,
        image_distance: k,
    };
    let none = LocalPupil::circular(Wavefront::default(), 0.0);
    let rays = |id: &str, values: &[f64], point: ScenePoint| {
        let effect = by_id(id).expect("listed");
        let pupil = behind(effect, values, point, none);
        let landed = RAYS.map(|u| pupil.landing(u));
        let all = landed
            .into_iter()
            .chain([effect.chief_ray(values, point), pupil.sensor.streak_px]);
        all.collect::<Vec<_>>()
    };
    let compare = |id: &str, seen_from: ScenePoint, factor: f64| {
        let effect = by_id(id).expect("listed");
        let values = strong(effect);
        let now = rays(id, &rescale(effect, &values, to), point());
        for (now, was) in now.into_iter().zip(rays(id, &values, seen_from)) {
            assert_close(now, was.map(|w| w * factor), id);
        }
    };
    // What glass or a turning camera does belongs to an angle.
    let angle = place(point().at.x / k, point().at.y / k);
    for id in [
        "decentre",
        "higher_order",
        "axial_colour",
        "lateral_colour",
        "distortion",
        "anamorphic",
        "motion",
    ] {
        compare(id, angle, k);
    }
    // A sensor in the wrong place is so by a length.
    for id in ["defocus_offset", "sensor_tilt"] {
        compare(id, point(), 1.0 / k);
    }
}
