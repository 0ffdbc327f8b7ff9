//! `seidel diagnose`: invalid input is refused before any long computation and without leaving files behind.

use std::fs;
use std::path::Path;

use seidel_calibrate::diagnose::estimate_pair;
use seidel_core::diagnosis::{PairImage, PairSettings};
use seidel_core::profile::Provenance;
use seidel_core::{LensProfile, ObjectDistance, Predictor, no_progress};
use seidel_optics::effects;
use seidel_optics::predict::predict_set;
use seidel_optics::psf::Pupil;

use crate::support::{
    must_refuse, read_channel, seidel_in, succeeds, write_exr, write_generated_set,
    write_moments_lens, write_pupil_lens,
};

/// Writes a `pupil` lens of R, G and B and a set of its PSFs, damages them with `spoil`, and asserts that `line` fails with
/// a message that contains all `parts` and leaves the folder unchanged.
fn refused(spoil: impl Fn(&Path), line: &str, parts: &[&str]) {
    let folder = tempfile::tempdir().expect("a folder");
    write_pupil_lens(folder.path(), &["R", "G", "B"]);
    write_generated_set(folder.path(), "set", &["R", "G", "B"]);
    spoil(folder.path());
    must_refuse(folder.path(), line, parts);
}

const DIAGNOSE: &str = "diagnose --lens @lens.json @set --out @out";

/// Writes an image of the lens's frame size with equal `channels`, sample by sample from `pixel`.
fn picture(folder: &Path, name: &str, channels: &[&str], pixel: impl Fn(usize) -> f32) {
    sized(folder, name, channels, (300, 200), pixel);
}

fn sized(
    folder: &Path,
    name: &str,
    channels: &[&str],
    size: (usize, usize),
    pixel: impl Fn(usize) -> f32,
) {
    let (width, height) = size;
    let plane: Vec<f32> = (0..width * height).map(pixel).collect();
    let planes: Vec<(&str, Vec<f32>)> = channels.iter().map(|&c| (c, plane.clone())).collect();
    write_exr(&folder.join(name), width, height, &planes);
}

fn grain(index: usize) -> f32 {
    ((index as f32 * 12.9898).sin() * 43_758.547).fract().abs()
}

#[test]
fn lenses_and_sets_that_do_not_match() {
    refused(
        |folder| fs::remove_file(folder.join("lens.json")).expect("there"),
        DIAGNOSE,
        &["lens.json", "check the path"],
    );
    refused(
        |folder| fs::remove_file(folder.join("set/manifest.json")).expect("there"),
        DIAGNOSE,
        &["set", "manifest.json"],
    );
    refused(
        |folder| write_moments_lens(folder, &["R", "G", "B"]),
        DIAGNOSE,
        &["lens.json", "moments", "--model reduced"],
    );
    refused(
        |folder| write_pupil_lens(folder, &["R", "B"]),
        DIAGNOSE,
        &["set", "channel G", "R, B"],
    );
    refused(
        |folder| {
            let path = folder.join("lens.json");
            let mut lens = LensProfile::from_json(&fs::read_to_string(&path).expect("there"))
                .expect("a profile");
            lens.provenance.settings = Provenance::NONE_HELD_OUT.to_owned();
            fs::write(&path, lens.to_json()).expect("writable");
        },
        DIAGNOSE,
        &["lens.json", "--use-all", "--design"],
    );
    refused(
        |_| (),
        "diagnose --lens @lens.json @set --out @out --only fog",
        &["fog", effects::ALL[0].id()],
    );
}

#[test]
fn invalid_outputs() {
    refused(
        |folder| {
            fs::create_dir(folder.join("out")).expect("writable");
            fs::write(folder.join("out/notes.txt"), "mine").expect("writable");
        },
        DIAGNOSE,
        &["out", "notes.txt"],
    );
    refused(
        |folder| fs::write(folder.join("out"), "mine").expect("writable"),
        DIAGNOSE,
        &["out", "not a folder"],
    );
    refused(
        |folder| {
            fs::create_dir(folder.join("out")).expect("writable");
            fs::rename(folder.join("lens.json"), folder.join("out/corrected.json")).expect("moves");
        },
        "diagnose --lens @out/corrected.json @set --out @out",
        &["corrected.json", "overwritten", "--out"],
    );
}

