//! Depth of field beside a path tracer's: rows of docs/background/depth-edges.md.

use crate::remove_scenes::{WIDTH, decibels, scene};
use crate::support::{read_channel, real_data, succeeds};

/// Each scene is as near to its truth as the table says, less 0.1 dB.
#[test]
fn blur_is_as_near_to_a_path_tracer_as_stated() {
    let Some(data) = real_data("dof") else { return };
    let clean = format!(
        "--background {}",
        data.join("foreground_clean.exr").display()
    );
    for (name, options, least) in [
        ("floor", "", 48.0),
        ("character", "", 38.7),
        ("element", "", 34.2),
        ("foreground", "", 28.8),
        ("foreground", clean.as_str(), 37.7),
    ] {
        let scene = scene(name).expect("the same folder");
        let folder = tempfile::tempdir().expect("a folder");
        let line = format!(
            "apply --lens {} {} -o @blurred.exr --expand off --no-depth-check {options}",
            scene.lens.display(),
            scene.plate.display()
        );
        succeeds(folder.path(), &line);
        let found = decibels(&folder.path().join("blurred.exr"), &scene.truth, WIDTH);
        assert!(found > least, "{name} {options}: {found} dB");
    }
}

/// Right passes get no finding.
#[test]
fn depth_of_a_path_tracer_is_not_doubted() {
    let Some(_) = real_data("dof") else { return };
    for name in ["floor", "character", "element", "foreground", "lamps"] {
        let scene = scene(name).expect("the same folder");
        assert!(!read_channel(&scene.plate, "Z").is_empty());
        let folder = tempfile::tempdir().expect("a folder");
        let line = format!(
            "apply --lens {} {} -o @coc.exr --show coc-px",
            scene.lens.display(),
            scene.plate.display()
        );
        let outcome = succeeds(folder.path(), &line);
        assert!(
            !outcome.stderr.contains("doubtful"),
            "{name}: {}",
            outcome.stderr
        );
    }
}
