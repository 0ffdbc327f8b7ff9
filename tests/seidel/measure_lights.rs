//! `seidel measure lights`: from a raw photograph of lights to the lens that took it.

use std::path::{Path, PathBuf};

use seidel_core::profile::LensDescription;
use seidel_core::{LensProfile, ObjectDistance, ObservationSet, Predictor};
use seidel_optics::numeric::SplitMix64;
use seidel_optics::predict::predict_set;
use seidel_optics::psf::Pupil;
use serde_json::Value;

use crate::support::{
    generated_set, must_refuse, real_data, seidel_in, succeeds, write_pupil_lens,
};

const WIDTH: usize = 300;
const HEIGHT: usize = 200;
/// Counts per electron, black level and clipping level.
pub(crate) const GAIN: f64 = 0.5;
pub(crate) const BLACK: u16 = 256;
pub(crate) const WHITE: u16 = 16_000;
/// Colours of the top-left 2 x 2 pixels: G B R G.
pub(crate) const PATTERN: [usize; 4] = [1, 2, 0, 1];

/// A photograph: a lens, its lights, and how it is exposed.
struct Exposure {
    /// Electrons of a whole light in green.
    electrons: f64,
    seed: u64,
    distance: ObjectDistance,
}

/// Writes the photograph of the 24 lights of the generated lens to `path`, and returns its perfect PSFs.
fn photograph(folder: &Path, path: &Path, exposure: &Exposure) -> ObservationSet {
    let names = ["R", "G", "B"];
    write_pupil_lens(folder, &names);
    let text = std::fs::read_to_string(folder.join("lens.json")).expect("written");
    let lens = LensProfile::from_json(&text).expect("valid");
    let template = generated_set(&names, &[exposure.distance]);
    let predictor = Predictor::new(&lens).expect("a lens");
    let perfect = predict_set(&predictor, &template, &Pupil).expect("drawable");
    let mut random = SplitMix64::new(exposure.seed);
    let mut light = vec![0.0; WIDTH * HEIGHT];
    for observation in &perfect.observations {
        let electrons = exposure.electrons * (0.5 + 0.5 * random.unit());
        let corner = observation.frame_point(0.0, 0.0);
        let (left, top) = (corner.x_px as i64, corner.y_px as i64);
        let tile = &observation.tiles[0];
        for k in 0..tile.samples().len() {
            let x = left + (k % tile.width()) as i64;
            let y = top + (k / tile.width()) as i64;
            if (0..WIDTH as i64).contains(&x) && (0..HEIGHT as i64).contains(&y) {
                let channel = PATTERN[2 * (y as usize % 2) + x as usize % 2];
                let share = f64::from(observation.tiles[channel].samples()[k]);
                let response = [0.6, 1.0, 0.5][channel];
                light[y as usize * WIDTH + x as usize] += electrons * response * share;
            }
        }
    }
    let mut normal = || {
        let radius = (-2.0 * (1.0 - random.unit()).ln()).sqrt();
        radius * (std::f64::consts::TAU * random.unit()).cos()
    };
    let counts = light.iter().map(|electrons| {
        let noisy = electrons + electrons.sqrt() * normal() + 3.0 * normal();
        (noisy * GAIN + f64::from(BLACK))
            .round()
            .clamp(0.0, f64::from(WHITE)) as u16
    });
    std::fs::write(path, dng(&counts.collect::<Vec<_>>(), [WIDTH, HEIGHT]))
        .expect("the folder is writable");
    perfect
}

