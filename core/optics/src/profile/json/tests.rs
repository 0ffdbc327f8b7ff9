//! Profiles of both kinds round-trip; damaged ones are rejected with the place.

use std::collections::BTreeMap;

use proptest::prelude::*;

use super::*;
use crate::effects;
use crate::lens::{MomentCoefficients, VergenceSeries};
use crate::profile::{
    Adequacy, FieldPattern, FieldZone, HeldOut, HeldOutGroup, MomentsChannel, MomentsPlane,
    ProfileEffect, PupilChannel, RadialDisplacement, ResidualPattern, TileCoverage, WorstPlace,
};

fn moments_profile() -> LensProfile {
    let plane = |distance, s1| MomentsPlane {
        distance,
        s: MomentCoefficients([s1, 0.5, -0.25, 0.1, 0.2, 0.0, 0.3, 0.4, -0.5, 0.6]),
        s_sigma: [0.01; 10],
        displacement: Some(RadialDisplacement {
            magnification: 1e-3,
            distortion: -2e-3,
            magnification_sigma: 1e-5,
            distortion_sigma: 1e-5,
        }),
        tiles_used: 99,
        tiles_rejected: 1,
    };
    LensProfile {
        frame: Frame::new(1920, 1080, None).expect("valid"),
        pixel_pitch_um: Some(4.0),
        camera: Camera {
            focus_distance: ObjectDistance::Infinity,
            ..Camera::default()
        },
        description: LensDescription::Moments(vec![MomentsChannel {
            name: "G".into(),
            planes: vec![
                plane(ObjectDistance::Infinity, 3.0),
                plane(ObjectDistance::Metres(2.5), 7.0),
            ],
        }]),
        held_out: None,
        provenance: Provenance {
            program: "seidel 0.1.0".into(),
            sources: vec!["set".into()],
            settings: "moments".into(),
            tiles: vec![TileCoverage {
                vergence_per_m: Some(0.25),
                tiles: 9,
                x_px: [12.5, 880.25],
                y_px: [9.5, 500.0],
            }],
        },
    }
}

fn series(coefficients: &[f64]) -> VergenceSeries {
    VergenceSeries {
        coefficients: coefficients.to_vec(),
        sigma: coefficients.iter().map(|c| c.abs() / 7.0).collect(),
        remainders: vec![(0.1, 0.01), (0.25, -0.02)],
    }
}

/// A profile with every effect, slightly off neutral.
fn pupil_profile() -> LensProfile {
    let effects = effects::ALL.iter().map(|&effect| ProfileEffect {
        effect,
        values: effect
            .parameters()
            .iter()
            .map(|p| {
                let value = 0.9 * p.neutral + 0.1 * p.most.min(1.0);
                VergenceSeries::new(vec![value, 1e-3])
            })
            .collect(),
    });
    LensProfile {
        description: LensDescription::Pupil(vec![PupilChannel {
            name: "G".into(),
            alpha: series(&[-5.5, 11.0]),
            beta: series(&[1.0 / 3.0, 0.1, -0.2]),
            gamma: series(&[0.7]),
            delta: series(&[-0.3]),
            phi: series(&[0.1 + 0.2]),
            blur_variance_px2: series(&[0.05]),
            magnification: series(&[1e-3]),
            distortion: series(&[-2e-3, 1e-4]),
            measured_vergence: (0.125, 1.0),
            stop_lever_m: 0.0,
            added: Vec::new(),
            picture: None,
            wavelength_px: 0.0,
            effects: effects.collect(),
        }]),
        held_out: Some(HeldOut {
            tiles: 12,
            rule: "every fifth observation".into(),
            snr_db: 41.2,
            pixel_gap: 3.7e-3,
            groups: vec![HeldOutGroup {
                channel: "G".into(),
                distance: ObjectDistance::Infinity,
                tiles: 12,
                snr_db: 41.2,
                pixel_gap: 3.7e-3,
                misplaced_light: Some(0.021),
            }],
            misplaced_light: Some(0.021),
            neighbours_snr_db: Some(36.5),
            adequacy: Some(Adequacy {
                noise_gap: 1e-4,
                excess_gap: 3.6e-3,
                systematic_gap: 2e-3,
                worst: WorstPlace {
                    channel: "G".into(),
                    distance: ObjectDistance::Infinity,
                    zone: FieldZone::Edge,
                    excess_gap: 5e-3,
                    elsewhere_gap: Some(3.5e-3),
                },
                pattern: ResidualPattern {
                    periods: 2,
                    share: 0.7,
                    field: FieldPattern::Meridional,
                },
            }),
        }),
        ..moments_profile()
    }
}

