//! Mistakes in the books of a set are named before effects, corrected, and never found where there is none.

use std::fs;
use std::path::Path;

use seidel_calibrate::fit::fit_pupil;
use seidel_core::fitting::{PupilModel, PupilSettings};
use seidel_core::{LensProfile, ObjectDistance, ObservationSet, no_progress};
use seidel_image_io::observation_set;
use seidel_optics::field::ImagePoint;
use seidel_optics::tile::Tile;
use seidel_trial::{Conditions, Kind, Recipe, Simulator, Size};
use serde_json::Value;

use crate::support::{must_refuse, succeeds};

/// A lens with three channels, and a set with a planted cause of the given kind.
fn case(kind: Kind) -> (LensProfile, ObservationSet) {
    let size = Size {
        design: 16,
        real: 14,
        holdout: 2,
        tile: 25,
    };
    let drawn = Recipe::new(kind, Simulator::ThirdOrder, 7001, Some(size));
    let recipe = Recipe {
        conditions: Conditions {
            distances: 2,
            snr: 200.0,
            noise_stated: true,
            ideal_positions: true,
            strength: 0.5,
            ..drawn.conditions
        },
        ..drawn
    };
    let case = seidel_trial::draw(&recipe);
    let settings = PupilSettings {
        model: PupilModel::Reduced,
        ..PupilSettings::default()
    };
    let fit = fit_pupil(&[case.design], &settings, &no_progress).expect("a sound design");
    (fit.lens, case.real)
}

/// Returns the report of `diagnose` for `set`.
fn report(folder: &Path, lens: &LensProfile, set: &ObservationSet, library: &str) -> Value {
    fs::write(folder.join("lens.json"), lens.to_json()).expect("writable");
    for name in ["set", "out"] {
        let _ = fs::remove_dir_all(folder.join(name));
    }
    observation_set::write(set, &folder.join("set")).expect("writable");
    let line = format!("diagnose --lens @lens.json @set --only {library} --no-pairs --out @out");
    succeeds(folder, &line);
    let text = fs::read_to_string(folder.join("out/report.json")).expect("written");
    serde_json::from_str(&text).expect("JSON")
}

/// Changes every observation of a copy of `set`.
fn changed(set: &ObservationSet, change: impl Fn(&mut seidel_core::Observation)) -> ObservationSet {
    let mut set = set.clone();
    set.observations.iter_mut().for_each(change);
    set
}

fn flipped(tile: &Tile) -> Tile {
    let rows = tile.samples().chunks(tile.width()).rev();
    let samples = rows.flatten().copied().collect();
    Tile::new(tile.width(), tile.height(), samples).expect("as large")
}

#[test]
fn mistakes_are_named_with_their_remedy_and_corrected() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let (lens, set) = case(Kind::None);
    let size = [set.frame.width_px(), set.frame.height_px()].map(f64::from);
    let turned = |at: ImagePoint| ImagePoint::new(size[0] - at.x_px, size[1] - at.y_px);
    let upwards = |at: ImagePoint| ImagePoint::new(at.x_px, size[1] - at.y_px);
    let scaled = |distance: ObjectDistance, scale: f64| match distance {
        ObjectDistance::Metres(metres) => ObjectDistance::Metres(metres * scale),
        other => other,
    };
    let distances = set.distances();
    let exchanged = |distance: ObjectDistance| match distance == distances[0] {
        true => distances[1],
        false => distances[0],
    };
    let mut cases = vec![
        (
            changed(&set, |o| {
                o.centre = upwards(o.centre);
                o.ideal = o.ideal.map(upwards);
            }),
            "positions",
            "y upwards",
        ),
        (
            changed(&set, |o| {
                o.centre = turned(o.centre);
                o.ideal = o.ideal.map(turned);
            }),
            "positions",
            "turned by 180",
        ),
        (
            changed(&set, |o| {
                o.centre = ImagePoint::new(o.centre.x_px - 0.5, o.centre.y_px - 0.5);
            }),
            "half_pixel",
            "too small",
        ),
        (
            changed(&set, |o| o.distance = scaled(o.distance, 1.0 / 0.3048)),
            "distance_unit",
            "feet",
        ),
        (
            changed(&set, |o| o.distance = exchanged(o.distance)),
            "distance_labels",
            "exchanged",
        ),
        (
            changed(&set, |o| {
                for tile in &mut o.tiles {
                    let codes = tile.samples().iter().map(|v| v.max(0.0).powf(1.0 / 2.2));
                    *tile =
                        Tile::new(tile.width(), tile.height(), codes.collect()).expect("a tile");
                }
                o.noise_sigma.fill(None);
            }),
            "encoding",
            "gamma",
        ),
    ];
    if set.channels.len() > 1 {
        let last = set.channels.len() - 1;
        cases.push((
            changed(&set, |o| o.tiles.swap(0, last)),
            "channels",
            "another order",
        ));
    }
    for (set, id, words) in &cases {
        let report = report(folder, &lens, set, "motion,defocus_offset");
        assert_eq!(
            report["verdict"], "bookkeeping",
            "{words}: {}",
            report["added"]
        );
        let found = &report["bookkeeping"];
        assert_eq!(found["mistake"], *id, "{found}");
        let stated = found["words"].as_str().expect("a text");
        assert!(stated.contains(words), "{stated}");
        let [before, after] = ["gap_before", "gap_after"].map(|key| found[key].as_f64());
        assert!(after < before.map(|before| 0.05 * before), "{found}");
        let corrected = folder.join("out/corrected-set/manifest.json");
        assert!(corrected.is_file());
    }
    // The corrected set of the last case is the right one; its folder is kept.
    let read = observation_set::read(&folder.join("out/corrected-set"), Default::default());
    let line = "diagnose --lens @lens.json @set --only motion --no-pairs --out @out";
    must_refuse(folder, line, &["already holds `corrected-set`"]);
    let again = report(
        folder,
        &lens,
        &read.expect("a sound set").set,
        "motion,defocus_offset",
    );
    assert!(again["bookkeeping"].is_null(), "{again}");
    let page = fs::read_to_string(folder.join("out/report.html")).expect("written");
    assert!(!page.contains("mistake in the books"));
}

#[test]
fn an_effect_beside_a_mistake_is_found_on_the_corrected_set_and_effects_are_no_mistakes() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let (lens, set) = case(Kind::Single("decentre"));
    let library = "decentre,motion,defocus_offset,sensor_tilt";
    let right = report(folder, &lens, &set, library);
    assert!(right["bookkeeping"].is_null(), "{}", right["bookkeeping"]);
    assert_eq!(right["added"][0], "decentre");
    let upside_down = changed(&set, |o| {
        o.tiles = o.tiles.iter().map(flipped).collect();
    });
    let report = report(folder, &lens, &upside_down, library);
    assert_eq!(
        report["verdict"], "bookkeeping",
        "{}",
        report["bookkeeping"]
    );
    assert_eq!(report["added"], right["added"], "{}", report["bookkeeping"]);
    let page = fs::read_to_string(folder.join("out/report.html")).expect("written");
    assert!(page.contains("mistake in the books of the set"));
    let notes = succeeds(folder, "eval --lens @lens.json @set").stderr;
    assert!(notes.contains("books of the set"), "{notes}");
    observation_set::write(&set, &folder.join("right")).expect("writable");
    let notes = succeeds(folder, "eval --lens @lens.json @right").stderr;
    assert!(!notes.contains("books of the set"), "{notes}");
}
