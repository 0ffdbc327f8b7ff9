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
    // A second run replaces the first; a folder with other files in it is refused.
    succeeds(folder.path(), "demo @out --width 64");
    std::fs::write(folder.path().join("out/mine.txt"), "notes").expect("writable");
    let refused = seidel_in(folder.path(), "demo @out --width 192");
    assert_eq!(refused.status, 1);
    assert!(refused.stderr.contains("mine.txt"), "{}", refused.stderr);
}