#[test]
fn pairs_without_information() {
    const ALL: [&str; 3] = ["R", "G", "B"];
    const PAIR: &str = "diagnose --lens @lens.json --reference @sharp.exr --observed @plate.exr \
                        --out @out --distance 2";
    let both = |folder: &Path| {
        picture(folder, "sharp.exr", &ALL, grain);
        picture(folder, "plate.exr", &ALL, grain);
    };
    refused(|_| (), PAIR, &["sharp.exr", "check the path"]);
    refused(
        |folder| {
            both(folder);
            sized(folder, "plate.exr", &ALL, (280, 190), |k| grain(k + 7919));
        },
        PAIR,
        &[
            "plate.exr",
            "300 x 200",
            "280 x 190",
            "common detail in 0 places",
            "one scene",
        ],
    );
    refused(
        |folder| {
            sized(folder, "sharp.exr", &ALL, (280, 200), grain);
            sized(folder, "plate.exr", &ALL, (280, 200), grain);
        },
        PAIR,
        &["280 x 200", "300 x 200", "frame", "crop"],
    );
    refused(
        |folder| {
            picture(folder, "sharp.exr", &ALL, |_| 0.5);
            picture(folder, "plate.exr", &ALL, |_| 0.5);
        },
        PAIR,
        &["plate.exr", "detail", "chart"],
    );
    refused(
        |folder| {
            both(folder);
            picture(folder, "sharp.exr", &["Y"], grain);
        },
        PAIR,
        &["sharp.exr", "R, G, B", "Y"],
    );
    refused(
        both,
        &PAIR.replace("--distance 2", ""),
        &["plate.exr", "--distance"],
    );
    refused(both, &format!("{PAIR} --patch 30"), &["patch", "30", "odd"]);
    refused(both, &format!("{PAIR} --patch 65"), &["too small", "65 px"]);
}

/// The blur that `apply` renders is estimated from its output.
#[test]
fn rendered_blur_is_estimated_correctly() {
    let folder = tempfile::tempdir().expect("a folder");
    write_pupil_lens(folder.path(), &["Y"]);
    picture(folder.path(), "sharp.exr", &["Y"], grain);
    succeeds(
        folder.path(),
        "apply --lens @lens.json @sharp.exr -o @plate.exr --distance 2.5",
    );
    let text = fs::read_to_string(folder.path().join("lens.json")).expect("there");
    let lens = LensProfile::from_json(&text).expect("a lens");
    let planes = ["sharp.exr", "plate.exr"].map(|n| [read_channel(&folder.path().join(n), "Y")]);
    let [sharp, plate] = [&planes[0], &planes[1]].map(|planes| PairImage {
        width: 300,
        height: 200,
        planes,
        quantisation: None,
    });
    let settings = PairSettings {
        side: 25,
        distance: ObjectDistance::Metres(2.5),
        ..PairSettings::default()
    };
    let found =
        estimate_pair(&lens, &sharp, &plate, &settings, &no_progress).expect("grain has detail");
    assert_eq!(found.left_out, 0);
    let predictor = Predictor::new(&lens).expect("a lens");
    let drawn = predict_set(&predictor, &found.set, &Pupil).expect("drawable");
    for (seen, drawn) in found.set.observations.iter().zip(&drawn.observations) {
        let (a, b) = (&seen.tiles[0], &drawn.tiles[0]);
        let sum = a.sum();
        let pairs = a.samples().iter().zip(b.samples());
        let square: f64 = pairs
            .map(|(a, b)| (f64::from(*a) / sum - f64::from(*b)).powi(2))
            .sum();
        let energy: f64 = b.samples().iter().map(|b| f64::from(*b).powi(2)).sum();
        // Without noise, so that only the renderer's and the estimator's own errors are left.
        let gap = square / energy;
        assert!(gap < 2e-6, "{gap}");
    }
}

/// Adds noise of standard deviation `sigma` to the channel Y of an image.
fn add_noise(path: &Path, sigma: f32) {
    let light = read_channel(path, "Y");
    let noisy: Vec<f32> = light
        .iter()
        .enumerate()
        .map(|(k, v)| {
            let sum: f32 = (0..4).map(|j| grain(4 * k + j + 99_991) - 0.5).sum();
            v + sigma * 3.0_f32.sqrt() * sum
        })
        .collect();
    write_exr(path, 300, 200, &[("Y", noisy)]);
}

