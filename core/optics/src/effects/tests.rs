//! Properties of all effects, and lenses and points for the tests of each.

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

/// Returns [`point`] at another field position.
pub(crate) fn place(x: f64, y: f64) -> ScenePoint {
    ScenePoint {
        at: FieldPoint::new(x, y),
        ..point()
    }
}

/// Returns a pupil with defocus only, on the axis, without blur.
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

/// Returns `pupil` with `effect` applied.
pub(crate) fn behind(
    effect: &dyn Effect,
    values: &[f64],
    point: ScenePoint,
    mut pupil: LocalPupil,
) -> LocalPupil {
    effect.apply(values, point, &mut pupil);
    pupil
}

/// Returns a pupil with all third-order aberrations.
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

/// Returns pupil and chief ray of [`lens`] with `effect` applied.
fn applied(effect: &dyn Effect, values: &[f64]) -> (LocalPupil, [f64; 2]) {
    (
        behind(effect, values, point(), lens()),
        effect.chief_ray(values, point()),
    )
}

/// Returns values of which none is neutral, except counts.
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
fn every_effect_has_words_of_its_own() {
    for (index, effect) in ALL.iter().enumerate() {
        let (id, words) = (effect.id(), effect.description());
        let others = ALL[..index].iter().map(|e| e.description().title);
        assert!(others.into_iter().all(|title| title != words.title), "{id}");
        let is_plain = !words.title.is_empty() && (words.title != id || !id.contains('_'));
        assert!(is_plain, "{id} needs a plain title");
        for sentence in [words.meaning, words.action] {
            assert!(sentence.ends_with('.'), "{sentence}");
            let mut raw = ALL.iter().map(|e| e.id()).filter(|id| id.contains('_'));
            assert!(raw.all(|raw| !sentence.contains(raw)), "{sentence}");
        }
        assert_eq!(words.meaning.matches(". ").count(), 0, "one sentence: {id}");
    }
}

#[test]
fn neutral_values_have_no_effect() {
    for effect in ALL {
        let still = applied(*effect, &neutral(*effect));
        assert_eq!(still, (lens(), [0.0; 2]), "{}", effect.id());
    }
}

#[test]
fn neutral_effects_keep_an_earlier_instance_of_themselves() {
    for effect in ALL {
        let (once, _) = applied(*effect, &strong(*effect));
        let twice = behind(*effect, &neutral(*effect), point(), once.clone());
        assert_eq!(twice, once, "{}", effect.id());
    }
}

#[test]
fn starts_are_not_neutral_and_every_free_parameter_matters() {
    for effect in ALL {
        let parameters = effect.parameters();
        let mut freed = vec![false; parameters.len()];
        for start in effect.starts() {
            let here = applied(*effect, &start.values);
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
                    assert_ne!(
                        applied(*effect, &values),
                        here,
                        "{} {}",
                        effect.id(),
                        p.name
                    );
                }
                freed[k] |= start.free[k];
            }
        }
        for (p, freed) in parameters.iter().zip(freed) {
            // Counts, and what only fits to tiles tell.
            let is_of_shots = p.name == "shots" || p.name.starts_with("vergence_");
            let held = is_of_shots || ["blades", "pivot", "slant"].contains(&p.name);
            assert!(freed != held, "{} {}", effect.id(), p.name);
        }
    }
}

/// Returns the maps of the frame onto itself under which a lens of `symmetry` stays the same: rows of their matrices.
fn maps(symmetry: Symmetry) -> Vec<[[f64; 2]; 2]> {
    let (sin, cos) = 0.7_f64.sin_cos();
    match symmetry {
        Symmetry::Round => vec![[[cos, -sin], [sin, cos]], [[-1.0, 0.0], [0.0, 1.0]]],
        Symmetry::TwoPlanes => vec![[[-1.0, 0.0], [0.0, 1.0]], [[1.0, 0.0], [0.0, -1.0]]],
        Symmetry::None => Vec::new(),
    }
}

