//! Faults of photographs of lights: each is named by its cause, and sound photographs pass.

use seidel_optics::mosaic::Mosaic;

use super::measured;
use super::simulator::{Light, Simulator, grid};
use crate::background::Background;
use crate::checks::{Severity, black_level, greens, noise_correlation};
use crate::lights::LightSet;
use crate::photograph::Photograph;

const WIDTH: usize = 320;
const HEIGHT: usize = 240;

/// Returns a photograph of 35 lights that differ in brightness.
fn lights(seed: u64) -> Photograph {
    exposed(seed, seed + 100)
}

/// Exposes the lights of a layout, with the noise of `seed`.
fn exposed(layout: u64, seed: u64) -> Photograph {
    let lights = grid(&mut Simulator::new(WIDTH, HEIGHT, layout), 7, 5);
    let mut simulator = Simulator::new(WIDTH, HEIGHT, seed);
    for light in lights {
        simulator.add(light);
    }
    simulator.expose(0).0
}

/// Returns three interpolated planes: each missing sample is the mean of its neighbours of one colour, weighted 2 beside and 1 across.
fn interpolated(photo: &Photograph) -> Photograph {
    let plane = |channel: usize| -> Vec<f32> {
        let at = |k: usize| {
            let (x, y) = (k % WIDTH, k / WIDTH);
            let (mut sum, mut weight) = (0.0, 0.0);
            for row in y.saturating_sub(1)..(y + 2).min(HEIGHT) {
                for column in x.saturating_sub(1)..(x + 2).min(WIDTH) {
                    let near = [4.0, 2.0, 1.0][column.abs_diff(x) + row.abs_diff(y)];
                    if photo.covers(channel, column, row) {
                        sum += near * photo.planes[0][row * WIDTH + column];
                        weight += near;
                    }
                }
            }
            if photo.covers(channel, x, y) {
                photo.planes[0][k]
            } else {
                sum / weight
            }
        };
        (0..WIDTH * HEIGHT).map(at).collect()
    };
    Photograph {
        planes: (0..3).map(plane).collect(),
        mosaic: None,
        ..photo.clone()
    }
}

/// Returns the mean over the pixels of one colour up to `reach` of them away.
fn smoothed(photo: &Photograph, reach: usize) -> Vec<f32> {
    let at = |k: usize| {
        let (x, y) = (k % WIDTH, k / WIDTH);
        let near = |at: usize, count: usize| {
            (0..=2 * reach)
                .filter_map(move |d| (at + 2 * d).checked_sub(2 * reach).filter(|v| *v < count))
        };
        let all: Vec<f32> = near(y, HEIGHT)
            .flat_map(|row| near(x, WIDTH).map(move |column| row * WIDTH + column))
            .map(|k| photo.planes[0][k])
            .collect();
        all.iter().sum::<f32>() / all.len() as f32
    };
    (0..WIDTH * HEIGHT).map(at).collect()
}

/// Returns the severity and text of the only concern.
fn only(set: &LightSet) -> (Severity, String) {
    assert_eq!(set.concerns.len(), 1, "{:?}", set.concerns);
    let concern = &set.concerns[0];
    (concern.severity, concern.error.to_string())
}

#[test]
fn a_sound_photograph_raises_no_concern() {
    for seed in [31, 32] {
        let set = measured(vec![lights(seed)]);
        assert_eq!(set.concerns, [], "seed {seed}");
    }
}

#[test]
fn interpolated_colours_are_named_and_widen_the_stated_noise() {
    let photo = lights(33);
    let found = noise_correlation::noise_correlation(&photo, 1).expect("noise");
    assert!(found.neighbours.abs() < 0.06, "{found:?}");
    let set = measured(vec![interpolated(&photo)]);
    let (severity, text) = only(&set);
    assert!(
        matches!(severity, Severity::Widen(_)) && text.contains("interpolated"),
        "{text}"
    );
    let observations = set.observations(None).expect("a set");
    let (stated, light) = (observations.observations[0].noise_sigma[1], &set.lights[0]);
    assert!(stated.expect("stated") > 5.0 * light.noise_sigma[1]);
}

