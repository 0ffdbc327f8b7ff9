//! A lens of one distance follows the data of its camera; missing, contradicting and impossible data are named.

use seidel_core::{Controls, FieldPoint};
use seidel_optics::lens::VergenceSeries;

use super::*;

const TWO_METRES: ObjectDistance = ObjectDistance::Metres(2.0);
/// Slope of the defocus of a thin lens of 50 mm and f/2 in focus at 3 m, with pixels of 4 µm, px m.
const SLOPE: f64 = 0.0125 * 0.05 / (1.0 - 0.05 / 3.0) / 4e-6;

/// Returns a lens that was measured at 2 m alone, with `defocus` there.
fn lens(defocus: f64) -> LensProfile {
    let mut lens = crate::demo::lens::lens(320, 180).expect("a lens");
    let LensDescription::Pupil(channels) = &mut lens.description else {
        panic!("the demo's lens has a pupil");
    };
    for channel in channels {
        let at = |series: &VergenceSeries| VergenceSeries::constant(series.at(0.5));
        channel.alpha = VergenceSeries::constant(defocus);
        channel.measured_vergence = (0.5, 0.5);
        for series in [
            &mut channel.beta,
            &mut channel.gamma,
            &mut channel.delta,
            &mut channel.phi,
        ] {
            *series = at(series);
        }
    }
    lens.camera = Camera {
        focal_length_mm: Some(50.0),
        f_number: Some(2.0),
        focus_distance: ObjectDistance::Metres(3.0),
        ..Camera::default()
    };
    lens.pixel_pitch_um = Some(4.0);
    lens
}

fn variance(lens: &LensProfile, metres: f64) -> f64 {
    let channel = &lens.pupil_channels()[0];
    channel
        .moments_at(FieldPoint::new(0.0, 0.0), 1.0 / metres)
        .trace()
}

#[test]
fn one_distance_and_a_camera_make_a_lens_that_can_be_focused() {
    let expected = SLOPE / 6.0;
    // A fit may find the pupil inverted.
    for sign in [1.0, -1.0] {
        let mut lens = lens(sign * expected);
        let before = variance(&lens, 2.0);
        let remark = extend_one_distance(&mut lens, TWO_METRES).expect("a remark");
        assert!(remark.contains("thin lens of 50 mm and f/2"), "{remark}");
        assert!((variance(&lens, 2.0) / before - 1.0).abs() < 1e-9);
        assert!(variance(&lens, 3.0) < 0.1 * before && variance(&lens, 1.0) > 4.0 * before);
        let controls = Controls {
            focus_distance: Some(TWO_METRES),
            f_number: Some(4.0),
            ..Controls::default()
        };
        let focused = lens.with_controls(&controls).expect("a camera");
        assert!(variance(&focused, 2.0) < 0.1 * before);
    }
}

#[test]
fn missing_and_contradicting_data_are_named() {
    let mut bare = lens(20.0);
    bare.camera.f_number = None;
    let before = bare.clone();
    let remark = extend_one_distance(&mut bare, TWO_METRES).expect("a remark");
    assert!(remark.contains("Give --f-number,"), "{remark}");
    assert_eq!(bare, before);
    let remark = extend_one_distance(&mut lens(5.0), TWO_METRES).expect("a remark");
    assert!(remark.contains("the photographs show 10.0"), "{remark}");
    assert_eq!(
        extend_one_distance(&mut lens(5.0), ObjectDistance::Unknown),
        None
    );
}

#[test]
fn values_out_of_range_name_their_option() {
    let args = CameraArgs {
        pitch_um: Some(0.004),
        ..CameraArgs::default()
    };
    let error = args.of(&[], 640).expect_err("no pitch").to_string();
    assert!(
        error.contains("--pitch-um") && error.contains("0.2"),
        "{error}"
    );
}