/// Returns a DNG file of `counts`, which have columns and rows: little-endian, one uncompressed strip.
pub(crate) fn dng(counts: &[u16], [width, height]: [usize; 2]) -> Vec<u8> {
    let data: Vec<u8> = counts.iter().flat_map(|c| c.to_le_bytes()).collect();
    let pattern = PATTERN.iter().rev().fold(0, |sum, c| sum << 8 | *c as u32);
    let entries: [(u16, u16, u32, u32); 14] = [
        (256, 4, 1, width as u32),
        (257, 4, 1, height as u32),
        (258, 3, 1, 16),
        (259, 3, 1, 1),
        (262, 3, 1, 32803),
        (273, 4, 1, 8),
        (277, 3, 1, 1),
        (278, 4, 1, height as u32),
        (279, 4, 1, data.len() as u32),
        (33421, 3, 2, 2 << 16 | 2),
        (33422, 1, 4, pattern),
        (50706, 1, 4, 0x0000_0401),
        (50714, 3, 1, u32::from(BLACK)),
        (50717, 3, 1, u32::from(WHITE)),
    ];
    let mut file = b"II*\0".to_vec();
    file.extend((8 + data.len() as u32).to_le_bytes());
    file.extend(&data);
    file.extend((entries.len() as u16).to_le_bytes());
    for (tag, kind, count, value) in entries {
        file.extend(tag.to_le_bytes());
        file.extend(kind.to_le_bytes());
        file.extend(count.to_le_bytes());
        file.extend(value.to_le_bytes());
    }
    file.extend([0; 4]);
    file
}

pub(crate) fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("one document")
}

pub(crate) fn manifest(folder: &Path, name: &str) -> Value {
    let text = std::fs::read_to_string(folder.join(name)).expect("written");
    json(&text)
}

/// Returns the forward-blur SNR of `lens` on the perfect PSFs of the set called `truth`, by channel.
pub(crate) fn scores(folder: &Path, lens: &str, truth: &str) -> Vec<(String, f64)> {
    let report = json(&succeeds(folder, &format!("eval --lens {lens} {truth} --json")).stdout);
    let groups = report["groups"].as_array().expect("a list").iter();
    groups
        .map(|group| {
            let methods = group["forward_blur_snr"].as_array().expect("a list");
            let rays = methods
                .iter()
                .find(|m| m["id"] == "pupil-model")
                .expect("rays");
            let channel = group["channel"].as_str().expect("a name").to_owned();
            (channel, rays["mean_db"].as_f64().expect("dB"))
        })
        .collect()
}

/// Defocus that a lens file lacks, px of blur radius.
const DEFOCUS_PX: f64 = 0.5;
const NEAR: ObjectDistance = ObjectDistance::Metres(2.0);

#[test]
fn a_raw_photograph_gives_the_lens_that_took_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let exposure = Exposure {
        electrons: 600_000.0,
        seed: 1,
        distance: NEAR,
    };
    let perfect = photograph(folder, &folder.join("a.dng"), &exposure);
    seidel_image_io::observation_set::write(&perfect, &folder.join("truth")).expect("writable");
    let line =
        "measure lights @a.dng --distance 2 --out @set --fit @fitted.json --axis 150,100 --json";
    let report = json(&succeeds(folder, line).stdout);
    // The corners' lights are cut off by the border.
    let kept = report["kept"].as_u64().expect("a count");
    assert!((18..=24).contains(&kept), "{report}");
    // The file states none, and residuals hold more than noise.
    assert!(report["gain"].is_null(), "{}", report["gain"]);

    let set = manifest(folder, "set/manifest.json");
    assert_eq!(
        (&set["version"], &set["mosaic"]),
        (&Value::from(2), &Value::from("GBRG"))
    );
    assert_eq!(set["optical_axis"], serde_json::json!([150.0, 100.0]));
    let first = &set["observations"][0];
    assert_eq!(
        (&first["source"], &first["depth_m"]),
        (&Value::from("a.dng"), &Value::from(2.0))
    );
    for key in ["centroid", "centroid_sigma", "flux", "snr", "noise_sigma"] {
        assert!(
            first[key]["B"].is_number() || first[key]["B"].is_array(),
            "{key}"
        );
    }
    assert!(manifest(folder, "set/left_out.json").is_array());
    for name in ["set/sheet.png", "set/lens.json", "set/psf/0000.tif"] {
        assert!(folder.join(name).exists(), "{name}");
    }
    for (channel, db) in scores(folder, "@fitted.json", "@truth") {
        assert!(db > 43.0, "{channel}: {db} dB");
    }
    // The set is read by the other commands, which compare the pixels of each colour only.
    for (channel, db) in scores(folder, "@fitted.json", "@set") {
        assert!(db > 30.0, "{channel}: {db} dB");
    }
    succeeds(folder, "fit @set -o @moments.json --model moments");
}

