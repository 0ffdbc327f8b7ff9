//! `seidel psf`: predicted sets have the places of the observed sets, and similar PSFs.

use seidel_image_io::observation_set::{self as manifest, ReadOptions};
use seidel_optics::moments::pixels::TileMoments;

use crate::support::{seidel_in, succeeds, write_moments_lens};

#[test]
fn predictions_match_the_true_lens_in_place_size_and_moments() {
    let folder = tempfile::tempdir().expect("a folder");
    write_moments_lens(folder.path(), &["R", "G", "B"]);
    succeeds(
        folder.path(),
        "psf --lens @lens.json --like @set --out @predicted --psf mirrored-pair",
    );
    let read = |name: &str| {
        manifest::read(&folder.path().join(name), ReadOptions::default())
            .expect("a sound set")
            .set
    };
    let (observed, predicted) = (read("set"), read("predicted"));
    assert_eq!(observed.channels, predicted.channels);
    assert_eq!(observed.observations.len(), predicted.observations.len());
    for (seen, drawn) in observed.observations.iter().zip(&predicted.observations) {
        assert_eq!(
            (&seen.file, seen.centre, seen.distance, seen.ideal),
            (&drawn.file, drawn.centre, drawn.distance, drawn.ideal)
        );
        for channel in 0..3 {
            let (a, b) = (&seen.tiles[channel], &drawn.tiles[channel]);
            assert!((b.sum() - 1.0).abs() < 1e-6);
            let (a, b) = (
                TileMoments::plain(a, None).expect("lit"),
                TileMoments::plain(b, None).expect("lit"),
            );
            assert!((a.centroid_x - b.centroid_x).abs() < 0.01, "{}", seen.file);
            assert!((a.centroid_y - b.centroid_y).abs() < 0.01, "{}", seen.file);
            assert!((a.central.mu20 / b.central.mu20 - 1.0).abs() < 0.02);
            assert!((a.central.mu02 / b.central.mu02 - 1.0).abs() < 0.02);
        }
    }
}

#[test]
fn without_ideal_positions_the_centroid_is_the_observed_one() {
    let folder = tempfile::tempdir().expect("a folder");
    write_moments_lens(folder.path(), &["Y"]);
    let path = folder.path().join("set/manifest.json");
    let mut json: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(&path).expect("there")).expect("JSON");
    for observation in json["observations"].as_array_mut().expect("a list") {
        let keys = observation.as_object_mut().expect("an object");
        keys.remove("ideal_x");
        keys.remove("ideal_y");
    }
    std::fs::write(&path, json.to_string()).expect("writable");
    succeeds(
        folder.path(),
        "psf --lens @lens.json --like @set --out @out --psf gaussian",
    );
    let read = |name: &str| {
        manifest::read(&folder.path().join(name), ReadOptions::default())
            .expect("a sound set")
            .set
    };
    let (observed, predicted) = (read("set"), read("out"));
    for (seen, drawn) in observed.observations.iter().zip(&predicted.observations) {
        let (a, b) = (
            TileMoments::plain(&seen.tiles[0], None).expect("lit"),
            TileMoments::plain(&drawn.tiles[0], None).expect("lit"),
        );
        assert!((a.centroid_x - b.centroid_x).abs() < 0.01, "{}", seen.file);
        assert!((a.centroid_y - b.centroid_y).abs() < 0.01, "{}", seen.file);
    }
}

#[test]
fn an_unknown_model_is_refused_with_a_list_of_models() {
    let folder = tempfile::tempdir().expect("a folder");
    write_moments_lens(folder.path(), &["Y"]);
    let outcome = seidel_in(
        folder.path(),
        "psf --lens @lens.json --like @set --out @out --psf moffat",
    );
    assert_eq!(outcome.status, 1);
    assert!(outcome.stderr.contains("moffat") && outcome.stderr.contains("mirrored-pair"));
    assert!(!folder.path().join("out").exists());
}
