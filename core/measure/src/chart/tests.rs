//! Tests of charts with a simulator of their own: a chart under a homography, through a blur that changes over the field.

use std::sync::OnceLock;

use seidel_optics::distance::ObjectDistance;
use seidel_optics::mosaic::Mosaic;
use seidel_optics::no_progress;
use seidel_optics::numeric::SplitMix64;

use super::*;
use crate::photograph::SampleErrors;
use crate::printed::{Cells, Medium, Viewing, noise};

const WIDTH: usize = 360;
const HEIGHT: usize = 250;
/// Points of the simulated chart along either side of a pixel.
const POINTS: usize = 6;

/// A chart with marks, of about 1.8 px a cell in the photograph.
fn chart() -> Cells {
    let medium = Medium {
        width_mm: 48.0,
        height_mm: 33.0,
        margin_mm: 0.0,
        pixel_mm: None,
    };
    let viewing = Viewing {
        distance_m: 2.0,
        focal_mm: 50.0,
        pitch_um: 4.0,
        blur_px: 4.0,
    };
    noise(medium, &viewing, 5)
        .expect("room")
        .cells
        .expect("cells")
        .cells
}

fn picture(cells: &Cells) -> ChartPicture {
    let samples = cells
        .white
        .iter()
        .map(|w| f32::from(u8::from(*w)))
        .collect();
    ChartPicture::new(cells.columns, cells.rows, samples, Content::Cells).expect("valid")
}

/// Returns the standard deviation of the blur along x and y at a photograph position, px.
fn blur_at([x, _]: [f64; 2]) -> [f64; 2] {
    [0.7 + 0.5 * x / WIDTH as f64, 0.9]
}

/// A position of the chart in the photograph.
#[derive(Clone, Copy, PartialEq)]
enum Pose {
    Upright,
    UpsideDown,
    Mirrored,
}

/// Returns the light of the chart at every pixel, white at 1: a grid of points of the chart, Gaussian weights along both axes,
/// and the mean over each pixel.
fn light() -> &'static [f64] {
    static LIGHT: OnceLock<Vec<f64>> = OnceLock::new();
    LIGHT.get_or_init(|| {
        let cells = chart();
        let scale = 1.85;
        let (sin, cos) = 2_f64.to_radians().sin_cos();
        let level = |x: f64, y: f64| {
            let (u, v) = (x - WIDTH as f64 / 2.0, y - HEIGHT as f64 / 2.0);
            let depth = 1.0 + 3e-5 * u;
            let (u, v) = (u / depth, v / depth);
            let column = (u * cos - v * sin) / scale + cells.columns as f64 / 2.0;
            let row = (u * sin + v * cos) / scale + cells.rows as f64 / 2.0;
            let inside = (0.0..cells.columns as f64).contains(&column)
                && (0.0..cells.rows as f64).contains(&row);
            let is_white = !inside || cells.white[row as usize * cells.columns + column as usize];
            if is_white { 1.0 } else { 0.06 }
        };
        // Weights of the points about the pixel at `at` along an axis, whose blur is that at the pixel.
        let weights = |at: usize, sigma: f64, length: usize| -> Vec<(usize, f64)> {
            let middle = (at as f64 + 0.5) * POINTS as f64;
            let reach = (4.0 * sigma + 1.0) * POINTS as f64;
            let near = (middle - reach).max(0.0) as usize
                ..((middle + reach) as usize).min(length * POINTS);
            let weight = |k: usize| {
                let pixel = (0..POINTS).map(|p| {
                    let off = k as f64 - (at * POINTS + p) as f64;
                    (-0.5 * (off / (sigma * POINTS as f64)).powi(2)).exp()
                });
                (k, pixel.sum::<f64>())
            };
            let weights: Vec<(usize, f64)> = near.map(weight).collect();
            let total: f64 = weights.iter().map(|(_, w)| w).sum();
            weights.into_iter().map(|(k, w)| (k, w / total)).collect()
        };
        let sigmas = |x: usize| blur_at([x as f64 + 0.5, 0.0]);
        let across: Vec<_> = (0..WIDTH)
            .map(|x| weights(x, sigmas(x)[0], WIDTH))
            .collect();
        let fine_row = |row: usize| -> Vec<f64> {
            // Points differ from row to row and from column to column: the sides of cells are nearly parallel to both, and
            // regular points would move them.
            let place = |k: usize, other: usize, step: f64| {
                (k as f64 + (other as f64 * step).fract()) / POINTS as f64
            };
            let points: Vec<f64> = (0..WIDTH * POINTS)
                .map(|column| level(place(column, row, 0.618_034), place(row, column, 0.754_878)))
                .collect();
            let pixel = |w: &Vec<(usize, f64)>| w.iter().map(|(k, w)| w * points[*k]).sum();
            across.iter().map(pixel).collect()
        };
        let fine: Vec<Vec<f64>> = (0..HEIGHT * POINTS).into_par_iter().map(fine_row).collect();
        let row = |y: usize| {
            let down = weights(y, sigmas(0)[1], HEIGHT);
            let pixel = |x: usize| {
                let uneven = 1.0 - 3e-4 * x as f64 - 0.1 * (y as f64 / HEIGHT as f64 - 0.5).powi(2);
                uneven * down.iter().map(|(k, w)| w * fine[*k][x]).sum::<f64>()
            };
            (0..WIDTH).map(pixel).collect::<Vec<f64>>()
        };
        (0..HEIGHT).flat_map(row).collect()
    })
}

