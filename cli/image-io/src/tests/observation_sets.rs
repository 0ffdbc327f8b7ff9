//! Observation sets: round trips, and faults by observation and field.

use std::fs;
use std::path::Path;

use seidel_optics::distance::ObjectDistance;
use serde_json::{Value, json};

use super::{halves, image, part, save};
use crate::error::FileError;
use crate::observation_set::{ReadOptions, read, write};
use exr::image::FlatSamples;
use exr::prelude::Compression;

fn bump(channel: usize) -> Vec<f32> {
    let mut samples = vec![0.0_f32; 20];
    samples[7] = 1.0 + channel as f32;
    samples[8] = 0.5;
    samples
}

fn tile(path: &Path, change: impl Fn(&mut Vec<f32>)) {
    let channel = |name, index| {
        let mut samples = bump(index);
        change(&mut samples);
        (name, FlatSamples::F32(samples))
    };
    let channels = vec![channel("R", 0), channel("G", 1), channel("B", 2)];
    save(
        &image(vec![part(
            None,
            (5, 4),
            (0, 0),
            Compression::ZIP16,
            channels,
        )]),
        path,
    );
}

fn observation(name: &str) -> Value {
    json!({"file": name, "x": 96.5, "y": 80.5})
}

fn set(observations: Vec<Value>) -> Value {
    json!({
        "format": "psf-observations", "version": 1, "image_size": [3840, 2160],
        "channels": ["R", "G", "B"], "observations": observations
    })
}

fn put(folder: &Path, manifest: &Value) {
    fs::write(folder.join("manifest.json"), manifest.to_string()).expect("writes");
}

fn refused(folder: &Path) -> String {
    read(folder, ReadOptions::default())
        .expect_err("refused")
        .to_string()
}

#[test]
fn all_fields_round_trip() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let at = folder.path();
    for name in ["a.exr", "b.exr", "c.exr"] {
        tile(&at.join(name), |_| {});
    }
    let mut all = set(vec![
        observation("a.exr"),
        observation("b.exr"),
        observation("c.exr"),
    ]);
    all["pixel_pitch_um"] = json!(4.0);
    all["optical_axis"] = json!([1900.0, 1000.5]);
    all["camera"] = json!({"focal_length_mm": 50.0, "focus_distance_m": null,
        "wavelength_nm": {"R": 620.0}, "squeeze": 2.0});
    all["observations"][0]["depth_m"] = json!(2.0);
    all["observations"][0]["ideal_x"] = json!(97.0);
    all["observations"][0]["ideal_y"] = json!(81.0);
    all["observations"][1]["depth_m"] = Value::Null;
    all["observations"][1]["noise_sigma"] = json!({"G": 0.25});
    all["observations"][1]["background"] = json!({"R": 0.0078125});
    all["observations"][2]["noise_sigma"] = json!(0.5);
    all["observations"][2]["saturated"] = json!(true);
    put(at, &all);
    let loaded = read(at, ReadOptions::default()).expect("a valid set");
    assert!(loaded.skipped.is_empty());
    let found = &loaded.set;
    assert_eq!(
        read(&at.join("manifest.json"), ReadOptions::default()).expect("by file"),
        loaded
    );
    assert_eq!(found.camera.focus_distance, ObjectDistance::Infinity);
    assert_eq!(found.camera.f_number, None);
    assert_eq!(found.camera.squeeze, Some(2.0));
    let distances: Vec<_> = found.observations.iter().map(|o| o.distance).collect();
    assert_eq!(
        distances,
        [
            ObjectDistance::Metres(2.0),
            ObjectDistance::Infinity,
            ObjectDistance::Unknown
        ]
    );
    assert_eq!(found.observations[1].noise_sigma, [None, Some(0.25), None]);
    assert_eq!(found.observations[1].background, [0.0078125, 0.0, 0.0]);
    assert_eq!(found.observations[2].noise_sigma, [Some(0.5); 3]);
    assert_eq!(found.observations[0].tiles[2].samples()[7], 3.0);

    let copy = at.join("sub/copy");
    write(found, &copy).expect("writes");
    assert_eq!(
        &read(&copy, ReadOptions::default()).expect("reads").set,
        found
    );
    write(found, &copy).expect("over itself");
    fs::write(copy.join("notes.txt"), "mine").expect("writes");
    assert!(write(found, &copy).is_err());
}

