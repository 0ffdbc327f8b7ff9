//! Looks of the command: neutral ones, what they do to the light of a lamp, refusals.

use std::path::Path;

use seidel_core::LookPreset;

use crate::support::{read_channel, seidel_in, succeeds, write_exr, write_moments_lens};

const WIDTH: usize = 150;
const HEIGHT: usize = 110;
const LAMP: (usize, usize) = (75, 55);

/// Writes a dark plate with a lamp of 1000 in its middle.
fn write_lamp(folder: &Path) {
    let mut light = vec![0.1; WIDTH * HEIGHT];
    light[LAMP.1 * WIDTH + LAMP.0] = 1000.0;
    let channels = ["R", "G", "B"].map(|name| (name, light.clone()));
    write_exr(&folder.join("plate.exr"), WIDTH, HEIGHT, &channels);
}

const LINE: &str = "apply --lens library:modern-50 @plate.exr --distance inf --lens-scale 1";

/// Returns green of the plate with these options.
fn blurred(folder: &Path, options: &str) -> Vec<f32> {
    succeeds(folder, &format!("{LINE} -o @out.exr {options}"));
    read_channel(&folder.join("out.exr"), "G")
}

/// Returns the mean light between two distances from the lamp, pixels.
fn ring(light: &[f32], inner: f64, outer: f64) -> f64 {
    let at = |k: usize| {
        let (x, y) = ((k % WIDTH) as f64, (k / WIDTH) as f64);
        (x - LAMP.0 as f64).hypot(y - LAMP.1 as f64)
    };
    let within: Vec<f64> = (0..light.len())
        .filter(|k| (inner..outer).contains(&at(*k)))
        .map(|k| f64::from(light[k]) - 0.1)
        .collect();
    within.iter().sum::<f64>() / within.len() as f64
}

#[test]
fn neutral_looks_keep_every_bit() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_lamp(folder);
    let measured = blurred(folder, "");
    let neutral = "--squeeze 1 --obstruction 0 --cats-eye 0 --spherical 0 --axial-colour 1 \
                   --lateral-colour 1 --tilt 0 --tilt-direction 30 --bloom 0";
    assert_eq!(blurred(folder, neutral), measured);
    let shown = succeeds(folder, "info @out.exr").stdout;
    assert!(!shown.contains("look"), "{shown}");
    // Bloom leaves a plate below its level alone.
    assert_eq!(blurred(folder, "--bloom 0.5 --bloom-level 2000"), measured);
}

#[test]
fn looks_change_the_disc_of_a_lamp() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_lamp(folder);
    let measured = blurred(folder, "");
    // The disc has a radius of 24 px.
    let (middle, rim) = (ring(&measured, 0.0, 8.0), ring(&measured, 19.0, 23.0));
    assert!(
        middle > 0.3 && (rim / middle - 1.0).abs() < 0.2,
        "{middle} {rim}"
    );
    let mirror = blurred(folder, "--obstruction 0.5");
    assert!(ring(&mirror, 0.0, 8.0).abs() < 0.02 * middle);
    assert!(ring(&mirror, 14.0, 20.0) > 1.25 * ring(&measured, 14.0, 20.0));
    let bubble = blurred(folder, "--spherical 1");
    let soft = blurred(folder, "--spherical -1");
    let edge = |light: &[f32]| ring(light, 16.0, 19.0) / ring(light, 0.0, 8.0);
    assert!(edge(&bubble) > 1.3 * edge(&measured) && edge(&soft) < 0.8 * edge(&measured));
    let oval = blurred(folder, "--squeeze 2");
    let at = |light: &[f32], x: usize, y: usize| f64::from(light[y * WIDTH + x]) - 0.1;
    assert!(at(&oval, LAMP.0 + 16, LAMP.1).abs() < 0.02 * middle);
    assert!(at(&oval, LAMP.0, LAMP.1 + 16) > 1.5 * middle);
    // A corner of a triangle reaches the rim, its sides half of it. Discs behind the focus are turned by 180 degrees.
    let triangle = blurred(folder, "--blades 3 --rotation 90");
    assert!(at(&triangle, LAMP.0, LAMP.1 + 18).abs() < 0.02 * middle);
    assert!(at(&triangle, LAMP.0, LAMP.1 - 18) > middle);
    let shown = succeeds(folder, "info @out.exr").stdout;
    assert!(
        shown.contains("3 blades, roundness 0, rotation 90 degrees"),
        "{shown}"
    );
}

