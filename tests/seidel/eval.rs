//! `seidel eval`: its reports, and agreement with an independent program on measured data.

use std::ffi::OsString;
use std::path::Path;

use serde_json::Value;

use crate::reference_tables::{REFERENCES, Reference};
use crate::support::{real_data, seidel, seidel_in, succeeds, write_exr, write_moments_lens};

#[test]
fn tables_json_markdown_and_plot() {
    let folder = tempfile::tempdir().expect("a folder");
    write_moments_lens(folder.path(), &["R", "G"]);
    let text = succeeds(folder.path(), "eval --lens @lens.json @set --channel G");
    assert!(text.stdout.contains("Table 1") && text.stdout.contains("Table 2"));
    assert!(!text.stdout.contains("Figure 13"));
    let markdown = succeeds(
        folder.path(),
        "eval --lens @lens.json @set --form markdown --plot @fig.svg --splits 3",
    );
    assert!(markdown.stdout.contains("| --- |") && markdown.stdout.contains("Figure 13"));
    let svg = std::fs::read_to_string(folder.path().join("fig.svg")).expect("written");
    assert!(svg.starts_with("<svg") && svg.contains("G 1.2 m"));
    let json = succeeds(
        folder.path(),
        "eval --lens @lens.json @set --json --sparse --splits 2",
    );
    let document: Value = serde_json::from_str(&json.stdout).expect("one document");
    let groups = document["groups"].as_array().expect("groups");
    assert_eq!(groups.len(), 6);
    for group in groups {
        // The true lens is in the model, so it explains the variance and has a high SNR.
        let explained = &group["variance_explained"]["mu20"]["all_percent"];
        assert!(explained.as_f64().expect("it varies") > 99.0, "{group}");
        let pair = group["forward_blur_snr"]
            .as_array()
            .expect("methods")
            .iter()
            .find(|m| m["id"] == "mirrored-pair-model")
            .expect("listed");
        assert!(pair["mean_db"].as_f64().expect("a number") > 50.0, "{pair}");
        assert!(group["sparse"]["points"][0]["training"].as_u64() == Some(3));
    }
    assert!(
        groups.iter().any(|g| g["depth_m"].is_null()),
        "infinity is null"
    );
}

#[test]
fn shapes_are_drawn_by_the_models_of_the_lens() {
    let folder = tempfile::tempdir().expect("a folder");
    write_moments_lens(folder.path(), &["R", "G"]);
    let line = "eval --lens @lens.json @set --channel G --shapes @shapes.png";
    let text = succeeds(folder.path(), line);
    assert!(text.stdout.contains("wrote") && text.stdout.contains("shapes.png"));
    let picture = image::open(folder.path().join("shapes.png")).expect("a picture");
    // Moments: observed, two predictions, two differences; three distances at three places.
    assert_eq!(picture.width(), 16 + 5 * 232);
    assert_eq!(picture.height(), 104 + 48 + 9 * 286 + 8);
    let quiet = succeeds(folder.path(), &format!("{line} --json"));
    serde_json::from_str::<Value>(&quiet.stdout).expect("one document");
    let misnamed = seidel_in(folder.path(), "eval --lens @lens.json @set --shapes @s.jpg");
    assert_eq!(misnamed.status, 1);
    assert!(misnamed.stderr.contains("s.jpg"), "{}", misnamed.stderr);
}

#[test]
fn the_test_image_can_be_chosen_and_is_checked() {
    let folder = tempfile::tempdir().expect("a folder");
    write_moments_lens(folder.path(), &["Y"]);
    let score = |line: &str| -> f64 {
        let json = succeeds(folder.path(), line).stdout;
        let document: Value = serde_json::from_str(&json).expect("one document");
        document["groups"][0]["forward_blur_snr"][2]["mean_db"]
            .as_f64()
            .expect("a number")
    };
    let checks = (0..64 * 64)
        .map(|i| ((i % 64 / 4 + i / 256) % 2) as f32)
        .collect();
    write_exr(&folder.path().join("z.exr"), 64, 64, &[("Y", checks)]);
    let own = score("eval --lens @lens.json @set --json --image @z.exr");
    assert!((own - score("eval --lens @lens.json @set --json")).abs() > 0.1);
    write_exr(
        &folder.path().join("flat.exr"),
        8,
        8,
        &[("Y", vec![1.0; 64])],
    );
    let flat = seidel_in(
        folder.path(),
        "eval --lens @lens.json @set --image @flat.exr",
    );
    assert_eq!(flat.status, 1);
    assert!(flat.stderr.contains("flat.exr"), "{}", flat.stderr);
}

/// Tolerance of a cell of MVarFrac, percentage points.
const EXPLAINED_TOLERANCE: f64 = 0.2 + 0.05;
/// Tolerance of a cell of SNR, dB.
const SNR_TOLERANCE: f64 = 0.1;

