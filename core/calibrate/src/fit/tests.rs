//! Recovery of synthetic lenses; reports of outliers and of incompatible sets.

use super::*;
use seidel_optics::lens::{MomentCoefficients, ReducedNumbers};
use seidel_optics::moments::pixels::PIXEL_VARIANCE_PX2;
use seidel_optics::no_progress;
use seidel_optics::observations::Observation;
use seidel_optics::psf::{LocalBlur, MirroredPair, PsfModel, SampleGrid};
use seidel_optics::tile::Tile;

const TRUTH: ReducedNumbers = ReducedNumbers {
    alpha: 7.0,
    beta: 0.5,
    gamma: 0.9,
    delta: -0.8,
    phi: 0.6,
};

/// Tiles of a mirrored pair with the seven moments of the true lens, on a grid over the frame.
fn planted(axis: ImagePoint, distance: ObjectDistance) -> ObservationSet {
    let frame = Frame::new(900, 600, Some(axis)).expect("valid");
    let s = TRUTH.coefficients();
    let mut observations = Vec::new();
    for row in 0..6 {
        for column in 0..8 {
            let ideal = ImagePoint::new(
                60.0 + 112.3 * f64::from(column),
                40.0 + 104.7 * f64::from(row),
            );
            let at = frame.field_point(ideal);
            let stretch = 1.0 + 2e-3 - 3e-3 * at.radius().powi(2);
            let centroid = frame.image_point(seidel_optics::field::FieldPoint::new(
                at.x * stretch,
                at.y * stretch,
            ));
            let size = 61;
            let centre = ImagePoint::new(centroid.x_px.round() + 0.5, centroid.y_px.round() + 0.5);
            let window = SampleGrid::for_tile(
                size,
                size,
                centroid.x_px - centre.x_px + size as f64 / 2.0,
                centroid.y_px - centre.y_px + size as f64 / 2.0,
            );
            let blur = LocalBlur::from_moments(
                s.moments(at).with_added_variance(PIXEL_VARIANCE_PX2),
                at.meridian(),
            );
            let mut samples = vec![0.0; window.len()];
            MirroredPair.sample(&blur, &window, &mut samples);
            let samples = samples.iter().map(|&v| v as f32).collect();
            let tile = Tile::new(size, size, samples).expect("valid");
            let file = format!("psf/{row}{column}.exr");
            observations.push(Observation {
                ideal: Some(ideal),
                ..Observation::new(file, centre, distance, vec![tile])
            });
        }
    }
    ObservationSet {
        axis_stated: true,
        pixel_pitch_um: Some(5.0),
        ..ObservationSet::new(frame, vec!["Y".into()], observations)
    }
}

fn assert_close(got: &MomentCoefficients, relative: f64) {
    let want = TRUTH.coefficients();
    let distance = got.distance(&want, 1.0);
    assert!(distance < relative, "{distance}: {got:?} not {want:?}");
}

#[test]
fn a_synthetic_lens_is_recovered_with_either_weighting() {
    let centre = ImagePoint::new(450.0, 300.0);
    let set = planted(centre, ObjectDistance::Metres(2.0));
    for weighting in [Weighting::Weighted, Weighting::Unweighted] {
        let settings = MomentsSettings {
            weighting,
            ..MomentsSettings::default()
        };
        let fit = fit_moments(std::slice::from_ref(&set), &settings, &no_progress).expect("fits");
        let plane = &fit.lens.moments_channels()[0].planes[0];
        assert_close(&plane.s, 1e-3);
        let moved = plane.displacement.expect("ideal positions are known");
        assert!((moved.magnification - 2e-3).abs() < 1e-6, "{moved:?}");
        assert!((moved.distortion + 3e-3).abs() < 1e-6, "{moved:?}");
        assert!(fit.rejected.is_empty() && fit.planes[0].converged);
        assert!(fit.planes[0].second_residual < 1e-3);
    }
}

#[test]
fn the_axis_is_found_when_free() {
    let off = ImagePoint::new(462.0, 291.0);
    let mut set = planted(off, ObjectDistance::Infinity);
    set.frame = set
        .frame
        .with_axis(ImagePoint::new(450.0, 300.0))
        .expect("valid");
    let settings = MomentsSettings {
        axis: AxisChoice::Free,
        ..MomentsSettings::default()
    };
    let fit = fit_moments(&[set], &settings, &no_progress).expect("fits");
    let found = fit.axis.expect("asked for");
    assert!(found.converged, "{found:?}");
    assert!((found.axis.x_px - 462.0).abs() < 0.5, "{found:?}");
    assert!((found.axis.y_px - 291.0).abs() < 0.5, "{found:?}");
}

#[test]
fn outliers_and_saturated_tiles_are_rejected_and_named() {
    let mut set = planted(ImagePoint::new(450.0, 300.0), ObjectDistance::Metres(2.0));
    set.observations[5].saturated = true;
    let tile = &set.observations[9].tiles[0];
    let mut samples = tile.samples().to_vec();
    samples[200] += 0.3;
    set.observations[9].tiles[0] = Tile::new(61, 61, samples).expect("valid");
    let fit = fit_moments(&[set], &MomentsSettings::default(), &no_progress).expect("fits");
    let named: Vec<usize> = fit.rejected.iter().map(|r| r.observation).collect();
    assert_eq!(named, [5, 9]);
    assert!(fit.rejected[0].reason.contains("saturated"));
    assert!(fit.rejected[1].reason.contains("residual"));
    assert_close(&fit.lens.moments_channels()[0].planes[0].s, 1e-3);
}

#[test]
fn incompatible_sets_are_rejected() {
    let centre = ImagePoint::new(450.0, 300.0);
    let near = planted(centre, ObjectDistance::Metres(2.0));
    let mut other = planted(centre, ObjectDistance::Metres(4.0));
    other.channels = vec!["R".into()];
    let error = fit_moments(
        &[near.clone(), other],
        &MomentsSettings::default(),
        &no_progress,
    )
    .expect_err("channels differ");
    assert!(error.place.contains("channels"), "{error}");
    let mut mixed = near.clone();
    mixed.observations[3].distance = ObjectDistance::Unknown;
    let error = fit_moments(&[mixed], &MomentsSettings::default(), &no_progress)
        .expect_err("mixed distances");
    assert!(error.place.contains("depth_m"), "{error}");
    let mut clipped = near.clone();
    (clipped.observations.iter_mut()).for_each(|observation| observation.saturated = true);
    let error = fit_moments(&[clipped], &MomentsSettings::default(), &no_progress)
        .expect_err("no usable tile");
    assert!(error.problem.contains("marked saturated"), "{error}");
    let mut few = near;
    few.observations.truncate(2);
    assert!(fit_moments(&[few], &MomentsSettings::default(), &no_progress).is_err());
    assert!(fit_moments(&[], &MomentsSettings::default(), &no_progress).is_err());
}

#[test]
fn a_single_distance_gives_a_depth_warning() {
    let set = planted(ImagePoint::new(450.0, 300.0), ObjectDistance::Metres(2.0));
    let fit = fit_moments(&[set], &MomentsSettings::default(), &no_progress).expect("fits");
    assert!(
        fit.warnings
            .iter()
            .any(|r| r.contains("one object distance")),
        "{:?}",
        fit.warnings
    );
}