#[test]
fn discs_show_a_picture_of_the_aperture() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_lamp(folder);
    // White in the upper half.
    let mut picture = image::GrayImage::new(40, 40);
    for (_, y, pixel) in picture.enumerate_pixels_mut() {
        pixel.0[0] = if y < 20 { 255 } else { 0 };
    }
    picture.save(folder.join("half.png")).expect("writable");
    let half = blurred(folder, "--aperture-picture @half.png");
    let at = |y: usize| f64::from(half[y * WIDTH + LAMP.0]) - 0.1;
    // The command keeps the centroid of the light in its place.
    let lit: Vec<usize> = (0..HEIGHT).filter(|y| at(*y) > 0.3).collect();
    assert!((20..=28).contains(&lit.len()), "{lit:?}");
    let shown = succeeds(folder, "info @out.exr").stdout;
    assert!(shown.contains("aperture picture"), "{shown}");
    std::fs::remove_file(folder.join("out.exr")).expect("written before");
    let black = image::GrayImage::new(8, 8);
    black.save(folder.join("black.png")).expect("writable");
    for (file, words) in [
        ("black.png", ["black.png", "white where light passes"]),
        ("none.png", ["none.png", "none.png"]),
    ] {
        let line = format!("{LINE} -o @out.exr --aperture-picture @{file}");
        let refused = seidel_in(folder, &line);
        assert_eq!(refused.status, 1, "{file}");
        for word in words {
            assert!(refused.stderr.contains(word), "{}", refused.stderr);
        }
        assert!(!folder.join("out.exr").exists());
    }
}

#[test]
fn bloom_spreads_highlights_and_keeps_their_light() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_lamp(folder);
    let in_focus = |options: &str| blurred(folder, &format!("--focus-distance inf {options}"));
    let measured = in_focus("");
    // 1 % of the frame of 1920 are 19 px.
    let bloom = in_focus("--bloom 0.3 --bloom-level 0.5 --bloom-radius 0.5");
    let sum = |light: &[f32]| light.iter().map(|v| f64::from(*v)).sum::<f64>();
    let gained = sum(&bloom) / sum(&measured) - 1.0;
    assert!(gained.abs() < 1e-3, "{gained}");
    let core = |light: &[f32]| ring(light, 0.0, 6.0);
    assert!(core(&bloom) < 0.85 * core(&measured));
    assert!(ring(&bloom, 8.0, 16.0) > 10.0 * ring(&measured, 8.0, 16.0).abs());
    let shown = succeeds(folder, "info @out.exr").stdout;
    assert!(shown.contains("0.3 above 0.5, radius 0.5 %"), "{shown}");
}

