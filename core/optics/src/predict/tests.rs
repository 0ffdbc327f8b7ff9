//! The same lens predicts the same PSFs in either kind of profile.

use super::*;
use crate::camera::Camera;
use crate::effects;
use crate::field::ImagePoint;
use crate::lens::{ReducedNumbers, VergenceSeries};
use crate::observations::{Observation, ObservationSet};
use crate::profile::{MomentsPlane, ProfileEffect, Provenance};
use crate::tile::Tile;

const DISTANCES: [ObjectDistance; 3] = [
    ObjectDistance::Infinity,
    ObjectDistance::Metres(2.0),
    ObjectDistance::Metres(1.0),
];

fn numbers(v: f64) -> ReducedNumbers {
    ReducedNumbers {
        alpha: -4.0 + 9.0 * v,
        beta: 0.8,
        gamma: 1.1,
        delta: -0.6,
        phi: 0.4,
    }
}

fn profile(description: LensDescription) -> LensProfile {
    LensProfile {
        frame: Frame::new(400, 300, None).expect("valid"),
        pixel_pitch_um: None,
        camera: Camera::default(),
        description,
        held_out: None,
        provenance: Provenance::default(),
    }
}

fn pupil_channel() -> PupilChannel {
    let n = numbers(0.0);
    let constant = VergenceSeries::constant;
    PupilChannel {
        name: "Y".into(),
        alpha: VergenceSeries::new(vec![-4.0, 9.0]),
        beta: constant(n.beta),
        gamma: constant(n.gamma),
        delta: constant(n.delta),
        phi: constant(n.phi),
        blur_variance_px2: constant(0.0),
        magnification: constant(2e-3),
        distortion: VergenceSeries::new(vec![-3e-3, 1e-3]),
        measured_vergence: (0.0, 1.0),
        stop_lever_m: 0.0,
        added: Vec::new(),
        picture: None,
        wavelength_px: 0.0,
        effects: Vec::new(),
    }
}

fn of_pupil(channel: PupilChannel) -> Predictor {
    Predictor::new(&profile(LensDescription::Pupil(vec![channel]))).expect("a lens")
}

/// A set of one observation near the right edge of the frame.
fn set_of_one(lens: &Predictor, ideal: ImagePoint, tile: Tile) -> ObservationSet {
    let (centre, distance) = (ImagePoint::new(310.5, 90.5), ObjectDistance::Infinity);
    let observation = Observation {
        ideal: Some(ideal),
        ..Observation::new("0.exr", centre, distance, vec![tile])
    };
    ObservationSet::new(lens.frame(), vec!["Y".into()], vec![observation])
}

fn of_moments() -> Predictor {
    let planes = DISTANCES.iter().map(|&distance| {
        let v = distance.vergence_per_m().expect("known");
        MomentsPlane {
            distance,
            s: numbers(v).coefficients(),
            s_sigma: [1e-6; 10],
            displacement: Some(crate::profile::RadialDisplacement {
                magnification: 2e-3,
                distortion: -3e-3 + 1e-3 * v,
                magnification_sigma: 0.0,
                distortion_sigma: 0.0,
            }),
            tiles_used: 0,
            tiles_rejected: 0,
        }
    });
    let channel = MomentsChannel {
        name: "Y".into(),
        planes: planes.collect(),
    };
    Predictor::new(&profile(LensDescription::Moments(vec![channel]))).expect("a lens")
}

#[test]
fn both_kinds_of_the_same_lens_have_equal_blur() {
    let (rays, moments) = (of_pupil(pupil_channel()), of_moments());
    assert!(rays.has_rays() && !moments.has_rays());
    assert!(rays.depends_on_depth() && moments.depends_on_depth());
    for v in [0.0, 0.3, 0.5, 0.9] {
        let at = FieldPoint::new(0.7, -0.4);
        let (a, b) = (rays.blur_at(0, at, v), moments.blur_at(0, at, v));
        assert!(a.blur.pupil.is_some() && b.blur.pupil.is_none());
        for (a, b) in a
            .blur
            .moments
            .to_array()
            .iter()
            .zip(b.blur.moments.to_array())
        {
            assert!((a - b).abs() < 1e-9, "{v}: {a} {b}");
        }
        assert!((a.displacement_px.0 - b.displacement_px.0).abs() < 1e-12);
        assert!((a.displacement_px.1 - b.displacement_px.1).abs() < 1e-12);
    }
    // Displacement keeps its value beyond the measured range.
    let at = FieldPoint::new(0.7, -0.4);
    let landing = |v| rays.blur_at(0, at, v).displacement_px;
    assert_eq!(landing(1.0), landing(1.7));
}

#[test]
fn closed_forms_and_quadrature_agree() {
    let plain = of_pupil(pupil_channel());
    let mut channel = pupil_channel();
    // Neutral vignetting changes nothing but requires quadrature.
    let effect = effects::by_id("vignetting").expect("listed");
    let neutral = effects::neutral(effect);
    channel.effects.push(ProfileEffect {
        effect,
        values: neutral.into_iter().map(VergenceSeries::constant).collect(),
    });
    let drawn = of_pupil(channel);
    let at = FieldPoint::new(-0.2, 0.5);
    let both = [&plain, &drawn].map(|lens| lens.blur_at(0, at, 0.8).blur.moments.to_array());
    for (a, b) in both[0].iter().zip(both[1]) {
        assert!((a - b).abs() < 1e-9 * both[0][0].max(1.0), "{a} {b}");
    }
}