/// Photographs the chart.
fn photograph(pose: Pose, exposure: f64) -> Photograph {
    let mut random = SplitMix64::new(9);
    let mut normal = || {
        let radius = (-2.0 * (1.0 - random.unit()).ln()).sqrt();
        radius * (std::f64::consts::TAU * random.unit()).cos()
    };
    let counts = (0..WIDTH * HEIGHT).map(|k| {
        let (x, y) = (k % WIDTH, k / WIDTH);
        let (x, y) = match pose {
            Pose::Upright => (x, y),
            Pose::UpsideDown => (WIDTH - 1 - x, HEIGHT - 1 - y),
            Pose::Mirrored => (WIDTH - 1 - x, y),
        };
        let electrons = 20_000.0 * exposure * light()[y * WIDTH + x];
        let noisy = electrons + (electrons + 16.0).sqrt() * normal();
        (0.5 * noisy).round().min(14_900.0) as f32
    });
    Photograph {
        name: "chart".to_owned(),
        width: WIDTH,
        height: HEIGHT,
        planes: vec![counts.collect()],
        channels: ["R", "G", "B"].map(str::to_owned).to_vec(),
        mosaic: Some(Mosaic::parse("RGGB").expect("a pattern")),
        white: 14_880.0,
        distance: ObjectDistance::Metres(2.0),
        gain: None,
        errors: SampleErrors::default(),
        bad: Vec::new(),
    }
}

fn measure(photo: &Photograph, chart: &ChartPicture) -> Result<ChartMeasurement> {
    let settings = ChartSettings {
        tile: Some(9),
        ..ChartSettings::default()
    };
    measure_chart(photo, std::slice::from_ref(chart), &settings, &no_progress)
}

#[test]
fn a_blur_that_changes_over_the_field_is_measured_in_every_colour() {
    let cells = chart();
    let photo = photograph(Pose::Upright, 1.0);
    let measured = measure(&photo, &picture(&cells)).expect("measurable");
    assert!(measured.has_white_surround);
    let blocks = measured.blocks.len();
    assert!(blocks >= 6, "{blocks}, {:?}", measured.left_out);
    for part in ["linear", "sharpened", "differs"] {
        assert!(!names(&measured, part), "{:?}", measured.concerns);
    }
    assert!(
        measured.registration_px < 0.05,
        "{}",
        measured.registration_px
    );
    for channel in 0..3 {
        // Errors of every block, beside marks too: the largest of xx, xy and yy over the trace.
        let mut errors: Vec<f64> = (measured.blocks.iter())
            .map(|block| {
                let want = blur_at(block.centre.map(|v| v as f64)).map(|s| s * s + 1.0 / 12.0);
                let [xx, xy, yy] = block.covariance(channel);
                let errors =
                    [xx - want[0], xy, yy - want[1]].map(|e| e.abs() / (want[0] + want[1]));
                errors.into_iter().fold(0.0, f64::max)
            })
            .collect();
        let worst = errors.iter().copied().fold(0.0, f64::max);
        let typical = median(&mut errors);
        assert!(worst < 0.06, "channel {channel}: {worst}");
        assert!(typical < 0.03, "channel {channel}: {typical}");
        for block in &measured.blocks {
            assert!((block.tiles[channel].iter().sum::<f64>() - 1.0).abs() < 0.02);
        }
    }
}

