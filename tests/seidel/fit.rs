//! `seidel fit` on generated sets: the true lens is recovered, and the report is complete.

use seidel_core::{BlurField, FieldPoint, LensProfile, Predictor};

use crate::support::{
    seidel_in, succeeds, true_alpha, true_numbers, write_generated_set, write_moments_lens,
};

fn profile(path: &std::path::Path) -> LensProfile {
    LensProfile::from_json(&std::fs::read_to_string(path).expect("written")).expect("valid")
}

#[test]
fn the_true_lens_is_recovered_in_every_channel_and_plane() {
    let folder = tempfile::tempdir().expect("a folder");
    write_moments_lens(folder.path(), &["R", "G", "B"]);
    let lens = profile(&folder.path().join("lens.json"));
    assert_eq!(lens.channel_names(), ["R", "G", "B"]);
    assert_eq!(lens.provenance.sources, ["set"]);
    for (channel, fitted) in lens.moments_channels().iter().enumerate() {
        for plane in &fitted.planes {
            let v = plane.distance.vergence_per_m().expect("known");
            let truth = true_numbers(true_alpha(channel, v)).coefficients();
            let distance = plane.s.distance(&truth, 1.0);
            assert!(distance < 5e-3, "{channel} {}: {distance}", plane.distance);
            let moved = plane.displacement.expect("ideal positions are given");
            assert!((moved.magnification - 0.002 * channel as f64).abs() < 2e-5);
        }
    }
    // Between the planes the depth law interpolates the blur.
    let predictor = Predictor::new(&lens).expect("a lens");
    let v: f64 = 0.65;
    let at = FieldPoint::new(0.6, -0.4);
    let want = true_numbers(true_alpha(0, v)).coefficients().moments(at);
    let got = predictor.blur_at(0, at, v).blur.moments;
    for (got, want_one) in got.to_array().iter().zip(want.to_array()) {
        assert!(
            (got - want_one).abs() < 0.01 * want.trace(),
            "{got} {want_one}"
        );
    }
}

#[test]
fn sets_of_single_distances_fit_like_one_set_of_all() {
    use seidel_core::ObjectDistance;
    let folder = tempfile::tempdir().expect("a folder");
    write_moments_lens(folder.path(), &["Y"]);
    for (name, distance) in [
        ("near", ObjectDistance::Metres(1.2)),
        ("mid", ObjectDistance::Metres(2.5)),
        ("far", ObjectDistance::Infinity),
    ] {
        let set = crate::support::generated_set(&["Y"], &[distance]);
        seidel_image_io::observation_set::write(&set, &folder.path().join(name)).expect("writable");
    }
    succeeds(
        folder.path(),
        "fit @near @mid @far -o @joined.json --model moments",
    );
    let (one, many) = (
        profile(&folder.path().join("lens.json")),
        profile(&folder.path().join("joined.json")),
    );
    assert_eq!(one.description, many.description);
    assert_eq!(many.provenance.sources, ["near", "mid", "far"]);
}

#[test]
fn the_report_is_text_or_json_and_mentions_a_single_distance() {
    let folder = tempfile::tempdir().expect("a folder");
    let set = crate::support::generated_set(&["Y"], &[seidel_core::ObjectDistance::Unknown]);
    seidel_image_io::observation_set::write(&set, &folder.path().join("set")).expect("writable");
    let text = succeeds(
        folder.path(),
        "fit @set -o @a.json --axis free --model moments",
    );
    assert!(text.stdout.contains("optical axis (1"), "{}", text.stdout);
    assert!(text.stderr.contains("object distance"), "{}", text.stderr);
    let json = succeeds(
        folder.path(),
        "fit @set -o @b.json --unweighted --json --model moments",
    );
    let report: serde_json::Value = serde_json::from_str(&json.stdout).expect("one document");
    assert_eq!(report["planes"][0]["tiles"], 24);
    assert_eq!(report["planes"][0]["converged"], true);
}

#[test]
fn bad_observations_are_skipped_on_request_only_and_named() {
    let folder = tempfile::tempdir().expect("a folder");
    write_generated_set(folder.path(), "set", &["Y"]);
    std::fs::remove_file(folder.path().join("set/psf/0003.exr")).expect("it is there");
    let refused = seidel_in(folder.path(), "fit @set -o @lens.json --model moments");
    assert_eq!(refused.status, 1);
    assert!(
        refused.stderr.contains("psf/0003.exr"),
        "{}",
        refused.stderr
    );
    assert!(!folder.path().join("lens.json").exists());
    let left_out = succeeds(
        folder.path(),
        "fit @set -o @lens.json --skip-bad --model moments",
    );
    assert!(
        left_out.stderr.contains("psf/0003.exr"),
        "{}",
        left_out.stderr
    );
}
