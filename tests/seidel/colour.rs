//! Colour spaces of plates: log plates are blurred as light, conversions are reported, and other data are untouched.

use std::fs;
use std::path::Path;

use exr::prelude::*;

use crate::support::{
    must_refuse, read_channel, seidel_in, succeeds, write_exr, write_moments_lens, write_plate,
};

const COLOURS: [&str; 3] = ["R", "G", "B"];
const SIZE: (usize, usize) = (72, 54);
/// Lens options of these tests.
const LENS: &str = "--lens @lens.json --lens-scale 0.6";
/// Selects the project's own config, whatever the environment names.
const OWN: &str = "--ocio seidel";

/// Returns a folder with a lens and `light.exr`, a scene-linear plate with alpha and depth.
fn test_folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    write_moments_lens(folder.path(), &COLOURS);
    write_plate(&folder.path().join("light.exr"), SIZE.0, SIZE.1);
    folder
}

/// Writes `light.exr` as a camera would have recorded it.
fn write_log(folder: &Path, file: &str, space: &str) {
    let line = format!("lut @light.exr -o @{file} {OWN} --in-space ACEScg --out-space {space}");
    succeeds(folder, &line);
}

/// Adds a text attribute to a plate.
fn tag(path: &Path, name: &str, value: &str) {
    let mut image = read_all_data_from_file(path).expect("readable");
    let text = AttributeValue::Text(Text::from(value));
    let other = &mut image.layer_data[0].attributes.other;
    other.insert(Text::from(name), text);
    image.write().to_file(path).expect("writable");
}

/// Returns a text attribute of a plate.
fn tagged(path: &Path, name: &str) -> Option<String> {
    let meta = MetaData::read_from_file(path, false).expect("readable");
    match meta.headers[0].own_attributes.other.get(&Text::from(name)) {
        Some(AttributeValue::Text(text)) => Some(text.to_string()),
        _ => None,
    }
}

/// Largest difference between the colours of two files, relative to the larger of 0.1 and the colour.
fn off(folder: &Path, found: &str, want: &str) -> f32 {
    let of_channel = |name: &&str| {
        let of = |file: &str| read_channel(&folder.join(file), name);
        let (found, want) = (of(found), of(want));
        assert_eq!(found.len(), want.len());
        let pairs = found.iter().zip(&want);
        pairs.fold(0.0, |worst: f32, (f, w)| {
            worst.max((f - w).abs() / w.abs().max(0.1))
        })
    };
    COLOURS.iter().map(of_channel).fold(0.0, f32::max)
}

fn same_bits(folder: &Path, a: &str, b: &str, channels: &[&str]) -> bool {
    let of = |file: &str, name: &str| -> Vec<u32> {
        let samples = read_channel(&folder.join(file), name);
        samples.iter().map(|v| v.to_bits()).collect()
    };
    channels.iter().all(|name| of(a, name) == of(b, name))
}

#[test]
fn a_log_plate_is_blurred_as_light() {
    let folder = test_folder();
    let folder = folder.path();
    succeeds(folder, &format!("apply @light.exr -o @want.exr {LENS}"));
    for space in [
        "logc4",
        "logc3",
        "slog3_sgamut3cine",
        "log3g10",
        "clog3",
        "vlog",
        "ACEScct",
    ] {
        write_log(folder, "log.exr", space);
        assert!(off(folder, "log.exr", "light.exr") > 0.1, "{space}");
        let line = format!("apply @log.exr -o @blurred.exr {LENS} {OWN} --in-space {space}");
        let message = succeeds(folder, &line).stderr;
        for part in ["--in-space", "processed in `ACEScg`", "Seidel's own config"] {
            assert!(message.contains(part), "{part} in {message}");
        }
        let line = format!(
            "lut @blurred.exr -o @found.exr {OWN} --in-space {space} --out-space scene_linear"
        );
        succeeds(folder, &line);
        let off_by = off(folder, "found.exr", "want.exr");
        assert!(off_by < 1e-3, "{space}: {off_by}");
        assert!(
            same_bits(folder, "blurred.exr", "light.exr", &["Z"]),
            "{space}"
        );
        assert!(
            same_bits(folder, "blurred.exr", "want.exr", &["A"]),
            "{space}"
        );
        // Blurring the codes themselves gives another image.
        let line = format!("apply @log.exr -o @wrong.exr {LENS}");
        assert!(!succeeds(folder, &line).stderr.contains("colour:"));
        assert!(off(folder, "wrong.exr", "blurred.exr") > 0.01, "{space}");
    }
}

