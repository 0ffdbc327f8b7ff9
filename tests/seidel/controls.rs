//! Lenses with a `pupil` profile: their PSF model, and other focus and aperture.

use std::path::Path;

use seidel_core::ObservationSet;
use seidel_image_io::observation_set::{self as manifest, ReadOptions};
use seidel_optics::moments::pixels::TileMoments;

use crate::support::{
    read_channel, real_data, seidel_in, succeeds, write_generated_set, write_moments_lens,
    write_plate, write_pupil_lens,
};

fn read(folder: &Path, name: &str) -> ObservationSet {
    manifest::read(&folder.join(name), ReadOptions::default())
        .expect("a sound set")
        .set
}

/// Mean trace of the second moments of all tiles, by distance from infinity inwards.
fn sizes(set: &ObservationSet) -> Vec<f64> {
    let mut distances = set.distances();
    distances.reverse();
    let mean = |distance| {
        let here = set.observations.iter().filter(|o| o.distance == distance);
        let traces: Vec<f64> = here
            .map(|o| TileMoments::plain(&o.tiles[0], None).expect("lit"))
            .map(|m| m.central.trace())
            .collect();
        traces.iter().sum::<f64>() / traces.len() as f64
    };
    distances.into_iter().map(mean).collect()
}

#[test]
fn stopping_down_and_focusing_change_the_blur_as_they_should() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_generated_set(folder, "set", &["R", "G"]);
    write_pupil_lens(folder, &["R", "G"]);
    let drawn = |name: &str, extra: &str| {
        let line = format!("psf --lens @lens.json --like @set --out @{name} {extra}");
        succeeds(folder, &line);
        sizes(&read(folder, name))
    };
    // The default model of this lens is `pupil`, which has the true moments.
    let own = drawn("own", "");
    assert_eq!(own, drawn("pupil", "--psf pupil"));
    for (own, planted) in own.iter().zip(sizes(&read(folder, "set"))) {
        assert!((own / planted - 1.0).abs() < 0.05, "{own} {planted}");
    }
    let narrow = drawn("narrow", "--f-number 4");
    for (narrow, wide) in narrow.iter().zip(&own) {
        assert!(narrow < &(0.4 * wide), "{narrow} {wide}");
    }
    // From infinity inwards: a near focus is sharpest near, a far one far.
    let near = drawn("near", "--focus-distance 1.2");
    let far = drawn("far", "--focus-distance inf");
    assert!(near[2] < near[1] && near[1] < near[0], "{near:?}");
    assert!(far[0] < far[1] && far[1] < far[2], "{far:?}");
    // This lens focuses beyond infinity; a sensor farther away focuses nearer.
    let moved = drawn("moved", "--sensor-shift-um 30");
    assert!(moved.iter().zip(&own).all(|(m, o)| m < o), "{moved:?}");
}

/// An exact trace of a lens at another focus: the same lens, moved as a whole from 3 m to 1.5 m.
#[test]
fn a_refocused_lens_draws_the_traced_sizes() {
    let (Some(train), Some(refocused)) = (
        real_data("psf/controls55-train"),
        real_data("psf/controls55-focus2"),
    ) else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let fit = format!("fit {} -o @lens.json --model reduced", train.display());
    succeeds(folder, &fit);
    let drawn = |name: &str, like: &Path, extra: &str| {
        let like = like.display();
        let line = format!("psf --lens @lens.json --like {like} --out @{name} {extra}");
        succeeds(folder, &line);
        read(folder, name)
    };
    // The focus that the set states is the lens's own.
    let own = drawn("own", &train, "");
    assert_eq!(
        own.observations,
        drawn("stated", &train, "--focus-distance 3").observations
    );
    let drawn = sizes(&drawn("near", &refocused, "--focus-distance 1.5"));
    let traced = manifest::read(&refocused, ReadOptions::default()).expect("a set");
    let traced = sizes(&traced.set);
    let least = traced.iter().copied().fold(f64::INFINITY, f64::min);
    // In focus this lens has more than third-order aberrations.
    let pairs = drawn.iter().zip(&traced).filter(|(_, t)| **t > least);
    let ratios: Vec<f64> = pairs.map(|(d, t)| (d / t).sqrt()).collect();
    assert_eq!(ratios.len(), 3);
    assert!(ratios.iter().all(|r| (r - 1.0).abs() < 0.11), "{ratios:?}");
}

#[test]
fn plates_and_sheets_obey_the_controls() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["R", "G", "B"]);
    write_plate(&folder.join("plate.exr"), 34, 26);
    let peak = |name: &str, extra: &str| {
        let line =
            format!("apply --lens @lens.json @plate.exr -o @{name}.exr --lens-scale 1 {extra}");
        let message = succeeds(folder, &line).stderr;
        let light = read_channel(&folder.join(format!("{name}.exr")), "G");
        (light.into_iter().fold(0.0, f32::max), message)
    };
    let (wide, quiet) = peak("wide", "");
    let (narrow, _) = peak("narrow", "--f-number 4");
    assert!(narrow > 1.5 * wide, "{narrow} {wide}");
    let (open, warnings) = peak("open", "--f-number 1.4");
    assert!(open < wide);
    assert!(warnings.contains("extrapolated") && !quiet.contains("extrapolated"));
    succeeds(
        folder,
        "lens show @lens.json -o @sheet.png --focus-distance 2 --psf gaussian",
    );
}

