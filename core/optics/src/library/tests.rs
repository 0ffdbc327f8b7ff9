//! Tests of the lens library: valid files, lenses that differ, names.

use super::*;
use crate::BlurField;
use crate::distance::ObjectDistance;
use crate::field::FieldPoint;
use crate::predict::Predictor;

#[test]
fn profiles_are_valid_and_agree_with_their_sheets() {
    for lens in ALL {
        let (profile, sheet) = (
            lens.profile().expect("valid"),
            lens.sheet().expect("a sheet"),
        );
        assert_eq!(sheet.name, lens.name);
        assert_eq!(profile.camera.focal_length_mm, Some(sheet.focal_length_mm));
        assert_eq!(profile.camera.f_number, Some(sheet.f_number_range[0]));
        assert!(sheet.f_number_range[1] >= sheet.f_number_range[0]);
        let focus = ObjectDistance::Metres(sheet.focus_distance_m);
        assert_eq!(profile.camera.focus_distance, focus);
        let sensor = (sheet.sensor.width_px, sheet.sensor.height_px);
        assert_eq!(
            (profile.frame.width_px(), profile.frame.height_px()),
            sensor
        );
        assert_eq!(profile.camera.squeeze.unwrap_or(1.0), sheet.squeeze);
        let (nearest, farthest) = profile.measured_range_m().expect("a range");
        assert!((nearest - sheet.nearest_m).abs() < 1e-9 && farthest.is_infinite());
        assert!(!sheet.shows.is_empty() && !sheet.good_for.is_empty());
        let text = sheet.to_string();
        assert!(text.contains(&sheet.computed_from) && text.contains("Good for"));
    }
}

#[test]
fn lenses_are_sharpest_where_they_are_focused() {
    for lens in ALL {
        let profile = lens.profile().expect("valid");
        let predictor = Predictor::new(&profile).expect("a lens");
        let focus = profile.camera.focus_distance.vergence_per_m();
        let focus = focus.expect("a focused distance");
        let size = |v: f64| {
            let moments = predictor
                .blur_at(1, FieldPoint::new(0.0, 0.0), v)
                .blur
                .moments;
            moments.trace().max(0.0).sqrt()
        };
        let near = 1.0 / lens.sheet().expect("a sheet").nearest_m;
        assert!(
            size(focus) < 0.3 * size(0.0).max(size(near)),
            "{}",
            lens.name
        );
        assert!(size(focus) < 4.0, "{}: {} px", lens.name, size(focus));
    }
}

/// Every pair differs in the shape of its off-axis discs, not only in their size.
#[test]
fn lenses_differ_from_each_other() {
    let tiles: Vec<Vec<f64>> = ALL.iter().map(disc).collect();
    for (i, a) in tiles.iter().enumerate() {
        for (j, b) in tiles.iter().enumerate().skip(i + 1) {
            let misplaced: f64 = a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>() / 2.0;
            let names = (ALL[i].name, ALL[j].name);
            assert!(misplaced > 0.08, "{names:?}: {misplaced}");
        }
    }
}

/// Returns the light of a far point near the corner, at the same size for every lens.
fn disc(lens: &LibraryLens) -> Vec<f64> {
    use crate::psf::SampleGrid;
    let profile = lens.profile().expect("valid");
    let predictor = Predictor::new(&profile).expect("a lens");
    let placed = predictor.blur_at(1, FieldPoint::new(0.8, 0.45), 0.0);
    let size = placed.blur.moments.trace().sqrt();
    let blur = placed.blur.rescaled(8.0 / size);
    let grid = SampleGrid::for_tile(41, 41, 20.5, 20.5);
    let mut samples = vec![0.0; grid.len()];
    predictor.default_model().sample(&blur, &grid, &mut samples);
    let sum: f64 = samples.iter().sum();
    samples.iter().map(|v| v / sum).collect()
}

#[test]
fn names_are_found_and_unknown_ones_get_the_nearest() {
    assert!(by_reference("swirl-58").is_none(), "a file");
    let found = by_reference("library:Swirl-58").expect("a reference");
    assert_eq!(found.expect("known").name, "swirl-58");
    for (name, nearest) in [
        ("swrl-58", "swirl-58"),
        ("macro", "macro-100"),
        ("", "library:"),
    ] {
        let error = by_name(name).expect_err("unknown");
        assert!(error.remedy.contains(nearest), "{name}: {}", error.remedy);
    }
}

#[test]
fn files_of_a_folder_are_named_without_a_way_out_of_it() {
    let named = |reference| file_name(reference);
    assert_eq!(named("library:my lens"), Some("my lens.json".to_owned()));
    for other in [
        "my lens",
        "library:",
        "library:../a",
        "library:a/b",
        "library:c:x",
        "library:..",
    ] {
        assert_eq!(named(other), None, "{other}");
    }
}
