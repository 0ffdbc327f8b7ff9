//! `seidel measure edges`: from a raw photograph of dark squares to the lens that took it.

use std::path::Path;

use seidel_core::{ImagePoint, LensProfile};
use seidel_optics::numeric::SplitMix64;
use seidel_optics::psf::normal_cdf;

use crate::measure_lights::{BLACK, GAIN, PATTERN, WHITE, dng, json, manifest, scores};
use crate::support::{must_refuse, real_data, seidel_in, succeeds, write_plate};

const WIDTH: usize = 330;
const HEIGHT: usize = 220;
/// Optical axis, px.
const AXIS: [f64; 2] = [169.0, 107.0];
/// Rays of a point, and the variance of the Gaussian blur with the pixel's area, px².
const RAYS: usize = 60;
const BLUR: f64 = 0.35 + 1.0 / 12.0;
/// Distance between dark squares turned by `TURN`, and half their side, px.
const PITCH: f64 = 52.0;
const HALF: f64 = 15.0;
const TURN: f64 = 0.13;
/// Light of the paper and of the squares, electrons.
const PAPER: f64 = 24_000.0;
const INK: f64 = 1_500.0;

/// Returns the landing points of rays from their centroid, at frame position `at`: defocus, astigmatism, coma.
fn rays(at: [f64; 2]) -> [[f64; 2]; RAYS] {
    let h = [0, 1].map(|k| (at[k] - AXIS[k]) / (WIDTH as f64 / 2.0));
    let h2 = h[0] * h[0] + h[1] * h[1];
    let mut rays: [[f64; 2]; RAYS] = std::array::from_fn(|k| {
        let radius = ((k as f64 + 0.5) / RAYS as f64).sqrt();
        let (sin, cos) = (2.399_963_229_728_653 * k as f64).sin_cos();
        let u = [radius * cos, radius * sin];
        let (u2, along) = (radius * radius, h[0] * u[0] + h[1] * u[1]);
        let round = 2.4 + 0.8 * u2 - 0.9 * h2;
        [0, 1].map(|a| round * u[a] + 1.6 * h[a] * along - 0.6 * (u2 * h[a] + 2.0 * along * u[a]))
    });
    let mean = [0, 1].map(|a| rays.iter().map(|r| r[a]).sum::<f64>() / RAYS as f64);
    rays.iter_mut()
        .for_each(|r| *r = [r[0] - mean[0], r[1] - mean[1]]);
    rays
}

/// Returns the variances of the blur along x and y without the pixel's area, px².
fn variances(at: [f64; 2]) -> [f64; 2] {
    let rays = rays(at);
    [0, 1].map(|a| {
        let square = rays.iter().map(|r| r[a] * r[a]).sum::<f64>();
        square / RAYS as f64 + BLUR - 1.0 / 12.0
    })
}

/// Writes a raw photograph of dark squares.
fn photograph(path: &Path, seed: u64) {
    let mut random = SplitMix64::new(seed);
    let mut normal = || {
        let radius = (-2.0 * (1.0 - random.unit()).ln()).sqrt();
        radius * (std::f64::consts::TAU * random.unit()).cos()
    };
    let (sin, cos) = TURN.sin_cos();
    let width = BLUR.sqrt();
    let mut counts = Vec::with_capacity(WIDTH * HEIGHT);
    for k in 0..WIDTH * HEIGHT {
        let (x, y) = ((k % WIDTH) as f64 + 0.5, (k / WIDTH) as f64 + 0.5);
        let mut covered = 0.0;
        for ray in rays([x, y]) {
            let (x, y) = (x - ray[0], y - ray[1]);
            let inside = |w: f64| {
                let off = w - ((w / PITCH).floor() + 0.5) * PITCH;
                normal_cdf((off + HALF) / width) - normal_cdf((off - HALF) / width)
            };
            covered += inside(cos * x + sin * y) * inside(cos * y - sin * x);
        }
        let light = PAPER + (INK - PAPER) * covered / RAYS as f64;
        let channel = PATTERN[2 * (k / WIDTH % 2) + k % WIDTH % 2];
        let electrons = light * [0.6, 1.0, 0.5][channel];
        let noisy = electrons + electrons.sqrt() * normal() + 3.0 * normal();
        let count = (noisy * GAIN + f64::from(BLACK)).round();
        counts.push(count.clamp(0.0, f64::from(WHITE)) as u16);
    }
    std::fs::write(path, dng(&counts, [WIDTH, HEIGHT])).expect("the folder is writable");
}

