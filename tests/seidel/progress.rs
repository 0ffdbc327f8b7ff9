//! Progress of the commands, as programs read it.

use std::ffi::OsString;
use std::path::Path;
use std::sync::{Arc, Mutex};

use seidel::{Console, ProgressOutput};
use serde_json::Value;

use crate::support::{seidel_in, write_moments_lens};

/// Runs a command line as [`seidel_in`] with `--progress json`. Returns the exit status, the lines of progress, and the
/// other lines of stderr.
fn with_json(folder: &Path, line: &str) -> (u8, [Vec<Value>; 2]) {
    let progress: Arc<Mutex<Vec<u8>>> = Arc::default();
    let (mut stdout, mut stderr) = (Vec::new(), Vec::new());
    let mut console = Console {
        stdout: &mut stdout,
        stderr: &mut stderr,
        progress: ProgressOutput::stream(progress.clone()),
    };
    let words = format!("seidel {line} --progress json");
    let words = words
        .split_whitespace()
        .map(|word| match word.strip_prefix('@') {
            Some(name) => folder.join(name).into_os_string(),
            None => OsString::from(word),
        });
    let status = seidel::run(words, &mut console);
    let progress = progress.lock().expect("free").clone();
    let parsed = [progress, stderr].map(|bytes| {
        let text = String::from_utf8(bytes).expect("text");
        let lines = text.lines().map(|line| {
            let parsed = serde_json::from_str(line);
            parsed.unwrap_or_else(|why| panic!("{line}: {why}"))
        });
        lines.collect()
    });
    (status, parsed)
}

/// Asserts that `line` reports its `task` from start to end. Returns the other lines.
fn reports_all(folder: &Path, line: &str, task: &str) -> Vec<Value> {
    let (status, [progress, others]) = with_json(folder, line);
    assert_eq!(status, 0, "{line}: {others:?}");
    let shares: Vec<f64> = (progress.iter().filter(|p| p["task"] == task))
        .map(|p| p["share"].as_f64().expect("a share"))
        .collect();
    assert!(shares.is_sorted(), "{line}: {shares:?}");
    assert_eq!(shares.first(), Some(&0.0), "{line}: {progress:?}");
    assert_eq!(shares.last(), Some(&1.0), "{line}: {progress:?}");
    for report in &progress {
        assert_eq!(report["event"], "progress");
        assert!(report["elapsed_s"].is_number(), "{report}");
        assert!(report["left_s"].is_number() || report["left_s"].is_null());
    }
    // Nothing is known about the time of work that has not begun.
    assert!(progress[0]["left_s"].is_null());
    others
}

#[test]
fn every_long_command_reports_its_start_and_its_end() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["R", "G", "B"]);
    exr::prelude::write_rgb_file(folder.join("plate.exr"), 64, 48, |x, y| {
        let grain = ((x * 7919 + y * 104_729) % 1009) as f32 / 1009.0;
        (grain, 0.5 * grain, 0.2)
    })
    .expect("writable");
    reports_all(folder, "fit @set -o @l.json --model moments", "fitting");
    let eval = "eval --lens @lens.json @set --sparse --splits 2";
    reports_all(folder, eval, "evaluating");
    let plate = "@plate.exr -o @out.exr --distance 2";
    let frames = reports_all(
        folder,
        &format!("apply --lens @lens.json {plate}"),
        "blurring",
    );
    let frame = frames.iter().find(|line| line["event"] == "frame");
    let frame = frame.expect("the frame is reported");
    assert!(frame["frame"].is_null());
    let written = frame["written"][0].as_str().expect("a path");
    assert!(written.ends_with("out.exr"), "{written}");
    let remove = format!("remove --lens @lens.json {plate} --lens-check off");
    let notes = reports_all(folder, &remove, "removing blur");
    let is_noise = |line: &Value| {
        let text = line["text"].as_str().unwrap_or_default();
        line["event"] == "note" && text.starts_with("noise, ")
    };
    assert!(notes.iter().any(is_noise), "{notes:?}");
    let relens = format!("relens --from @lens.json --to @lens.json {plate} --lens-check off");
    reports_all(folder, &relens, "changing lenses");
}

#[test]
fn errors_are_objects_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let (status, [_, others]) = with_json(folder.path(), "fit @no-such-set -o @l.json");
    assert_eq!(status, 1);
    let last = others.last().expect("an error");
    assert_eq!(last["event"], "error");
    let text = last["text"].as_str().expect("a text");
    assert!(text.contains("no-such-set"), "{text}");
}

#[test]
fn progress_is_no_part_of_provenance() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["R", "G", "B"]);
    exr::prelude::write_rgb_file(folder.join("plate.exr"), 64, 48, |_, _| (0.1, 0.2, 0.3))
        .expect("writable");
    let render = |options: &str| {
        let line = format!("apply --lens @lens.json @plate.exr -o @out.exr --distance 2 {options}");
        let outcome = seidel_in(folder, &line);
        assert_eq!(outcome.status, 0, "{}", outcome.stderr);
        std::fs::read(folder.join("out.exr")).expect("written")
    };
    assert!(render("") == render("--progress none"));
    assert!(render("") == render("--progress=lines"));
}