#[test]
fn tiles_of_every_format_are_read() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let at = folder.path();
    let grey = image::ImageBuffer::from_fn(4, 3, |x, _| image::Luma([x as u16 * 1000]));
    image::DynamicImage::ImageLuma16(grey.clone())
        .save(at.join("a.png"))
        .expect("saves");
    image::DynamicImage::ImageLuma16(grey)
        .save(at.join("b.tiff"))
        .expect("saves");
    let byte = image::ImageBuffer::from_fn(4, 3, |x, _| image::Luma([x as u8 * 51]));
    image::DynamicImage::ImageLuma8(byte)
        .save(at.join("c.png"))
        .expect("saves");
    let floats = vec![0.5_f32; 12];
    crate::formats::tiff::write_float(&at.join("d.tif"), 4, 3, vec![floats]).expect("saves");
    let half = part(
        None,
        (4, 3),
        (-9, 9),
        Compression::PIZ,
        vec![("Y", halves(12))],
    );
    save(&image(vec![half]), &at.join("e.exr"));
    let mut all = set(["a.png", "b.tiff", "c.png", "d.tif", "e.exr"]
        .map(observation)
        .to_vec());
    all["channels"] = json!(["Y"]);
    put(at, &all);
    let found = read(at, ReadOptions::default()).expect("all formats").set;
    let third = |i: usize| found.observations[i].tiles[0].samples()[2];
    assert_eq!(
        (third(0), third(1), third(2), third(3)),
        (2000.0 / 65535.0, 2000.0 / 65535.0, 0.4, 0.5)
    );

    let copy = at.join("copy");
    write(&found, &copy).expect("writes");
    let back = read(&copy, ReadOptions::default()).expect("reads").set;
    let names: Vec<_> = back.observations.iter().map(|o| o.file.as_str()).collect();
    assert_eq!(names, ["a.exr", "b.tiff", "c.exr", "d.tif", "e.exr"]);
    for (a, b) in found.observations.iter().zip(&back.observations) {
        assert_eq!(a.tiles, b.tiles);
    }
}

#[test]
fn all_faults_are_reported_together_and_bad_observations_can_be_skipped() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let at = folder.path();
    tile(&at.join("good.exr"), |_| {});
    tile(&at.join("nan.exr"), |s| s[6] = f32::NAN);
    tile(&at.join("dark.exr"), |s| s.fill(0.0));
    tile(&at.join("negative.exr"), |s| s[0] = -0.5);
    tile(&at.join("cut.exr"), |_| {});
    let bytes = fs::read(at.join("cut.exr")).expect("reads");
    fs::write(at.join("cut.exr"), &bytes[..bytes.len() - 30]).expect("writes");
    fs::write(at.join("empty.exr"), "").expect("writes");
    let layered = part(
        None,
        (5, 4),
        (0, 0),
        Compression::ZIP16,
        vec![("layer.R", halves(20))],
    );
    save(&image(vec![layered]), &at.join("layer.exr"));
    let mut bad_numbers = observation("good.exr");
    bad_numbers["depth_m"] = json!(-2.0);
    bad_numbers["noise_sigma"] = json!({"X": 1.0});
    bad_numbers["gain"] = json!(0.0);
    bad_numbers["ideal_x"] = json!(1.0);
    // A value of another type, and a key that does not exist: the first is the only fault of its observation.
    let misfit = |key: &str, value: Value| {
        let mut misfit = observation("good.exr");
        misfit[key] = value;
        misfit
    };
    let names = [
        "nan", "dark", "negative", "cut", "empty", "layer", "missing",
    ];
    let mut list = vec![observation("good.exr"), bad_numbers];
    list.extend(names.map(|n| observation(&format!("{n}.exr"))));
    list.extend(["../x.exr", "/etc/x.exr", "C:\\x.exr", "a\\..\\..\\x.exr"].map(observation));
    list.extend([json!(7), json!([1])]);
    list.push(misfit("x", json!("left")));
    list.push(misfit("dept_m", json!(2.0)));
    list.push(misfit("gain", Value::Null));
    list.push(misfit("flux", json!({"R": "x"})));
    let count = list.len();
    put(at, &set(list));
    let text = refused(at);
    for expected in [
        "observation 1 (good.exr) depth_m: is -2",
        "observation 1 (good.exr) noise_sigma: names the channel `X`",
        "observation 1 (good.exr) gain: is 0; give counts per electron",
        "observation 1 (good.exr) ideal_y: is missing beside ideal_x",
        "observation 2 (nan.exr) channel R: the sample at column 1, row 1 is NaN",
        "observation 2 (nan.exr) channel B",
        "observation 3 (dark.exr) channel G: holds no light",
        "observation 4 (negative.exr) channel R: holds -0.5",
        "observation 5 (cut.exr) file: is damaged or truncated",
        "observation 6 (empty.exr) file: is empty",
        "observation 7 (layer.exr) channel R, G, B: is not in the tile, which has layer.R",
        "observation 8 (missing.exr) file: cannot be",
        "observation 9 (../x.exr) file: is \"../x.exr\", which is not inside",
        "observation 10 (/etc/x.exr) file",
        "observation 11 (C:\\x.exr) file",
        "observation 12 (a\\..\\..\\x.exr) file",
        "observation 13 observation: does not fit: invalid type: integer `7`, expected a JSON object; correct it",
        "observation 14 observation: is a list",
        "observation 15 (good.exr) x: does not fit: invalid type: string \"left\"",
        "observation 16 (good.exr) dept_m: does not fit: unknown field `dept_m`, expected one of `file`, `x`, `y`, `depth_m`",
        "observation 17 (good.exr) gain: is null",
        "observation 18 (good.exr) flux: does not fit: expected a number, or an object",
    ] {
        assert!(text.contains(expected), "no `{expected}` in:\n{text}");
    }
    let loaded = read(at, ReadOptions { skip_bad: true }).expect("one is left");
    assert_eq!(loaded.set.observations.len(), 1);
    assert_eq!(loaded.skipped.len(), count - 1);
    assert_eq!(loaded.skipped[0].index, 1);
    assert_eq!(loaded.skipped[0].faults.len(), 4);
}

