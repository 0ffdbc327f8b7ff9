//! `seidel apply --alpha-per-channel`: colour fringes of an element survive a merge.

use std::path::Path;

use crate::support::{must_refuse, read_channel, succeeds, write_exr, write_moments_lens};

const WIDTH: usize = 90;
const HEIGHT: usize = 60;
const COLOURS: [&str; 3] = ["R", "G", "B"];

/// Coverage of an element with a hard edge on the left and a soft one on the right, away from the plate's edges.
fn coverage(k: usize) -> f32 {
    let (x, y) = (k % WIDTH, k / WIDTH);
    let inside = (20..60).contains(&x) && (15..45).contains(&y);
    if inside {
        (1.0 - (x as f32 - 50.0).max(0.0) / 12.0).clamp(0.0, 1.0)
    } else {
        0.0
    }
}

fn plane(of: impl Fn(usize) -> f32) -> Vec<f32> {
    (0..WIDTH * HEIGHT).map(of).collect()
}

/// Writes a lens whose channels are displaced and blurred differently, and an element of one colour.
fn write_element(folder: &Path) {
    write_moments_lens(folder, &COLOURS);
    let colour = |shade: f32| plane(|k| shade * coverage(k));
    let channels = [
        ("R", colour(0.8)),
        ("G", colour(0.5)),
        ("B", colour(0.3)),
        ("A", plane(coverage)),
        ("Z", plane(|k| if coverage(k) > 0.0 { 1.2 } else { 4.0 })),
    ];
    write_exr(&folder.join("plate.exr"), WIDTH, HEIGHT, &channels);
    // The same element over white, as the camera would record it.
    let over = |shade: f32| plane(|k| shade * coverage(k) + 1.0 - coverage(k));
    let channels = [("R", over(0.8)), ("G", over(0.5)), ("B", over(0.3))];
    write_exr(&folder.join("white.exr"), WIDTH, HEIGHT, &channels);
    let white = COLOURS.map(|name| (name, vec![1.0; WIDTH * HEIGHT]));
    write_exr(&folder.join("even.exr"), WIDTH, HEIGHT, &white);
}

fn read(folder: &Path, file: &str, channel: &str) -> Vec<f32> {
    read_channel(&folder.join(file), channel)
}

fn farthest(a: &[f32], b: impl Iterator<Item = f32>) -> f32 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f32::max)
}

#[test]
fn a_merge_is_what_the_camera_sees() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_element(folder);
    for quality in ["exact", "final"] {
        let options = format!("--lens @lens.json --distance 1.2 --quality {quality}");
        succeeds(
            folder,
            &format!("apply @plate.exr -o @out.exr --alpha-per-channel {options}"),
        );
        for (input, output) in [("white", "seen"), ("even", "ground")] {
            succeeds(
                folder,
                &format!("apply @{input}.exr -o @{output}.exr {options}"),
            );
        }
        let plain = read(folder, "out.exr", "A");
        let mut fringe = 0.0_f32;
        for (name, shade) in COLOURS.into_iter().zip([0.8, 0.5, 0.3]) {
            let colour = read(folder, "out.exr", name);
            let alpha = read(folder, "out.exr", &format!("alpha.{name}"));
            // The element has one colour, so each channel is proportional to its own alpha.
            let apart = farthest(&colour, alpha.iter().map(|a| shade * a));
            assert!(apart < 1e-5, "{quality} {name} over black: {apart}");
            let seen = read(folder, "seen.exr", name);
            let ground = read(folder, "ground.exr", name);
            let merged = |alpha: &[f32]| {
                let parts = colour.iter().zip(alpha).zip(&ground);
                let light: Vec<f32> = parts.map(|((c, a), white)| c + white - a).collect();
                farthest(&seen, light.into_iter())
            };
            let bound = if quality == "exact" { 1e-5 } else { 2e-3 };
            assert!(
                merged(&alpha) < bound,
                "{quality} {name}: {}",
                merged(&alpha)
            );
            fringe = fringe.max(merged(&plain));
        }
        assert!(fringe > 0.01, "one alpha for all leaves a fringe: {fringe}");
    }
}

