//! Amounts agree with the laws of lens controls and with geometry.

use super::*;
use crate::camera::Camera;
use crate::distance::ObjectDistance;
use crate::effects;
use crate::field::Frame;
use crate::lens::VergenceSeries;
use crate::profile::{Controls, LensDescription, LensProfile, Provenance, PupilChannel};

/// Returns the amount of the effect `id` of `lens`; empty where there is none.
fn amount(id: &str, values: &[FittedValue], lens: &LensProfile) -> String {
    let effect = effects::by_id(id).expect("listed");
    let lens = &lens.scale();
    let words = effect.fitted_amount(Fitted { values, lens });
    words.unwrap_or_default()
}

/// Returns a 50 mm lens at f/2 on pixels of 5 µm, focused at 2 m, with the pupil inverted if `sign` is -1.
pub(crate) fn lens(sign: f64) -> LensProfile {
    let slope = sign * 0.05 / 0.975 * 0.0125 / 5e-6;
    let none = VergenceSeries::constant(0.0);
    LensProfile {
        frame: Frame::new(600, 400, None).expect("valid"),
        pixel_pitch_um: Some(5.0),
        camera: Camera {
            focal_length_mm: Some(50.0),
            f_number: Some(2.0),
            focus_distance: ObjectDistance::Metres(2.0),
            ..Camera::default()
        },
        description: LensDescription::Pupil(vec![PupilChannel {
            name: "G".to_owned(),
            alpha: VergenceSeries::new(vec![-0.5 * slope, slope]),
            beta: none.clone(),
            gamma: none.clone(),
            delta: none.clone(),
            phi: none.clone(),
            blur_variance_px2: none.clone(),
            effects: Vec::new(),
            added: Vec::new(),
            picture: None,
            magnification: none.clone(),
            distortion: none,
            stop_lever_m: 0.0,
            wavelength_px: 0.0,
            measured_vergence: (0.0, 1.0),
        }]),
        held_out: None,
        provenance: Provenance::default(),
    }
}

fn value(name: &'static str, value: f64, sigma: f64) -> FittedValue {
    FittedValue {
        name,
        channel: None,
        unit: "px",
        value,
        sigma,
    }
}

/// Returns the change of alpha at the focus of `lens` by `controls`.
fn alpha_change(lens: &LensProfile, controls: &Controls) -> f64 {
    let moved = lens.with_controls(controls).expect("a known camera");
    let alpha = |lens: &LensProfile| lens.pupil_channels()[0].alpha.at(0.5);
    alpha(&moved) - alpha(lens)
}

#[test]
fn a_moved_sensor_is_named_by_length_side_and_focus() {
    for sign in [1.0, -1.0] {
        let lens = lens(sign);
        for (shift_um, side) in [(30.0, "behind"), (-30.0, "in front of")] {
            let moved = Controls {
                sensor_shift_um: Some(shift_um),
                ..Controls::default()
            };
            let alpha = alpha_change(&lens, &moved);
            let words = amount("defocus_offset", &[value("alpha", alpha, 0.01)], &lens);
            let expected = format!("0.03000 ± 0.00021 mm {side} the stated focus");
            assert!(words.contains(&expected), "{sign}: {words}");
        }
        let refocused = Controls {
            focus_distance: Some(ObjectDistance::Metres(2.1)),
            ..Controls::default()
        };
        let alpha = alpha_change(&lens, &refocused);
        let words = amount("defocus_offset", &[value("alpha", alpha, 0.01)], &lens);
        assert!(
            words.ends_with("focus is at 2.10 m, that of the profile at 2.00 m")
                && words.contains("in front of"),
            "{words}"
        );
    }
}

#[test]
fn without_camera_data_amounts_are_in_pixels() {
    let bare = LensProfile {
        pixel_pitch_um: None,
        camera: Camera::default(),
        ..lens(1.0)
    };
    let words = amount("defocus_offset", &[value("alpha", -1.2, 0.02)], &bare);
    assert!(words.contains("1.200 ± 0.020 px radius"), "{words}");
    let tilt = [value("tilt_x", 0.0, 0.1), value("tilt_y", -2.0, 0.1)];
    let words = amount("sensor_tilt", &tilt, &bare);
    assert!(
        words.contains("2.00 ± 0.10 px") && words.contains("the top"),
        "{words}"
    );
}

#[test]
fn a_tilted_sensor_is_named_by_angle_and_side() {
    // Half a frame width is 1.5 mm; at 0.5 degrees its right end is 13.09 µm farther from the lens, where defocus
    // falls by that length over twice the f-number of the cone and the pitch.
    let shift_um = 0.5_f64.to_radians().tan() * 1500.0;
    let change = -shift_um / (2.0 * (2.0 / 0.975) * 5.0);
    let tilt = [value("tilt_x", change, 0.01), value("tilt_y", 0.0, 0.01)];
    let words = amount("sensor_tilt", &tilt, &lens(1.0));
    assert!(words.contains("0.5000 ± 0.0078 degrees"), "{words}");
    assert!(words.contains("far side towards the right"), "{words}");
}

#[test]
fn a_clipped_pupil_is_a_share_of_its_area() {
    // A circle of the pupil's size, shifted by a radius, leaves 2/3 - √3/(2 π) of the disc.
    let values = [
        value("radius_1", 1.0, 0.0),
        value("shift_1", 1.0, 0.0),
        value("radius_2", 4.0, 0.0),
    ];
    let words = amount("vignetting", &values, &lens(1.0));
    assert_eq!(
        words,
        "61 % of the pupil is clipped at the side of the frame, 0 % in the middle"
    );
}

#[test]
fn lengths_directions_and_shares() {
    let lens = lens(1.0);
    let streak = [value("x", -3.0, 0.1), value("y", 3.0, 0.1)];
    assert_eq!(
        amount("motion", &streak, &lens),
        "a streak of 4.24 ± 0.10 px, 135 degrees from image x towards y"
    );
    let red = |name, v: f64| FittedValue {
        channel: Some("R".to_owned()),
        ..value(name, v, 0.01)
    };
    assert_eq!(
        amount(
            "lateral_colour",
            &[red("linear", -1.0), red("cubic", 0.25)],
            &lens
        ),
        "at the side of the frame, channel R 0.750 px inwards"
    );
    assert_eq!(
        amount("veiling_glare", &[red("share", 0.031)], &lens),
        "3.1 ± 1.0 % of the light of channel R scatters"
    );
    assert_eq!(
        amount("pupil_scale", &[value("scale", 1.25, 0.01)], &lens),
        "the pupil is 1.250 ± 0.010 times as wide as stated: f/1.600 ± 0.013 instead of f/2"
    );
}

#[test]
fn effects_without_fitted_values_have_no_amount() {
    for effect in effects::ALL {
        assert_eq!(amount(effect.id(), &[], &lens(1.0)), "", "{}", effect.id());
    }
}