#[test]
fn focal_length_and_film_back_are_those_of_the_shot() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["R", "G", "B"]);
    write_plate(&folder.join("plate.exr"), 60, 40);
    let render = |extra: &str| {
        let line =
            format!("apply --lens @lens.json @plate.exr -o @out.exr --quality exact {extra}");
        let message = succeeds(folder, &line).stderr;
        (read_channel(&folder.join("out.exr"), "G"), message)
    };
    // The frame is 300 px of 6 µm wide. A plate of 60 px shows all of it, or half of it.
    let (all, _) = render("");
    assert_eq!(render("--film-back-mm 1.8").0, all);
    let (half, quiet) = render("--film-back-mm 0.9");
    assert_eq!(render("--lens-scale 0.4").0, half);
    assert_ne!(half, all);
    let (_, warned) = render("--film-back-mm 2.7");
    assert!(
        warned.contains("1.50 times that of the lens's frame"),
        "{warned}"
    );
    assert!(!quiet.contains("of the lens's frame"), "{quiet}");
    // A lens and its sensor twice as large, at twice all distances, takes the same picture.
    let plane = "--distance 1.5 --focus-distance 2.5";
    let large = "--distance 3 --focus-distance 5 --focal-length-mm 100 --film-back-mm 1.8";
    let (own, of_large) = (
        render(&format!("{plane} --film-back-mm 0.9")).0,
        render(large).0,
    );
    for (a, b) in own.iter().zip(&of_large) {
        assert!((a - b).abs() <= 1e-5 * a.abs().max(0.01), "{a} {b}");
    }
    assert_ne!(own, render(plane).0);
    let both = seidel_in(
        folder,
        "apply --lens @lens.json @plate.exr -o @out.exr --film-back-mm 36 --lens-scale 1",
    );
    assert!(both.stderr.contains("--lens-scale"), "{}", both.stderr);
    let profile = std::fs::read_to_string(folder.join("lens.json")).expect("written");
    let without = profile.replace("\"pixel_pitch_um\": 6.0", "\"pixel_pitch_um\": null");
    assert_ne!(profile, without);
    std::fs::write(folder.join("lens.json"), without).expect("writable");
    let line = "apply --lens @lens.json @plate.exr -o @other.exr --film-back-mm 36";
    let refused = seidel_in(folder, line);
    assert_eq!(refused.status, 1);
    for word in ["lens.json", "pixel_pitch_um", "--lens-scale"] {
        assert!(refused.stderr.contains(word), "{}", refused.stderr);
    }
    assert!(!folder.join("other.exr").exists());
}

#[test]
fn moments_profiles_refuse_the_controls() {
    let folder = tempfile::tempdir().expect("a folder");
    write_moments_lens(folder.path(), &["Y"]);
    for extra in ["--psf pupil", "--f-number 4", "--focus-distance 1"] {
        for line in [
            "psf --lens @lens.json --like @set --out @out",
            "lens show @lens.json -o @sheet.png",
        ] {
            let refused = seidel_in(folder.path(), &format!("{line} {extra}"));
            assert_eq!(refused.status, 1, "{line} {extra}");
            assert!(
                refused.stderr.contains("--model reduced") && refused.stderr.contains("lens.json"),
                "{}",
                refused.stderr
            );
        }
    }
    assert!(!folder.path().join("out").exists());
}

#[test]
fn pupil_profiles_are_scored_by_rays() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_generated_set(folder, "set", &["Y"]);
    write_pupil_lens(folder, &["Y"]);
    let text = succeeds(folder, "eval --lens @lens.json @set").stdout;
    assert!(text.contains("rays lens"), "{text}");
    let json = succeeds(folder, "eval --lens @lens.json @set --json").stdout;
    assert!(json.contains("\"pupil-model\""), "{json}");
    write_moments_lens(folder, &["Y"]);
    let json = succeeds(folder, "eval --lens @lens.json @set --json").stdout;
    assert!(!json.contains("\"pupil-model\""), "{json}");
}

#[test]
fn amount_channel_scale_and_axis_offset_act_on_plates() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    crate::support::write_moments_lens(folder, &["R", "G", "B"]);
    crate::support::write_plate(&folder.join("plate.exr"), 60, 40);
    let red = |name: &str| crate::support::read_channel(&folder.join(name), "R");
    let render = |name: &str, options: &str| {
        let line =
            format!("apply --lens @lens.json @plate.exr -o @{name} --occlusion off {options}");
        crate::support::succeeds(folder, &line);
        red(name)
    };
    let plain = render("plain.exr", "");
    assert_eq!(render("none.exr", "--amount 0"), red("plate.exr"));
    let neutral = "--amount 1 --channel-scale G=1.5 --axis-offset 0,0";
    assert!(render("one.exr", neutral) == plain, "{neutral}");
    for (name, options) in [
        ("more.exr", "--amount 2"),
        ("red.exr", "--channel-scale R=0.5"),
        ("axis.exr", "--axis-offset -9,4"),
    ] {
        assert_ne!(render(name, options), plain, "{options}");
    }
    crate::support::must_refuse(
        folder,
        "apply --lens @lens.json @plate.exr -o @no.exr --channel-scale Q=2",
        &["channel scale Q", "R, G, B"],
    );
    crate::support::must_refuse_options(
        folder,
        "apply --lens @lens.json @plate.exr -o @no.exr --amount -1",
        &["--amount", "0 to 16"],
    );
}
