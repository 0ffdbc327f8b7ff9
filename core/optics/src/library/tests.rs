//! Tests of the lens library: valid files, lenses that differ, names.

use super::*;
use crate::BlurField;
use crate::distance::ObjectDistance;
use crate::field::FieldPoint;
use crate::predict::Predictor;
use crate::profile::Controls;
use crate::sharpest_vergence;

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
        let measured = lens.profile().expect("valid");
        let sheet = lens.sheet().expect("a sheet");
        let own = sheet.focus_distance_m;
        let least = Sizes::new(&measured).at(1.0 / own);
        assert!(least.hypot() < 3.0, "{}: {least:?} px", lens.name);
        for metres in [own, sheet.nearest_m * 1.1, 2.0 * own, 1e6] {
            let controls = Controls {
                focus_distance: Some(ObjectDistance::Metres(metres)),
                ..Controls::default()
            };
            let sizes = Sizes::new(&measured.with_controls(&controls).expect("possible"));
            let case = format!("{} focused at {metres} m", lens.name);
            let found = sharpest_vergence(|v| sizes.at(v).hypot().powi(2)).expect("a focus");
            assert!((found - 1.0 / metres).abs() < 1e-5, "{case}: {found}");
            // As sharp as the lens draws at its own focus, in each plane of symmetry.
            let focused = sizes.at(1.0 / metres);
            let grown = [focused.x / least.x, focused.y / least.y];
            assert!(
                grown.iter().all(|g| *g < 1.15),
                "{case}: {focused:?}, {least:?}"
            );
            // Before and behind it discs keep their shape, beyond the nearest distance too.
            let ratio = |v: f64, sizes: &Sizes| sizes.at(v).x / sizes.at(v).y;
            let far = 40.0 * least.hypot() / sizes.slope(1.0 / metres);
            for side in [-far, far] {
                let [is, was] = [(1.0 / metres, &sizes), (1.0 / own, &Sizes::new(&measured))]
                    .map(|(focus, sizes)| ratio(focus + side, sizes));
                assert!((is / was - 1.0).abs() < 0.05, "{case}, {side}: {is} {was}");
            }
        }
    }
}

/// The sizes of discs on the axis.
struct Sizes(Predictor);

/// Standard deviations, px.
#[derive(Debug)]
struct Size {
    x: f64,
    y: f64,
}

impl Size {
    fn hypot(&self) -> f64 {
        self.x.hypot(self.y)
    }
}

impl Sizes {
    fn new(profile: &LensProfile) -> Self {
        Self(Predictor::new(profile).expect("a lens"))
    }

    /// Returns the root mean square over channels at vergence `v`.
    fn at(&self, v: f64) -> Size {
        let axis = FieldPoint::new(0.0, 0.0);
        let all = (0..self.0.channel_count()).map(|k| self.0.blur_at(k, axis, v).blur.moments);
        let [x, y] = all.fold([0.0; 2], |[x, y], m| [x + m.mu20 / 3.0, y + m.mu02 / 3.0]);
        Size {
            x: x.sqrt(),
            y: y.sqrt(),
        }
    }

    /// Returns the growth of sizes away from `focus`, px m.
    fn slope(&self, focus: f64) -> f64 {
        self.at(focus + 1.0).hypot()
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
    assert!(LibraryLens::by_reference("swirl-58").is_none(), "a file");
    let found = LibraryLens::by_reference("library:Swirl-58").expect("a reference");
    assert_eq!(found.expect("known").name, "swirl-58");
    for (name, nearest) in [
        ("swrl-58", "swirl-58"),
        ("macro", "macro-100"),
        ("", "library:"),
    ] {
        let error = LibraryLens::by_name(name).expect_err("unknown");
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
