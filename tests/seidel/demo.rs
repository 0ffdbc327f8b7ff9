//! `seidel demo`: every file that it lists exists and can be used.

use crate::support::{read_channel, seidel_in, succeeds};

#[test]
fn the_demo_writes_its_files_and_its_command_works() {
    let folder = tempfile::tempdir().expect("a folder");
    let outcome = succeeds(folder.path(), "demo @out --width 192");
    for name in [
        "measured",
        "lens.json",
        "sheet.png",
        "plate.exr",
        "blurred.exr",
        "before-after.png",
        "anamorphic.json",
        "anamorphic.exr",
        "lenses.png",
        "observed",
        "report.json",
        "report.html",
        "corrected.json",
        "corrected.exr",
        "gap.png",
    ] {
        assert!(folder.path().join("out").join(name).exists(), "{name}");
        assert!(outcome.stdout.contains(name), "{name}");
    }
    // The printed command reproduces the demo's own blurred plate; the anamorphic one is desqueezed like the plate.
    for (lens, own) in [
        ("lens.json", "blurred.exr"),
        ("anamorphic.json", "anamorphic.exr"),
    ] {
        let command = format!("apply --lens @out/{lens} @out/plate.exr -o @again.exr");
        succeeds(folder.path(), &command);
        let (own, again) = (
            read_channel(&folder.path().join("out").join(own), "G"),
            read_channel(&folder.path().join("again.exr"), "G"),
        );
        let peak = own.iter().copied().fold(0.0, f32::max);
        for (a, b) in own.iter().zip(&again) {
            // The plate on disk has half-float samples.
            assert!((a - b).abs() < 2e-3 * peak, "{lens}: {a} {b}");
        }
    }
    // The planted fault is found, the correction closes its gap, and the time of the steps is stated.
    let report = std::fs::read_to_string(folder.path().join("out/report.json")).expect("written");
    let report: serde_json::Value = serde_json::from_str(&report).expect("JSON");
    assert_eq!(
        report["added"],
        serde_json::json!(["vignetting"]),
        "{}",
        report["verdict"]
    );
    assert!(
        report["gap"]["closed"]
            .as_f64()
            .is_some_and(|closed| closed > 0.8),
        "{}",
        report["gap"]
    );
    assert!(
        outcome.stdout.contains("the diagnosis added vignetting"),
        "{}",
        outcome.stdout
    );
    assert!(outcome.stdout.contains("Took ") && outcome.stdout.contains("diagnosis"));
    // Every picture states what made it, and renders the lens.
    for name in [
        "plate.exr",
        "blurred.exr",
        "corrected.exr",
        "anamorphic.exr",
        "sheet.png",
        "gap.png",
        "lenses.png",
    ] {
        let info = succeeds(folder.path(), &format!("info @out/{name}")).stdout;
        assert!(info.contains("seidel demo"), "{name}: {info}");
        let lens = name.ends_with("d.exr") || name == "anamorphic.exr";
        assert_eq!(info.contains(".json sha256:"), lens, "{name}: {info}");
    }
    // A second run replaces the first; a folder with other files in it is refused.
    succeeds(folder.path(), "demo @out --width 64");
    std::fs::write(folder.path().join("out/mine.txt"), "notes").expect("writable");
    let refused = seidel_in(folder.path(), "demo @out --width 192");
    assert_eq!(refused.status, 1);
    assert!(refused.stderr.contains("mine.txt"), "{}", refused.stderr);
}

/// The lens measured in the demo's own photographs draws the PSFs of the lens that took them.
#[test]
fn the_demo_measures_its_own_photographs() {
    let folder = tempfile::tempdir().expect("a folder");
    let outcome = succeeds(folder.path(), "demo @out --measure --width 384");
    for name in ["near.png", "middle.png", "far.png", "lens.json"] {
        assert!(folder.path().join("out").join(name).exists(), "{name}");
        assert!(outcome.stdout.contains(name), "{name}");
    }
    assert!(folder.path().join("out/lights/report.html").exists());
    let text = &outcome.stdout;
    let error = text.split("within ").nth(1).and_then(|rest| {
        let number = rest.split_whitespace().next()?;
        number.parse::<f64>().ok()
    });
    // PSFs at 1.4 m have a radius of 3 px.
    assert!(error.is_some_and(|error| error < 0.1), "{text}");
    assert!(text.contains("seidel measure lights "), "{text}");
    // A folder with other files in it is refused.
    std::fs::write(folder.path().join("out/mine.txt"), "notes").expect("writable");
    let refused = seidel_in(folder.path(), "demo @out --measure --width 384");
    assert_eq!(refused.status, 1);
    assert!(refused.stderr.contains("mine.txt"), "{}", refused.stderr);
}
