//! The lens library: listed, described, drawn, and taken by every command that takes a lens.

use seidel_core::{Frame, ObjectDistance, ObservationSet};
use serde_json::Value;

use crate::support::{
    generated_set, must_refuse, read_channel, succeeds, write_plate, write_pupil_lens,
};

#[test]
fn the_library_is_listed_and_described() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let table = succeeds(folder, "lens list").stdout;
    let json = succeeds(folder, "lens list --json").stdout;
    let sheets: Value = serde_json::from_str(&json).expect("JSON");
    let sheets = sheets.as_array().expect("a list");
    assert!((6..=12).contains(&sheets.len()), "{}", sheets.len());
    for sheet in sheets {
        let name = sheet["name"].as_str().expect("a name");
        let title = sheet["title"].as_str().expect("a title");
        let lines: Vec<&str> = table.lines().filter(|l| l.contains(title)).collect();
        assert!(
            lines.len() == 1 && lines[0].starts_with(&format!("library:{name} ")),
            "{table}"
        );
        // With and without the prefix.
        let described = succeeds(folder, &format!("lens show {name}")).stdout;
        assert_eq!(
            described,
            succeeds(folder, &format!("lens show library:{name}")).stdout
        );
        for part in [
            "Shows",
            "Good for",
            "computed from",
            "f-numbers",
            "sensor",
            title,
        ] {
            assert!(described.contains(part), "{name}: {part}");
        }
    }
    succeeds(folder, "lens show mirror-500 -o @sheet.png");
    let sheet = image::open(folder.join("sheet.png"))
        .expect("a PNG")
        .to_rgb8();
    let bright = sheet.pixels().filter(|p| p.0.iter().any(|&v| v > 128));
    assert!(bright.count() > 1000);
}

#[test]
fn commands_take_lenses_of_the_library() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_plate(&folder.join("plate.exr"), 64, 36);
    // Positions and tiles for the frame of the lens, at its focus.
    let set = ObservationSet {
        frame: Frame::new(1920, 1080, None).expect("a frame"),
        ..generated_set(&["R", "G", "B"], &[ObjectDistance::Metres(2.0)])
    };
    seidel_image_io::observation_set::write(&set, &folder.join("set")).expect("writable");
    succeeds(
        folder,
        "apply --lens library:swirl-58 @plate.exr -o @swirl.exr",
    );
    succeeds(
        folder,
        "apply --lens library:anamorphic-75 @plate.exr -o @oval.exr --f-number 4",
    );
    let (swirl, oval) = (
        read_channel(&folder.join("swirl.exr"), "G"),
        read_channel(&folder.join("oval.exr"), "G"),
    );
    assert!(swirl.iter().zip(&oval).any(|(a, b)| (a - b).abs() > 0.05));
    // The lens and its hash stand in the provenance.
    let info = succeeds(folder, "info @swirl.exr").stdout;
    assert!(info.contains("library:swirl-58 sha256:"), "{info}");
    succeeds(
        folder,
        "relens --from library:modern-50 --to library:swirl-58 @plate.exr -o @changed.exr --distance 3",
    );
    succeeds(
        folder,
        "psf --lens library:modern-50 --like @set --out @predicted",
    );
    succeeds(folder, "eval --lens library:modern-50 @predicted");
    // All effects are tried, except the blades that the lens has already.
    let line = "diagnose --lens library:modern-50 @predicted --out @diagnosis";
    succeeds(folder, line);
    let report = std::fs::read_to_string(folder.join("diagnosis/report.json")).expect("a report");
    assert!(report.contains("were not tried: iris blades"), "{report}");
    assert!(folder.join("changed.exr").exists() && folder.join("predicted/manifest.json").exists());
}

#[test]
fn unknown_names_get_the_nearest_and_leave_no_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_plate(&folder.join("plate.exr"), 32, 18);
    let line = "apply --lens library:swrl @plate.exr -o @out.exr --distance 3";
    let parts = [
        "library:swrl: is not the name of a lens",
        "library:swirl-58",
        "seidel lens list",
    ];
    must_refuse(folder, line, &parts);
    must_refuse(
        folder,
        "lens show library:macro -o @out.png",
        &["library:macro-100"],
    );
}

#[test]
fn files_are_described_and_lenses_of_the_library_written_to_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["Y"]);
    let shown = succeeds(folder, "lens show @lens.json").stdout;
    for words in [
        "lens.json: a lens drawn ray by ray",
        "f/2\n",
        "300 x 200 px",
        "channels      Y",
    ] {
        assert!(shown.contains(words), "{words}: {shown}");
    }
    succeeds(folder, "lens export modern-50 -o @pinned.json");
    write_plate(&folder.join("plate.exr"), 32, 18);
    let render = |lens: &str, name: &str| {
        succeeds(
            folder,
            &format!("apply --lens {lens} @plate.exr -o @{name} --distance 3"),
        );
        read_channel(&folder.join(name), "G")
    };
    assert!(render("@pinned.json", "file.exr") == render("library:modern-50", "library.exr"));
}

/// Colons are not allowed in the names of files on Windows.
#[cfg(unix)]
#[test]
fn a_file_of_that_name_comes_first() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["Y"]);
    let (own, named) = (folder.join("lens.json"), folder.join("library:swirl-58"));
    std::fs::rename(own, &named).expect("renamed");
    // The relative name is found in the folder of the process only, so that this one is given in full.
    let read = seidel_image_io::lens_profile::read(&named).expect("the file");
    assert_eq!(read.channel_names(), ["Y"]);
    let relative = std::path::Path::new("library:swirl-58");
    let library = seidel_image_io::lens_profile::read(relative).expect("the library");
    assert_eq!(library.channel_names(), ["R", "G", "B"]);
}
