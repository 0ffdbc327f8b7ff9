//! `seidel lut`: pictures from space to space, tables that other programs read, and what spaces there are.

use std::fs;
use std::path::Path;

use crate::support::{must_refuse, read_channel, seidel_in, succeeds, write_plate};

/// Colour by the project's own config, whatever the environment says.
const OWN: &str = "--ocio seidel";

#[test]
fn there_is_a_list_of_what_a_config_has() {
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
fn a_picture_goes_there_and_back() {
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
    let said = succeeds(
        folder,
        &format!("lut @light.exr -o @shown.exr {OWN} --in-space auto --view sRGB/Plain"),
    );
    assert!(
        said.stderr.contains("rule for all files"),
        "{}",
        said.stderr
    );
    assert_eq!(
        read_channel(&folder.join("shown.exr"), "Z"),
        read_channel(&folder.join("light.exr"), "Z")
    );
}

/// A config in `folder` whose space `Camera` is what the table `file` makes `Light` of.
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
fn tables_do_what_the_spaces_do() {
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
fn what_cannot_be_is_refused() {
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
