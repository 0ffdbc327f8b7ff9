//! `seidel apply --animate`: values that change from frame to frame.

use std::path::Path;

use crate::support::{
    must_refuse, read_channel, seidel_in, succeeds, write_plate, write_pupil_lens,
};

const APPLY: &str =
    "apply --lens @lens.json @plate.%02d.exr -o @out.%02d.exr --frames 1-3 --distance 2";

fn write_frames(folder: &Path) {
    write_pupil_lens(folder, &["R", "G", "B"]);
    for frame in 1..=3 {
        write_plate(&folder.join(format!("plate.{frame:02}.exr")), 34, 26);
    }
}

/// Renders three frames with the options `extra`.
fn frames(folder: &Path, extra: &str) -> [Vec<f32>; 3] {
    succeeds(folder, &format!("{APPLY} --lens-scale 1 {extra}"));
    [1, 2, 3].map(|frame| read_channel(&folder.join(format!("out.{frame:02}.exr")), "G"))
}

#[test]
fn each_frame_equals_one_rendered_with_options() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_frames(folder);
    let table =
        "frame,amount,focus-distance,channel-scale.G,front-multiplier\n1,0,1.5,1,\n3,1,inf,2,1\n";
    std::fs::write(folder.join("values.csv"), table).expect("writable");
    let animated = frames(folder, "--animate @values.csv");
    // Half way in vergence is 3 m.
    let options = [
        "--amount 0",
        "--amount 0.5 --focus-distance 3 --channel-scale G=1.5",
        "--amount 1 --focus-distance inf --channel-scale G=2",
    ];
    for (frame, options) in options.into_iter().enumerate() {
        assert!(
            animated[frame] == frames(folder, options)[frame],
            "{options}"
        );
    }
    // Options apply to everything that the table does not name.
    std::fs::write(folder.join("some.json"), r#"{"2": {"f-number": 5.6}}"#).expect("writable");
    let some = frames(folder, "--animate @some.json --amount 0.8");
    assert!(some == frames(folder, "--f-number 5.6 --amount 0.8"));
    assert!(some != animated);
}

#[test]
fn invalid_tables_are_refused_and_failed_frames_are_listed() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_frames(folder);
    std::fs::write(folder.join("odd.csv"), "frame,size\n1,2\n").expect("writable");
    let line = format!("{APPLY} --animate @odd.csv");
    must_refuse(
        folder,
        &line,
        &["odd.csv", "size", "amount", "axis-offset.x"],
    );
    std::fs::write(folder.join("good.csv"), "frame,amount\n1,1\n3,0\n").expect("writable");
    let still =
        "apply --lens @lens.json @plate.01.exr -o @out.exr --distance 2 --animate @good.csv";
    // A single plate is the frame of its name.
    succeeds(folder, still);
    let plain = "apply --lens @lens.json @plate.01.exr -o @plain.exr --distance 2 --amount 1";
    succeeds(folder, plain);
    let green = |name: &str| read_channel(&folder.join(name), "G");
    assert!(green("out.exr") == green("plain.exr"));
    std::fs::remove_file(folder.join("out.exr")).expect("there");
    let nameless = still
        .replace("@plate.01.exr", "@plain.exr")
        .replace("@out", "@no");
    must_refuse(
        folder,
        &nameless,
        &["plain.exr", "no frame number", "--animate"],
    );
    std::fs::write(folder.join("bad.csv"), "frame,amount\n1,1\n2,-1\n3,1\n").expect("writable");
    let outcome = seidel_in(
        folder,
        &format!("{APPLY} --lens-scale 1 --animate @bad.csv"),
    );
    assert_eq!(outcome.status, 1);
    assert!(outcome.stderr.contains("amount"), "{}", outcome.stderr);
    let there = |frame: u32| folder.join(format!("out.{frame:02}.exr")).exists();
    assert_eq!([1, 2, 3].map(there), [true, false, true]);
}
