//! The command line itself: helps, completions, manual pages, and what it says of slips.

use std::fs;
use std::path::Path;

use crate::support::{
    seidel, seidel_in, succeeds, write_generated_set, write_plate, write_pupil_lens,
};

/// Returns a folder with a lens, a plate and the set `measured`.
fn folder_with_files() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let channels = ["R", "G", "B"];
    write_pupil_lens(folder.path(), &channels);
    write_plate(&folder.path().join("plate.exr"), 40, 30);
    write_generated_set(folder.path(), "measured", &channels);
    folder
}

/// Asserts that a command line is refused with all these `words`.
fn says(folder: &Path, line: &str, words: &[&str]) {
    let outcome = seidel_in(folder, line);
    assert_ne!(outcome.status, 0, "{line}");
    for word in words {
        assert!(outcome.stderr.contains(word), "{line}: {}", outcome.stderr);
    }
}

#[test]
fn helps_have_headings_and_examples() {
    let short = seidel(&["apply", "-h"]).stdout;
    let long = seidel(&["apply", "--help"]).stdout;
    let headings = [
        "Input:", "Depth:", "Focus:", "Look:", "Colour:", "Output:", "Run:",
    ];
    for help in [&short, &long] {
        let mut rest = help.as_str();
        for heading in headings {
            let found = rest.split_once(heading);
            (_, rest) = found.unwrap_or_else(|| panic!("{heading} in its place: {help}"));
        }
    }
    assert!(!short.contains("--front-multiplier") && long.contains("--front-multiplier"));
    assert!(long.contains("Examples:") && !short.contains("Examples:"));
}

#[test]
fn scripts_complete_every_command_and_option() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = seidel(&["completions", shell]);
        assert_eq!(script.status, 0, "{shell}");
        for word in ["relens", "focus-distance", "plate-gap"] {
            assert!(script.stdout.contains(word), "{shell}: {word}");
        }
    }
}

#[test]
fn every_command_has_a_manual_page() {
    let folder = tempfile::tempdir().expect("a folder");
    succeeds(folder.path(), "man @share/man1");
    let page = |name: &str| {
        fs::read_to_string(folder.path().join("share/man1").join(name)).expect("a page")
    };
    assert!(page("seidel.1").contains("seidel\\-apply"));
    let apply = page("seidel-apply.1");
    let sections = [
        ".SH \"EXIT STATUS\"",
        ".SH ENVIRONMENT",
        "SEIDEL_LENSES",
        ".SH EXAMPLES",
    ];
    for word in ["focus\\-distance", "Depth"].iter().chain(&sections) {
        assert!(apply.contains(word), "{word}: {apply}");
    }
    assert!(
        !apply.contains("EXTRA") && !apply.contains("Examples:"),
        "{apply}"
    );
    assert!(page("seidel-measure-lights.1").contains("min\\-snr"));
}

#[test]
fn names_of_other_programs_lead_to_the_option() {
    let folder = Path::new(".");
    let line = "apply --lens lens.json in.exr -o out.exr";
    for (given, meant) in [
        ("--fstop 2", "'--f-number'"),
        ("--aperture=2", "'--f-number'"),
        ("--focus 3", "'--focus-distance'"),
        ("--intensity 0.5", "'--amount'"),
        ("--focal-point 3,4", "'--focus-at'"),
        ("--opacity 0.5", "'--mix'"),
    ] {
        let outcome = seidel_in(folder, &format!("{line} {given}"));
        assert_eq!(outcome.status, 2);
        assert!(outcome.stderr.contains(meant), "{}", outcome.stderr);
        assert!(!outcome.stderr.contains("-- --"), "{}", outcome.stderr);
    }
    // An option that the command does not have is not suggested.
    let outcome = seidel_in(folder, "info --fstop 2");
    assert!(!outcome.stderr.contains("--f-number"), "{}", outcome.stderr);
}

#[test]
fn f_numbers_are_read_as_they_are_written_on_lenses() {
    let folder = folder_with_files();
    let render = |number: &str| {
        let line = "apply --lens @lens.json @plate.exr --no-provenance --quality draft";
        succeeds(
            folder.path(),
            &format!("{line} --f-number {number} -o @out.exr"),
        );
        fs::read(folder.path().join("out.exr")).expect("the output")
    };
    let plain = render("4");
    assert!(plain == render("f/4") && plain == render("F4") && plain != render("f/8"));
    says(
        folder.path(),
        "apply --lens @lens.json @plate.exr -o @out.exr --f-number wide",
        &["--f-number", "such as 2.8 or f/2.8"],
    );
}

#[test]
fn negative_numbers_are_refused_for_what_they_are() {
    let folder = folder_with_files();
    let line = "apply --lens @lens.json @plate.exr -o @out.exr";
    for option in [
        "--distance",
        "--focus-distance",
        "--f-number",
        "--lens-scale",
    ] {
        let outcome = seidel_in(folder.path(), &format!("{line} {option} -3"));
        assert_ne!(outcome.status, 0, "{option}");
        assert!(!outcome.stderr.contains("-- -3"), "{}", outcome.stderr);
        assert!(outcome.stderr.contains("-3"), "{}", outcome.stderr);
        assert!(!outcome.stderr.contains("null"), "{}", outcome.stderr);
    }
}

#[test]
fn files_given_as_lenses_are_named_as_what_they_are() {
    let folder = folder_with_files();
    for (given, kind) in [
        ("plate.exr", "is a picture (OpenEXR), not a lens profile"),
        ("measured", "is an observation set, not a lens profile"),
        (".", "is a folder, not a lens profile"),
    ] {
        let line = format!("apply --lens @{given} @plate.exr -o @out.exr");
        says(folder.path(), &line, &[kind, "seidel fit"]);
        says(
            folder.path(),
            &format!("lens show @{given} -o @sheet.png"),
            &[kind],
        );
    }
}
