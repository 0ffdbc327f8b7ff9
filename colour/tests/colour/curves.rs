//! Seidel's own transfer functions: golden values, round trips, continuity and the code of grey.

use seidel_colour::curves::{Curve, CurveTable};
use seidel_colour::{Alphas, Config, ConversionReport, Source};

use super::golden::{numbers, read};

/// Largest relative difference from OpenColorIO's curves, which are in single precision.
const TOLERANCE: f64 = 2e-6;
/// The same for curves that OpenColorIO interpolates from a table.
const TABLE_TOLERANCE: f64 = 2e-5;
/// Below this value, differences count as if relative to it.
const FLOOR: f64 = 1e-3;
/// The same for OpenColorIO's values: single-precision codes near black resolve no smaller values.
const GOLDEN_FLOOR: f64 = 1e-2;
/// Largest relative difference after a round trip through the engine, in single precision.
const ENGINE_TOLERANCE: f32 = 1e-5;
/// Below this value, such differences count as if relative to it; see [`GOLDEN_FLOOR`].
const ENGINE_FLOOR: f32 = 1e-2;
/// Linear values of round trips.
const RANGE: (f64, f64) = (-0.5, 60_000.0);

fn table() -> &'static CurveTable {
    CurveTable::embedded().unwrap()
}

fn curves() -> impl Iterator<Item = (&'static str, &'static Curve)> {
    let curves = table().curves.iter();
    curves.map(|(name, curve)| (name.as_str(), curve))
}

/// Returns linear values over [`RANGE`], dense around black.
fn linear_values() -> Vec<f64> {
    let steps = 0..=4000;
    let dense = steps.clone().map(|i| -0.5 + f64::from(i) / 4000.0);
    let stops = steps.map(|i| (f64::from(i) / 4000.0 * 36.0 - 20.0).exp2());
    let all: Vec<f64> = dense
        .chain(stops)
        .filter(|v| (RANGE.0..=RANGE.1).contains(v))
        .collect();
    all.into_iter().chain([RANGE.1]).collect()
}

#[test]
fn curves_match_opencolorio() {
    let golden = read("curves.json");
    for (name, curve) in curves() {
        let values = &golden["curves"][name];
        let tolerance = match name {
            "canon-log3" | "acescc" => TABLE_TOLERANCE,
            _ => TOLERANCE,
        };
        let pairs = numbers(&values["code"])
            .into_iter()
            .zip(numbers(&values["linear"]));
        let mut count = 0;
        for (code, linear) in pairs {
            let found = curve.transfer.decode(code);
            let off = (found - linear).abs() / linear.abs().max(GOLDEN_FLOOR);
            assert!(
                off <= tolerance,
                "{name} at {code}: {found}, not {linear}: {off:e}"
            );
            count += 1;
        }
        assert!(count > 50, "{name}");
    }
}

#[test]
fn curves_round_trip_in_double_precision() {
    for (name, curve) in curves() {
        for linear in linear_values() {
            // ACEScc has one code for all values at or below black.
            if name == "acescc" && linear < 0.0 {
                continue;
            }
            let back = curve.transfer.decode(curve.transfer.encode(linear));
            let off = (back - linear).abs() / linear.abs().max(FLOOR);
            assert!(off <= 1e-9, "{name}: {linear} came back as {back}");
        }
    }
}

#[test]
fn curves_round_trip_through_the_engine() {
    let config = Config::load(&Source::Embedded).unwrap();
    let table = table();
    for space in &table.spaces {
        let Some(curve) = table.curve(space).unwrap() else {
            continue;
        };
        if space.name == "ACEScc" {
            continue;
        }
        let linear = table
            .spaces
            .iter()
            .find(|other| other.curve.is_none() && other.gamut == space.gamut);
        let linear = &linear.unwrap().name;
        let to_code = config.processor(linear, &space.name).unwrap();
        let to_linear = config.processor(&space.name, linear).unwrap();
        let linear_values: Vec<f32> = linear_values().iter().map(|v| *v as f32).collect();
        let codes: Vec<f32> = (linear_values.iter())
            .map(|v| curve.transfer.encode(f64::from(*v)) as f32)
            .collect();
        for (first, second, values) in [
            (&to_code, &to_linear, &linear_values),
            (&to_linear, &to_code, &codes),
        ] {
            let mut planes = vec![values.clone(); 3];
            let forward = first.convert_planes(&mut planes, Alphas::Straight).unwrap();
            let back = second
                .convert_planes(&mut planes, Alphas::Straight)
                .unwrap();
            assert_eq!(forward + back, ConversionReport::default());
            let off =
                |(value, back): (&f32, &f32)| (back - value).abs() / value.abs().max(ENGINE_FLOOR);
            let worst = values.iter().zip(&planes[1]).map(off).fold(0.0, f32::max);
            println!("{} to {} and back: {worst:.1e}", first.from(), first.to());
            assert!(worst <= ENGINE_TOLERANCE, "{}: {worst:e}", space.name);
        }
    }
}

#[test]
fn every_16_bit_code_survives_a_round_trip_through_acescg() {
    let config = Config::load(&Source::Embedded).unwrap();
    let whole: Vec<f32> = (0..=u16::MAX)
        .map(|code| f32::from(code) / 65535.0)
        .collect();
    for space in config.spaces().iter().filter(|space| !space.is_data) {
        // It has one code for all values at or below black.
        if space.name == "ACEScc" {
            continue;
        }
        let mut planes = vec![whole.clone(); 3];
        for (from, to) in [(space.name.as_str(), "ACEScg"), ("ACEScg", &space.name)] {
            let processor = config.processor(from, to).unwrap();
            let report = processor.convert_planes(&mut planes, Alphas::Straight);
            assert_eq!(report.unwrap(), ConversionReport::default());
        }
        for plane in &planes {
            for (code, back) in plane.iter().enumerate() {
                assert_eq!((back * 65535.0).round(), code as f32, "{}", space.name);
            }
        }
    }
}

#[test]
fn curves_are_continuous_and_increasing() {
    for (name, curve) in curves() {
        for code in curve.transfer.break_codes() {
            let [below, at, above] = [-1e-9, 0.0, 1e-9].map(|by| curve.transfer.decode(code + by));
            let size = at.abs().max(FLOOR);
            assert!(
                (above - below).abs() / size < 1e-5,
                "{name}: {below} {above}"
            );
        }
        let mut last = f64::NEG_INFINITY;
        for i in 0..=20_000 {
            let code = -0.125 + 1.25 * f64::from(i) / 20_000.0;
            let linear = curve.transfer.decode(code);
            assert!(linear > last, "{name} at {code}");
            last = linear;
        }
    }
}

#[test]
fn grey_has_the_published_code() {
    for (name, curve) in curves() {
        let digits = curve.grey.to_string().len() as i32 - 2;
        let code = curve.transfer.encode(0.18);
        let half_a_digit = 0.51 * 10_f64.powi(-digits);
        assert!((code - curve.grey).abs() <= half_a_digit, "{name}: {code}");
    }
}

#[test]
fn every_curve_and_gamut_names_its_document() {
    let table = table();
    for (name, curve) in &table.curves {
        assert!(
            !curve.document.is_empty() && !curve.revision.is_empty(),
            "{name}"
        );
    }
    for (name, gamut) in &table.gamuts {
        assert!(
            !gamut.document.is_empty() && !gamut.revision.is_empty(),
            "{name}"
        );
    }
}