#[test]
fn effects_have_the_symmetry_that_they_state() {
    for effect in ALL {
        let starts = effect.starts().into_iter().map(|start| start.values);
        for values in starts.chain([strong(*effect)]) {
            let series: Vec<_> = (values.iter().copied())
                .map(VergenceSeries::constant)
                .collect();
            let symmetry = effect.symmetry(&series);
            for map in maps(symmetry) {
                let moved = |[x, y]: [f64; 2]| map.map(|row| row[0] * x + row[1] * y);
                let [x, y] = moved([point().at.x, point().at.y]);
                let here = behind(*effect, &values, point(), disc(3.0));
                let there = behind(*effect, &values, place(x, y), disc(3.0));
                let id = effect.id();
                for u in RAYS {
                    assert_close(there.landing(moved(u)), moved(here.landing(u)), id);
                    assert_eq!(there.passes(moved(u)), here.passes(u), "{id}");
                    let (a, b) = (there.transmission.at(moved(u)), here.transmission.at(u));
                    assert!((a - b).abs() < 1e-12, "{id}");
                }
                let chief = |point| effect.chief_ray(&values, point);
                assert_close(chief(place(x, y)), moved(chief(point())), id);
                assert_eq!(here.sensor.streak_px, [0.0; 2], "{id}");
                let is_round = here.sensor.copies_px == [0.0; 2];
                assert!(is_round || symmetry != Symmetry::Round, "{id}");
            }
        }
    }
}

#[test]
fn light_is_conserved() {
    const SIDE: usize = 96;
    let grid = TileGrid {
        corner_px: [-(SIDE as f64) / 2.0; 2],
        width: SIDE,
        height: SIDE,
    };
    for effect in ALL.iter().filter(|e| e.id() != "tone_curve") {
        for start in effect.starts() {
            let (pupil, _) = applied(*effect, &start.values);
            let (mut space, mut drawn) = (Workspace::default(), PsfImage::default());
            draw(&pupil, &grid, &[], Detail::FIT, &mut space, &mut drawn);
            // Wide skirts extend beyond the grid.
            let light: f64 = drawn.light.iter().sum();
            assert!((light - 1.0).abs() < 0.02, "{} {light}", effect.id());
        }
    }
}

fn rescale(effect: &dyn Effect, values: &[f64], ratios: ControlRatios) -> Vec<f64> {
    let series: Vec<_> = values
        .iter()
        .copied()
        .map(VergenceSeries::constant)
        .collect();
    effect
        .rescale(&series, ratios)
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
fn effects_of_a_narrower_pupil_agree_with_the_narrowed_pupil() {
    let ratios = ControlRatios {
        pupil: 0.5,
        image_distance: 1.0,
    };
    // The iris itself narrows; it has its own test.
    for effect in ALL.iter().filter(|e| e.id() != "aperture_polygon") {
        let (id, values) = (effect.id(), strong(*effect));
        let narrow = ScenePoint {
            defocus_px_m: point().defocus_px_m * ratios.pupil,
            ..point()
        };
        let now = rescale(*effect, &values, ratios);
        let got = behind(*effect, &now, narrow, lens().with_pupil(ratios.pupil));
        let (was, chief) = applied(*effect, &values);
        let want = was.with_pupil(ratios.pupil);
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
fn a_farther_sensor_scales_angles_up_and_cones_down() {
    let k = 1.25;
    let ratios = ControlRatios {
        pupil: 1.0,
        image_distance: k,
    };
    let none = LocalPupil::circular(Wavefront::default(), 0.0);
    let rays = |id: &str, values: &[f64], point: ScenePoint| {
        let effect = by_id(id).expect("listed");
        let pupil = behind(effect, values, point, none.clone());
        let landed = RAYS.map(|u| pupil.landing(u));
        let all = landed
            .into_iter()
            .chain([effect.chief_ray(values, point), pupil.sensor.streak_px]);
        all.collect::<Vec<_>>()
    };
    let compare = |id: &str, seen_from: ScenePoint, factor: f64| {
        let effect = by_id(id).expect("listed");
        let mut values = strong(effect);
        if id == "sensor_tilt" {
            // The slant of a disc is of second order in the tilt.
            values[3] = 0.0;
        }
        let now = rays(id, &rescale(effect, &values, ratios), point());
        for (now, was) in now.into_iter().zip(rays(id, &values, seen_from)) {
            assert_close(now, was.map(|w| w * factor), id);
        }
    };
    // Effects of the glass or of a turning camera are angles.
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
    // Effects of the sensor position are lengths.
    for id in ["defocus_offset", "sensor_tilt"] {
        compare(id, point(), 1.0 / k);
    }
}