#[test]
fn colours_are_converted_on_request_only() {
    let folder = test_folder();
    let folder = folder.path();
    write_log(folder, "log.exr", "logc4");
    succeeds(folder, &format!("apply @log.exr -o @want.exr {LENS}"));
    tag(&folder.join("log.exr"), "oiio:ColorSpace", "ARRI LogC4");
    let message = succeeds(folder, &format!("apply @log.exr -o @found.exr {LENS}")).stderr;
    assert!(
        message.contains("ARRI LogC4") && message.contains("--in-space auto"),
        "{message}"
    );
    assert!(same_bits(
        folder,
        "found.exr",
        "want.exr",
        &["R", "G", "B", "A", "Z"]
    ));
    tag(
        &folder.join("log.exr"),
        "oiio:ColorSpace",
        "lin_rec709_scene",
    );
    let message = succeeds(folder, &format!("apply @log.exr -o @found.exr {LENS}")).stderr;
    assert!(!message.contains("colour"), "{message}");
}

#[test]
fn the_space_may_come_from_the_plate() {
    let folder = test_folder();
    let folder = folder.path();
    write_log(folder, "log.exr", "logc4");
    let named = format!("{LENS} {OWN} --in-space logc4");
    succeeds(folder, &format!("apply @log.exr -o @want.exr {named}"));
    let auto = format!("{LENS} {OWN} --in-space auto");
    // From its attribute, else its name, else the rule for all files.
    fs::copy(folder.join("log.exr"), folder.join("tagged.exr")).expect("copied");
    tag(&folder.join("tagged.exr"), "colorInteropID", "unknown");
    tag(&folder.join("tagged.exr"), "oiio:ColorSpace", "arri_logc4");
    fs::copy(folder.join("log.exr"), folder.join("a_logc4_v1.exr")).expect("copied");
    for (file, says) in [
        ("tagged.exr", "its oiio:ColorSpace"),
        ("a_logc4_v1.exr", "the config's file rules"),
    ] {
        let message = succeeds(folder, &format!("apply @{file} -o @found.exr {auto}")).stderr;
        assert!(message.contains(says), "{message}");
        assert!(
            same_bits(folder, "found.exr", "want.exr", &["R", "G", "B"]),
            "{file}"
        );
    }
    let message = succeeds(folder, &format!("apply @log.exr -o @found.exr {auto}")).stderr;
    assert!(
        message.contains("rule for all files") && message.contains("`ACEScg`"),
        "{message}"
    );
    tag(
        &folder.join("tagged.exr"),
        "oiio:ColorSpace",
        "no such space",
    );
    let message = succeeds(folder, &format!("apply @tagged.exr -o @found.exr {auto}")).stderr;
    assert!(
        message.contains("`no such space` is not a space of the config"),
        "{message}"
    );
}

#[test]
fn the_output_space_may_differ() {
    let folder = test_folder();
    let folder = folder.path();
    write_log(folder, "log.exr", "logc4");
    for (name, value) in [
        ("oiio:ColorSpace", "logc4"),
        ("colorInteropID", "arri_logc4"),
    ] {
        tag(&folder.join("log.exr"), name, value);
    }
    let ways = format!("{LENS} {OWN} --in-space logc4");
    let line = format!("apply @log.exr -o @light2.exr {ways} --out-space ACEScg");
    let message = succeeds(folder, &line).stderr;
    assert!(message.contains("colorInteropID is left out"), "{message}");
    succeeds(folder, &format!("apply @light.exr -o @want.exr {LENS}"));
    assert!(off(folder, "light2.exr", "want.exr") < 1e-3);
    let of = |name: &str| tagged(&folder.join("light2.exr"), name);
    assert_eq!(of("oiio:ColorSpace").as_deref(), Some("ACEScg"));
    assert_eq!(of("colorInteropID"), None);
    // Also without blur; bit-identical where the space stays the same.
    let line = format!("apply @log.exr -o @plain.exr {ways} --out-space ACEScg --amount 0");
    succeeds(folder, &line);
    assert!(off(folder, "plain.exr", "light.exr") < 1e-4);
    succeeds(
        folder,
        &format!("apply @log.exr -o @same.exr {ways} --amount 0"),
    );
    assert!(same_bits(
        folder,
        "same.exr",
        "log.exr",
        &["R", "G", "B", "A", "Z"]
    ));
    let of = |name: &str| tagged(&folder.join("same.exr"), name);
    assert_eq!(of("oiio:ColorSpace").as_deref(), Some("logc4"));
    assert!(of("colorInteropID").is_some());
}

