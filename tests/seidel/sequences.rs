//! `seidel apply` on sequences: runs resume, failed frames do not stop others, and results depend on neither memory nor
//! threads.

use std::fs;
use std::path::Path;

use crate::support::{
    listing, must_refuse, read_channel, seidel_in, succeeds, write_exr, write_moments_lens,
    write_plate,
};

const RUN: &str = "apply --lens @lens.json @plate.%04d.exr -o @out.%04d.exr --frames 1-5";

fn write_test_files(folder: &Path) {
    write_moments_lens(folder, &["Y"]);
    for frame in 1..=5 {
        // Later frames are smaller, so that some finish before earlier ones.
        write_plate(
            &folder.join(format!("plate.{frame:04}.exr")),
            60 - 6 * frame,
            40,
        );
    }
}

fn out(folder: &Path, frame: usize) -> Vec<u8> {
    fs::read(folder.join(format!("out.{frame:04}.exr"))).expect("written")
}

#[test]
fn a_run_resumes_where_it_stopped() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_test_files(folder);
    succeeds(folder, RUN);
    let all: Vec<_> = (1..=5).map(|frame| out(folder, frame)).collect();
    for frame in [2, 4] {
        fs::remove_file(folder.join(format!("out.{frame:04}.exr"))).expect("removable");
    }
    // A frame of other content, to see that it is left alone.
    let kept = all[0].clone();
    fs::write(folder.join("out.0003.exr"), &kept).expect("writable");
    let outcome = succeeds(folder, RUN);
    assert!(
        outcome.stderr.contains("3 of 5 frames exist already"),
        "{}",
        outcome.stderr
    );
    let written: Vec<_> = outcome.stdout.lines().collect();
    assert_eq!(written.len(), 2, "{}", outcome.stdout);
    assert!(written[0].ends_with("out.0002.exr") && written[1].ends_with("out.0004.exr"));
    assert_eq!(out(folder, 3), kept);
    assert_eq!(out(folder, 4), all[3]);
    let outcome = succeeds(folder, &format!("{RUN} --overwrite"));
    assert_eq!(outcome.stdout.matches("wrote").count(), 5);
    assert_eq!(out(folder, 3), all[2]);
    // A single image is always written again.
    let single = "apply --lens @lens.json @plate.0001.exr -o @out.0001.exr";
    fs::write(folder.join("out.0001.exr"), "old").expect("writable");
    succeeds(folder, single);
    assert_eq!(out(folder, 1), all[0]);
}

#[test]
fn failed_frames_do_not_stop_others_and_are_listed_at_the_end() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_test_files(folder);
    fs::write(folder.join("plate.0002.exr"), "no picture").expect("writable");
    let mut light = vec![0.5; 12];
    light[7] = f32::NAN;
    write_exr(
        &folder.join("plate.0004.exr"),
        4,
        3,
        &[("Y", light), ("Z", vec![2.0; 12])],
    );
    let before = listing(folder).len();
    let outcome = seidel_in(folder, RUN);
    assert_eq!(outcome.status, 1);
    assert_eq!(outcome.stdout.matches("wrote").count(), 3);
    assert_eq!(listing(folder).len(), before + 3, "nothing half-written");
    let (_, end) = outcome
        .stderr
        .split_once("error: 2 of 5 frames failed:")
        .expect("a list at the end");
    let lines: Vec<_> = end.trim().lines().map(str::trim).collect();
    assert_eq!(lines.len(), 2, "{end}");
    assert!(lines[0].starts_with("frame 2: ") && lines[0].contains("plate.0002.exr"));
    assert!(lines[1].starts_with("frame 4: ") && lines[1].contains("column 3, row 1 is NaN"));
    for frame in [1, 3, 5] {
        assert!(!out(folder, frame).is_empty());
    }
    // The next run renders the corrected frame, and nothing else.
    let outcome = seidel_in(folder, &format!("{RUN} --scrub"));
    assert_eq!(outcome.status, 1);
    assert_eq!(outcome.stdout.matches("wrote").count(), 1);
    assert!(outcome.stdout.contains("out.0004.exr"));
    // Also without any blur.
    let line = "apply --lens @lens.json @plate.0004.exr -o @same.exr --scrub --amount 0";
    succeeds(folder, line);
    let mut corrected = vec![0.5; 12];
    corrected[7] = 0.0;
    assert_eq!(read_channel(&folder.join("same.exr"), "Y"), corrected);
}

#[test]
fn memory_and_threads_change_nothing_and_messages_are_in_order() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_test_files(folder);
    let mut first = None;
    for options in [
        "--memory 1 --threads 1",
        "--memory 300K --threads 3",
        "--memory 2G --threads 2",
    ] {
        let outcome = succeeds(
            folder,
            &format!("{RUN} --overwrite --edges mirror {options}"),
        );
        let frames: Vec<_> = outcome
            .stderr
            .lines()
            .filter_map(|line| line.strip_prefix("note: frame ")?.split(':').next())
            .collect();
        assert_eq!(frames, ["1", "2", "3", "4", "5"], "{}", outcome.stderr);
        let all: Vec<_> = (1..=5).map(|frame| out(folder, frame)).collect();
        assert!(
            *first.get_or_insert_with(|| all.clone()) == all,
            "{options}"
        );
    }
    let outcome = seidel_in(folder, &format!("{RUN} --memory much"));
    assert_eq!(outcome.status, 2);
    assert!(outcome.stderr.contains("500M"), "{}", outcome.stderr);
}

#[test]
fn a_missing_folder_is_reported_before_anything_is_rendered() {
    let folder = tempfile::tempdir().expect("a folder");
    write_test_files(folder.path());
    crate::support::must_refuse(
        folder.path(),
        "apply --lens @lens.json @plate.%04d.exr -o @no/out.%04d.exr --frames 1-5",
        &["folder", "does not exist"],
    );
}

#[test]
fn a_run_does_not_resume_what_another_run_made() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_test_files(folder);
    succeeds(folder, RUN);
    let at = |frame: usize| folder.join(format!("out.{frame:04}.exr"));
    let before = out(folder, 2);
    // An empty file is no frame.
    fs::write(at(2), "").expect("writable");
    let outcome = succeeds(folder, RUN);
    let note = "out.0002.exr: is empty; the frame is rendered again";
    assert!(outcome.stderr.contains(note), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("4 of 5 frames exist already"));
    assert_eq!(out(folder, 2), before);
    // Neither is another file, which is left alone.
    fs::write(at(3), "precious").expect("writable");
    must_refuse(
        folder,
        RUN,
        &["out.0003.exr: exists but is no frame", "--overwrite"],
    );
    succeeds(folder, &format!("{RUN} --overwrite"));
    // Frames of other options are named.
    let other = succeeds(folder, &format!("{RUN} --amount 0.5"));
    let note = "5 of them were made with other options, first frame 1";
    assert!(other.stderr.contains(note), "{}", other.stderr);
    // So is another lens of the same name.
    let lens = folder.join("lens.json");
    let text = fs::read_to_string(&lens).expect("readable");
    fs::write(&lens, format!("{text}\n")).expect("writable");
    let expected = [
        "out.0001.exr: seidelLens: is lens.json sha256:",
        "--overwrite",
    ];
    must_refuse(folder, RUN, &expected);
}
