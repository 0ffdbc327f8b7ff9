//! Mistakes planted in a set that a lens predicts exactly are named, and nothing else is.

use seidel_optics::camera::Camera;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::field::{Frame, ImagePoint};
use seidel_optics::lens::VergenceSeries;
use seidel_optics::numeric::SplitMix64;
use seidel_optics::observations::{Observation, ObservationSet};
use seidel_optics::predict::{Predictor, predict_set};
use seidel_optics::profile::{Controls, LensDescription, LensProfile, Provenance, PupilChannel};
use seidel_optics::psf::Pupil;
use seidel_optics::tile::Tile;

use super::sharpening::blurred;
use crate::diagnose::{Bookkeeping, FoundMistake, find_mistake};

const FRAME: (u32, u32) = (1600, 900);
const SIDE: usize = 25;
const CHANNELS: [&str; 3] = ["R", "G", "B"];

/// A lens with third-order aberrations, whose channels differ in focus and size of the image.
fn lens() -> LensProfile {
    let constant = VergenceSeries::constant;
    let channel = |index: usize| PupilChannel {
        name: CHANNELS[index].to_owned(),
        alpha: VergenceSeries {
            coefficients: vec![-1.0 + 0.5 * index as f64, 6.0],
            sigma: vec![0.0; 2],
            remainders: Vec::new(),
        },
        beta: constant(0.4),
        gamma: constant(1.1),
        delta: constant(-0.9),
        phi: constant(0.7),
        blur_variance_px2: constant(0.2),
        effects: Vec::new(),
        magnification: constant(3e-4 * index as f64),
        distortion: constant(-2e-3),
        measured_vergence: (0.2, 0.8),
        stop_lever_m: 0.0,
        added: Vec::new(),
        picture: None,
        wavelength_px: 0.0,
    };
    LensProfile {
        frame: Frame::new(FRAME.0, FRAME.1, None).expect("a frame"),
        pixel_pitch_um: None,
        camera: Camera::default(),
        description: LensDescription::Pupil((0..CHANNELS.len()).map(channel).collect()),
        held_out: None,
        provenance: Provenance::default(),
    }
}

/// The set that [`lens`] predicts, within a window of the frame. Exposures differ.
fn set(lens: &LensProfile, within: [f64; 4]) -> ObservationSet {
    let [left, top, right, bottom] = within;
    let blank = || Tile::new(SIDE, SIDE, vec![1.0; SIDE * SIDE]).expect("a tile");
    let places = (0..24).map(|k| {
        let (column, row) = (k % 4, k / 4 % 3);
        let along = |k: usize, count: usize| (k as f64 + 0.5) / count as f64;
        let x = left + (right - left) * along(column, 4) + 3.3 * row as f64;
        let y = top + (bottom - top) * along(row, 3) + 1.7 * column as f64;
        let distance = ObjectDistance::Metres(if k < 12 { 1.5 } else { 4.0 });
        let centre = ImagePoint::new(x.floor() + 0.5, y.floor() + 0.5);
        let tiles = vec![blank(); CHANNELS.len()];
        Observation {
            ideal: Some(ImagePoint::new(x, y)),
            ..Observation::new(format!("{k}"), centre, distance, tiles)
        }
    });
    let names = CHANNELS.map(str::to_owned).to_vec();
    let template = ObservationSet::new(lens.frame, names, places.collect());
    let predictor = Predictor::new(lens).expect("a sound lens");
    let drawn = predict_set(&predictor, &template, &Pupil).expect("drawable");
    changed(&drawn, |index, o| {
        let exposure = 0.5 + 0.3 * (index % 5) as f32;
        o.tiles = each(&o.tiles, |v| exposure * v);
        o.noise_sigma.fill(Some(1e-5));
    })
}

fn each(tiles: &[Tile], change: impl Fn(f32) -> f32) -> Vec<Tile> {
    let tile = |tile: &Tile| {
        let samples = tile.samples().iter().map(|v| change(*v)).collect();
        Tile::new(tile.width(), tile.height(), samples).expect("finite")
    };
    tiles.iter().map(tile).collect()
}

fn changed(set: &ObservationSet, change: impl Fn(usize, &mut Observation)) -> ObservationSet {
    let mut set = set.clone();
    let observations = set.observations.iter_mut().enumerate();
    observations.for_each(|(index, observation)| change(index, observation));
    set
}

