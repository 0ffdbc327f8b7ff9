//! A scene at two distances, through a lens that is focused elsewhere than the profile says.

use seidel_optics::lens::VergenceSeries;
use seidel_optics::no_progress;
use seidel_optics::profile::LensDescription;

use super::super::tests::{SIDE, SIZE, lens, picture, texture};
use super::super::*;
use crate::diagnose::{DiagnosisSettings, Verdict, diagnose, rays};

/// Vergences of the left and the right half, 1/m.
const VERGENCES: [f32; 2] = [0.25, 0.8];

/// A lens whose defocus grows by 4 px a dioptre from `far` px at infinity.
fn focused(far: f64) -> LensProfile {
    let mut lens = lens(0.3);
    if let LensDescription::Pupil(channels) = &mut lens.description {
        channels[0].alpha = VergenceSeries::new(vec![far, 4.0]);
    }
    lens
}

/// Renders `sharp` through `lens`.
fn plate(lens: &LensProfile, sharp: &[Vec<f32>], vergence: &[f32]) -> Vec<Vec<f32>> {
    let view = LensView {
        channels: rays(lens).expect("rays"),
        frame: lens.frame,
        vergence: 0.5,
        positions: Positions::Undistorted,
    };
    let predictor = Predictor::new(lens).expect("a sound lens");
    let sharp = picture(sharp);
    rendering::rendered(&view, &predictor, &sharp, Some(vergence), &no_progress).expect("rendered")
}

#[test]
fn windows_are_compared_at_their_own_distance() {
    let half = |k: usize| usize::from(k % SIZE.0 >= SIZE.0 / 2);
    let vergence: Vec<f32> = (0..SIZE.0 * SIZE.1).map(|k| VERGENCES[half(k)]).collect();
    let sharp = [texture()];
    let (given, planted) = (focused(-2.0), focused(-1.4));
    let plate = plate(&planted, &sharp, &vergence);
    let settings = PairSettings {
        side: SIDE,
        vergence: Some(vergence),
        ..PairSettings::default()
    };
    let pictures = [picture(&sharp), picture(&plate)];
    let found = estimate_pair(&given, &pictures[0], &pictures[1], &settings, &no_progress);
    let found = found.expect("textured");
    assert!(
        found.remarks.iter().any(|r| r.contains("at one distance")),
        "{:?}",
        found.remarks
    );
    for observation in &found.set.observations {
        let side = usize::from(observation.centre.x_px > SIZE.0 as f64 / 2.0);
        let stated = observation.distance.vergence_per_m().expect("known");
        assert!(
            (stated - f64::from(VERGENCES[side])).abs() < 1e-4,
            "{stated}"
        );
    }
    let settings = DiagnosisSettings {
        library: ["defocus_offset", "depth_scale", "pupil_scale"]
            .map(str::to_owned)
            .to_vec(),
        pairs: false,
        responses: found.responses,
        ..DiagnosisSettings::default()
    };
    let diagnosis = diagnose(&given, &found.set, &settings, &no_progress).expect("comparable");
    assert_eq!(diagnosis.verdict, Verdict::Explained, "{:?}", diagnosis.gap);
    assert_eq!(diagnosis.added, ["defocus_offset"]);
    let distances = found.set.distances().len();
    assert_eq!(distances, 2);
}
