//! Lenses beyond fifth order and without symmetry: the parts that describe them are found, and models without them are
//! reported.

use super::*;
use seidel_optics::effects::{self, Effect};
use seidel_optics::no_progress;
use seidel_optics::profile::{FieldPattern, ProfileEffect, Verdict};

/// Places per distance.
const PLACES: usize = 24;

/// Returns the planted lens with `effect`.
fn with(effect: &'static dyn Effect, values: &[f64]) -> PupilChannel {
    let mut lens = planted(&mut SplitMix64::new(11));
    let values = values.iter().map(|v| VergenceSeries::constant(*v));
    lens.effects.push(ProfileEffect {
        effect,
        values: values.collect(),
    });
    lens
}

fn observe(lens: &PupilChannel) -> ObservationSet {
    observed(lens, PLACES, 0.0, &mut SplitMix64::new(12))
}

/// Places per distance that are too few for two planes of symmetry, which take long to try.
const FEW_PLACES: usize = 16;

fn observe_few(lens: &PupilChannel) -> ObservationSet {
    observed(lens, FEW_PLACES, 0.0, &mut SplitMix64::new(12))
}

fn fitted(set: &ObservationSet, model: PupilModel) -> PupilFit {
    let settings = PupilSettings {
        model,
        support: Support::AllPixels,
        ..PupilSettings::default()
    };
    fit_pupil(std::slice::from_ref(set), &settings, &no_progress).expect("a sound set")
}

/// Returns the value at a middle distance of a parameter that the fit found.
fn found(fit: &PupilFit, id: &str, parameter: usize) -> Option<f64> {
    let channel = &fit.lens.pupil_channels()[0];
    let part = channel.effects.iter().find(|e| e.effect.id() == id)?;
    Some(part.values[parameter].at(1.0 / 3.0))
}

fn verdict(fit: &PupilFit) -> Verdict {
    fit.lens.adequacy().expect("PSFs were held out").verdict()
}

#[test]
fn a_decentred_lens_is_found_and_a_symmetric_model_of_it_reported() {
    let mut values = effects::neutral(&effects::Decentre);
    (values[0], values[1], values[3]) = (1.2, -0.8, 0.9);
    let set = observe(&with(&effects::Decentre, &values));
    let fit = fitted(&set, PupilModel::Extended);
    assert_eq!(verdict(&fit), Verdict::Describes, "{:?}", fit.lens.held_out);
    for (k, want) in [(0, 1.2), (1, -0.8)] {
        let got = found(&fit, "decentre", k).expect("decentred");
        assert!((got - want).abs() < 0.05, "{k}: {got}");
    }
    assert_eq!(found(&fit, "double_plane", 0), None);

    let symmetric = fitted(&set, PupilModel::Reduced);
    let adequacy = symmetric.lens.adequacy().expect("PSFs were held out");
    assert_ne!(verdict(&symmetric), Verdict::Describes, "{adequacy}");
    // Constant coma is one-sided, and the same over the field.
    assert_eq!(adequacy.pattern.periods % 2, 1, "{adequacy}");
    assert_eq!(adequacy.pattern.field, FieldPattern::Constant, "{adequacy}");
    assert!(adequacy.systematic_gap > 0.5 * adequacy.excess_gap);
    // Errors that assume a wrong model are not stated.
    let stated = numbers(&symmetric.lens.pupil_channels()[0]);
    assert!(stated.iter().all(|(_, _, sigma)| *sigma == 0.0));
    let warned = |w: &String| w.contains("Standard errors are not stated");
    assert!(
        symmetric.warnings.iter().any(warned),
        "{:?}",
        symmetric.warnings
    );
}