#[test]
fn profiles_survive_the_round_trip() {
    for profile in [moments_profile(), pupil_profile()] {
        let text = profile.to_json();
        assert_eq!(LensProfile::from_json(&text), Ok(profile));
    }
    let mut unknown = moments_profile();
    unknown.camera.focus_distance = ObjectDistance::Unknown;
    let LensDescription::Moments(channels) = &mut unknown.description else {
        panic!("of this kind");
    };
    channels[0].planes.truncate(1);
    channels[0].planes[0].distance = ObjectDistance::Unknown;
    let text = unknown.to_json();
    assert!(!text.contains("depth_m"), "unknown distances are left out");
    assert_eq!(LensProfile::from_json(&text), Ok(unknown));
}

/// Replaces the first occurrence of each text in turn; every result must be rejected with the expected message.
fn assert_all_rejected(good: &str, damages: &[(&str, &str, &str)]) {
    for (from, to, expected) in damages {
        let bad = good.replacen(from, to, 1);
        assert_ne!(bad, good, "{from} stands in the text");
        let error = LensProfile::from_json(&bad).expect_err(to);
        assert!(error.to_string().contains(expected), "{to}: {error}");
    }
}

#[test]
fn damaged_profiles_are_rejected_with_the_place() {
    let good = moments_profile().to_json();
    assert_all_rejected(
        &good,
        &[
            ("seidel-lens", "other", "format"),
            ("\"version\": 1", "\"version\": 2", "version"),
            (
                "\"kind\": \"moments\"",
                "\"kind\": \"reduced\"",
                "\"pupil\"",
            ),
            ("\"kind\": \"moments\"", "\"kind\": \"pupil\"", "line"),
            ("\"tiles_used\"", "\"tiles\"", "line"),
            (
                "\"image_size\": [\n    1920",
                "\"image_size\": [\n    0",
                "image_size",
            ),
            ("\"depth_m\": 2.5", "\"depth_m\": -2.5", "depth_m"),
            ("\"depth_m\": 2.5", "\"depth_m\": null", "channel G"),
            (
                "\"pixel_pitch_um\": 4.0",
                "\"pixel_pitch_um\": 0.0",
                "pixel_pitch_um",
            ),
            ("3.0", "1e999", "line"),
        ],
    );
    let unknown_key = LensProfile::from_json(&good.replacen("\"tiles_used\"", "\"tiles\"", 1))
        .expect_err("an unknown key");
    assert!(unknown_key.problem.contains("tiles"), "{unknown_key}");
}

#[test]
fn damaged_pupils_are_rejected_with_the_place() {
    assert_all_rejected(
        &pupil_profile().to_json(),
        &[
            ("\"gamma\"", "\"gama\"", "gama"),
            (
                "\"coefficients\": [\n          0.7\n        ]",
                "\"coefficients\": []",
                "gamma: coefficients",
            ),
            (
                "\"coefficients\": [\n          0.7\n        ]",
                "\"coefficients\": [1, 2]",
                "gamma: sigma",
            ),
            ("0.09999999999999999", "-0.1", "sigma"),
            ("0.125", "1.125", "measured_vergence_per_m"),
            ("0.125", "-0.125", "measured_vergence_per_m"),
            (
                "\"id\": \"higher_order\"",
                "\"id\": \"fog\"",
                "higher_order, ",
            ),
            ("\"id\": \"vignetting\"", "\"id\": \"higher_order\"", "w060"),
            ("\"w060\"", "\"w061\"", "w060"),
            (
                "\"w060\": {",
                "\"w061\": {\"coefficients\": [0], \"sigma\": [0]}, \"w060\": {",
                "no parameter `w061`",
            ),
            (
                "\"shift_1\": {\n              \"coefficients\": [\n                0.1",
                "\"shift_1\": {\n              \"coefficients\": [\n                9.1",
                "shift_1",
            ),
            ("\"rule\"", "\"rules\"", "rules"),
        ],
    );
}