#[test]
fn denoised_and_sharpened_photographs_are_refused() {
    let photo = lights(34);
    let soft = smoothed(&photo, 1);
    let denoised = Photograph {
        planes: vec![soft.clone()],
        ..photo.clone()
    };
    let text = measured(vec![denoised])
        .refusal()
        .expect("refused")
        .to_string();
    assert!(text.contains("denoised"), "{text}");
    let sharp = photo.planes[0]
        .iter()
        .zip(&soft)
        .map(|(v, s)| v + 0.8 * (v - s));
    let sharp = Photograph {
        planes: vec![sharp.collect()],
        ..photo.clone()
    };
    let settings = crate::LightSettings::default();
    let text = match crate::measure_lights(vec![sharp], &crate::Calibration::default(), &settings) {
        Ok(set) => set.refusal().expect("refused").to_string(),
        Err(error) => error.to_string(),
    };
    assert!(text.contains("sharpened"), "{text}");
}

#[test]
fn a_curve_between_light_and_values_is_refused() {
    let mut photo = lights(35);
    for value in &mut photo.planes[0] {
        *value = 3000.0 * (1.0 + value.max(-50.0) / 100.0).ln();
    }
    photo.white = f32::INFINITY;
    let text = measured(vec![photo])
        .refusal()
        .expect("refused")
        .to_string();
    assert!(text.contains("not linear"), "{text}");
}

#[test]
fn a_cropped_column_shows_in_the_two_greens() {
    let mut photo = lights(36);
    // A lamp with little blue.
    for k in 0..WIDTH * HEIGHT {
        if photo.covers(2, k % WIDTH, k / WIDTH) {
            photo.planes[0][k] *= 0.7;
        }
    }
    assert_eq!(greens::check(&photo), None);
    let shifted = Photograph {
        mosaic: Mosaic::parse("RGGB").ok(),
        ..photo
    };
    let concern = greens::check(&shifted).expect("the greens are apart");
    assert_eq!(concern.severity, Severity::Refuse);
    assert!(
        concern.error.to_string().contains("GRBG"),
        "{}",
        concern.error
    );
}

#[test]
fn a_black_level_that_is_too_low_or_too_high_is_mentioned() {
    let check = |shift: f32| {
        let mut photo = lights(37);
        photo.planes[0].iter_mut().for_each(|value| *value += shift);
        black_level::check(&photo, &Background::of(&photo, 1))
            .map(|c| (c.severity, c.error.to_string()))
    };
    assert_eq!(check(0.0), None);
    for (shift, text) in [(2000.0, "too low"), (-100.0, "too high")] {
        let (severity, found) = check(shift).expect("a concern");
        assert!(
            severity == Severity::Note && found.contains(text),
            "{found}"
        );
    }
}

#[test]
fn motion_is_named_with_its_length_and_refused() {
    let mut photo = lights(38);
    // The pixels of one colour lie two apart: a motion of two and four pixels in equal parts.
    let still = photo.planes[0].clone();
    for (k, value) in photo.planes[0].iter_mut().enumerate() {
        let at = |d: usize| still[k - (k % WIDTH).min(d) / 2 * 2];
        *value = (at(0) + at(2) + at(4)) / 3.0;
    }
    let set = measured(vec![photo]);
    let all: Vec<String> = set.concerns.iter().map(|c| c.error.to_string()).collect();
    assert!(
        all.iter()
            .any(|text| text.contains("motion") && text.contains("along 0°")),
        "{all:?}"
    );
    assert!(set.refusal().is_some());
}

#[test]
fn two_lenses_at_one_distance_are_refused_and_repeats_are_not() {
    let (first, second) = (exposed(39, 1), exposed(39, 2));
    assert_eq!(measured(vec![first.clone(), second]).concerns, []);
    let mut wider = exposed(39, 3);
    let soft = smoothed(&wider, 1);
    for (value, soft) in wider.planes[0].iter_mut().zip(soft) {
        *value = 0.7 * *value + 0.3 * soft;
    }
    let set = measured(vec![first, wider]);
    let all: Vec<String> = set.concerns.iter().map(|c| c.error.to_string()).collect();
    assert!(
        all.iter().any(|text| text.contains("another lens")),
        "{all:?}"
    );
}

#[test]
fn a_photograph_overexposed_in_part_is_mentioned() {
    let mut simulator = Simulator::new(WIDTH, HEIGHT, 42);
    for light in grid(&mut simulator, 7, 5) {
        let brighter = if light.x > 160.0 { 4.0 } else { 1.0 };
        simulator.add(Light {
            peak: light.peak * brighter,
            ..light
        });
    }
    let (severity, text) = only(&measured(vec![simulator.expose(0).0]));
    assert!(
        severity == Severity::Note && text.contains("overexposed in part"),
        "{text}"
    );
}