#[test]
fn a_tilted_sensor_is_found_from_the_sizes_of_tiles_and_is_no_decentred_element() {
    let values = [1.5, -5.0, 0.0, 0.0];
    let lens = with(&effects::SensorTilt, &values);
    let set = observe_few(&lens);
    let fit = fitted(&set, PupilModel::Auto);
    assert_eq!(verdict(&fit), Verdict::Describes, "{:?}", fit.lens.held_out);
    for (k, want) in [(0, 1.5), (1, -5.0)] {
        let got = found(&fit, "sensor_tilt", k).expect("tilted");
        assert!((got - want).abs() < 0.05, "{k}: {got}");
    }
    assert_eq!(found(&fit, "decentre", 0), None);
    let score = fit.lens.held_out.as_ref().expect("PSFs were held out");
    let neighbours = score.neighbours_snr_db.expect("there are neighbours");
    assert!(score.snr_db > neighbours + 10.0, "{neighbours}");

    let symmetric = fitted(&set, PupilModel::Reduced);
    let remarked = |w: &String| w.contains("the nearest PSFs of the set predict");
    assert!(
        symmetric.warnings.iter().any(remarked),
        "{:?}",
        symmetric.warnings
    );
}

#[test]
fn an_anamorphic_lens_is_found() {
    let mut lens = with(
        &effects::DoublePlane,
        &effects::neutral(&effects::DoublePlane),
    );
    let part = &mut lens.effects[0].values;
    // Another line of defocus along x, astigmatism and coma of one plane alone.
    part[0] = VergenceSeries::new(vec![1.5, -7.0]);
    part[4] = VergenceSeries::constant(0.8);
    part[7] = VergenceSeries::constant(-1.1);
    let mut set = observe(&lens);
    // Another magnification and distortion along x than along y.
    let shift = |x: f64, y: f64| [9.0 * x - 4.0 * x * y * y, -3.0 * y + 2.0 * y * y * y];
    for observation in &mut set.observations {
        let at = set.frame.field_point(observation.ideal.expect("planted"));
        let [x, y] = shift(at.x, at.y);
        observation.centre.x_px += x;
        observation.centre.y_px += y;
    }
    let fit = fitted(&set, PupilModel::Extended);
    assert_eq!(verdict(&fit), Verdict::Describes, "{:?}", fit.lens.held_out);
    let defocus = found(&fit, "double_plane", 0).expect("two planes");
    assert!((defocus - (1.5 - 7.0 / 3.0)).abs() < 0.05, "{defocus}");
    let channel = &fit.lens.pupil_channels()[0];
    for (x, y) in [(0.9, 0.1), (-0.4, 0.5)] {
        let at = FieldPoint::new(x, y);
        let (got_x, got_y) = channel.displacement_at(at, 0.3, set.frame.half_width_px());
        let [want_x, want_y] = shift(x, y);
        let error = (got_x - want_x).hypot(got_y - want_y);
        assert!(error < 0.02, "({x}, {y}): {error}");
    }
    assert_ne!(
        verdict(&fitted(&set, PupilModel::Reduced)),
        Verdict::Describes
    );
}

#[test]
fn an_uneven_pupil_and_its_centre_are_found() {
    let values = [0.8, 0.0, 0.25, -0.1];
    let fit = fitted(
        &observe_few(&with(&effects::Apodisation, &values)),
        PupilModel::Extended,
    );
    for (k, want) in values.into_iter().enumerate() {
        let got = found(&fit, "apodisation", k).expect("apodised");
        assert!((got - want).abs() < 0.05, "{k}: {got}");
    }
    assert_eq!(verdict(&fit), Verdict::Describes, "{:?}", fit.lens.held_out);
}

#[test]
fn the_mirror_of_a_catadioptric_lens_is_found_and_its_place() {
    let values = [0.42, 0.2];
    let lens = with(&effects::Obstruction, &values);
    let set = observe_few(&lens);
    let fit = fitted(&set, PupilModel::Extended);
    for (k, want) in values.into_iter().enumerate() {
        let got = found(&fit, "obstruction", k).expect("a ring");
        assert!((got - want).abs() < 0.02, "{k}: {got}");
    }
    assert_eq!(found(&fit, "apodisation", 0), None);
    assert_eq!(verdict(&fit), Verdict::Describes, "{:?}", fit.lens.held_out);
}

