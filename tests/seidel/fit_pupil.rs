//! `seidel fit` by rays: the true lens is recovered, held-out PSFs confirm it, and reports are complete.

use std::path::Path;

use seidel_core::{LensProfile, ObjectDistance, Predictor, Tile};
use seidel_optics::predict::predict_set;
use seidel_optics::psf::Pupil;
use serde_json::Value;

use crate::support::{generated_set, seidel_in, succeeds, write_exr, write_pupil_lens};

/// Side of the tiles, px.
const SIDE: usize = 25;

fn profile(path: &Path) -> LensProfile {
    LensProfile::from_json(&std::fs::read_to_string(path).expect("written")).expect("valid")
}

/// Writes `folder`/`set`: 48 PSFs of the lens of [`write_pupil_lens`], at two distances.
fn write_pupil_set(folder: &Path) -> LensProfile {
    write_pupil_lens(folder, &["Y"]);
    let lens = profile(&folder.join("lens.json"));
    let distances = [ObjectDistance::Metres(2.5), ObjectDistance::Infinity];
    let mut template = generated_set(&["Y"], &distances);
    let dark = Tile::new(SIDE, SIDE, vec![0.0; SIDE * SIDE]).expect("a size");
    for observation in &mut template.observations {
        observation.tiles = vec![dark.clone()];
    }
    let predictor = Predictor::new(&lens).expect("a lens");
    let set = predict_set(&predictor, &template, &Pupil).expect("drawable");
    seidel_image_io::observation_set::write(&set, &folder.join("set")).expect("writable");
    lens
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("one document")
}

#[test]
fn the_true_lens_is_recovered() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let planted = write_pupil_set(folder);
    let text = succeeds(folder, "fit @set -o @fitted.json").stdout;
    for part in ["alpha", "infinity", "held out: ", " dB", "wrote"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let fitted = profile(&folder.join("fitted.json"));
    assert_eq!(fitted.provenance.sources, ["set"]);
    let (truth, found) = (&planted.pupil_channels()[0], &fitted.pupil_channels()[0]);
    for v in [0.0, 0.2, 0.4] {
        let (t, f) = (truth.numbers(v), found.numbers(v));
        for (t, f) in [
            (t.alpha, f.alpha),
            (t.beta, f.beta),
            (t.gamma, f.gamma),
            (t.delta, f.delta),
            (t.phi, f.phi),
        ] {
            assert!((t - f).abs() < 0.01, "{v}: {t} {f}");
        }
    }
    let held_out = fitted.held_out.expect("PSFs were held out");
    assert!(held_out.tiles >= 8 && held_out.groups.len() == 2);
    assert!(held_out.snr_db > 50.0, "{}", held_out.snr_db);

    let scores = json(&succeeds(folder, "eval --lens @fitted.json @set --json").stdout);
    for group in scores["groups"].as_array().expect("a list") {
        let methods = group["forward_blur_snr"].as_array().expect("a list");
        let rays = methods.iter().find(|m| m["id"] == "pupil-model");
        let db = rays.expect("it has rays")["mean_db"].as_f64().expect("dB");
        assert!(db > 50.0, "{db}");
    }
    succeeds(folder, "psf --lens @fitted.json --like @set --out @drawn");
    assert!(folder.join("drawn/psf/0047.exr").exists());
}

#[test]
fn the_extended_model_and_its_options_are_reported_completely() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_set(folder);
    let picture: Vec<f32> = (0..64 * 64).map(|k| ((k * k) % 97) as f32).collect();
    write_exr(&folder.join("z.exr"), 64, 64, &[("Y", picture)]);
    let line = "fit @set -o @a.json --model extended --axis free --image @z.exr --json";
    let report = json(&succeeds(folder, line).stdout);
    assert_eq!(report["converged"], true, "{report}");
    assert_eq!(report["channels"][0]["distance"], "infinity");
    let count = |key: &str| report["channels"][0][key].as_u64().expect("a count");
    assert_eq!(count("used") + count("aside"), 24);
    assert!((report["channels"][0]["alpha"].as_f64().expect("a number") - 3.5).abs() < 0.05);
    let axis = |key: &str| report["axis"][key].as_f64().expect("a number");
    assert!((axis("x_px") - 150.0).abs() < 0.5 && axis("sigma_x_px") >= 0.0);
    assert!(report["held_out"]["snr_db"].as_f64().expect("dB") > 40.0);
    for list in ["correlations", "unclear", "rejected", "left_out", "remarks"] {
        assert!(report[list].is_array(), "{list}");
    }
    let parts = report["parts_tried"].as_array().expect("parts");
    assert!(parts.iter().any(|part| part["effect"] == "decentre"));
    for part in parts {
        assert!(part["trials"].as_u64() >= Some(1) && part["seconds"].as_f64() > Some(0.0));
        assert!(part["added"].is_boolean(), "{part}");
    }

    let line = "fit @set -o @b.json --use-all --law-only --json";
    let report = json(&succeeds(folder, line).stdout);
    assert_eq!(report["held_out"], Value::Null);
    assert_eq!(report["channels"][0]["used"], 24);
    let all = profile(&folder.join("b.json"));
    assert!(all.held_out.is_none());
    let settings = all.provenance.settings;
    assert!(settings.contains("law only") && settings.contains("none held out"));
}

#[test]
fn options_of_another_model_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    for (options, report) in [
        ("--unweighted", "--model moments"),
        ("--model extended --unweighted", "--model moments"),
        ("--model moments --use-all", "--use-all"),
        ("--model moments --law-only", "--law-only"),
        ("--model moments --image z.exr", "--image"),
    ] {
        let refused = seidel_in(folder.path(), &format!("fit @set -o @x.json {options}"));
        assert_eq!(refused.status, 2, "{options}: {}", refused.stderr);
        assert!(refused.stderr.contains(report), "{}", refused.stderr);
    }
}
