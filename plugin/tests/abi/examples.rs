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

/// Lays out header, library and package file as the release archive does.
#[test]
fn a_program_is_built_by_pkg_config() {
    if !cfg!(unix) || !is_installed("cc") || !is_installed("pkg-config") {
        return skip("no C compiler `cc` or no `pkg-config`");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let place = |from: &Path, to: &str| {
        let to = folder.path().join(to);
        std::fs::create_dir_all(to.parent().expect("a folder")).expect("a folder");
        std::fs::copy(from, to).expect("copied");
    };
    let library = library();
    let name = library.file_name().expect("a name").to_string_lossy();
    place(&library, &format!("lib/{name}"));
    place(&package.join("include/seidel.h"), "include/seidel.h");
    let text = std::fs::read_to_string(package.join("package/seidel.pc")).expect("the template");
    let text = text.replace("@VERSION@", env!("CARGO_PKG_VERSION"));
    let packages = folder.path().join("lib/pkgconfig");
    std::fs::create_dir_all(&packages).expect("a folder");
    std::fs::write(packages.join("seidel.pc"), text).expect("written");

    let ask = |question: &[&str]| {
        let output = Command::new("pkg-config")
            .args(question)
            .arg("seidel")
            .env("PKG_CONFIG_PATH", &packages)
            .output()
            .expect("pkg-config runs");
        assert_success(&output);
        String::from_utf8(output.stdout).expect("text")
    };
    let version = env!("CARGO_PKG_VERSION");
    assert_eq!(ask(&["--modversion"]).trim(), version);
    let program = folder.path().join("apply");
    let compiled = Command::new("cc")
        .arg("-std=c99")
        .arg(package.join("examples/apply.c"))
        .args(ask(&["--cflags", "--libs"]).split_whitespace())
        .args(["-lm", "-o"])
        .arg(&program)
        .output()
        .expect("cc runs");
    assert_success(&compiled);
    let output = Command::new(&program)
        .arg(write_lens(folder.path()))
        .env("LD_LIBRARY_PATH", folder.path().join("lib"))
        .env("DYLD_LIBRARY_PATH", folder.path().join("lib"))
        .output()
        .expect("it runs");
    assert_success(&output);
    let stdout = String::from_utf8_lossy(&output.stdout);
    assert!(
        stdout.starts_with(&format!("seidel {version}:")),
        "{stdout}"
    );
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