#[test]
fn one_stop_is_found_and_not_imitated_by_seventh_order() {
    let fit = fitted(
        &observe(&with(&effects::Vignetting, &[1.05, 0.35, 4.0, 0.0])),
        PupilModel::Extended,
    );
    // In the coordinates of the stop, the rim of the pupil is a stop of 1 / 1.05 that shifts by 0.35 / 1.05.
    let stops = [0, 2].map(|k| {
        let part = |offset: usize| found(&fit, "vignetting", k + offset).expect("a stop");
        [part(0), part(1).abs()]
    });
    let near = |[radius, shift]: [f64; 2]| (radius - 1.05).hypot(shift - 0.35) < 0.05;
    let same = |[radius, shift]: [f64; 2]| near([1.0 / radius, shift / radius]);
    assert!(
        stops.into_iter().any(|stop| near(stop) || same(stop)),
        "{stops:?}"
    );
    assert_eq!(found(&fit, "seventh_order", 0), None);
    assert_eq!(verdict(&fit), Verdict::Describes, "{:?}", fit.lens.held_out);
}

#[test]
fn blades_are_counted() {
    let set = observe_few(&with(&effects::AperturePolygon, &[7.0, 20.0, 1.06, 0.1]));
    let fit = fitted(&set, PupilModel::Extended);
    assert_eq!(found(&fit, "aperture_polygon", 0), Some(7.0));
    let rotation = found(&fit, "aperture_polygon", 1).expect("blades");
    // Heptagons repeat after a seventh of a turn.
    let off = (rotation - 20.0).rem_euclid(360.0 / 7.0);
    assert!(off.min(360.0 / 7.0 - off) < 2.0, "{rotation}");
}

#[test]
fn a_symmetric_lens_gains_no_plane_or_decentre() {
    let set = observe(&planted(&mut SplitMix64::new(13)));
    let fit = fitted(&set, PupilModel::Extended);
    assert_eq!(verdict(&fit), Verdict::Describes);
    for id in [
        "decentre",
        "double_plane",
        "aperture_polygon",
        "obstruction",
    ] {
        assert_eq!(found(&fit, id, 0), None, "{id}");
    }
}

#[test]
fn squeeze_of_a_symmetric_lens_is_rejected() {
    let mut set = observe(&planted(&mut SplitMix64::new(14)));
    set.camera.squeeze = Some(2.0);
    let problem = fit_pupil(&[set], &reduced(), &no_progress).expect_err("no squeeze");
    assert!(problem.to_string().contains("camera.squeeze"), "{problem}");
}

#[test]
fn parts_that_few_tiles_do_not_determine_are_held_back() {
    let lens = planted(&mut SplitMix64::new(15));
    let set = observed(&lens, 9, 0.0, &mut SplitMix64::new(16));
    let fit = fitted(&set, PupilModel::Extended);
    let named = |w: &String| w.contains("two planes of symmetry (double_plane): not tried");
    assert!(fit.warnings.iter().any(named), "{:?}", fit.warnings);
}

#[test]
fn a_free_axis_is_kept_when_parts_are_added() {
    let mut values = effects::neutral(&effects::HigherOrder);
    (values[0], values[1]) = (2.0, -3.0);
    let mut set = observe_few(&with(&effects::HigherOrder, &values));
    let truth = set.frame.axis();
    let off = ImagePoint::new(truth.x_px + 30.0, truth.y_px - 20.0);
    set.frame = set.frame.with_axis(off).expect("in the frame");
    let settings = PupilSettings {
        model: PupilModel::Auto,
        axis: AxisChoice::Free,
        support: Support::AllPixels,
        ..PupilSettings::default()
    };
    let fit = fit_pupil(&[set], &settings, &no_progress).expect("a sound set");
    assert!(
        found(&fit, "higher_order", 0).is_some(),
        "{:?}",
        fit.warnings
    );
    let axis = fit.lens.frame.axis();
    let error = (axis.x_px - truth.x_px).hypot(axis.y_px - truth.y_px);
    assert!(error < 1.0, "{axis:?} {truth:?}");
    assert_eq!(verdict(&fit), Verdict::Describes);
}