#[test]
fn a_raw_photograph_of_squares_gives_the_lens_that_took_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    photograph(&folder.join("a.dng"), 1);
    let line = "measure edges @a.dng --distance 2 --out @edges --fit @lens.json --json";
    let report = json(&succeeds(folder, line).stdout);
    assert!(report["kept"]["G"].as_u64() > Some(60), "{report}");
    let axis = &report["lens"]["axis"];
    for (k, want) in AXIS.iter().enumerate() {
        let got = axis[k].as_f64().expect("px");
        assert!((got - want).abs() < 0.02 * WIDTH as f64, "{axis}");
    }
    let text = std::fs::read_to_string(folder.join("lens.json")).expect("written");
    let lens = LensProfile::from_json(&text).expect("valid");
    let channel = &lens.pupil_channels()[1];
    for (x, y) in [(165, 110), (40, 40), (290, 60), (60, 180), (280, 190)] {
        let at = [f64::from(x), f64::from(y)];
        let place = lens.frame.field_point(ImagePoint::new(at[0], at[1]));
        let moments = channel.moments_at(place, 0.5);
        for (got, want) in [moments.mu20, moments.mu02].iter().zip(variances(at)) {
            assert!((got / want - 1.0).abs() < 0.06, "{at:?}: {got} {want}");
        }
    }
    // The folder is an observation set of the lens, and a part of another measurement.
    let predicted = succeeds(folder, "eval --lens @edges/lens.json @edges --json");
    assert!(predicted.stdout.contains("forward_blur_snr"));
    let edges = |name: &str| {
        let document = manifest(folder, name);
        document["edges"].as_array().expect("a list").len()
    };
    let left_out = manifest(folder, "edges/left_out.json");
    let first = &left_out.as_array().expect("a list")[0];
    assert!(
        first["source"] == "a.dng" && first["why"].is_string(),
        "{first}"
    );
    let more = "measure edges @a.dng --distance 2 --axis 169,107 --out @more --also @edges \
        --focal-length-mm 50 --f-number 2 --focus-distance 2.03 --pitch-um 4";
    let measured = succeeds(folder, more);
    assert!(
        measured.stderr.contains("thin lens of 50 mm"),
        "{}",
        measured.stderr
    );
    assert_eq!(edges("more/edges.json"), 2 * edges("edges/edges.json"));
    assert!(folder.join("more/sheet.png").is_file());
    // The camera is in the lens: its focus, aperture and sensor can be set.
    write_plate(&folder.join("plate.exr"), 33, 22);
    let shot = "apply --lens @more/lens.json @plate.exr -o @out.exr --distance 2.1 --focus-distance 2.2 \
        --f-number 4 --film-back-mm 1.2";
    succeeds(folder, shot);
    let bare = "apply --lens @lens.json @plate.exr -o @out.exr --f-number 4";
    must_refuse(folder, bare, &["f-number", "measured"]);
}

#[test]
fn a_photograph_without_edges_is_refused_and_leaves_nothing_behind() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let flat = vec![4000; WIDTH * HEIGHT];
    std::fs::write(folder.join("flat.dng"), dng(&flat, [WIDTH, HEIGHT])).expect("writable");
    must_refuse(
        folder,
        "measure edges @flat.dng --out @edges",
        &["none found", "dark squares"],
    );
    let two = "measure edges @flat.dng --distance 1,2 --out @edges";
    assert_eq!(seidel_in(folder, two).status, 2);
    assert!(!folder.join("edges").exists());
}

/// Measures the green edges of a photograph of an independent simulator. Its lens draws the true PSFs at `least_db` or more.
fn check_case(name: &str, least_db: f64) {
    let Some(case) = real_data(&format!("measure/{name}")) else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path();
    let photo = case.join("photo0.dng");
    let line = format!(
        "measure edges {} --distance 2 --channels G --out @edges --fit @lens.json",
        photo.display()
    );
    succeeds(out, &line);
    let truth = case.join("truth0");
    let green = scores(
        out,
        "@lens.json",
        &format!("{} --channel G", truth.display()),
    );
    assert!(green[0].1 > least_db, "{green:?}");
    let lens = manifest(&case, "truth.json");
    let axis = manifest(out, "lens.json");
    for k in 0..2 {
        let want = lens["photos"][0]["lens"]["axis"][k].as_f64().expect("px");
        let got = axis["optical_axis"][k].as_f64().expect("px");
        assert!((got - want).abs() < 12.8, "{got} {want}");
    }
}

#[test]
fn simulated_photographs_of_an_independent_program_give_their_lenses() {
    check_case("squares_0", 46.0);
    check_case("checker_0", 44.0);
}

#[test]
fn a_sharpened_photograph_is_refused() {
    let Some(boards) = real_data("photos/checker-chess-corners") else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let line = format!(
        "measure edges {} --encoding srgb --out @edges",
        boards.join("cc_mid.png").display()
    );
    must_refuse(folder.path(), &line, &["cc_mid.png", "sharpened"]);
}
