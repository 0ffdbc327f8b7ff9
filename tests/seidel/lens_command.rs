//! `seidel lens`: the PSF sheet and the JSON schema.

use crate::support::{seidel_in, succeeds, write_moments_lens, write_pupil_lens};

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