#[test]
fn opaque_stays_opaque_over_depth_edges() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_element(folder);
    let near = plane(|k| if k % WIDTH < WIDTH / 2 { 1.0 } else { 5.0 });
    let mut channels: Vec<_> = ["R", "G", "B"]
        .map(|n| (n, vec![0.4; WIDTH * HEIGHT]))
        .into();
    channels.push(("A", vec![1.0; WIDTH * HEIGHT]));
    channels.push(("Z", near));
    write_exr(&folder.join("opaque.exr"), WIDTH, HEIGHT, &channels);
    let line =
        "apply --lens @lens.json @opaque.exr -o @out.exr --alpha-per-channel --geometry none";
    succeeds(folder, line);
    for name in ["A", "alpha.R", "alpha.G", "alpha.B"] {
        let alpha = read(folder, "out.exr", name);
        let apart = farthest(&alpha, std::iter::repeat(1.0));
        assert!(apart < 1e-4, "{name}: {apart}");
    }
}

#[test]
fn existing_alphas_belong_to_their_channels() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_element(folder);
    let options = "--lens @lens.json --distance 1.2 --alpha-per-channel";
    let whole = plane(coverage);
    let half = plane(|k| 0.5 * coverage(k));
    let channels = [
        ("R", whole.clone()),
        ("G", whole.clone()),
        ("B", whole.clone()),
        ("A", whole.clone()),
        ("alpha.R", half),
    ];
    write_exr(&folder.join("own.exr"), WIDTH, HEIGHT, &channels);
    succeeds(folder, &format!("apply @own.exr -o @out.exr {options}"));
    let alpha = |name: &str| read(folder, "out.exr", name);
    let (red, own_red) = (alpha("R"), alpha("alpha.R"));
    assert!(farthest(&own_red, red.iter().map(|v| 0.5 * v)) < 1e-5);
    // A channel without an alpha of its own uses the common one.
    assert!(farthest(&alpha("alpha.B"), alpha("B").into_iter()) < 1e-5);
    // Unpremultiplied colour is multiplied and divided by its own alpha.
    succeeds(
        folder,
        &format!("apply @own.exr -o @out.exr {options} --alpha unpremultiplied"),
    );
    let (straight, own) = (alpha("R"), alpha("alpha.R"));
    succeeds(
        folder,
        "apply @own.exr -o @usual.exr --lens @lens.json --distance 1.2 --alpha unpremultiplied",
    );
    assert_eq!(
        read(folder, "own.exr", "alpha.R"),
        read(folder, "usual.exr", "alpha.R")
    );
    for k in (0..WIDTH * HEIGHT).filter(|k| own[*k] > 1e-3) {
        // Colour with 0.5 coverage divided by 0.5 coverage: coverage weighted by itself remains.
        assert!(
            straight[k] > 0.0 && straight[k] <= 1.0 + 1e-4,
            "{}",
            straight[k]
        );
    }
    let twice = plane(|k| coverage(k) * 0.5 * coverage(k));
    let zeros = plane(|_| 0.0);
    let channels = [("R", twice), ("G", zeros.clone()), ("B", zeros)];
    write_exr(&folder.join("light.exr"), WIDTH, HEIGHT, &channels);
    succeeds(
        folder,
        "apply @light.exr -o @light-out.exr --lens @lens.json --distance 1.2",
    );
    let light = read(folder, "light-out.exr", "R");
    let lit: Vec<usize> = (0..WIDTH * HEIGHT).filter(|k| own[*k] > 0.05).collect();
    assert!(lit.len() > 500);
    for k in lit {
        assert!((straight[k] * own[k] - light[k]).abs() < 1e-3, "{k}");
    }
}

#[test]
fn formats_and_plates_that_cannot_hold_them_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_element(folder);
    image::RgbaImage::new(48, 32)
        .save(folder.join("plate.png"))
        .expect("writable");
    for (input, output, says) in [
        (
            "plate.png",
            "out.png",
            ["one alpha only", "convert the plate to EXR"],
        ),
        ("white.exr", "out.exr", ["channel A", "with alpha"]),
    ] {
        let line = format!(
            "apply --lens @lens.json @{input} -o @{output} --distance 1.2 --alpha-per-channel"
        );
        must_refuse(folder, &line, &says);
    }
}
