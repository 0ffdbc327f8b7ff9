//! The examples, run as a reader would run them.

use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Output};

use crate::support::{library, profile};

/// A word past the capture of passing tests' words, so that it is seen.
fn skipped(why: &str) {
    let _ = writeln!(std::io::stderr(), "skipped: {why}");
}

fn is_there(program: &str) -> bool {
    let asked = Command::new(program).arg("--version").output();
    asked.is_ok_and(|answer| answer.status.success())
}

#[track_caller]
fn went_well(done: &Output) {
    let words = String::from_utf8_lossy(&done.stdout);
    let faults = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success(), "{words}{faults}");
}

fn lens_in(folder: &Path) -> std::path::PathBuf {
    let lens = folder.join("lens.json");
    std::fs::write(&lens, profile(2.0).to_json()).expect("writable");
    lens
}

#[test]
fn the_example_in_c_blurs_a_picture_and_says_why_it_cannot() {
    if !cfg!(unix) || !is_there("cc") {
        return skipped("no C compiler `cc`");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let program = folder.path().join("apply");
    let libraries = library();
    let libraries = libraries.parent().expect("a folder");
    let built = Command::new("cc")
        .args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic"])
        .arg("-I")
        .arg(package.join("include"))
        .arg(package.join("examples/apply.c"))
        .arg("-L")
        .arg(libraries)
        .args(["-lseidel_c", "-lm", "-o"])
        .arg(&program)
        .output()
        .expect("cc runs");
    went_well(&built);
    let run = |lens: &Path| {
        Command::new(&program)
            .arg(lens)
            .env("LD_LIBRARY_PATH", libraries)
            .env("DYLD_LIBRARY_PATH", libraries)
            .output()
            .expect("it runs")
    };
    let done = run(&lens_in(folder.path()));
    went_well(&done);
    let words = String::from_utf8_lossy(&done.stdout);
    assert!(words.contains("done 100 %"), "{words}");
    let done = run(&folder.path().join("none.json"));
    let words = String::from_utf8_lossy(&done.stderr);
    assert!(!done.status.success() && words.contains("none.json: could not be read"));
}

#[test]
fn the_header_can_be_read_as_c_plus_plus() {
    if !cfg!(unix) || !is_there("c++") {
        return skipped("no C++ compiler `c++`");
    }
    let header = Path::new(env!("CARGO_MANIFEST_DIR")).join("include/seidel.h");
    let read = Command::new("c++")
        .args(["-std=c++11", "-Wall", "-Wextra", "-Werror", "-fsyntax-only"])
        .args(["-x", "c++"])
        .arg(header)
        .output()
        .expect("c++ runs");
    went_well(&read);
}

#[test]
fn the_example_in_python_blurs_a_picture() {
    if !is_there("python3") {
        return skipped("no `python3`");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/apply.py");
    let done = Command::new("python3")
        .arg("-B")
        .arg(script)
        .arg(library())
        .arg(lens_in(folder.path()))
        .output()
        .expect("python3 runs");
    went_well(&done);
    let words = String::from_utf8_lossy(&done.stdout);
    assert!(words.contains("point 50 ->"), "{words}");
}
