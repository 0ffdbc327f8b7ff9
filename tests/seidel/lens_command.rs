//! `seidel lens`: the PSF sheet and the JSON schema.

use std::path::Path;

use serde_json::{Value, json};

use crate::support::{seidel_in, succeeds, write_moments_lens, write_plate, write_pupil_lens};

#[test]
fn the_sheet_is_an_image_with_content() {
    let folder = tempfile::tempdir().expect("a folder");
    write_moments_lens(folder.path(), &["R", "G", "B"]);
    succeeds(folder.path(), "lens show @lens.json -o @sheet.png");
    let sheet = image::open(folder.path().join("sheet.png"))
        .expect("a PNG")
        .to_rgb8();
    assert!(sheet.width() >= 640 && sheet.height() >= 200);
    let bright = sheet
        .pixels()
        .filter(|p| p.0.iter().any(|&v| v > 128))
        .count();
    assert!(bright > 1000, "{bright} bright pixels");
    let other = seidel_in(folder.path(), "lens show @lens.json -o @sheet.jpg");
    assert_eq!(other.status, 1);
    assert!(other.stderr.contains("sheet.jpg") && other.stderr.contains(".png"));
}

#[test]
fn the_schema_has_every_key_of_profiles() {
    let folder = tempfile::tempdir().expect("a folder");
    let schema = succeeds(folder.path(), "lens schema").stdout;
    let parsed: serde_json::Value = serde_json::from_str(&schema).expect("JSON");
    assert_eq!(parsed["additionalProperties"], false);
    for write in [write_moments_lens, write_pupil_lens] {
        write(folder.path(), &["Y"]);
        let lens = std::fs::read_to_string(folder.path().join("lens.json")).expect("written");
        every_key_is_in(&schema, &serde_json::from_str(&lens).expect("JSON"));
    }
}

fn every_key_is_in(schema: &str, lens: &serde_json::Value) {
    fn keys(value: &serde_json::Value, all: &mut Vec<String>) {
        match value {
            serde_json::Value::Object(map) => {
                for (key, value) in map {
                    all.push(key.clone());
                    keys(value, all);
                }
            }
            serde_json::Value::Array(list) => list.iter().for_each(|v| keys(v, all)),
            _ => {}
        }
    }
    let mut all = Vec::new();
    keys(lens, &mut all);
    for key in all {
        assert!(schema.contains(&format!("\"{key}\"")), "{key}");
    }
}

/// Gives `folder`/`lens.json` held-out PSFs that differ from the model by `excess` of their energy.
fn state_adequacy(folder: &Path, excess: f64) {
    let path = folder.join("lens.json");
    let text = std::fs::read_to_string(&path).expect("written");
    let mut lens: Value = serde_json::from_str(&text).expect("JSON");
    lens["held_out"] = json!({
        "tiles": 9, "rule": "by hand", "snr_db": 25.0, "pixel_gap": excess, "groups": [],
        "adequacy": {
            "noise_gap": 0.0, "excess_gap": excess, "systematic_gap": excess / 2.0,
            "worst": { "channel": "Y", "depth_m": 2.0, "zone": "edge", "excess_gap": 2.0 * excess },
            "pattern": { "periods": 2, "share": 0.8, "field": "constant" },
        },
    });
    std::fs::write(&path, lens.to_string()).expect("writable");
}

#[test]
fn a_poor_model_is_reported_where_its_lens_is_used() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["Y"]);
    write_plate(&folder.join("plate.exr"), 48, 32);
    let show = "lens show @lens.json -o @sheet.png";
    let apply = "apply --lens @lens.json @plate.exr -o @out.exr --distance 2";
    assert!(succeeds(folder, show).stdout.contains("does not say"));

    state_adequacy(folder, 0.002);
    assert!(succeeds(folder, show).stdout.contains("describes the lens"));
    assert!(!succeeds(folder, apply).stderr.contains("the model"));

    state_adequacy(folder, 0.2);
    let verdict = "does not describe the lens: held-out PSFs differ from it by 20.0 % of their energy. Largest at the edge \
                   of the field, channel Y, 2 m: 40.0 %. Residuals are two-fold, one axis against the other, the same over \
                   the field";
    let shown = succeeds(folder, show).stdout;
    assert!(shown.contains(verdict), "{shown}");
    let warned = succeeds(folder, apply).stderr;
    assert_eq!(warned.matches(verdict).count(), 1, "{warned}");
    assert!(warned.contains("lens.json"), "{warned}");
}