#[test]
fn a_raw_photograph_shows_in_one_go_what_a_lens_file_lacks() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let exposure = Exposure {
        electrons: 600_000.0,
        seed: 3,
        distance: NEAR,
    };
    photograph(folder, &folder.join("a.dng"), &exposure);
    let only = "--photo @a.dng --distance 2 --only defocus_offset --no-pairs --json";
    let diagnose = |lens: &str, out: &str| {
        let line = format!("diagnose --lens {lens} {only} --out {out}");
        json(&succeeds(folder, &line).stdout)
    };
    let right = diagnose("@lens.json", "@right");
    // The same lens, out of focus by half a pixel of blur radius.
    let text = std::fs::read_to_string(folder.join("lens.json")).expect("written");
    let mut lens = LensProfile::from_json(&text).expect("valid");
    if let LensDescription::Pupil(channels) = &mut lens.description {
        channels
            .iter_mut()
            .for_each(|c| c.alpha.coefficients[0] += DEFOCUS_PX);
    }
    std::fs::write(folder.join("old.json"), lens.to_json()).expect("writable");
    let wrong = diagnose("@old.json", "@wrong");
    let before = |report: &Value| report["gap"]["before"].as_f64().expect("a share");
    assert_eq!(right["verdict"], "no_gap", "{right}");
    assert!(before(&wrong) > 5.0 * before(&right), "{right} {wrong}");
    assert_eq!(
        wrong["added"],
        serde_json::json!(["defocus_offset"]),
        "{wrong}"
    );
    assert!(wrong["gap"]["closed"].as_f64() > Some(0.8), "{wrong}");
    assert!(folder.join("wrong/psf/manifest.json").is_file());
    // A set of raw tiles is diagnosed as well.
    let again =
        "diagnose --lens @old.json @wrong/psf --only defocus_offset --no-pairs --out @again";
    succeeds(folder, again);
    let unknown = "diagnose --lens @lens.json --photo @a.dng --out @none";
    must_refuse(folder, unknown, &["a.dng", "--distance"]);
}

#[test]
fn another_distance_is_appended_and_the_set_is_replaced_as_a_whole() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    for (name, seed, distance) in [
        ("a.dng", 1, NEAR),
        ("b.dng", 2, ObjectDistance::Metres(4.0)),
    ] {
        let exposure = Exposure {
            electrons: 400_000.0,
            seed,
            distance,
        };
        photograph(folder, &folder.join(name), &exposure);
    }
    succeeds(
        folder,
        "measure lights @a.dng --distance 2 --out @set --tile 31",
    );
    let before = manifest(folder, "set/manifest.json");
    let count = |set: &Value| set["observations"].as_array().expect("a list").len();
    succeeds(
        folder,
        "measure lights @b.dng --distance 4 --out @set --also @set",
    );
    let after = manifest(folder, "set/manifest.json");
    assert!(count(&after) > count(&before) + 12);
    assert_eq!(after["observations"][0], before["observations"][0]);
    let last = after["observations"]
        .as_array()
        .expect("a list")
        .last()
        .expect("one");
    assert_eq!(
        (&last["source"], &last["depth_m"]),
        (&Value::from("b.dng"), &Value::from(4.0))
    );
    // Both at once give the same lights.
    succeeds(
        folder,
        "measure lights @a.dng @b.dng --distance 2,4 --out @both --tile 31",
    );
    assert!(count(&manifest(folder, "both/manifest.json")) >= count(&after) - 2);
}

