//! Outputs contain their provenance, and `seidel info` shows it.

use std::path::Path;

use seidel_image_io::format::Format;

use crate::support::{must_refuse, seidel_in, succeeds, write_plate, write_pupil_lens};

fn info(folder: &Path, file: &str) -> String {
    succeeds(folder, &format!("info @{file}")).stdout
}

#[test]
fn outputs_contain_their_provenance_in_every_format() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["R", "G", "B"]);
    write_plate(&folder.join("plate.exr"), 40, 30);
    let pixels = image::Rgb32FImage::from_fn(20, 16, |x, y| {
        image::Rgb([x as f32 / 20.0, y as f32 / 16.0, 0.5])
    });
    let pixels = image::DynamicImage::ImageRgb32F(pixels);
    pixels
        .to_rgb16()
        .save(folder.join("plate.png"))
        .expect("writable");
    for format in Format::writable() {
        let format = format.extension();
        if !["exr", "png"].contains(&format) {
            let line = format!(
                "apply @plate.png -o @plate.{format} --lens @lens.json --distance 2 --amount 0 --no-provenance"
            );
            succeeds(folder, &line);
        }
        assert!(!info(folder, &format!("plate.{format}")).contains("made by Seidel"));
        let line = format!(
            "apply @plate.{format} -o @one.{format} --lens @lens.json --distance 2 --amount 0.5"
        );
        succeeds(folder, &line);
        let report = info(folder, &format!("one.{format}"));
        for part in [
            "made by Seidel",
            "seidelVersion: 0.",
            "seidelCommand: seidel apply ",
            "--amount 0.5",
            "seidelLens: lens.json sha256:",
            "amount: 0.5",
            "quality: final",
        ] {
            assert!(
                report.contains(part),
                "{format}: `{part}` is missing in {report}"
            );
        }
        assert!(!report.contains("seidelBefore"), "{report}");
        let line = format!(
            "remove @one.{format} -o @two.{format} --lens @lens.json --distance 2 --lens-check off"
        );
        succeeds(folder, &line);
        let report = info(folder, &format!("two.{format}"));
        assert!(report.contains("seidelCommand: seidel remove "), "{report}");
        let (_, before) = report
            .split_once("seidelBefore")
            .expect("earlier provenance");
        assert!(before.contains(": seidel apply "), "{before}");
        let line = format!(
            "apply @plate.{format} -o @mute.{format} --lens @lens.json --distance 2 --no-provenance"
        );
        succeeds(folder, &line);
        assert!(
            !info(folder, &format!("mute.{format}")).contains("seidel"),
            "{format}"
        );
    }
}

#[test]
fn files_are_described_with_their_attributes() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_plate(&folder.join("plate.exr"), 40, 30);
    let report = info(folder, "plate.exr");
    for part in [
        "OpenEXR",
        "size: 40 x 30",
        "Z (float)",
        "data window: 40 x 30 at (0, 0)",
        "compression: ",
    ] {
        assert!(report.contains(part), "`{part}` is missing in {report}");
    }
    let json = succeeds(folder, "info --json @plate.exr").stdout;
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!(json[0]["parts"][0]["size"][0], 40);
    std::fs::write(
        folder.join("bad.exr"),
        b"\x76\x2f\x31\x01\x02\0\0\0channels\0",
    )
    .expect("writable");
    must_refuse(folder, "info @bad.exr", &["bad.exr", "damaged"]);
    assert_eq!(seidel_in(folder, "info").status, 2);
}