/// Diagnoses a plate that `apply` rendered through the lens with `planted` effects; returns the report.
fn diagnosed_pair(planted: &str, apply: &str, options: &str) -> serde_json::Value {
    let folder = tempfile::tempdir().expect("a folder");
    write_pupil_lens(folder.path(), &["Y"]);
    picture(folder.path(), "sharp.exr", &["Y"], grain);
    let lens = folder.path().join("lens.json");
    let text = fs::read_to_string(&lens).expect("there");
    let mut profile: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let held_out = serde_json::json!({
        "tiles": 20, "rule": "test", "snr_db": 60.0, "pixel_gap": 1e-4, "misplaced_light": 1e-3, "groups": []
    });
    profile["held_out"] = held_out;
    fs::write(&lens, profile.to_string()).expect("writable");
    profile["channels"][0]["added_effects"] = serde_json::from_str(planted).expect("JSON");
    fs::write(folder.path().join("planted.json"), profile.to_string()).expect("writable");
    succeeds(
        folder.path(),
        &format!(
            "apply --lens @planted.json @sharp.exr -o @plate.exr --distance 2.5 --quality exact {apply}"
        ),
    );
    add_noise(&folder.path().join("plate.exr"), 0.002);
    let line = format!(
        "diagnose --lens @lens.json --reference @sharp.exr --observed @plate.exr --out @out --distance 2.5 \
         --patch 17 --no-pairs --json {options}"
    );
    let report = succeeds(folder.path(), &line).stdout;
    if options.contains("--plate-gap") {
        assert!(folder.path().join("out/plate-gap.png").is_file());
        let mean = |name: &str| {
            let values = read_channel(&folder.path().join("out/plate-gap.exr"), name);
            values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len() as f64
        };
        let (before, after) = (mean("before.Y"), mean("after.Y"));
        assert!(after < 0.5 * before, "{before} {after}");
    }
    serde_json::from_str(&report).expect("JSON")
}

const CAUSES: &str = "--only sensor_tilt,decentre,pixel_footprint,defocus_offset";

#[test]
fn a_pair_with_nothing_planted_has_no_gap() {
    for geometry in ["--geometry lateral", "--geometry full"] {
        let report = diagnosed_pair("[]", geometry, CAUSES);
        assert_eq!(report["verdict"], "no_gap", "{geometry}: {}", report["gap"]);
    }
}

#[test]
fn a_planted_tilt_is_named_and_closes_the_gap_of_the_plate() {
    let tilt = r#"[{"id": "sensor_tilt", "parameters": {
        "tilt_x": {"coefficients": [2.0], "sigma": [0]},
        "tilt_y": {"coefficients": [0.0], "sigma": [0]},
        "keystone": {"coefficients": [0.0], "sigma": [0]}}}]"#;
    let report = diagnosed_pair(tilt, "", &format!("{CAUSES} --plate-gap"));
    assert_eq!(report["verdict"], "explained", "{}", report["gap"]);
    assert_eq!(report["added"], serde_json::json!(["sensor_tilt"]));
}

#[test]
fn the_command_line_and_the_schema() {
    let folder = tempfile::tempdir().expect("a folder");
    for line in [
        "diagnose",
        "diagnose --lens @lens.json --out @out",
        "diagnose --lens @lens.json @set",
        "diagnose --lens @lens.json --out @out --reference @a.exr",
        "diagnose --lens @lens.json @set --out @out --reference @a.exr --observed @b.exr",
        "diagnose --lens @lens.json @set --out @out --distance 2",
        "diagnose --lens @lens.json @set --out @out --distance -2",
    ] {
        let outcome = seidel_in(folder.path(), line);
        assert_eq!(outcome.status, 2, "{line}: {}", outcome.stderr);
    }
    let schema = succeeds(folder.path(), "diagnose --schema").stdout;
    let schema: serde_json::Value = serde_json::from_str(&schema).expect("JSON");
    for key in ["verdict", "causes", "where", "next_capture"] {
        assert!(!schema["properties"][key].is_null(), "{key}");
    }
}
