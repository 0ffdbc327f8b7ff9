//! The attack itself: planted faults are found, and a short run of every target finds none.
#![cfg(unix)]

use std::path::Path;
use std::process::{Command, Output};

const ATTACK: &str = env!("CARGO_BIN_EXE_seidel-attack");

fn run(folder: &Path, args: &[&str]) -> Output {
    Command::new(ATTACK)
        .args(args)
        .arg("--log")
        .arg(folder.join("log.json"))
        .output()
        .expect("it starts")
}

fn words(output: &Output) -> String {
    let stdout = String::from_utf8_lossy(&output.stdout);
    format!("{stdout}\n{}", String::from_utf8_lossy(&output.stderr))
}

#[test]
fn every_planted_fault_is_found_and_stored() {
    let folder = tempfile::tempdir().expect("a folder");
    let attacked = run(folder.path(), &["--only", "planted", "--cases", "12"]);
    let text = words(&attacked);
    assert_eq!(attacked.status.code(), Some(1), "{text}");
    for finding in [
        "planted:1: panic: ",
        "planted:2: abort: signal 6",
        "planted:3: memory: more than 1 GiB",
        "planted:4: slow: 2.",
        "planted:5: silent-change: a planted change",
        "planted:6: message: the error does not name input",
        "planted:7: message: the error has no remedy",
        "planted:8: abort: signal",
        "8 findings",
        // The worker was started again behind every case that ended it.
        "| planted | 12 | 0 | 1 | 2 | 1 | 1 | 1 | 0 | 2 | 0 |",
    ] {
        assert!(text.contains(finding), "no `{finding}` in {text}");
    }
    // The damaged inputs are stored, also where the undamaged twin ran after them.
    for number in 1..=8 {
        let input = format!("findings/planted-{number}/input");
        let input = std::fs::read_to_string(folder.path().join(input)).expect("stored");
        assert_eq!(input, format!("case {number}"));
    }
    // A case runs again alone, and findings are checked again.
    let kept = folder.path().join("findings/planted-3/input");
    std::fs::remove_file(&kept).expect("stored");
    let again = run(folder.path(), &["--case", "planted:3"]);
    assert!(kept.is_file(), "{}", words(&again));
    assert!(words(&again).contains("memory: "), "{}", words(&again));
    let sound = run(folder.path(), &["--case", "planted:9"]);
    assert_eq!(sound.status.code(), Some(0), "{}", words(&sound));
    let checked = run(folder.path(), &["--recheck"]);
    assert!(words(&checked).contains("planted:5 silent-change: still"));
}

#[test]
fn a_slow_case_that_runs_alone_keeps_its_damaged_inputs() {
    let folder = tempfile::tempdir().expect("a folder");
    let slow = run(folder.path(), &["--case", "planted:4"]);
    assert!(words(&slow).contains("slow: "), "{}", words(&slow));
    let kept = folder.path().join("findings/planted-4/input");
    assert_eq!(std::fs::read_to_string(kept).expect("stored"), "case 4");
}

#[test]
fn a_short_run_of_every_target_finds_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let attacked = run(folder.path(), &["--cases", "10", "--jobs", "2"]);
    assert_eq!(attacked.status.code(), Some(0), "{}", words(&attacked));
    let targets = run(folder.path(), &["--targets"]);
    let targets = words(&targets);
    let summary = words(&run(folder.path(), &["--summary"]));
    for line in targets.lines().filter(|line| !line.is_empty()) {
        let name = line.split_whitespace().next().expect("a name");
        let start = format!("| {name} | 10 | ");
        assert!(summary.contains(&start), "no `{start}` in {summary}");
    }
}
