//! `seidel apply` on sequences: runs resume, failed frames do not stop others, and results depend on neither memory nor
//! threads.

use std::fs;
use std::path::Path;

use seidel_image_io::format::Format;

use crate::support::{
    listing, read_channel, seidel_in, succeeds, write_exr, write_moments_lens, write_plate,
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
    let written_at = |frame: usize| {
        let path = folder.join(format!("out.{frame:04}.exr"));
        let file = path.metadata().expect("a file");
        file.modified().expect("a time")
    };
    let before = written_at(3);
    let resumed = format!("{RUN} --skip-existing");
    let outcome = succeeds(folder, &format!("{resumed} --threads 1"));
    assert!(
        outcome
            .stderr
            .contains("3 of 5 frames are finished and kept"),
        "{}",
        outcome.stderr
    );
    let written: Vec<_> = outcome.stdout.lines().collect();
    assert_eq!(written.len(), 2, "{}", outcome.stdout);
    assert!(written[0].ends_with("out.0002.exr") && written[1].ends_with("out.0004.exr"));
    assert_eq!(written_at(3), before);
    assert_eq!(out(folder, 4), all[3]);
    // Without the option all are written again.
    let outcome = succeeds(folder, RUN);
    assert_eq!(outcome.stdout.matches("wrote").count(), 5);
    assert_eq!(out(folder, 3), all[2]);
    // The same holds for a single image.
    let single = "apply --lens @lens.json @plate.0001.exr -o @out.0001.exr";
    fs::write(folder.join("out.0001.exr"), "old").expect("writable");
    succeeds(folder, single);
    assert_eq!(out(folder, 1), all[0]);
    let outcome = succeeds(folder, &format!("{single} --skip-existing"));
    assert_eq!(outcome.stdout.matches("wrote").count(), 0);
    let outcome = succeeds(folder, &format!("{single} --skip-existing --amount 0.5"));
    assert_eq!(outcome.stdout.matches("wrote").count(), 1);
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
    // The next run tries the failed frames alone; other options render all that can be read.
    let outcome = seidel_in(folder, &format!("{RUN} --skip-existing"));
    assert_eq!(outcome.status, 1);
    assert_eq!(outcome.stdout.matches("wrote").count(), 0);
    assert!(outcome.stderr.contains("2 of 2 frames failed"));
    let outcome = seidel_in(folder, &format!("{RUN} --scrub --skip-existing"));
    assert_eq!(outcome.status, 1);
    assert_eq!(outcome.stdout.matches("wrote").count(), 4);
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
        let outcome = succeeds(folder, &format!("{RUN} --edges mirror {options}"));
        let frames = outcome.stdout.lines().filter_map(|line| {
            let name = line.strip_prefix("wrote ")?.strip_suffix(".exr")?;
            Some(name[name.len() - 1..].to_owned())
        });
        let frames: Vec<_> = frames.collect();
        // The range of depth is printed once.
        assert_eq!(
            outcome.stderr.matches(" spans ").count(),
            1,
            "{}",
            outcome.stderr
        );
        let says_so = outcome.stderr.contains("more than --memory allows");
        assert_eq!(
            says_so,
            !options.contains("--memory 2G"),
            "{}",
            outcome.stderr
        );
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
    let before = [out(folder, 2), out(folder, 3), out(folder, 4)];
    // Neither an empty file is a frame, nor another one, nor an image that does not say what made it.
    fs::write(at(2), "").expect("writable");
    fs::write(at(3), "precious").expect("writable");
    fs::copy(folder.join("plate.0004.exr"), at(4)).expect("writable");
    let again = |options: &str, rendered: usize, reason: &str| {
        let outcome = succeeds(folder, &format!("{RUN} --skip-existing {options}"));
        let note = format!("{rendered} of 5 frames exist but are not of this run");
        assert!(
            outcome.stderr.contains(&note) && outcome.stderr.contains(reason),
            "{}",
            outcome.stderr
        );
        assert_eq!(outcome.stdout.matches("wrote").count(), rendered);
    };
    again("", 3, "out.0002.exr cannot be read as an image");
    assert!(before == [out(folder, 2), out(folder, 3), out(folder, 4)]);
    // Nor are frames of other options.
    again(
        "--amount 0.5",
        5,
        "out.0001.exr was made with other options: now also --amount 0.5",
    );
    again("", 5, "was made with other options: --amount 0.5");
    // Nor those of another lens of the same name.
    let lens = folder.join("lens.json");
    let text = fs::read_to_string(&lens).expect("readable");
    fs::write(&lens, format!("{text}\n")).expect("writable");
    again("", 5, "out.0001.exr was made with lens.json sha256:");
}

#[test]
fn every_format_says_what_made_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_test_files(folder);
    for format in Format::writable() {
        let extension = format.extension();
        let run = RUN.replace("out.%04d.exr", &format!("out.%04d.{extension}"));
        succeeds(folder, &run);
        let skipped = format!("{run} --skip-existing");
        let written = |options: &str| {
            let outcome = succeeds(folder, &format!("{skipped} {options}"));
            (outcome.stdout.matches("wrote").count(), outcome.stderr)
        };
        let (count, notes) = written("");
        assert_eq!(count, 0, "{extension}: {notes}");
        assert!(
            notes.contains("5 of 5 frames are finished and kept"),
            "{extension}: {notes}"
        );
        let (count, notes) = written("--amount 0.5");
        assert_eq!(count, 5, "{extension}: {notes}");
        assert!(
            notes.contains("was made with other options"),
            "{extension}: {notes}"
        );
        // A file without provenance may be of anything.
        succeeds(folder, &format!("{run} --provenance none"));
        let (count, notes) = written("");
        assert_eq!(count, 5, "{extension}: {notes}");
        assert!(
            notes.contains("does not say what made it"),
            "{extension}: {notes}"
        );
    }
    // Without provenance only the names are known.
    for option in ["--provenance none", "--no-provenance"] {
        let run = RUN.replace("out.%04d.exr", "out.%04d.png");
        let outcome = succeeds(
            folder,
            &format!("{run} --amount 0.7 --skip-existing {option}"),
        );
        assert_eq!(outcome.stdout.matches("wrote").count(), 0, "{option}");
        assert!(
            outcome.stderr.contains("only their names were checked"),
            "{}",
            outcome.stderr
        );
    }
}