fn found(lens: &LensProfile, set: &ObservationSet) -> Option<Bookkeeping> {
    let found = find_mistake(lens, set).expect("comparable");
    found.and_then(FoundMistake::sure)
}

const WHOLE: [f64; 4] = [60.0, 40.0, 1540.0, 860.0];

#[test]
fn positions_offsets_and_crops_are_named_with_their_amount() {
    let lens = lens();
    let whole = set(&lens, WHOLE);
    assert!(found(&lens, &whole).is_none());
    let shifted = |x: f64, y: f64| move |at: ImagePoint| ImagePoint::new(at.x_px + x, at.y_px + y);
    // A window whose corner lies at (420, 236).
    let window = set(&lens, [450.0, 260.0, 1500.0, 850.0]);
    assert!(found(&lens, &window).is_none());
    let cases = [
        (
            changed(&whole, |_, o| o.centre = shifted(3.0, -2.0)(o.centre)),
            "offset",
            "(3, -2) px",
        ),
        (
            changed(&whole, |_, o| {
                o.centre = shifted(-800.0, -450.0)(o.centre);
                o.ideal = o.ideal.map(shifted(-800.0, -450.0));
            }),
            "origin",
            "from the centre",
        ),
        (
            changed(&window, |_, o| {
                o.centre = shifted(-420.0, -236.0)(o.centre);
                o.ideal = o.ideal.map(shifted(-420.0, -236.0));
            }),
            "crop",
            "a crop, whose corner lies at (4",
        ),
    ];
    for (set, id, words) in cases {
        let found = found(&lens, &set).unwrap_or_else(|| panic!("{id}: nothing found"));
        assert_eq!(found.mistake, id, "{}", found.words);
        assert!(found.words.contains(words), "{}", found.words);
        assert!(found.gap_after < 0.03 * found.gap_before, "{found:?}");
    }
}

#[test]
fn values_that_are_not_light_are_named() {
    let lens = lens();
    let whole = set(&lens, WHOLE);
    let srgb = |v: f32| match v.max(0.0) {
        v if v <= 0.003_130_8 => 12.92 * v,
        v => 1.055 * v.powf(1.0 / 2.4) - 0.055,
    };
    let log_c = |v: f32| match v > 0.010_591 {
        true => 0.247_19 * (5.555_556 * v + 0.052_272).log10() + 0.385_537,
        false => 5.367_655 * v + 0.092_809,
    };
    let sharpened = |tile: &Tile| {
        let light: Vec<f64> = tile.samples().iter().map(|v| f64::from(*v)).collect();
        let soft = blurred(&light, SIDE, SIDE, 1.0);
        let samples = light
            .iter()
            .zip(soft)
            .map(|(l, s)| (l + 0.8 * (l - s)) as f32);
        Tile::new(SIDE, SIDE, samples.collect()).expect("finite")
    };
    for (change, id, words) in [
        (
            &(|o: &Observation| each(&o.tiles, |v| v + 0.02)) as &dyn Fn(&Observation) -> Vec<Tile>,
            "black_level",
            "0.020",
        ),
        (&|o| each(&o.tiles, srgb), "encoding", "sRGB"),
        (&|o| each(&o.tiles, log_c), "encoding", "LogC3"),
        (
            &|o| each(&o.tiles, |v| 255.0 * srgb(v)),
            "encoding",
            "in codes up to 255",
        ),
        (
            &|o| each(&o.tiles, |v| v.max(0.0).powf(2.2)),
            "encoding",
            "decoded",
        ),
        (
            &|o| o.tiles.iter().map(sharpened).collect(),
            "sharpening",
            "0.8",
        ),
    ] {
        let wrong = changed(&whole, |_, o| o.tiles = change(o));
        let found = found(&lens, &wrong).unwrap_or_else(|| panic!("{words}: nothing found"));
        assert_eq!(found.mistake, id, "{}", found.words);
        assert!(found.words.contains(words), "{}", found.words);
    }
}

/// Adds noise of the standard deviation `sigma` to tiles, and states it.
fn noisy(set: &ObservationSet, sigma: f64) -> ObservationSet {
    let mut random = SplitMix64::new(5);
    let mut set = set.clone();
    for observation in &mut set.observations {
        for tile in &mut observation.tiles {
            let samples = tile.samples().iter().map(|v| {
                let sum: f64 = (0..12).map(|_| random.unit() - 0.5).sum();
                v + (sigma * sum) as f32
            });
            *tile = Tile::new(SIDE, SIDE, samples.collect()).expect("finite");
        }
        observation.noise_sigma.fill(Some(sigma));
    }
    set
}

