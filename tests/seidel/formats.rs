//! The command on plates in formats other than EXR: read, blurred, and written in the same and in another format.

use std::fs;
use std::path::Path;

use image::{ImageBuffer, Rgb};

use crate::support::{
    listing, must_refuse, read_channel, seidel_in, succeeds, write_exr, write_moments_lens,
    write_plate, write_pupil_lens,
};

/// Returns a folder with a lens and the PNG plates `plate.1.png` and `plate.2.png` of 30 x 20 pixels.
fn test_folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    write_moments_lens(folder.path(), &["R", "G", "B"]);
    for frame in 1..=2_u32 {
        let pixel = |x: u32, y: u32| {
            let light = if (x / 3 + y / 4 + frame).is_multiple_of(3) {
                52_000
            } else {
                9_000
            };
            Rgb([light, light / 2 + 100, 3_000 + x as u16])
        };
        ImageBuffer::<Rgb<u16>, Vec<u16>>::from_fn(30, 20, pixel)
            .save(folder.path().join(format!("plate.{frame}.png")))
            .expect("the test's own file");
    }
    folder
}

const APPLY: &str = "apply --lens @lens.json --distance 2 --no-provenance";

fn bytes(folder: &Path, name: &str) -> Vec<u8> {
    fs::read(folder.join(name)).expect("written")
}

#[test]
fn the_blur_is_the_same_in_every_format() {
    let folder = test_folder();
    let folder = folder.path();
    for frame in 1..=2 {
        succeeds(
            folder,
            &format!("{APPLY} --amount 0 @plate.{frame}.png -o @same.{frame}.dpx"),
        );
    }
    // Also sequences: 16-bit sRGB codes of PNG and of DPX become the same light.
    for input in ["plate.%d.png", "same.%d.dpx"] {
        succeeds(
            folder,
            &format!("{APPLY} @{input} -o @{input}.exr --frames 1-2"),
        );
    }
    for frame in 1..=2 {
        for name in ["R", "G", "B"] {
            let of = |input: &str| read_channel(&folder.join(format!("{input}.exr")), name);
            let (png, dpx) = (
                of(&format!("plate.{frame}.png")),
                of(&format!("same.{frame}.dpx")),
            );
            assert!(png == dpx, "{frame} {name}");
            assert!(png.iter().any(|v| *v > 0.001));
        }
    }
    // In the same format, DPX keeps every byte outside the pixels, and those too where nothing is blurred.
    succeeds(
        folder,
        &format!("{APPLY} --amount 0 @same.1.dpx -o @again.dpx"),
    );
    assert!(bytes(folder, "same.1.dpx") == bytes(folder, "again.dpx"));
    let outcome = succeeds(folder, &format!("{APPLY} @same.1.dpx -o @blurred.dpx"));
    assert!(
        outcome.stderr.contains("read as sRGB"),
        "{}",
        outcome.stderr
    );
    let (before, after) = (bytes(folder, "same.1.dpx"), bytes(folder, "blurred.dpx"));
    assert!(before[..2048] == after[..2048] && before.len() == after.len());
    assert!(before[2048..] != after[2048..]);
}

#[test]
fn lost_data_are_reported_and_jpeg_is_never_written() {
    let folder = test_folder();
    let folder = folder.path();
    write_plate(&folder.join("plate.exr"), 30, 20);
    let outcome = succeeds(folder, "apply --lens @lens.json @plate.exr -o @out.hdr");
    for part in [
        "channels Z are left out",
        "holds no alpha",
        "written as RGBE",
    ] {
        assert!(outcome.stderr.contains(part), "{part}: {}", outcome.stderr);
    }
    let outcome = succeeds(folder, "apply --lens @lens.json @plate.exr -o @out.png");
    assert!(
        outcome.stderr.contains("over 1 do not fit 16-bit"),
        "{}",
        outcome.stderr
    );
    // Before anything is rendered.
    let before = listing(folder).len();
    for name in ["out.jpg", "out", "out.gif"] {
        must_refuse(
            folder,
            &format!("{APPLY} @plate.1.png -o @{name}"),
            &[name, ".exr"],
        );
    }
    assert_eq!(listing(folder).len(), before);
    let help = seidel_in(folder, "apply --help");
    for word in ["DPX", "HDR", "JPEG"] {
        assert!(help.stdout.contains(word), "{}", help.stdout);
    }
}

#[test]
fn remove_writes_other_formats_except_for_residuals() {
    let folder = test_folder();
    let folder = folder.path();
    write_plate(&folder.join("plate.exr"), 30, 20);
    must_refuse(
        folder,
        "remove --lens @lens.json --distance 2 @plate.exr -o @sharp.tif --residual @r.exr",
        &["sharp.tif", "--residual", "OpenEXR"],
    );
    let line = "remove --lens @lens.json --distance 2 --lens-check off @plate.exr";
    succeeds(folder, &format!("{line} -o @sharp.tif"));
    succeeds(folder, &format!("{line} -o @sharp.exr --no-overscan"));
    let tif = image::open(folder.join("sharp.tif"))
        .expect("reads")
        .into_rgba32f();
    assert_eq!((tif.width(), tif.height()), (30, 20));
    for (channel, name) in ["R", "G", "B", "A"].iter().enumerate() {
        let plane: Vec<f32> = tif.pixels().map(|p| p[channel]).collect();
        assert!(
            plane == read_channel(&folder.join("sharp.exr"), name),
            "{name}"
        );
    }
}

#[test]
fn exr_compression_can_be_chosen_and_spares_data_channels() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["R", "G", "B"]);
    write_plate(&folder.join("depth.exr"), 64, 40);
    let colours = ["R", "G", "B"].map(|name| (name, read_channel(&folder.join("depth.exr"), name)));
    write_exr(&folder.join("plate.exr"), 64, 40, &colours);
    let line = "apply --lens @lens.json --distance 2 --amount 0";
    let packed = |input: &str, how: &str| {
        let outcome = succeeds(
            folder,
            &format!("{line} @{input}.exr -o @{how}.exr --compression {how}"),
        );
        let info = succeeds(folder, &format!("info @{how}.exr")).stdout;
        let stored = info.lines().find(|l| l.contains("compression: "));
        (
            outcome.stderr,
            stored.expect("a compression").to_lowercase(),
        )
    };
    for how in ["none", "rle", "zips", "zip", "piz"] {
        packed("plate", how);
        for (name, samples) in &colours {
            assert!(
                read_channel(&folder.join(format!("{how}.exr")), name) == *samples,
                "{how}"
            );
        }
    }
    let (message, stored) = packed("plate", "dwaa");
    assert!(
        stored.contains("dwaa") && !message.contains("degrade"),
        "{stored} {message}"
    );
    let lossy = read_channel(&folder.join("dwaa.exr"), "R");
    assert!(lossy != colours[0].1);
    // With depth in the same part the option is ignored, with a warning.
    let (message, stored) = packed("depth", "dwaa");
    assert!(
        stored.contains("zip") && message.contains("would degrade Z"),
        "{stored} {message}"
    );
    let line = format!("{line} @plate.exr -o @plate.tif --compression zip");
    assert_eq!(seidel_in(folder, &line).status, 2);
}