#[test]
fn integers_are_converted_alike_with_and_without_a_config() {
    let folder = test_folder();
    let folder = folder.path();
    let picture = image::ImageBuffer::from_fn(SIZE.0 as u32, SIZE.1 as u32, |x, y| {
        let step = |a: u32, b: u32| (40_000.0 * f64::from(a % b) / f64::from(b)) as u16 + 9000;
        image::Rgb([step(x, 9), step(y, 7), step(x + y, 11)])
    });
    picture.save(folder.join("plate.png")).expect("writable");
    let sight = format!("{LENS} --distance 2");
    succeeds(folder, &format!("apply @plate.png -o @want.png {sight}"));
    let colour = format!("{OWN} --in-space srgb_tx --working-space lin_rec709");
    succeeds(
        folder,
        &format!("apply @plate.png -o @found.png {sight} {colour}"),
    );
    let open = |name: &str| {
        image::open(folder.join(name))
            .expect("readable")
            .into_rgb16()
    };
    let (found, want) = (open("found.png"), open("want.png"));
    assert_ne!(open("plate.png"), want);
    let apart = found.iter().zip(want.iter()).map(|(f, w)| f.abs_diff(*w));
    assert!(apart.max() <= Some(2));
    // A plate of codes without blur survives the round trip through light.
    let line = format!("lut @plate.png -o @light.png {OWN} --in-space srgb_tx --out-space srgb_tx");
    succeeds(folder, &line);
    assert_eq!(open("light.png"), open("plate.png"));
}