#[test]
fn looks_change_by_frame() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_lamp(folder);
    for frame in [1, 2] {
        let to = folder.join(format!("plate.{frame}.exr"));
        std::fs::copy(folder.join("plate.exr"), to).expect("writable");
    }
    let table = |text: &str| std::fs::write(folder.join("look.csv"), text).expect("writable");
    table("frame,squeeze,rotation,bloom\n0,1,0,0\n2,2,60,0.4\n");
    let common =
        "apply --lens library:modern-50 --distance inf --lens-scale 1 --blades 3 --bloom-level 2";
    let frames = "@plate.%d.exr -o @out.%d.exr --frames 1-2 --animate @look.csv --bloom 0.1";
    succeeds(folder, &format!("{common} {frames}"));
    for (frame, options) in [
        (1, "--squeeze 1.5 --rotation 30 --bloom 0.2"),
        (2, "--squeeze 2 --rotation 60 --bloom 0.4"),
    ] {
        succeeds(
            folder,
            &format!("{common} {options} @plate.exr -o @out.exr"),
        );
        let own = read_channel(&folder.join(format!("out.{frame}.exr")), "G");
        assert!(own == read_channel(&folder.join("out.exr"), "G"), "{frame}");
    }
    let shown = succeeds(folder, "info @out.1.exr").stdout;
    assert!(
        shown.contains("rotation 30 degrees, squeeze 1.5"),
        "{shown}"
    );
    for (text, command, words) in [
        (
            "frame,squeeze\n1,9\n",
            common,
            ["frame 1, squeeze", "0.4 to 2.5"],
        ),
        ("frame,glow\n1,1\n", common, ["glow", "bloom-radius"]),
        (
            "frame,rotation\n1,1\n",
            "apply --lens library:modern-50 --distance inf",
            ["look.csv", "--blades"],
        ),
        (
            "frame,squeeze\n1,1\n",
            "remove --lens library:modern-50 --distance inf",
            ["squeeze", "amount"],
        ),
    ] {
        table(text);
        let line = frames.replace(" --bloom 0.1", "").replace("out", "bad");
        let bloom = if command == common {
            " --bloom 0.1"
        } else {
            ""
        };
        let refused = seidel_in(folder, &format!("{command} {line}{bloom}"));
        assert_eq!(refused.status, 1, "{text}: {}", refused.stderr);
        for word in words {
            assert!(refused.stderr.contains(word), "{text}: {}", refused.stderr);
        }
        assert!(!folder.join("bad.1.exr").exists(), "{text}");
    }
}

#[test]
fn bad_looks_are_refused_with_their_option_and_a_remedy() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_lamp(folder);
    for (options, words) in [
        ("--blades 2", &["--blades", "3 to 13"][..]),
        ("--blades 5.5", &["--blades", "3 to 13"]),
        ("--blades 5 --roundness 2", &["--roundness", "0 to 1"]),
        ("--roundness 0.5", &["--blades"]),
        ("--rotation 30", &["--blades"]),
        ("--blades 5 --rotation 200", &["--rotation", "-180 to 180"]),
        ("--squeeze 0", &["--squeeze", "0.4 to 2.5"]),
        ("--obstruction 1", &["--obstruction", "0 to 0.9"]),
        ("--cats-eye -2", &["--cats-eye", "-1 to 1"]),
        ("--spherical nan", &["--spherical", "-1 to 1"]),
        ("--axial-colour 5", &["--axial-colour", "-4 to 4"]),
        ("--lateral-colour x", &["--lateral-colour", "-4 to 4"]),
        ("--tilt 40", &["--tilt", "-30 to 30"]),
        ("--bloom 1.5", &["--bloom", "0 to 1"]),
        ("--bloom-level 2", &["--bloom"]),
        (
            "--bloom 0.5 --bloom-level -1",
            &["--bloom-level", "0 or more"],
        ),
        (
            "--bloom 0.5 --bloom-radius 50",
            &["--bloom-radius", "0.05 to 20"],
        ),
    ] {
        let refused = seidel_in(folder, &format!("{LINE} -o @out.exr {options}"));
        assert_ne!(refused.status, 0, "{options}");
        for word in words {
            assert!(
                refused.stderr.contains(word),
                "{options}: {}",
                refused.stderr
            );
        }
        assert!(!folder.join("out.exr").exists(), "{options}");
    }
    write_moments_lens(folder, &["R", "G", "B"]);
    let line = "apply --lens @lens.json @plate.exr -o @out.exr --distance 1.5 --squeeze 2";
    let refused = seidel_in(folder, line);
    assert_eq!(refused.status, 1);
    for word in ["lens.json", "look", "--model reduced"] {
        assert!(refused.stderr.contains(word), "{}", refused.stderr);
    }
}

/// Every look with a name gives what the guide says that it stands for.
#[test]
fn the_guide_lists_the_looks_with_a_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_lamp(folder);
    let guide = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/guide/looks.md");
    let guide = std::fs::read_to_string(guide).expect("the guide");
    for preset in LookPreset::all() {
        let start = format!("| `{}` | ", preset.name);
        let row = guide.lines().find(|line| line.starts_with(&start));
        let options = row.and_then(|row| row.split('`').nth(3));
        let options = options.unwrap_or_else(|| panic!("no row {start}"));
        let named = blurred(folder, &format!("--look {}", preset.name));
        assert_eq!(named, blurred(folder, options), "{options}");
    }
}
