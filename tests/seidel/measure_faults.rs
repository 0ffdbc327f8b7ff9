//! `seidel measure` on photographs with faults that make a lens wrong: each is named by its cause.

use std::path::Path;

use seidel_calibrate::fit::edges::Departures;
use seidel_colour::curves::CurveTable;
use seidel_core::ObjectDistance;
use seidel_measure::{
    Calibration, EdgeSettings, MeasuredEdges, Photograph, SampleErrors, measure_edges,
};
use seidel_optics::edges::Edge;
use seidel_optics::numeric::SplitMix64;
use seidel_optics::psf::normal_cdf;

use crate::support::{seidel_in, succeeds};

const WIDTH: usize = 300;
const HEIGHT: usize = 200;
/// Distance between dark squares, half their side, px, and the turns of neighbours, rad: four orientations of edges.
const PITCH: f64 = 50.0;
const HALF: f64 = 13.0;
const TURNS: [f64; 2] = [0.12, 0.91];
/// Light of the paper and of the squares, of a clipping level of 1.
const PAPER: f64 = 0.6;
const INK: f64 = 0.03;
/// Standard deviation of the blur with the pixel's area, px, and that of the noise of the paper.
const BLUR: f64 = 1.4;
const NOISE: f64 = 0.004;

/// A fault of a photograph.
#[derive(Clone, Copy, Default)]
struct Fault {
    /// Path of the camera during the exposure, px.
    moved: [f64; 2],
    /// Pixels are so much wider than high in the scene.
    squeeze: Option<f64>,
    /// The blur is that of another lens, so much wider.
    wider: Option<f64>,
}

/// Returns the light of every pixel of dark squares.
fn light(fault: Fault) -> Vec<f64> {
    let mut random = SplitMix64::new(7);
    let mut normal = || {
        let radius = (-2.0 * (1.0 - random.unit()).ln()).sqrt();
        radius * (std::f64::consts::TAU * random.unit()).cos()
    };
    let blur = BLUR * fault.wider.unwrap_or(1.0);
    let inside = |off: f64| normal_cdf((off + HALF) / blur) - normal_cdf((off - HALF) / blur);
    // The share of a place that a square covers: that of its cell.
    let covered_at = |x: f64, y: f64| {
        let [column, row] = [x, y].map(|v| (v / PITCH).floor());
        let [u, v] = [x - (column + 0.5) * PITCH, y - (row + 0.5) * PITCH];
        let (sin, cos) = TURNS[(column + row).rem_euclid(2.0) as usize].sin_cos();
        inside(cos * u + sin * v) * inside(cos * v - sin * u)
    };
    const STEPS: usize = 8;
    let mut all = Vec::with_capacity(WIDTH * HEIGHT);
    for k in 0..WIDTH * HEIGHT {
        let (x, y) = ((k % WIDTH) as f64 + 0.5, (k / WIDTH) as f64 + 0.5);
        let x = x * fault.squeeze.unwrap_or(1.0);
        let steps = if fault.moved == [0.0; 2] { 1 } else { STEPS };
        let covered = (0..steps).map(|step| {
            let along = (step as f64 + 0.5) / steps as f64 - 0.5;
            covered_at(x + along * fault.moved[0], y + along * fault.moved[1])
        });
        let covered = covered.sum::<f64>() / steps as f64;
        let light = PAPER + (INK - PAPER) * covered;
        all.push(light + NOISE * (light / PAPER).sqrt() * normal());
    }
    all
}

/// Returns the photograph called `name` with these planes, of R, G and B or of G alone.
fn photograph(name: &str, planes: &[Vec<f64>]) -> Photograph {
    let counts = planes
        .iter()
        .map(|samples| samples.iter().map(|v| (v * 16_000.0) as f32).collect());
    let channels: &[&str] = if planes.len() == 3 {
        &["R", "G", "B"]
    } else {
        &["G"]
    };
    Photograph {
        name: name.to_owned(),
        width: WIDTH,
        height: HEIGHT,
        planes: counts.collect(),
        channels: channels.iter().map(|c| (*c).to_owned()).collect(),
        mosaic: None,
        white: f32::INFINITY,
        distance: ObjectDistance::Metres(2.0),
        gain: None,
        errors: SampleErrors::default(),
        bad: Vec::new(),
    }
}

fn measured_of(photographs: Vec<Photograph>) -> MeasuredEdges {
    let settings = EdgeSettings::default();
    measure_edges(photographs, &Calibration::default(), &settings).expect("edges")
}

fn measured(samples: Vec<f64>) -> MeasuredEdges {
    measured_of(vec![photograph("a.tif", &[samples])])
}

fn departures(samples: Vec<f64>) -> Departures {
    let measured = measured(samples);
    let edges: Vec<&Edge> = measured.set.edges.iter().collect();
    assert!(edges.len() > 40, "{}", edges.len());
    Departures::of(&measured.set.frame, &[edges]).expect("two orientations")
}

#[test]
fn a_still_photograph_has_no_departures() {
    let found = departures(light(Fault::default()));
    let elongation = found.elongation_px2;
    assert!(elongation.value < 0.03 * found.variance_px2, "{found:?}");
    assert!(found.skewness.value.abs() < 0.03, "{found:?}");
    assert!(
        (found.variance_px2 / (BLUR * BLUR) - 1.0).abs() < 0.1,
        "{found:?}"
    );
}