#[test]
fn conversion_between_formats_converts_colour() {
    let folder = test_folder();
    let folder = folder.path();
    let ways = format!("{LENS} --distance 2 --amount 0 {OWN}");
    let apply = |files: &str, more: &str| {
        let message = succeeds(folder, &format!("apply {files} {ways} {more}")).stderr;
        message
            .lines()
            .find(|line| line.contains("colour: "))
            .expect("a warning")
            .to_owned()
    };
    // Integer codes become light.
    write_log(folder, "log.png", "logc4");
    write_log(folder, "log.dpx", "logc4");
    for name in ["log.png", "log.dpx"] {
        let message = apply(&format!("@{name} -o @light2.exr"), "--in-space logc4");
        assert!(
            message.contains("written in `ACEScg` (OUT is scene-linear)"),
            "{message}"
        );
        let space = tagged(&folder.join("light2.exr"), "oiio:ColorSpace");
        assert_eq!(space.as_deref(), Some("ACEScg"));
        // PNG holds no colour where alpha is 0.
        let covered: Vec<bool> = read_channel(&folder.join("light.exr"), "A")
            .iter()
            .map(|alpha| *alpha > 0.5)
            .collect();
        let within = if name == "log.png" { 2e-3 } else { 2e-2 };
        for channel in COLOURS {
            let of = |file: &str| read_channel(&folder.join(file), channel);
            let pairs = of("light2.exr").into_iter().zip(of("light.exr"));
            for ((found, want), _) in pairs.zip(&covered).filter(|(_, covered)| **covered) {
                let apart = (found - want).abs() / want.abs().max(0.1);
                assert!(apart < within, "{name} {channel}: {found} {want}");
            }
        }
        // On request they stay codes.
        let message = apply(
            &format!("@{name} -o @codes.exr"),
            "--in-space logc4 --out-space logc4",
        );
        assert!(message.contains("written in `ARRI LogC4`,"), "{message}");
        assert_eq!(tagged(&folder.join("codes.exr"), "oiio:ColorSpace"), None);
    }
    // Codes of an EXR file stay codes, in EXR and in integers; HDR holds light.
    write_log(folder, "log.exr", "logc4");
    for out in ["same.exr", "same.png"] {
        let message = apply(&format!("@log.exr -o @{out}"), "--in-space logc4");
        assert!(message.contains("written in `ARRI LogC4`,"), "{message}");
    }
    let message = apply("@log.exr -o @light.hdr", "--in-space logc4");
    assert!(
        message.contains("written in `ACEScg` (OUT is scene-linear)"),
        "{message}"
    );
    // Light becomes sRGB codes in integers, by a file rule of the config or else by name, and stays light in float TIFF.
    for out in ["a.png", "a.dpx"] {
        let message = apply(&format!("@light.exr -o @{out}"), "--in-space ACEScg");
        let written = "written in `sRGB - Texture` (OUT holds integers)";
        assert!(message.contains(written), "{message}");
    }
    let line = format!("lut @light.exr -o @want.png {OWN} --in-space ACEScg --out-space srgb_tx");
    succeeds(folder, &line);
    let open = |name: &str| {
        let picture = image::open(folder.join(name)).expect("readable");
        picture.into_rgba16()
    };
    let (found, want) = (open("a.png"), open("want.png"));
    let apart = found.iter().zip(want.iter()).map(|(f, w)| f.abs_diff(*w));
    assert!(apart.max() <= Some(1));
    let message = apply("@light.exr -o @a.tif", "--in-space ACEScg");
    assert!(message.contains("written in `ACEScg`,"), "{message}");
    // A config without such a space is refused.
    let yaml = "ocio_profile_version: 2.1\nroles:\n  default: Light\n  scene_linear: Light\n\
        file_rules:\n  - !<Rule> {name: Default, colorspace: default}\n\
        displays:\n  Screen:\n    - !<View> {name: Plain, colorspace: Light}\n\
        colorspaces:\n  - !<ColorSpace>\n    name: Light\n    encoding: scene-linear\n";
    fs::write(folder.join("tiny.ocio"), yaml).expect("writable");
    let line = format!(
        "apply @light.exr -o @b.png {LENS} --distance 2 --ocio @tiny.ocio --in-space Light"
    );
    must_refuse(
        folder,
        &line,
        &["b.png", "scene-linear `Light`", "--out-space"],
    );
}

#[test]
fn removing_and_reapplying_works_on_log_plates() {
    let folder = test_folder();
    let folder = folder.path();
    write_log(folder, "log.exr", "logc4");
    let sight = format!("{LENS} --distance 1.6");
    for out in ["logc4", "ACEScg"] {
        let line = format!(
            "remove @log.exr -o @sharp.exr --residual @rest.exr {sight} {OWN} --in-space logc4 --out-space {out} --lens-check off"
        );
        succeeds(folder, &line);
        let line = format!(
            "apply @sharp.exr -o @back.exr --residual @rest.exr {sight} {OWN} --in-space {out} --out-space logc4"
        );
        let message = succeeds(folder, &line).stderr;
        assert!(!message.contains("other settings"), "{message}");
        let off_by = off(folder, "back.exr", "log.exr");
        assert!(off_by < 2e-5, "{out}: {off_by}");
    }
    let line = format!("apply @sharp.exr -o @back.exr --residual @rest.exr {sight}");
    let message = succeeds(folder, &line).stderr;
    assert!(message.contains("working-space was ACEScg"), "{message}");
    let line = format!(
        "relens @log.exr -o @other.exr --from @lens.json --to @lens.json --lens-scale 0.6 --distance 1.6 {OWN} --in-space logc4 --lens-check off"
    );
    assert!(succeeds(folder, &line).stderr.contains("`ARRI LogC4`"));
    let line = "relens @light.exr -o @want.exr --from @lens.json --to @lens.json --lens-scale 0.6 --distance 1.6 --lens-check off";
    succeeds(folder, line);
    let line = format!("lut @other.exr -o @found.exr {OWN} --in-space logc4 --out-space ACEScg");
    succeeds(folder, &line);
    let off_by = off(folder, "found.exr", "want.exr");
    assert!(off_by < 1e-2, "{off_by}");
}