#[test]
fn unusable_photographs_are_refused_with_a_remedy() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let dark = vec![BLACK; WIDTH * HEIGHT];
    std::fs::write(folder.join("dark.dng"), dng(&dark, [WIDTH, HEIGHT])).expect("writes");
    let bytes = dng(&dark, [WIDTH, HEIGHT]);
    std::fs::write(folder.join("cut.dng"), &bytes[..bytes.len() / 2]).expect("writes");
    let exposure = Exposure {
        electrons: 2e7,
        seed: 3,
        distance: NEAR,
    };
    photograph(folder, &folder.join("bright.dng"), &exposure);
    let mut pgm = b"P5 40 30 65535\n".to_vec();
    pgm.resize(pgm.len() + 2400, 0);
    std::fs::write(folder.join("a.pgm"), &pgm).expect("writes");
    std::fs::write(folder.join("a.cr2"), b"II*\0 and more than sixteen bytes").expect("writes");
    for (line, parts) in [
        ("@dark.dng", &["dark.dng", "no light above its noise"][..]),
        ("@cut.dng", &["cut.dng", "damaged or truncated"]),
        ("@bright.dng", &["clipped", "expose less"]),
        ("@a.pgm", &["a.pgm", "--cfa RGGB"]),
        ("@a.cr2", &["Canon CR2", "dnglab convert"]),
        ("@missing.dng", &["missing.dng", "cannot be read"]),
        ("@bright.dng @a.pgm --cfa RGGB", &["a.pgm", "40 x 30"]),
        ("@bright.dng --channels R,Y", &["channel Y", "R, G, B"]),
    ] {
        must_refuse(folder, &format!("measure lights {line} --out @set"), parts);
    }
    for (options, part) in [
        ("--distance 1,2", "2 distances for 1 photographs"),
        ("--axis free", "--fit LENS"),
        ("--cfa RGB", "RGGB"),
        ("--tile 3", "7 to 1023"),
    ] {
        let line = format!("measure lights @dark.dng --out @set {options}");
        let refused = seidel_in(folder, &line);
        assert_eq!(refused.status, 2, "{options}: {}", refused.stderr);
        assert!(refused.stderr.contains(part), "{}", refused.stderr);
    }
}

/// A light of a simulated photograph, as its simulator states it.
struct TrueLight {
    place: [f64; 2],
    /// Centroids in R, G and B.
    centroids: [[f64; 2]; 3],
    peak: f64,
    is_single: bool,
}

fn pair(value: &Value) -> [f64; 2] {
    [0, 1].map(|k| value[k].as_f64().expect("a number"))
}

