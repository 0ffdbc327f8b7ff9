//! Fits with the camera's data: the side of focus, and one distance.

use super::*;

/// Defocus of the planted lens: in focus at 1 / 0.3 m.
const ALPHA: [f64; 2] = [-6.0, 20.0];

/// Returns a lens of pure defocus, which tells no side, observed at `distances` with a signal-to-noise ratio of `snr`.
fn set_at(distances: &[f64], camera: Camera, snr: f64, seed: u64) -> ObservationSet {
    let mut lens = planted(&mut SplitMix64::new(31));
    let none = VergenceSeries::constant(0.0);
    lens.alpha = VergenceSeries::new(ALPHA.to_vec());
    for number in [
        &mut lens.beta,
        &mut lens.gamma,
        &mut lens.delta,
        &mut lens.phi,
    ] {
        number.clone_from(&none);
    }
    let mut set = observed(&lens, 12, snr, &mut SplitMix64::new(seed));
    set.observations
        .retain(|o| (o.distance.vergence_per_m()).is_some_and(|v| distances.contains(&(1.0 / v))));
    ObservationSet {
        pixel_pitch_um: Some(10.0),
        camera,
        ..set
    }
}

/// Returns the data of a thin lens with the defocus of [`ALPHA`].
fn camera() -> Camera {
    let (focal_m, focus) = (0.05, -ALPHA[0] / ALPHA[1]);
    let image_m = focal_m / (1.0 - focal_m * focus);
    Camera {
        focal_length_mm: Some(1e3 * focal_m),
        f_number: Some(focal_m * image_m / (2.0 * 10e-6 * ALPHA[1])),
        focus_distance: ObjectDistance::Metres(1.0 / focus),
        ..Camera::default()
    }
}

fn fitted(set: &ObservationSet) -> PupilFit {
    let settings = PupilSettings {
        model: PupilModel::Reduced,
        support: Support::AllPixels,
        law_only: true,
        ..PupilSettings::default()
    };
    fit_pupil(std::slice::from_ref(set), &settings, &no_progress).expect("a sound set")
}

fn alpha(fit: &PupilFit, metres: f64) -> f64 {
    fit.lens.pupil_channels()[0].numbers(1.0 / metres).alpha
}

#[test]
fn the_cameras_data_tell_the_side_of_focus() {
    let distances = [2.0, 6.0];
    let is_right = |fit: &PupilFit| {
        distances
            .iter()
            .all(|m| (alpha(fit, *m) - ALPHA[0] - ALPHA[1] / m).abs() < 0.2)
    };
    let of = |camera, seed| fitted(&set_at(&distances, camera, 20.0, seed));
    let misleading = (32..44).find(|seed| !is_right(&of(Camera::default(), *seed)));
    let seed = misleading.expect("noise that hides the side");
    let fit = of(camera(), seed);
    assert!(is_right(&fit), "{} {}", alpha(&fit, 2.0), alpha(&fit, 6.0));
}

#[test]
fn camera_data_that_contradict_the_psfs_are_refused_by_name() {
    let mut wrong = camera();
    wrong.focus_distance = ObjectDistance::Metres(1.0);
    let mut set = set_at(&[2.0, 3.0, 6.0], wrong, 0.0, 32);
    // Aberrations that tell the side.
    let mut lens = planted(&mut SplitMix64::new(33));
    lens.alpha = VergenceSeries::new(ALPHA.to_vec());
    lens.beta = VergenceSeries::constant(1.4);
    let clear = observed(&lens, 12, 0.0, &mut SplitMix64::new(34));
    set.observations = clear.observations;
    let fit = fitted(&set);
    assert!((alpha(&fit, 2.0) - 4.0).abs() < 0.1, "{}", alpha(&fit, 2.0));
    let refused = |w: &String| w.contains("2 m") && w.contains("Check these three fields");
    assert!(fit.warnings.iter().any(refused), "{:?}", fit.warnings);
}

#[test]
fn one_distance_is_reported_to_tell_no_other() {
    let fit = fitted(&set_at(&[2.0], camera(), 0.0, 32));
    assert_eq!(alpha(&fit, 2.0), alpha(&fit, 6.0));
    let stated = fit.warnings[0].contains("the same at every other distance");
    assert!(stated, "{:?}", fit.warnings);
}
