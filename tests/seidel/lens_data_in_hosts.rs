//! *Lens Data* of the node against `--lens-metadata` of the command.

// As for `host_render`.
#![cfg(not(all(target_vendor = "apple", target_arch = "aarch64")))]

use exr::prelude::AttributeValue;

use crate::host_render::{assert_equals_command, try_in_host_at};
use crate::lens_metadata::{samples, time_code, write_shot, write_with};

const DEPTH: [(&str, &str); 2] = [("math", "depth"), ("worldScale", "metres")];
const LINE: &str = "apply --lens @lens.json --no-depth-check --lens-scale 1";

/// A shot of 24 frames with a focus pull, of which frame 1013 is `plate.exr` too.
fn shot() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    write_shot(folder.path());
    let plate = |name: &str| folder.path().join(name);
    std::fs::copy(plate("plate.1013.exr"), plate("plate.exr")).expect("copied");
    std::fs::write(plate("track.json"), samples(time_code)).expect("writable");
    let numbered = samples(|frame| format!(r#""sequenceNumber": {frame}"#));
    std::fs::write(plate("numbered.json"), numbered).expect("writable");
    folder
}

#[test]
fn lens_data_equals_the_command() {
    let folder = shot();
    let folder = folder.path();
    let path = |name: &str| folder.join(name).display().to_string();
    let data = |name: &str, more: &[(&'static str, &'static str)]| {
        let path = path(name);
        let own = [("lensScale", "1"), ("lensData", path.as_str())];
        let knobs = [&DEPTH[..], &own, more].concat();
        try_in_host_at(folder, 1013.0, &knobs).expect("rendered")
    };
    let line = format!("{LINE} --lens-metadata plate");
    for (name, start) in [
        ("plate.####.exr", ""),
        ("plate.%04d.exr", ""),
        ("plate.1013.exr", ""),
        ("numbered.json", ""),
        ("track.json", "1001"),
    ] {
        let host = data(name, &[("lensDataStart", start), ("showLensData", "")]);
        assert_equals_command(&host, folder, &line);
    }
    // The knobs come before the files.
    let own = [
        ("focus", "Focus Distance"),
        ("focusDistance", "2"),
        ("fStop", "4"),
    ];
    let host = data("plate.####.exr", &own);
    assert_equals_command(
        &host,
        folder,
        &format!("{line} --focus-distance 2 --f-number 4"),
    );
    // A renderer's distance counts units of the depth pass.
    let scene = [
        ("cameraTargetDistance", AttributeValue::F32(2.5)),
        ("cameraFNumber", AttributeValue::F32(2.8)),
    ];
    write_with(&folder.join("plate.exr"), None, &scene);
    let host = data("plate.exr", &[]);
    assert_equals_command(&host, folder, &format!("{line} --depth-unit m"));
}

#[test]
fn lens_data_that_does_not_fit_is_refused_by_file() {
    let folder = shot();
    let folder = folder.path();
    std::fs::write(folder.join("broken.json"), "{").expect("writable");
    let bad = [("focus", AttributeValue::F32(1e18))];
    write_with(&folder.join("far.1013.exr"), None, &bad);
    write_with(&folder.join("empty.1013.exr"), None, &[]);
    // It lacks the focus, which its only neighbour has.
    write_with(&folder.join("plate.1024.exr"), None, &[]);
    for (time, name, start, words) in [
        (1025.0, "plate.####.exr", "", &["plate.1025.exr"][..]),
        (
            1024.0,
            "plate.####.exr",
            "",
            &["plate.1024.exr", "frame 1024", "`focus`"],
        ),
        (
            1013.0,
            "far.####.exr",
            "",
            &["far.1013.exr", "`focus`", "no lens has"],
        ),
        (1013.0, "empty.####.exr", "", &["empty", "states no focus"]),
        (1013.0, "broken.json", "", &["broken.json"]),
        (1013.0, "missing.csv", "", &["missing.csv"]),
        (1013.0, "track.json", "", &["track.json", "Lens Data Start"]),
        (
            1013.0,
            "track.json",
            "first",
            &["Lens Data Start", "`first`"],
        ),
        (
            1025.0,
            "numbered.json",
            "",
            &["frames 1001 to 1024", "1025"],
        ),
    ] {
        let path = folder.join(name).display().to_string();
        let own = [("lensData", path.as_str()), ("lensDataStart", start)];
        let report = try_in_host_at(folder, time, &[&DEPTH[..], &own].concat());
        let report = report.expect_err(name);
        for word in words {
            assert!(
                report.contains(word),
                "{name} at {time}: `{word}` in {report}"
            );
        }
    }
}