fn true_lights(truth: &Value) -> Vec<TrueLight> {
    let lights = truth["photos"][0]["lights"].as_array().expect("a list");
    let lights = lights.iter().map(|light| TrueLight {
        place: ["x", "y"].map(|key| light[key].as_f64().expect("a number")),
        centroids: [0, 1, 2].map(|c| pair(&light["centroid"][c])),
        peak: light["peak"].as_f64().expect("a number"),
        is_single: light["kind"] == "ok" || light["kind"] == "bright",
    });
    lights.collect()
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Measures a photograph of an independent simulator: at least 95 of 100 usable lights are found and no false one, and stated
/// errors of centroids cover the true ones.
fn check_case(case: PathBuf, distance_m: &str) {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path();
    let photo = case.join("photo0.dng");
    let line = format!(
        "measure lights {} --distance {distance_m} --out @set",
        photo.display()
    );
    succeeds(out, &line);
    let truth = manifest(&case, "truth.json");
    let size = pair(&truth["photos"][0]["lens"]["size"]);
    let lights = true_lights(&truth);
    let set = manifest(out, "set/manifest.json");
    let kept = set["observations"].as_array().expect("a list");
    let places: Vec<[f64; 2]> = kept.iter().map(|o| pair(&o["centroid"]["G"])).collect();
    let crowded = |k: usize, radius: f64| {
        let mut others = lights.iter().enumerate();
        others.any(|(j, other)| {
            j != k
                && other.peak > 0.03 * lights[k].peak
                && distance(other.place, lights[k].place) < radius
        })
    };
    let inside =
        |[x, y]: [f64; 2]| x > 25.0 && y > 25.0 && x < size[0] - 25.0 && y < size[1] - 25.0;
    let usable: Vec<usize> = (0..lights.len())
        .filter(|&k| {
            let light = &lights[k];
            light.is_single
                && (0.05..0.95).contains(&light.peak)
                && inside(light.place)
                && !crowded(k, 25.0)
        })
        .collect();
    let found = usable.iter().filter(|k| {
        let place = lights[**k].place;
        places.iter().any(|p| distance(*p, place) < 4.0)
    });
    let found = found.count();
    assert!(
        found as f64 >= 0.95 * usable.len() as f64,
        "{found} of {}",
        usable.len()
    );
    let (mut covered, mut all) = (0.0, 0.0);
    for (observation, place) in kept.iter().zip(&places) {
        let nearest = (0..lights.len())
            .min_by(|a, b| {
                let of = |k: usize| distance(lights[k].place, *place);
                of(*a).total_cmp(&of(*b))
            })
            .expect("there are lights");
        assert!(
            distance(lights[nearest].place, *place) < 4.0,
            "a false light at {place:?}"
        );
        assert!(!crowded(nearest, 12.0), "a double at {place:?}");
        for (c, name) in ["R", "G", "B"].iter().enumerate() {
            let centroid = pair(&observation["centroid"][name]);
            let sigma = observation["centroid_sigma"][name]
                .as_f64()
                .expect("a number");
            for (got, want) in centroid.iter().zip(lights[nearest].centroids[c]) {
                all += 1.0;
                covered += f64::from(u8::from((got - want).abs() < 1.96 * sigma));
            }
        }
    }
    let share = covered / all;
    assert!(
        (0.88..0.99).contains(&share),
        "{share} of the centroids are within 1.96 sigma"
    );
}

#[test]
fn simulated_photographs_of_an_independent_program_are_measured() {
    if let Some(case) = real_data("measure/pin_0") {
        check_case(case, "2");
    }
}

/// Returns the star photograph of the set `dash-stars` (tests/data/compressed_dash.fits of the source distribution of regularizepsf
/// 1.2.1): the file that `SEIDEL_DASH` names, or one beside the photographs of the data.
fn star_photograph() -> Option<PathBuf> {
    match std::env::var_os("SEIDEL_DASH") {
        Some(path) => Some(PathBuf::from(path)),
        None => real_data("photos/compressed_dash.fits"),
    }
}

#[test]
fn a_star_photograph_gives_the_lens_of_its_set() {
    let Some(file) = star_photograph() else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let line = format!(
        "measure lights {} --cfa none --distance inf --out @stars --fit @lens.json --json",
        file.display()
    );
    let report: Value = serde_json::from_str(&succeeds(folder, &line).stdout).expect("JSON");
    let kept = report["kept"].as_u64().expect("a number");
    assert!(kept > 500, "{kept}");
    let text = std::fs::read_to_string(folder.join("lens.json")).expect("written");
    let lens = LensProfile::from_json(&text).expect("valid");
    // Rows of the set run as in the file, upwards; its moments are symmetric about (1497, 818).
    let axis = lens.frame.axis();
    let off = (axis.x_px - 1497.0).hypot(axis.y_px - (2048.0 - 818.0));
    assert!(off < 0.02 * 3072.0, "{axis:?}");
}