#[test]
fn noise_that_is_blurred_or_in_another_unit_is_named_and_a_blur_of_the_lens_is_not() {
    let lens = lens();
    let sigma = 2e-4;
    let whole = noisy(&set(&lens, WHOLE), sigma);
    assert!(found(&lens, &whole).is_none());
    let soft = |tile: &Tile| {
        let light: Vec<f64> = tile.samples().iter().map(|v| f64::from(*v)).collect();
        let soft = blurred(&light, SIDE, SIDE, 0.85);
        let samples = soft.into_iter().map(|v| v as f32).collect();
        Tile::new(SIDE, SIDE, samples).expect("finite")
    };
    let softened =
        |set: &ObservationSet| changed(set, |_, o| o.tiles = o.tiles.iter().map(soft).collect());
    let denoised = found(&lens, &softened(&whole)).expect("blurred noise");
    assert_eq!(denoised.mistake, "denoising", "{}", denoised.words);
    assert!(denoised.words.contains("0.85"), "{}", denoised.words);
    // The same blur before the noise.
    let by_optics = noisy(&softened(&set(&lens, WHOLE)), sigma);
    assert!(found(&lens, &by_optics).is_none());
    for (factor, words) in [(255.0, "too large"), (1.0 / 4095.0, "4095 times too small")] {
        let wrong = changed(&whole, |_, o| o.noise_sigma.fill(Some(factor * sigma)));
        let found = found(&lens, &wrong).expect("wrong noise");
        assert_eq!(found.mistake, "noise_scale", "{}", found.words);
        assert!(found.words.contains(words), "{}", found.words);
    }
}

#[test]
fn a_camera_that_the_tiles_contradict_is_named_and_other_settings_are_a_remark() {
    let mut lens = lens();
    lens.camera.f_number = Some(4.0);
    lens.pixel_pitch_um = Some(5.0);
    let mut whole = set(&lens, WHOLE);
    whole.camera.f_number = Some(4.0);
    whole.pixel_pitch_um = Some(5.0);
    assert!(found(&lens, &whole).is_none());
    let mut wrong = whole.clone();
    wrong.camera.f_number = Some(5.6);
    wrong.pixel_pitch_um = Some(10.0);
    let camera = found(&lens, &wrong).expect("a contradiction");
    assert_eq!(camera.mistake, "camera");
    for words in [
        "f-number of 5.6, the lens 4",
        "pixel pitch of 10 µm, the lens 5 µm",
    ] {
        assert!(camera.words.contains(words), "{}", camera.words);
    }
    assert_eq!(camera.corrected.camera, lens.camera);
    // A set that was taken at f/5.6.
    let stopped = Controls {
        f_number: Some(5.6),
        ..Controls::default()
    };
    let mut stopped = set(&lens.with_controls(&stopped).expect("known"), WHOLE);
    stopped.camera.f_number = Some(5.6);
    let LensDescription::Pupil(channels) = &lens.description else {
        panic!("the lens has rays");
    };
    let books = super::find(&lens, channels, &stopped, 0.0).expect("comparable");
    assert!(
        !matches!(&books.found, Some(FoundMistake::Sure(_))),
        "{:?}",
        books.found
    );
    let remark = books.remark.expect("other settings");
    assert!(remark.contains("at the settings of the set"), "{remark}");
}

#[test]
fn a_lens_that_describes_the_observed_set_and_not_its_own_was_given_them_exchanged() {
    let lens = lens();
    let mut other = lens.clone();
    let LensDescription::Pupil(channels) = &mut other.description else {
        panic!("the lens has rays");
    };
    for channel in channels.iter_mut() {
        channel.alpha.coefficients[0] += 2.0;
    }
    let (own, strange) = (set(&lens, WHOLE), set(&other, WHOLE));
    let LensDescription::Pupil(channels) = &lens.description else {
        panic!("the lens has rays");
    };
    let exchanged = super::exchanged::find(&lens, channels, &own, &strange, 1e-3);
    assert_eq!(exchanged.map(|found| found.mistake), Some("exchanged_sets"));
    assert!(super::exchanged::find(&lens, channels, &strange, &own, 1e-3).is_none());
}