#[test]
fn lenses_measured_at_one_distance_need_none() {
    let mut channel = pupil_channel();
    channel.alpha = VergenceSeries::constant(3.0);
    let lens = of_pupil(channel);
    assert!(!lens.depends_on_depth());
    assert_eq!(lens.vergence(ObjectDistance::Unknown), Ok(0.0));
    assert!(of_moments().vergence(ObjectDistance::Unknown).is_err());
}

#[test]
fn models_that_need_rays_are_rejected_for_moments() {
    let (rays, moments) = (of_pupil(pupil_channel()), of_moments());
    assert_eq!(moments.default_model().id(), "skew-normal");
    assert_eq!(rays.default_model().id(), "pupil");
    for model in psf::ALL {
        assert!(rays.check_model(*model).is_ok());
        match moments.check_model(*model) {
            Ok(()) => assert!(!model.needs_rays()),
            Err(error) => {
                assert!(model.needs_rays());
                assert!(error.remedy.contains("reduced model"), "{error}");
            }
        }
    }
}

#[test]
fn drawn_tiles_have_the_predicted_moments() {
    use crate::moments::pixels::{PIXEL_VARIANCE_PX2, TileMoments};
    let mut channel = pupil_channel();
    channel.blur_variance_px2 = VergenceSeries::constant(0.3);
    let lens = of_pupil(channel);
    let ideal = ImagePoint::new(310.2, 90.7);
    let dark = Tile::new(41, 41, vec![0.0; 41 * 41]).expect("valid");
    let like = set_of_one(&lens, ideal, dark);
    let drawn = predict_set(&lens, &like, &Pupil).expect("drawable");
    let seen = &drawn.observations[0];
    let got = TileMoments::plain(&seen.tiles[0], None).expect("lit");
    let at = lens.frame().field_point(ideal);
    let want = lens.blur_at(0, at, 0.0);
    let want_moments = want.blur.moments.with_added_variance(PIXEL_VARIANCE_PX2);
    for (g, w) in got.central.to_array().iter().zip(want_moments.to_array()) {
        assert!(
            (g - w).abs() < 5e-3 * want_moments.trace().powf(1.5),
            "{g} {w}"
        );
    }
    let landed = seen.frame_point(got.centroid_x, got.centroid_y);
    assert!((landed.x_px - ideal.x_px - want.displacement_px.0).abs() < 5e-3);
    assert!((landed.y_px - ideal.y_px - want.displacement_px.1).abs() < 5e-3);
    let refused = predict_set(&of_moments(), &like, &Pupil).expect_err("needs rays");
    assert!(refused.remedy.contains("reduced model"), "{refused}");
}

/// An effect that sets the tone of the sensor.
struct Toned;

const TONE: Tone = Tone {
    gamma: 0.8,
    knee: 0.6,
    clip: 1.2,
};

impl effects::Effect for Toned {
    fn description(&self) -> &'static effects::Description {
        &effects::Description {
            id: "toned",
            ..effects::Description::DEFAULT
        }
    }

    fn parameters(&self) -> &'static [effects::Parameter] {
        &[]
    }

    fn apply(&self, _: &[f64], _: effects::ScenePoint, pupil: &mut crate::lens::LocalPupil) {
        pupil.sensor.tone = TONE;
    }

    fn starts(&self) -> Vec<effects::SearchStart> {
        Vec::new()
    }

    fn rescale(&self, values: &[VergenceSeries], _: effects::ControlRatios) -> Vec<VergenceSeries> {
        values.to_vec()
    }
}

#[test]
fn tone_acts_at_the_exposure_of_the_observed_tile() {
    let mut toned = pupil_channel();
    toned.effects.push(ProfileEffect {
        effect: &Toned,
        values: Vec::new(),
    });
    let (plain, toned) = (of_pupil(pupil_channel()), of_pupil(toned));
    assert!(plain.tone(0).is_linear() && toned.tone(0) == TONE);
    let like = |tile: Tile| set_of_one(&plain, ImagePoint::new(310.2, 90.7), tile);
    let dark = like(Tile::new(33, 33, vec![0.0; 33 * 33]).expect("valid"));
    let of = |lens: &Predictor, like: &ObservationSet| {
        let drawn = predict_set(lens, like, &Pupil).expect("drawable");
        drawn.observations[0].tiles[0].samples().to_vec()
    };
    let light = of(&plain, &dark);
    // A tile without light has no exposure; the tone is not applied.
    assert_eq!(of(&toned, &dark), light);
    // Exposed so that the brightest pixels clip.
    let peak = light.iter().copied().fold(0.0_f32, f32::max);
    let seen: Vec<f32> = light
        .iter()
        .map(|v| TONE.apply(f64::from(*v * 2.0 / peak)) as f32)
        .collect();
    let sum: f32 = seen.iter().sum();
    let found = of(
        &toned,
        &like(Tile::new(33, 33, seen.clone()).expect("valid")),
    );
    for (found, seen) in found.iter().zip(&seen) {
        assert!((found - seen / sum).abs() < 1e-6, "{found} {}", seen / sum);
    }
    // Rendered planes get the same tone; a linear tone leaves them unchanged.
    let mut plane = vec![-0.1, 0.0, 0.2, 1.0, 7.0];
    crate::blur_field::apply_tone(&plain, &[1.0], &mut plane);
    assert_eq!(plane, [-0.1, 0.0, 0.2, 1.0, 7.0]);
    crate::blur_field::apply_tone(&toned, &[1.0], &mut plane);
    for (value, light) in plane.iter().zip([-0.1, 0.0, 0.2, 1.0, 7.0]) {
        assert!((f64::from(*value) - TONE.apply(light)).abs() < 1e-6);
    }
}