/// Returns whether exact ties decide a cell of the middle 90 %. Errors of zemax-dgauss28 come in mirrored pairs, and rounding in
/// the independent program decided which of a pair it dropped. The range from dropping four or five tiles at an end
/// contains both figures.
fn decided_by_ties(r: &Reference, moment: usize) -> bool {
    r.set == "zemax-dgauss28"
        && ((r.depth_m == 2.04953 && moment == 2) || (r.depth_m == 3.04953 && moment == 0))
}

/// Fits `set` with the options `extra` and evaluates the lens on it through the test image `z`.
fn fitted_and_evaluated(set: &Path, z: &Path, extra: &[&str]) -> Value {
    let folder = tempfile::tempdir().expect("a folder");
    let lens = folder.path().join("lens.json");
    let mut fit: Vec<OsString> = vec![
        "fit".into(),
        "--model".into(),
        "moments".into(),
        set.into(),
        "-o".into(),
        lens.clone().into(),
    ];
    fit.extend(extra.iter().map(OsString::from));
    let fitted = seidel(&fit);
    assert_eq!(fitted.status, 0, "{}", fitted.stderr);
    let evaluated = seidel(&[
        "eval".as_ref(),
        "--json".as_ref(),
        "--lens".as_ref(),
        lens.as_os_str(),
        set.as_os_str(),
        "--image".as_ref(),
        z.as_os_str(),
    ]);
    assert_eq!(evaluated.status, 0, "{}", evaluated.stderr);
    serde_json::from_str(&evaluated.stdout).expect("one document")
}

#[test]
fn tables_of_the_paper_on_measured_data() {
    let (Some(sets), Some(z)) = (real_data("psf"), real_data("plates/camera-512.exr")) else {
        return;
    };
    let mut compared = 0;
    for (name, extra) in [
        ("zemax-dgauss28", vec!["--unweighted"]),
        ("optiland-us8879901", vec!["--unweighted"]),
        ("dash-stars", vec!["--unweighted", "--axis", "1497.3,818.1"]),
    ] {
        let document = fitted_and_evaluated(&sets.join(name), &z, &extra);
        for reference in REFERENCES.iter().filter(|r| r.set == name) {
            compare(reference, &document);
            compared += 1;
        }
    }
    assert_eq!(compared, REFERENCES.len());
}

fn compare(r: &Reference, document: &Value) {
    let group = document["groups"]
        .as_array()
        .expect("groups")
        .iter()
        .find(|g| {
            let depth = g["depth_m"].as_f64().unwrap_or(f64::INFINITY);
            g["channel"] == r.channel && depth == r.depth_m
        })
        .unwrap_or_else(|| panic!("{} {} {} m", r.set, r.channel, r.depth_m));
    let place = format!("{} {} {} m", r.set, r.channel, r.depth_m);
    for (moment, name) in seidel_core::CentralMoments::NAMES.iter().enumerate() {
        let cell = &group["variance_explained"][name];
        for (want, key) in r.explained[moment]
            .iter()
            .zip(["all_percent", "middle_90_percent"])
        {
            if key == "middle_90_percent" && decided_by_ties(r, moment) {
                continue;
            }
            let got = cell[key].as_f64().expect("it varies");
            assert!(
                (got - want).abs() <= EXPLAINED_TOLERANCE,
                "{place} {name} {key}: {got}, not {want}"
            );
        }
    }
    let methods = group["forward_blur_snr"].as_array().expect("methods");
    for (want, method) in r.snr_db.iter().zip(methods) {
        let got = method["mean_db"].as_f64().expect("a number");
        assert!(
            (got - want).abs() <= SNR_TOLERANCE,
            "{place} {}: {got}, not {want}",
            method["id"]
        );
    }
}

#[test]
fn near_focus_weighted_fits_lose_nothing_and_stay_positive() {
    let (Some(set), Some(z)) = (
        real_data("psf/zemax-dgauss28"),
        real_data("plates/camera-512.exr"),
    ) else {
        return;
    };
    let mut scores = Vec::new();
    for extra in [vec![], vec!["--unweighted"]] {
        let document = fitted_and_evaluated(&set, &z, &extra);
        if extra.is_empty() {
            assert_eq!(
                document["remarks"],
                serde_json::json!([]),
                "a negative variance"
            );
        }
        let near = document["groups"]
            .as_array()
            .expect("groups")
            .iter()
            .map(|g| {
                let methods = g["forward_blur_snr"].as_array().expect("methods");
                methods
                    .iter()
                    .filter(|m| m["id"].as_str().is_some_and(|id| id.ends_with("-model")))
                    .map(|m| m["mean_db"].as_f64().expect("a number"))
                    .collect::<Vec<f64>>()
            })
            .collect::<Vec<_>>();
        scores.push(near);
    }
    for (weighted, plain) in scores[0].iter().flatten().zip(scores[1].iter().flatten()) {
        // The tables print hundredths of a decibel.
        assert!(weighted >= &(plain - 0.01), "{weighted} against {plain}");
    }
}
