//! `seidel lut`: conversion between colour spaces, tables for other programs, and the list of spaces.

use std::fs;
use std::path::Path;

use crate::support::{must_refuse, read_channel, seidel_in, succeeds, write_exr, write_plate};

/// Selects the project's own config, whatever the environment names.
const OWN: &str = "--ocio seidel";

#[test]
fn the_spaces_of_a_config_are_listed() {
    let folder = tempfile::tempdir().expect("a folder");
    let listed = succeeds(folder.path(), &format!("lut --list {OWN}")).stdout;
    for part in [
        "Seidel's own config",
        "ARRI LogC4",
        "logc4",
        "scene_linear",
        "sRGB/Plain",
    ] {
        assert!(listed.contains(part), "{listed}");
    }
    let studio = succeeds(folder.path(), "lut --list --ocio ocio://cg-config-latest").stdout;
    assert!(
        studio.contains("ocio://cg-config-latest") && studio.contains("ACEScg"),
        "{studio}"
    );
}

#[test]
fn conversion_can_be_reversed() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_plate(&folder.join("light.exr"), 40, 30);
    succeeds(
        folder,
        &format!("lut @light.exr -o @log.exr {OWN} --in-space ACEScg --out-space vlog"),
    );
    succeeds(
        folder,
        &format!("lut @log.exr -o @back.exr {OWN} --in-space vlog --out-space ACEScg"),
    );
    for name in ["R", "G", "B", "A", "Z"] {
        let of = |file: &str| read_channel(&folder.join(file), name);
        for (back, light) in of("back.exr").iter().zip(of("light.exr")) {
            assert!(
                (back - light).abs() <= 1e-5 * light.abs().max(0.01),
                "{name}: {back} {light}"
            );
        }
    }
    let message = succeeds(
        folder,
        &format!("lut @light.exr -o @shown.exr {OWN} --in-space auto --view sRGB/Plain"),
    );
    assert!(
        message.stderr.contains("rule for all files"),
        "{}",
        message.stderr
    );
    assert_eq!(
        read_channel(&folder.join("shown.exr"), "Z"),
        read_channel(&folder.join("light.exr"), "Z")
    );
}

#[test]
fn sequences_are_converted() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    for frame in 1..=3 {
        write_plate(
            &folder.join(format!("light.{frame:04}.exr")),
            40 - frame,
            30,
        );
    }
    let spaces = format!("{OWN} --in-space ACEScg --out-space logc4 --no-provenance");
    let run = format!("lut @light.%04d.exr -o @log.####.exr --frames 1-3 {spaces}");
    let out = |name: &str, frame: usize| {
        fs::read(folder.join(format!("{name}.{frame:04}.exr"))).expect("written")
    };
    let done = succeeds(folder, &run);
    assert_eq!(done.stdout.matches("wrote ").count(), 3, "{}", done.stdout);
    let colour = "frame 1: colour: `ACEScg` (--in-space) to `ARRI LogC4`";
    assert!(done.stderr.contains(colour), "{}", done.stderr);
    assert_eq!(done.stderr.matches("colour:").count(), 1, "{}", done.stderr);
    for frame in 1..=3 {
        let line = format!("lut @light.{frame:04}.exr -o @one.{frame:04}.exr {spaces}");
        succeeds(folder, &line);
        assert!(out("one", frame) == out("log", frame), "{frame}");
    }
    // A run goes on where it stopped with --skip-existing, and starts again without.
    fs::remove_file(folder.join("log.0002.exr")).expect("there");
    let done = succeeds(folder, &format!("{run} --skip-existing"));
    assert!(
        done.stderr.contains("2 of 3 frames are finished and kept"),
        "{}",
        done.stderr
    );
    assert!(done.stdout.matches("wrote ").count() == 1 && out("log", 2) == out("one", 2));
    fs::copy(folder.join("light.0003.exr"), folder.join("log.0003.exr")).expect("copies");
    succeeds(folder, &format!("{run} --memory 1 --threads 1"));
    assert!(out("log", 3) == out("one", 3));
    // A missing frame does not stop the others, and is reported at the end.
    fs::remove_file(folder.join("light.0002.exr")).expect("there");
    fs::remove_file(folder.join("log.0001.exr")).expect("there");
    let done = seidel_in(folder, &run);
    assert_eq!(done.status, 1);
    let (_, end) = (done.stderr)
        .split_once("error: 1 of 3 frames failed:")
        .expect("a list at the end");
    assert!(end.contains("light.0002.exr"), "{end}");
    assert!(out("log", 1) == out("one", 1));
    // --frames needs a pattern, tables take neither, and an output must not replace its input.
    let line = format!("lut @gone.%04d.exr -o @b.%04d.exr {spaces}");
    must_refuse(folder, &line, &["has no frame on disk", "--frames"]);
    // Without --frames it is all frames on disk.
    let found = succeeds(
        folder,
        &format!("lut @light.%04d.exr -o @c.%04d.exr {spaces}"),
    );
    assert!(
        found
            .stderr
            .contains("2 frames on disk, 1 to 3; missing: 2"),
        "{}",
        found.stderr
    );
    assert!(out("c", 3) == out("one", 3));
    let line = format!("lut @light.%04d.exr -o @b.exr {spaces} --frames 1-3");
    must_refuse(folder, &line, &["b.exr", "contains no frame pattern"]);
    let line = format!("lut @light.0001.exr -o @light.0001.exr {spaces}");
    must_refuse(folder, &line, &["would be overwritten"]);
    let done = seidel_in(folder, &format!("lut -o @b.cube {spaces} --frames 1-3"));
    assert_eq!(done.status, 2, "{}", done.stderr);
}