#[test]
fn colour_is_converted_unpremultiplied() {
    let folder = test_folder();
    let folder = folder.path();
    let count = SIZE.0 * SIZE.1;
    // A uniform plate of coverage 0.5: its unpremultiplied code is 0.5 in each channel.
    let plane = |value: f32| vec![value; count];
    let channels = [("R", 0.25), ("G", 0.25), ("B", 0.25), ("A", 0.5)];
    let channels = channels.map(|(name, value)| (name, plane(value)));
    write_exr(&folder.join("flat.exr"), SIZE.0, SIZE.1, &channels);
    let sight = format!("{LENS} --distance 2 {OWN} --in-space logc4");
    succeeds(folder, &format!("apply @flat.exr -o @blurred.exr {sight}"));
    // The lens may change the coverage. The unpremultiplied code stays, within the error of the renderer.
    let of = |name: &str| read_channel(&folder.join("blurred.exr"), name);
    for (code, alpha) in of("G").iter().zip(of("A")) {
        assert!((code / alpha - 0.5).abs() < 2e-3, "{code} {alpha}");
    }
    let line = format!(
        "lut @flat.exr -o @light.exr {OWN} --in-space logc4 --out-space lin_arri_wide_gamut_4"
    );
    succeeds(folder, &line);
    let light = read_channel(&folder.join("light.exr"), "G")[0];
    let full = seidel_colour_logc4(0.5);
    assert!((light / (full * 0.5) - 1.0).abs() < 1e-4, "{light} {full}");
}

fn seidel_colour_logc4(code: f64) -> f32 {
    let table = seidel_colour::curves::CurveTable::embedded().expect("in order");
    table.curves["logc4"].transfer.decode(code) as f32
}

#[test]
fn non_finite_numbers_are_reported() {
    let folder = test_folder();
    let folder = folder.path();
    write_log(folder, "log.exr", "logc4");
    let ways = format!("{LENS} {OWN} --in-space logc4");
    let names = ["R", "G", "B", "A", "Z"];
    let mut channels = names.map(|name| (name, read_channel(&folder.join("log.exr"), name)));
    channels[1].1[10] = f32::NAN;
    write_exr(&folder.join("nan.exr"), SIZE.0, SIZE.1, &channels);
    must_refuse(
        folder,
        &format!("apply @nan.exr -o @o.exr {ways}"),
        &["channel G", "--scrub"],
    );
    let message = succeeds(folder, &format!("apply @nan.exr -o @o.exr {ways} --scrub")).stderr;
    assert!(message.contains("replaced by zero"), "{message}");
    fs::remove_file(folder.join("o.exr")).expect("there");
    channels[1].1[10] = 1e6;
    write_exr(&folder.join("far.exr"), SIZE.0, SIZE.1, &channels);
    must_refuse(
        folder,
        &format!("apply @far.exr -o @o.exr {ways}"),
        &["no finite scene-linear value", "--in-space"],
    );
}

#[test]
fn unknown_spaces_and_configs_are_refused() {
    let folder = test_folder();
    let folder = folder.path();
    let apply = format!("apply @light.exr -o @o.exr {LENS}");
    must_refuse(
        folder,
        &format!("{apply} {OWN} --in-space logc5"),
        &["`logc5`", "`logc4`"],
    );
    must_refuse(
        folder,
        &format!("{apply} {OWN} --out-space nothing"),
        &["`nothing`", "--list"],
    );
    must_refuse(
        folder,
        &format!("{apply} --ocio @none.ocio"),
        &["none.ocio", "--ocio"],
    );
    fs::write(
        folder.join("bad.ocio"),
        "ocio_profile_version: 2.1\nroles: [",
    )
    .expect("writable");
    must_refuse(
        folder,
        &format!("{apply} --ocio @bad.ocio"),
        &["bad.ocio", "cannot be read"],
    );
    let outcome = seidel_in(
        folder,
        &format!("{apply} --in-space logc4 --encoding linear"),
    );
    assert_eq!(outcome.status, 2, "{}", outcome.stderr);
    let message = succeeds(
        folder,
        &format!("{apply} {OWN} --in-space ACEScg --working-space logc4"),
    );
    assert!(
        message.stderr.contains("linear light only"),
        "{}",
        message.stderr
    );
    let message = succeeds(folder, &format!("{apply} {OWN} --in-space Raw"));
    assert!(message.stderr.contains("is for data"), "{}", message.stderr);
}
