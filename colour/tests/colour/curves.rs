//! The project's own curves: against golden values, there and back, at their joints and at grey.

use seidel_colour::curves::{Curve, own};
use seidel_colour::{Alphas, Config, Source};

use super::golden::{numbers, read};

/// What a curve may differ by from OpenColorIO's, which works in single precision.
const TOLERANCE: f64 = 2e-6;
/// The same of curves that OpenColorIO has a table for: what it has between entries.
const TABLE_TOLERANCE: f64 = 2e-5;
/// Below this size differences count as they are.
const FLOOR: f64 = 1e-3;
/// The same of what OpenColorIO gives in single precision, in which black has a code of which so much is left.
const GOLDEN_FLOOR: f64 = 1e-2;
/// What values that go through the engine and back may differ by, in its single precision.
const ENGINE_TOLERANCE: f32 = 1e-5;
/// Below this size such differences count as they are: single precision has a code of black to so much.
const ENGINE_FLOOR: f32 = 1e-2;
/// Linear values that come back.
const RANGE: (f64, f64) = (-0.5, 60_000.0);

fn all() -> impl Iterator<Item = (&'static str, &'static Curve)> {
    let curves = own().unwrap().curves.iter();
    curves.map(|(name, curve)| (name.as_str(), curve))
}

/// Linear values over [`RANGE`], dense about black.
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
fn curves_are_those_of_opencolorio() {
    let golden = read("curves.json");
    for (name, curve) in all() {
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
            let found = curve.form.linear(code);
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
fn what_goes_comes_back() {
    for (name, curve) in all() {
        for linear in linear_values() {
            // Black and less have one code in ACEScc, by its document.
            if name == "acescc" && linear < 0.0 {
                continue;
            }
            let back = curve.form.linear(curve.form.code(linear));
            let off = (back - linear).abs() / linear.abs().max(FLOOR);
            assert!(off <= 1e-9, "{name}: {linear} came back as {back}");
        }
    }
}

/// In single precision, through the engine: code to linear to code, and linear to code to linear.
#[test]
fn what_goes_through_the_engine_comes_back() {
    let config = Config::load(&Source::Own).unwrap();
    let table = own().unwrap();
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
        let light: Vec<f32> = linear_values().iter().map(|v| *v as f32).collect();
        let code: Vec<f32> = (light.iter())
            .map(|v| curve.form.code(f64::from(*v)) as f32)
            .collect();
        for (first, second, values) in [
            (&to_code, &to_linear, &light),
            (&to_linear, &to_code, &code),
        ] {
            let mut planes = vec![values.clone(); 3];
            let there = first.planes(&mut planes, Alphas::Straight).unwrap();
            let back = second.planes(&mut planes, Alphas::Straight).unwrap();
            assert_eq!(there + back, Default::default());
            let off =
                |(value, back): (&f32, &f32)| (back - value).abs() / value.abs().max(ENGINE_FLOOR);
            let worst = values.iter().zip(&planes[1]).map(off).fold(0.0, f32::max);
            println!("{} to {} and back: {worst:.1e}", first.from(), first.to());
            assert!(worst <= ENGINE_TOLERANCE, "{}: {worst:e}", space.name);
        }
    }
}

#[test]
fn every_16_bit_code_comes_back_from_light() {
    let config = Config::load(&Source::Own).unwrap();
    let whole: Vec<f32> = (0..=u16::MAX)
        .map(|code| f32::from(code) / 65535.0)
        .collect();
    for space in config.spaces().iter().filter(|space| !space.is_data) {
        // Of which black and less have one code.
        if space.name == "ACEScc" {
            continue;
        }
        let mut planes = vec![whole.clone(); 3];
        for (from, to) in [(space.name.as_str(), "ACEScg"), ("ACEScg", &space.name)] {
            let processor = config.processor(from, to).unwrap();
            let report = processor.planes(&mut planes, Alphas::Straight).unwrap();
            assert_eq!(report, Default::default());
        }
        for plane in &planes {
            for (code, back) in plane.iter().enumerate() {
                assert_eq!((back * 65535.0).round(), code as f32, "{}", space.name);
            }
        }
    }
}

#[test]
fn curves_rise_and_have_no_steps() {
    for (name, curve) in all() {
        for joint in curve.form.joints() {
            let [below, at, above] = [-1e-9, 0.0, 1e-9].map(|by| curve.form.linear(joint + by));
            let size = at.abs().max(FLOOR);
            assert!(
                (above - below).abs() / size < 1e-5,
                "{name}: {below} {above}"
            );
        }
        let mut last = f64::NEG_INFINITY;
        for i in 0..=20_000 {
            let code = -0.125 + 1.25 * f64::from(i) / 20_000.0;
            let linear = curve.form.linear(code);
            assert!(linear > last, "{name} at {code}");
            last = linear;
        }
    }
}

#[test]
fn grey_has_the_code_that_makers_say() {
    for (name, curve) in all() {
        let digits = curve.grey.to_string().len() as i32 - 2;
        let code = curve.form.code(0.18);
        let half_a_digit = 0.51 * 10_f64.powi(-digits);
        assert!((code - curve.grey).abs() <= half_a_digit, "{name}: {code}");
    }
}

#[test]
fn every_curve_and_gamut_says_where_it_is_from() {
    let table = own().unwrap();
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