#[test]
fn outputs_contain_their_provenance() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_plate(&folder.join("light.0007.exr"), 20, 10);
    let line = format!(
        "lut @light.%04d.exr -o @log.%04d.exr {OWN} --in-space ACEScg --out-space logc4 --frames 7"
    );
    succeeds(folder, &line);
    let info = succeeds(folder, "info @log.0007.exr").stdout;
    for part in ["seidelCommand", "light.0007.exr", "out-space: ARRI LogC4"] {
        assert!(info.contains(part), "{part} in {info}");
    }
    assert!(!info.contains("--frames"), "{info}");
}

#[test]
fn non_finite_samples_are_refused_or_become_zero() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let plane = |bad: usize, fill: f32| -> Vec<f32> {
        let sample = |k| if k == bad { f32::NAN } else { fill };
        (0..200).map(sample).collect()
    };
    let channels = [
        ("R", plane(3, 0.5)),
        ("G", plane(200, 0.4)),
        ("B", plane(200, 0.3)),
        ("A", plane(7, 1.0)),
    ];
    write_exr(&folder.join("bad.exr"), 20, 10, &channels);
    let line = format!("lut @bad.exr -o @out.exr {OWN} --in-space logc4 --out-space ACEScg");
    must_refuse(folder, &line, &["bad.exr", "R", "--scrub"]);
    let message = succeeds(folder, &format!("{line} --scrub")).stderr;
    assert!(message.contains("replaced by zero"), "{message}");
    for name in ["R", "G", "B", "A"] {
        let plane = read_channel(&folder.join("out.exr"), name);
        assert!(plane.iter().all(|sample| sample.is_finite()), "{name}");
        if name == "A" {
            assert_eq!((plane[7], plane[8]), (0.0, 1.0));
        }
    }
}

/// Writes a config whose space `Camera` is converted to `Light` by the table `file`.
fn write_config(folder: &Path, file: &str) {
    let yaml = format!(
        "ocio_profile_version: 2.1\nsearch_path: .\nroles:\n  default: Light\n  scene_linear: Light\n\
         file_rules:\n  - !<Rule> {{name: Default, colorspace: default}}\n\
         displays:\n  Screen:\n    - !<View> {{name: Plain, colorspace: Camera}}\n\
         colorspaces:\n  - !<ColorSpace>\n    name: Light\n    encoding: scene-linear\n  - !<ColorSpace>\n    name: Camera\n    \
         to_scene_reference: !<FileTransform> {{src: {file}}}\n"
    );
    fs::write(folder.join("tables.ocio"), yaml).expect("writable");
}

#[test]
fn tables_equal_the_conversion() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_plate(&folder.join("light.exr"), 40, 30);
    succeeds(
        folder,
        &format!(
            "lut @light.exr -o @log.exr {OWN} --in-space lin_arri_wide_gamut_3 --out-space logc3"
        ),
    );
    for (table, to, within) in [
        (
            "a.spi1d --range=-0.125,1.125",
            "lin_arri_wide_gamut_3",
            1e-3,
        ),
        ("a.cube --size 65 --range=-0.125,1.25", "ACEScct", 0.01),
    ] {
        succeeds(
            folder,
            &format!("lut -o @{table} {OWN} --in-space logc3 --out-space {to}"),
        );
        succeeds(
            folder,
            &format!("lut @log.exr -o @want.exr {OWN} --in-space logc3 --out-space {to}"),
        );
        let file = table.split(' ').next().expect("a name");
        write_config(folder, file);
        succeeds(
            folder,
            "lut @log.exr -o @found.exr --ocio @tables.ocio --in-space Camera --out-space Light",
        );
        for name in ["R", "G", "B"] {
            let of = |file: &str| read_channel(&folder.join(file), name);
            for (found, want) in of("found.exr").iter().zip(of("want.exr")) {
                let off = (found - want).abs() / want.abs().max(0.05);
                assert!(off < within, "{file} {name}: {found} {want}");
            }
        }
    }
    let line = format!("lut -o @b.spi1d {OWN} --in-space logc3 --out-space ACEScg");
    must_refuse(folder, &line, &["b.spi1d", "mixes", ".cube"]);
}

#[test]
fn invalid_requests_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let spaces = format!("{OWN} --in-space logc3 --out-space ACEScg");
    must_refuse(
        folder,
        &format!("lut -o @b.txt {spaces}"),
        &["b.txt", ".spi1d"],
    );
    must_refuse(
        folder,
        &format!("lut -o @no/b.cube {spaces}"),
        &["b.cube", "does not exist"],
    );
    let line = format!("lut -o @b.cube {OWN} --in-space logc3 --view sRGB/Filmic");
    must_refuse(folder, &line, &["sRGB/Filmic", "sRGB/Plain"]);
    let line = format!("lut -o @b.cube {spaces} --range 0,1e30");
    must_refuse(folder, &line, &["finite", "--range"]);
    for wrong in ["--size 1", "--size 1000", "--range 1,0", "--range 1"] {
        let outcome = seidel_in(folder, &format!("lut -o @b.cube {spaces} {wrong}"));
        assert_eq!(outcome.status, 2, "{wrong}: {}", outcome.stderr);
    }
    assert_eq!(seidel_in(folder, "lut").status, 2);
    fs::write(folder.join("lost.ocio"), "").expect("writable");
    write_config(folder, "lost.cube");
    let line = "lut -o @b.cube --ocio @tables.ocio --in-space Camera --out-space Light";
    must_refuse(folder, line, &["tables.ocio", "lost.cube"]);
}