#[test]
fn interpolated_colours_are_named_and_widen_the_stated_errors() {
    let raw = light(Fault::default());
    let clean = measured(raw.clone());
    assert!(clean.concerns.is_empty(), "{:?}", clean.concerns);
    // Bilinear interpolation of the mosaic RGGB.
    let is_of = |channel: usize, x: usize, y: usize| [0, 1, 1, 2][2 * (y % 2) + x % 2] == channel;
    let plane = |channel: usize| -> Vec<f64> {
        let at = |k: usize| {
            let (mut sum, mut weights) = (0.0, 0.0);
            for (dx, dy) in (0..9).map(|n| (n % 3, n / 3)) {
                let (x, y) = (k % WIDTH + dx, k / WIDTH + dy);
                let inside = (1..=WIDTH).contains(&x) && (1..=HEIGHT).contains(&y);
                if inside && is_of(channel, x - 1, y - 1) {
                    let weight = [1.0, 2.0, 1.0][dx] * [1.0, 2.0, 1.0][dy];
                    sum += weight * raw[(y - 1) * WIDTH + x - 1];
                    weights += weight;
                }
            }
            sum / weights
        };
        (0..WIDTH * HEIGHT).map(at).collect()
    };
    let planes = [0, 1, 2].map(plane);
    let found = measured_of(vec![photograph("b.tif", &planes)]);
    let [concern] = &found.concerns[..] else {
        panic!("{:?}", found.concerns);
    };
    assert!(concern.error.to_string().contains("interpolated colours"));
    let is_covered = |edge: &&Edge| {
        (edge.variance_px2 + 1.0 / 12.0 - BLUR * BLUR).abs() < 1.96 * edge.variance_sigma
    };
    let edges = &found.set.edges;
    let covered = edges.iter().filter(is_covered).count();
    assert!(
        covered as f64 > 0.9 * edges.len() as f64,
        "{covered} of {}",
        edges.len()
    );
}

#[test]
fn two_lenses_at_one_distance_are_named() {
    let photographs = |wider| {
        let second = Fault {
            wider,
            ..Fault::default()
        };
        let all = [("a.tif", Fault::default()), ("b.tif", second)];
        let all = all.map(|(name, fault)| photograph(name, &[light(fault)]));
        measured_of(all.to_vec()).concerns
    };
    assert!(photographs(None).is_empty());
    let found = photographs(Some(1.1));
    let [concern] = &found[..] else {
        panic!("{found:?}");
    };
    let text = concern.error.to_string();
    assert!(
        text.contains("another lens") && text.contains("a.tif"),
        "{text}"
    );
}

#[test]
fn a_moving_camera_is_found_with_its_direction() {
    let (sin, cos) = 20_f64.to_radians().sin_cos();
    let moved = [3.0 * cos, 3.0 * sin];
    let found = departures(light(Fault {
        moved,
        ..Fault::default()
    }));
    // Half the variance of a path of 3 px, 9 / 12.
    let elongation = found.elongation_px2;
    assert!((elongation.value - 0.375).abs() < 0.06, "{found:?}");
    assert!(elongation.value > 6.0 * elongation.sigma, "{found:?}");
    assert!((found.direction_deg - 20.0).abs() < 5.0, "{found:?}");
}

#[test]
fn a_squeezed_picture_is_blurred_less_along_one_axis() {
    let found = departures(light(Fault {
        squeeze: Some(1.6),
        ..Fault::default()
    }));
    assert!((found.direction_deg - 90.0).abs() < 4.0, "{found:?}");
    assert!(
        found.elongation_px2.value > 0.25 * found.variance_px2,
        "{found:?}"
    );
}

#[test]
fn codes_that_are_not_linear_draw_edges_out_to_one_side() {
    let table = CurveTable::embedded().expect("curves");
    for name in ["slog3", "srgb", "logc3-ei800"] {
        let curve = &table.curves[name].transfer;
        let codes = light(Fault::default())
            .iter()
            .map(|v| curve.encode(*v))
            .collect();
        let found = departures(codes);
        let skewness = found.skewness;
        assert!(
            skewness.value > 0.06_f64.max(6.0 * skewness.sigma),
            "{name}: {found:?}"
        );
    }
}

/// Writes a picture with 16 bits and codes of the log curve S-Log3.
fn write_log(path: &Path) {
    let table = CurveTable::embedded().expect("curves");
    let curve = &table.curves["slog3"].transfer;
    let codes: Vec<u16> = (light(Fault::default()).iter())
        .map(|v| (curve.encode(*v) * 65535.0).round() as u16)
        .collect();
    let picture = image::ImageBuffer::from_fn(WIDTH as u32, HEIGHT as u32, |x, y| {
        let code = codes[y as usize * WIDTH + x as usize];
        image::Rgb([code; 3])
    });
    picture.save(path).expect("writes");
}

#[test]
fn log_footage_needs_its_curve_and_leaves_no_lens_without() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_log(&folder.join("log.png"));
    let line = "measure edges @log.png --channels G --axis 150,100 --distance 2 --out @edges";
    let refused = seidel_in(folder, &format!("{line} --encoding linear"));
    assert_eq!(refused.status, 1);
    for part in [
        "log.png",
        "not linear",
        "bright side",
        "--encoding",
        "--force",
    ] {
        assert!(refused.stderr.contains(part), "{part}: {}", refused.stderr);
    }
    assert!(folder.join("edges/sheet.png").is_file());
    assert!(!folder.join("edges/lens.json").exists());
    succeeds(folder, &format!("{line} --encoding slog3"));
    assert!(folder.join("edges/lens.json").is_file());
}
