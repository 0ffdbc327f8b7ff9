//! Invalid input: a message that names file, field and remedy, exit status 1, and no file left behind.

use std::fs;
use std::path::Path;

use crate::support::{
    TILE, must_refuse, seidel_in, write_exr, write_generated_set, write_moments_lens, write_plate,
};

/// Writes a valid lens, set and plate, damages them with `spoil`, and asserts that `line` fails with exit status 1 and a
/// message that contains all `parts`, and leaves the folder unchanged.
fn refused(spoil: impl Fn(&Path), line: &str, parts: &[&str]) {
    let folder = tempfile::tempdir().expect("a folder");
    write_moments_lens(folder.path(), &["R", "G", "B"]);
    write_plate(&folder.path().join("plate.exr"), 40, 30);
    spoil(folder.path());
    must_refuse(folder.path(), line, parts);
}

const FIT: &str = "fit @set -o @new.json";
const APPLY: &str = "apply --lens @lens.json @plate.exr -o @out.exr";

fn edit(path: &Path, from: &str, to: &str) {
    let text = fs::read_to_string(path).expect("there");
    assert!(text.contains(from), "{from} stands in {}", path.display());
    fs::write(path, text.replacen(from, to, 1)).expect("writable");
}

fn truncate(path: &Path, share: f64) {
    let bytes = fs::read(path).expect("there");
    let keep = (bytes.len() as f64 * share) as usize;
    fs::write(path, &bytes[..keep]).expect("writable");
}

/// Rewrites the first tile with one sample changed.
fn spoil_tile(folder: &Path, sample: f32) {
    let path = folder.join("set/psf/0000.exr");
    let channels: Vec<(&str, Vec<f32>)> = ["R", "G", "B"]
        .into_iter()
        .map(|name| {
            let mut samples = crate::support::read_channel(&path, name);
            if name == "G" {
                samples[100] = sample;
            }
            (name, samples)
        })
        .collect();
    write_exr(&path, TILE, TILE, &channels);
}

#[test]
fn missing_files() {
    let gone = |name: &'static str| {
        move |folder: &Path| fs::remove_file(folder.join(name)).expect("there")
    };
    refused(
        gone("set/manifest.json"),
        FIT,
        &["manifest.json", "give the folder"],
    );
    refused(
        gone("set/psf/0002.exr"),
        FIT,
        &["psf/0002.exr", "observation 2"],
    );
    refused(gone("lens.json"), APPLY, &["lens.json", "check the path"]);
    refused(gone("plate.exr"), APPLY, &["plate.exr"]);
    refused(
        |_| (),
        &format!("{APPLY} --depth @nowhere.exr").replace("@nowhere", "nowhere"),
        &["nowhere.exr"],
    );
    refused(
        |_| (),
        "fit @set -o @nowhere/lens.json",
        &["nowhere", "does not exist"],
    );
}

#[test]
fn truncated_files() {
    let cut = |name: &'static str| move |folder: &Path| truncate(&folder.join(name), 0.6);
    refused(
        cut("set/psf/0001.exr"),
        FIT,
        &["psf/0001.exr", "observation 1"],
    );
    refused(cut("set/manifest.json"), FIT, &["manifest.json", "line"]);
    refused(cut("lens.json"), APPLY, &["lens.json", "line"]);
    refused(cut("plate.exr"), APPLY, &["plate.exr"]);
}

#[test]
fn mismatched_sets_and_sizes() {
    refused(
        |folder| {
            write_generated_set(folder, "other", &["R", "G", "B"]);
            edit(&folder.join("other/manifest.json"), "300", "310");
        },
        "fit @set @other -o @new.json",
        &["image_size", "310"],
    );
    refused(
        |folder| edit(&folder.join("set/manifest.json"), "300", "310"),
        "psf --lens @lens.json --like @set --out @new",
        &["image_size", "310", "set"],
    );
}

