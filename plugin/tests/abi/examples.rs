//! The examples in C and Python compile and run, and the header is valid C++.

use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Output};

use crate::support::{library, profile};

/// Prints the reason for skipping a test to stderr, past the capture of output.
fn skip(reason: &str) {
    let _ = writeln!(std::io::stderr(), "skipped: {reason}");
}

fn is_installed(program: &str) -> bool {
    let output = Command::new(program).arg("--version").output();
    output.is_ok_and(|output| output.status.success())
}

#[track_caller]
fn assert_success(output: &Output) {
    let stdout = String::from_utf8_lossy(&output.stdout);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stdout}{stderr}");
}

fn write_lens(folder: &Path) -> std::path::PathBuf {
    let lens = folder.join("lens.json");
    std::fs::write(&lens, profile(2.0).to_json()).expect("writable");
    lens
}

#[test]
fn the_c_example_blurs_an_image_and_prints_errors() {
    if !cfg!(unix) || !is_installed("cc") {
        return skip("no C compiler `cc`");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let program = folder.path().join("apply");
    let libraries = library();
    let libraries = libraries.parent().expect("a folder");
    let compiled = Command::new("cc")
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
    assert_success(&compiled);
    let run = |lens: &Path| {
        Command::new(&program)
            .arg(lens)
            .env("LD_LIBRARY_PATH", libraries)
            .env("DYLD_LIBRARY_PATH", libraries)
            .output()
            .expect("it runs")
    };
    let output = run(&write_lens(folder.path()));
    assert_success(&output);
    let stdout = String::from_utf8_lossy(&output.stdout);
    assert!(stdout.contains("done 100 %"), "{stdout}");
    let output = run(&folder.path().join("none.json"));
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success());
    assert!(stderr.contains("none.json: could not be read"), "{stderr}");
}

#[test]
fn the_header_is_valid_cpp() {
    if !cfg!(unix) || !is_installed("c++") {
        return skip("no C++ compiler `c++`");
    }
    let header = Path::new(env!("CARGO_MANIFEST_DIR")).join("include/seidel.h");
    let checked = Command::new("c++")
        .args(["-std=c++11", "-Wall", "-Wextra", "-Werror", "-fsyntax-only"])
        .args(["-x", "c++"])
        .arg(header)
        .output()
        .expect("c++ runs");
    assert_success(&checked);
}

#[test]
fn the_python_example_blurs_an_image() {
    if !is_installed("python3") {
        return skip("no `python3`");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/apply.py");
    let output = Command::new("python3")
        .arg("-B")
        .arg(script)
        .arg(library())
        .arg(write_lens(folder.path()))
        .output()
        .expect("python3 runs");
    assert_success(&output);
    let stdout = String::from_utf8_lossy(&output.stdout);
    assert!(stdout.contains("point 50 ->"), "{stdout}");
}
