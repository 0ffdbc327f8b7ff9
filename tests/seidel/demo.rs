//! `seidel demo`: everything it says it writes is there and can be used.

use crate::support::{read_channel, seidel_in, succeeds};

#[test]
fn the_demo_writes_what_it_says_and_its_command_works() {
    let folder = tempfile::tempdir().expect("a folder");
    let outcome = succeeds(folder.path(), "demo @out --width 192");
    for name in [
        "measured",
        "lens.json",
        "sheet.png",
        "plate.exr",
        "blurred.exr",
        "before-after.png",
    ] {
        assert!(folder.path().join("out").join(name).exists(), "{name}");
        assert!(outcome.stdout.contains(name), "{name}");
    }
    // The demo's own blur is what the command it prints does.
    succeeds(
        folder.path(),
        "apply --lens @out/lens.json @out/plate.exr -o @again.exr",
    );
    let (own, again) = (
        read_channel(&folder.path().join("out/blurred.exr"), "G"),
        read_channel(&folder.path().join("again.exr"), "G"),
    );
    let peak = own.iter().copied().fold(0.0, f32::max);
    for (a, b) in own.iter().zip(&again) {
        // The plate on disk is half float.
        assert!((a - b).abs() < 2e-3 * peak, "{a} {b}");
    }
    // A second run replaces the first, a folder with other things in it is left alone.
    succeeds(folder.path(), "demo @out --width 192");
    std::fs::write(folder.path().join("out/mine.txt"), "notes").expect("writable");
    let refused = seidel_in(folder.path(), "demo @out --width 192");
    assert_eq!(refused.status, 1);
    assert!(refused.stderr.contains("mine.txt"), "{}", refused.stderr);
}