#[test]
fn wrong_channels() {
    refused(
        |folder| edit(&folder.join("set/manifest.json"), "\"G\"", "\"Q\""),
        FIT,
        &["psf/0000.exr", "Q", "R"],
    );
    refused(
        |folder| {
            write_exr(
                &folder.join("plate.exr"),
                8,
                8,
                &[("velocity", vec![0.0; 64])],
            )
        },
        APPLY,
        &["plate.exr", "velocity", "--layer"],
    );
    refused(
        |_| (),
        &format!("{APPLY} --layer beauty"),
        &["plate.exr", "beauty"],
    );
    refused(
        |folder| {
            edit(
                &folder.join("lens.json"),
                "\"name\": \"G\"",
                "\"name\": \"Q\"",
            )
        },
        APPLY,
        &["channel G", "Q"],
    );
    refused(
        |folder| {
            edit(
                &folder.join("lens.json"),
                "\"name\": \"G\"",
                "\"name\": \"Q\"",
            )
        },
        "psf --lens @lens.json --like @set --out @new",
        &["channel G", "Q"],
    );
}

#[test]
fn nan_and_infinity() {
    refused(
        |folder| spoil_tile(folder, f32::NAN),
        FIT,
        &["psf/0000.exr", "channel G", "NaN"],
    );
    refused(
        |folder| spoil_tile(folder, f32::INFINITY),
        FIT,
        &["psf/0000.exr", "inf"],
    );
    refused(
        |folder| {
            edit(
                &folder.join("set/manifest.json"),
                "\"x\": 20.5",
                "\"x\": NaN",
            )
        },
        FIT,
        &["manifest.json", "x"],
    );
    for bad in [f32::NAN, f32::INFINITY] {
        refused(
            |folder| {
                let mut light = vec![0.5; 64];
                light[9] = bad;
                write_exr(
                    &folder.join("plate.exr"),
                    8,
                    8,
                    &[("Y", light), ("Z", vec![2.0; 64])],
                );
            },
            APPLY,
            &["plate.exr", "channel Y", "column 1, row 1", "--scrub"],
        );
    }
    refused(
        |folder| {
            let mut depth = vec![2.0; 64];
            depth[9] = f32::NAN;
            write_exr(
                &folder.join("plate.exr"),
                8,
                8,
                &[("Y", vec![0.5; 64]), ("Z", depth)],
            );
        },
        APPLY,
        &["plate.exr", "channel Z", "(1, 1)", "NaN"],
    );
}

#[test]
fn negative_and_empty_tiles() {
    refused(
        |folder| spoil_tile(folder, -0.5),
        FIT,
        &["psf/0000.exr", "channel G", "negative"],
    );
    refused(
        |folder| {
            let dark = |name| (name, vec![0.0; TILE * TILE]);
            write_exr(
                &folder.join("set/psf/0005.exr"),
                31,
                31,
                &["R", "G", "B"].map(dark),
            );
        },
        FIT,
        &["psf/0005.exr", "no light"],
    );
}

#[test]
fn depth_passes_that_do_not_fit() {
    refused(
        |folder| write_exr(&folder.join("z.exr"), 20, 30, &[("Z", vec![2.0; 600])]),
        "apply --lens @lens.json @plate.exr -o @out.exr --depth @z.exr",
        &["z.exr", "20x30", "40x30"],
    );
    refused(
        |folder| write_exr(&folder.join("z.exr"), 40, 30, &[("Z", vec![-2.0; 1200])]),
        "apply --lens @lens.json @plate.exr -o @out.exr --depth @z.exr",
        &["z.exr", "in front of the camera"],
    );
    refused(
        |folder| write_exr(&folder.join("plate.exr"), 8, 8, &[("Y", vec![0.5; 64])]),
        APPLY,
        &["plate.exr", "--depth", "--distance"],
    );
    refused(
        |folder| {
            let set =
                crate::support::generated_set(&["Y"], &[seidel_core::ObjectDistance::Metres(2.0)]);
            seidel_image_io::observation_set::write(&set, &folder.join("one")).expect("writable");
            assert_eq!(
                seidel_in(folder, "fit @one -o @lens.json --model moments").status,
                0
            );
            fs::copy(folder.join("plate.exr"), folder.join("z.exr")).expect("writable");
        },
        "apply --lens @lens.json @plate.exr -o @out.exr --depth @z.exr",
        &["lens.json", "one object distance"],
    );
}

