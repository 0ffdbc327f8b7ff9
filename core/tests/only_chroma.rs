//! The colour error of a lens alone, without the blur that its channels share.

use seidel_core::profile::{LensDescription, PupilChannel};
use seidel_core::{
    Depth, DepthPass, Displacement, Image, Lens, LensProfile, ObjectDistance, Plate, Quality,
    Settings, apply, no_progress,
};

const WIDTH: usize = 80;
const HEIGHT: usize = 60;
/// Place of the light: on the axis, where lateral colour is nothing.
const LIGHT: usize = HEIGHT / 2 * WIDTH + WIDTH / 2;

const LENS: &str = include_str!("data/lens.json");

fn lens_of(change: impl FnOnce(&mut Vec<PupilChannel>)) -> Lens {
    let mut profile = LensProfile::from_json(LENS).expect("a profile");
    match &mut profile.description {
        LensDescription::Pupil(channels) => change(channels),
        LensDescription::Moments(_) => panic!("a lens of rays"),
    }
    Lens::new(profile).expect("a lens")
}

fn only_chroma(quality: Quality) -> Settings {
    let mut settings = Settings::default();
    settings.only_chroma = true;
    settings.quality = quality;
    settings.displacement = Displacement::None;
    settings
}

fn plate(samples: &[f32], depth: Depth) -> Plate {
    let image = Image::from_interleaved(WIDTH, HEIGHT, 3, samples).expect("an image");
    Plate::new(image).with_depth(depth)
}

fn at_metres(metres: f64) -> Depth {
    Depth::Distance(ObjectDistance::metres(metres).expect("a distance"))
}

/// Returns the sum of a plane and its variance about the light along x and y, px^2.
fn energy_and_variance(plane: &[f32]) -> (f64, f64) {
    let (mut sum, mut second) = (0.0, 0.0);
    for (index, sample) in plane.iter().enumerate() {
        let apart = |at: usize, light: usize| (at as f64 - light as f64).powi(2);
        let radius2 = apart(index % WIDTH, LIGHT % WIDTH) + apart(index / WIDTH, LIGHT / WIDTH);
        sum += f64::from(*sample);
        second += f64::from(*sample) * radius2;
    }
    (sum, second / sum)
}

#[test]
fn a_lens_of_equal_channels_gives_the_plate_back() {
    let lens = lens_of(|channels| {
        for index in 1..channels.len() {
            let name = std::mem::take(&mut channels[index].name);
            channels[index] = PupilChannel {
                name,
                ..channels[0].clone()
            };
        }
    });
    let bars =
        |k: usize| 0.1 + 0.5 * ((k / 3 / 7) % 2) as f32 + 4.0 * f32::from(u8::from(k / 3 == LIGHT));
    let bars: Vec<f32> = (0..WIDTH * HEIGHT * 3).map(bars).collect();
    let near_and_far = (0..WIDTH * HEIGHT).map(|k| if k % WIDTH < 30 { 1.5 } else { 6.0 });
    let pass = Depth::Pass(DepthPass::metres(near_and_far.collect()));
    for depth in [at_metres(4.0), pass] {
        for quality in [Quality::Final, Quality::Exact] {
            let settings = only_chroma(quality);
            let plate = plate(&bars, depth.clone());
            let result = apply(&lens, &plate, &settings, &no_progress).expect("a render");
            let pairs = result.to_interleaved().into_iter().zip(&bars);
            let worst = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(worst < 1e-5, "{quality:?}: {worst}");
        }
    }
}

#[test]
fn colours_blur_by_their_excess_over_the_sharpest() {
    let lens = Lens::from_json(LENS).expect("a lens");
    let light = |k: usize| f32::from(u8::from(k / 3 == LIGHT));
    let light: Vec<f32> = (0..WIDTH * HEIGHT * 3).map(light).collect();
    let plate = plate(&light, at_metres(0.6));
    let render = |settings: &Settings| {
        let image = apply(&lens, &plate, settings, &no_progress).expect("a render");
        let planes = image.colours.iter();
        let measured: Vec<_> = planes.map(|plane| energy_and_variance(plane)).collect();
        assert!(image.colours.iter().flatten().all(|v| *v >= 0.0));
        measured
    };
    let mut own = only_chroma(Quality::Final);
    own.look.axial_colour = 4.0;
    let mut whole = own.clone();
    whole.only_chroma = false;
    let (whole, own) = (render(&whole), render(&own));
    let least = whole.iter().map(|(_, v)| *v).fold(f64::INFINITY, f64::min);
    let has_excess = whole.iter().any(|(_, v)| *v > 1.1 * least);
    assert!(has_excess && least > 1.0, "{whole:?}");
    for ((_, whole), (energy, own)) in whole.iter().zip(&own) {
        assert!((energy - 1.0).abs() < 1e-4, "{energy}");
        let excess = whole - least;
        // The footprints of two pixels add a third of a square pixel at most.
        let added = own - excess;
        assert!((-0.01..0.34).contains(&added), "{own} {excess}");
    }
}

#[test]
fn a_lens_of_one_channel_is_refused() {
    let lens = lens_of(|channels| channels.truncate(1));
    let plate = plate(&[0.5; WIDTH * HEIGHT * 3], at_metres(4.0));
    let settings = only_chroma(Quality::Final);
    let refused = apply(&lens, &plate, &settings, &no_progress).expect_err("no colour error");
    assert!(refused.to_string().contains("one channel"), "{refused}");
}