#[test]
fn an_observation_that_is_listed_twice_is_a_fault_of_the_second() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let at = folder.path();
    for name in ["a.exr", "b.exr"] {
        tile(&at.join(name), |_| {});
    }
    let mut elsewhere = observation("a.exr");
    elsewhere["x"] = json!(300.5);
    let mut farther = observation("a.exr");
    farther["depth_m"] = json!(9.0);
    let list = vec![
        observation("a.exr"),
        observation("b.exr"),
        elsewhere,
        farther,
    ];
    put(at, &set(list.clone()));
    assert!(read(at, ReadOptions::default()).is_ok(), "places differ");
    put(at, &set([list, vec![observation("a.exr")]].concat()));
    let text = refused(at);
    let expected = "observation 4 (a.exr) file: is listed before with the same position";
    assert!(text.contains(expected), "{text}");
    let loaded = read(at, ReadOptions { skip_bad: true }).expect("four are left");
    assert_eq!(loaded.set.observations.len(), 4);
    assert_eq!(loaded.skipped[0].index, 4);
}

#[test]
fn faults_of_the_set_itself_are_never_skipped() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let at = folder.path();
    assert!(refused(at).contains("contains no manifest.json"));
    tile(&at.join("a.exr"), |_| {});
    for (key, value, expected) in [
        ("format", json!("other"), "format: is \"other\""),
        (
            "version",
            json!(3),
            "version: is 3; give a set of the format",
        ),
        ("image_size", json!([0, 10]), "image_size: is [0,10]"),
        ("image_size", json!([10.5, 10]), "image_size: is [10.5,10]"),
        ("image_size", json!([10]), "image_size"),
        (
            "optical_axis",
            json!([1.0, "b"]),
            "optical_axis[1]: does not fit: invalid type: string \"b\"",
        ),
        (
            "optical_axis",
            json!([1e9, 1.0]),
            "optical_axis: is (1000000000, 1)",
        ),
        ("pixel_pitch_um", json!(0.0), "pixel_pitch_um: is 0"),
        ("channels", json!([]), "channels: is empty"),
        ("channels", json!(["R", "R"]), "names `R` twice"),
        ("channels", json!("R"), "channels: does not fit"),
        (
            "camera",
            json!({"f_number": -1.0}),
            "camera.f_number: is -1",
        ),
        (
            "camera",
            json!({"iso": 3}),
            "camera.iso: does not fit: unknown field",
        ),
        (
            "camera",
            json!({"wavelength_nm": {"R": "x"}}),
            "camera.wavelength_nm.R: does not fit",
        ),
        (
            "camera",
            json!({"focus_distance_m": 0.0}),
            "camera.focus_distance_m: is 0",
        ),
        (
            "camera",
            json!({"wavelength_nm": {"R": 620.0, "X": 620.0}}),
            "camera.wavelength_nm.X: is of a channel that does not exist; name one of the channels: R, G, B",
        ),
        (
            "camera",
            json!({"wavelength_nm": {"R": 0.62}}),
            "camera.wavelength_nm.R: is 0.62; give nanometres",
        ),
        ("observations", json!([]), "observations: is empty"),
        ("observations", json!({}), "observations: does not fit"),
        ("extra", json!(1), "extra: does not fit: unknown field"),
    ] {
        let mut all = set(vec![observation("a.exr")]);
        all[key] = value;
        put(at, &all);
        let text = refused(at);
        assert!(text.contains(expected), "no `{expected}` in: {text}");
        let error = read(at, ReadOptions { skip_bad: true }).expect_err("a fault of the set");
        assert!(matches!(error, FileError::Many { .. }));
    }
    for key in [
        "format",
        "version",
        "image_size",
        "channels",
        "observations",
    ] {
        let mut all = set(vec![observation("a.exr")]);
        all.as_object_mut().expect("object").remove(key);
        put(at, &all);
        let text = refused(at);
        assert!(text.contains("missing") && text.contains(key), "{text}");
    }
    fs::write(at.join("manifest.json"), "{\"format\": \n oops}").expect("writes");
    assert!(refused(at).contains("line 2, column 2"), "{}", refused(at));
    let text = set(vec![observation("a.exr")])
        .to_string()
        .replace("96.5", "NaN");
    fs::write(at.join("manifest.json"), text).expect("writes");
    assert!(
        refused(at).contains("observation 0 (a.exr) x: does not fit: invalid type: string \"NaN\""),
        "{}",
        refused(at)
    );
}