/// The one channel of a pupil profile.
#[test]
fn a_blur_too_large_to_draw_is_rejected() {
    for coefficients in [[1.001e4, 0.0], [0.0, 1.1e4], [5.6e8, 0.0]] {
        let mut profile = pupil_profile();
        only_channel(&mut profile).blur_variance_px2 = series(&coefficients);
        let error = LensProfile::from_json(&profile.to_json()).expect_err("too large");
        let place = "channels[0] (G): blur_variance_px2: coefficients";
        assert_eq!(error.place, place);
        assert!(error.remedy.contains("10000 px²"), "{error}");
    }
    // 100 px standard deviation at the nearest measured distance.
    let mut largest = pupil_profile();
    only_channel(&mut largest).blur_variance_px2 = series(&[0.0, 1e4]);
    LensProfile::from_json(&largest.to_json()).expect("drawable");
}

#[test]
fn wavelengths_of_no_light_and_of_no_channel_are_rejected() {
    for (name, nm) in [("G", 0.0), ("G", -1.0), ("G", 0.55), ("X", 540.0)] {
        let mut profile = pupil_profile();
        profile.camera.wavelength_nm = BTreeMap::from([(name.to_owned(), nm)]);
        let error = LensProfile::from_json(&profile.to_json()).expect_err("no wavelength");
        assert_eq!(error.place, format!("camera.wavelength_nm.{name}"));
    }
}

fn only_channel(profile: &mut LensProfile) -> &mut PupilChannel {
    match &mut profile.description {
        LensDescription::Pupil(channels) => &mut channels[0],
        LensDescription::Moments(_) => panic!("of the other kind"),
    }
}

#[test]
fn effects_and_channels_occur_once_and_effects_in_order() {
    let mut reversed = pupil_profile();
    only_channel(&mut reversed).effects.reverse();
    let mut twice = pupil_profile();
    let first = only_channel(&mut twice).effects[0].clone();
    only_channel(&mut twice).effects.insert(0, first);
    let mut again = pupil_profile();
    let channel = only_channel(&mut again).clone();
    again.description = LensDescription::Pupil(vec![channel.clone(), channel]);
    let mut none = pupil_profile();
    none.description = LensDescription::Pupil(Vec::new());
    for (profile, expected) in [
        (reversed, "effects: has"),
        (twice, "effects: has"),
        (again, "occurs twice"),
        (none, "is empty"),
    ] {
        let error = LensProfile::from_json(&profile.to_json()).expect_err(expected);
        assert!(error.to_string().contains(expected), "{error}");
    }
}

#[test]
fn added_effects_round_trip_and_are_checked_like_fitted_ones() {
    let with = |ids: &[&str], value: f64| {
        let mut profile = pupil_profile();
        let added = ids.iter().map(|id| {
            let effect = effects::by_id(id).expect("listed");
            let mut values = effects::neutral(effect);
            values[0] = value;
            ProfileEffect {
                effect,
                values: values.into_iter().map(VergenceSeries::constant).collect(),
            }
        });
        only_channel(&mut profile).added = added.collect();
        profile
    };
    let good = with(&["axial_colour", "vignetting"], 0.5);
    assert_eq!(LensProfile::from_json(&good.to_json()), Ok(good));
    for (ids, value, expected) in [
        (&["diffraction"][..], 65.0, "f_number"),
        (&["diffraction"], -1.0, "f_number"),
        (&["vignetting", "axial_colour"], 0.5, "added_effects"),
        (&["motion", "motion"], 0.5, "added_effects"),
        (&["aperture_polygon"], 7.0, "added_effects"),
    ] {
        let error = LensProfile::from_json(&with(ids, value).to_json()).expect_err(expected);
        assert!(error.to_string().contains(expected), "{error}");
    }
    let mut bladed = with(&["aperture_polygon"], 7.0);
    only_channel(&mut bladed).effects.clear();
    assert_eq!(LensProfile::from_json(&bladed.to_json()), Ok(bladed));
}

#[test]
fn the_schema_names_every_key_of_both_kinds() {
    let schema = schema();
    for key in [
        "depth_m",
        "s_sigma",
        "optical_axis",
        "provenance",
        "distortion",
        "blur_variance_px2",
        "measured_vergence_per_m",
        "coefficients",
        "effects",
        "held_out",
    ] {
        assert!(schema.contains(key), "{key}");
    }
}

proptest! {
    #[test]
    fn damaged_text_never_panics(
        kind in any::<bool>(), cut in 0usize..4000, byte in any::<u8>(), at in 0usize..8000
    ) {
        let profile = if kind { pupil_profile() } else { moments_profile() };
        let mut bytes = profile.to_json().into_bytes();
        let at = at % bytes.len();
        bytes[at] = byte;
        bytes.truncate(bytes.len().saturating_sub(cut));
        if let Ok(text) = String::from_utf8(bytes) {
            let _ = LensProfile::from_json(&text);
        }
    }
}