/// Returns whether a concern about the photograph has `part` in its words.
fn names(measured: &ChartMeasurement, part: &str) -> bool {
    let mut concerns = measured.concerns.iter();
    concerns.any(|concern| concern.error.to_string().contains(part))
}

#[test]
fn values_that_are_not_linear_in_light_and_sharpened_ones_are_named() {
    let cells = chart();
    let mut photo = photograph(Pose::Upright, 1.0);
    let counts = photo.planes[0].clone();
    for value in &mut photo.planes[0] {
        *value = 120.0 * value.max(0.0).sqrt();
    }
    let found = measure(&photo, &picture(&cells)).expect("measurable");
    assert!(names(&found, "not linear in light"), "{:?}", found.concerns);
    // An unsharp mask between pixels of one colour.
    for y in 2..HEIGHT - 2 {
        for x in 2..WIDTH - 2 {
            let at = |dx: usize, dy: usize| counts[(y + dy - 2) * WIDTH + x + dx - 2];
            let around = at(0, 2) + at(4, 2) + at(2, 0) + at(2, 4);
            photo.planes[0][y * WIDTH + x] = 1.6 * at(2, 2) - 0.15 * around;
        }
    }
    let found = measure(&photo, &picture(&cells)).expect("measurable");
    assert!(names(&found, "sharpened"), "{:?}", found.concerns);
}

#[test]
fn hot_pixels_change_no_block() {
    let cells = chart();
    let mut photo = photograph(Pose::Upright, 1.0);
    let clean = measure(&photo, &picture(&cells)).expect("measurable");
    for block in &clean.blocks {
        let [x, y] = block.centre;
        photo.planes[0][(y + 7) * photo.width + x - 5] = 9_000.0;
        photo.planes[0][(y - 6) * photo.width + x + 3] = 9_000.0;
    }
    let hot = measure(&photo, &picture(&cells)).expect("measurable");
    assert_eq!(hot.blocks.len(), clean.blocks.len());
    for (a, b) in clean.blocks.iter().zip(&hot.blocks) {
        for channel in 0..3 {
            let (a, b) = (a.covariance(channel), b.covariance(channel));
            for (a, b) in a.into_iter().zip(b) {
                assert!((a - b).abs() < 0.02, "channel {channel}: {a} {b}");
            }
        }
    }
}

#[test]
fn charts_that_cannot_be_used_are_refused_with_the_reason() {
    let cells = chart();
    let chart = picture(&cells);
    let other = {
        let mut other = cells.clone();
        let mut random = SplitMix64::new(77);
        let columns = cells.columns;
        for (k, white) in other.white.iter_mut().enumerate() {
            let (x, y) = (k % columns, k / columns);
            if (45..columns - 45).contains(&x) || (45..cells.rows - 45).contains(&y) {
                *white = random.unit() < 0.5;
            }
        }
        picture(&other)
    };
    let refusals = [
        (Pose::UpsideDown, 1.0, &chart, "upside down"),
        (Pose::Mirrored, 1.0, &chart, "mirrored"),
        (Pose::Upright, 1.0, &other, "another picture"),
        (Pose::Upright, 3.0, &chart, "expose less"),
    ];
    for (pose, exposure, chart, part) in refusals {
        let error = measure(&photograph(pose, exposure), chart).expect_err(part);
        assert!(error.to_string().contains(part), "{part}: {error}");
    }
}

#[test]
fn a_turned_chart_is_measured_at_stated_corners() {
    let cells = chart();
    let photo = photograph(Pose::UpsideDown, 1.0);
    let error = measure(&photo, &picture(&cells))
        .expect_err("turned")
        .to_string();
    let corners = error.split("corners: ").nth(1).expect("corners");
    let numbers: Vec<f64> = (corners.split(','))
        .map(|n| {
            n.trim_matches(|c: char| !c.is_ascii_digit())
                .parse()
                .expect("a number")
        })
        .collect();
    let settings = ChartSettings {
        tile: Some(9),
        corners: Some(std::array::from_fn(|k| {
            [numbers[2 * k], numbers[2 * k + 1]]
        })),
        ..ChartSettings::default()
    };
    let measured =
        measure_chart(&photo, &[picture(&cells)], &settings, &no_progress).expect("measurable");
    assert!(measured.blocks.len() >= 6);
}