#[test]
fn unknown_keys_and_other_versions() {
    let manifest = |from: &'static str, to: &'static str| {
        move |folder: &Path| edit(&folder.join("set/manifest.json"), from, to)
    };
    let lens = |from: &'static str, to: &'static str| {
        move |folder: &Path| edit(&folder.join("lens.json"), from, to)
    };
    refused(
        manifest("\"channels\"", "\"chanels\""),
        FIT,
        &["manifest.json", "chanels"],
    );
    refused(
        manifest("\"depth_m\"", "\"dept_m\""),
        FIT,
        &["manifest.json", "dept_m"],
    );
    refused(
        |folder: &Path| {
            let path = folder.join("set/manifest.json");
            let text = fs::read_to_string(&path).expect("a manifest");
            let mut set: serde_json::Value = serde_json::from_str(&text).expect("JSON");
            let first = set["observations"][0]
                .as_object_mut()
                .expect("an observation");
            assert!(first.remove("depth_m").is_some());
            fs::write(path, set.to_string()).expect("writable");
        },
        "fit @set -o @new.json --model moments",
        &["set: depth_m", "is missing for some observations"],
    );
    refused(
        manifest("\"version\": 1", "\"version\": 7"),
        FIT,
        &["manifest.json", "version", "7"],
    );
    refused(
        manifest("psf-observations", "something"),
        FIT,
        &["manifest.json", "format"],
    );
    refused(
        lens("\"s_sigma\"", "\"sigma\""),
        APPLY,
        &["lens.json", "sigma"],
    );
    refused(
        lens("\"version\": 1", "\"version\": 2"),
        APPLY,
        &["lens.json", "version", "2"],
    );
    refused(
        lens("seidel-lens", "other"),
        APPLY,
        &["lens.json", "format"],
    );
}

#[test]
fn invalid_outputs() {
    refused(
        |_| (),
        "apply --lens @lens.json @plate.exr -o @plate.exr",
        &["plate.exr", "overwritten", "another name"],
    );
    refused(
        |folder| {
            fs::copy(folder.join("plate.exr"), folder.join("z.exr")).expect("writable");
        },
        "apply --lens @lens.json @plate.exr -o @z.exr --depth @z.exr",
        &["z.exr", "overwritten"],
    );
    refused(
        |_| (),
        "apply --lens @lens.json @plate.exr -o @out.jpg",
        &["out.jpg", "never written"],
    );
    refused(
        |folder| fs::create_dir(folder.join("out.exr")).expect("writable"),
        APPLY,
        &["out.exr"],
    );
    refused(
        |folder| {
            fs::create_dir(folder.join("taken")).expect("writable");
            fs::write(folder.join("taken/notes.txt"), "mine").expect("writable");
        },
        "psf --lens @lens.json --like @set --out @taken",
        &["taken", "notes.txt"],
    );
}

#[test]
fn invalid_command_lines() {
    let folder = tempfile::tempdir().expect("a folder");
    for line in [
        "",
        "blur",
        "apply",
        "fit -o @x.json",
        "fit @set -o @x.json --axis here",
        "apply --lens @l @p.exr -o @o.exr --distance -3",
        "apply --lens @l @p.exr -o @o.exr --depth z.exr --distance 3",
    ] {
        let outcome = seidel_in(folder.path(), line);
        assert_eq!(outcome.status, 2, "{line}: {}", outcome.stderr);
        assert!(!outcome.stderr.is_empty());
    }
    write_moments_lens(folder.path(), &["Y"]);
    write_plate(&folder.path().join("plate.exr"), 8, 8);
    let outcome = seidel_in(folder.path(), &format!("{APPLY} --depth-kind far-one"));
    assert_eq!(outcome.status, 2, "{}", outcome.stderr);
    assert!(outcome.stderr.contains("--near"));
}
