//! `seidel apply`: near objects occlude far ones, and holdouts stay sharp.

use std::path::Path;

use crate::support::{
    must_refuse, read_channel, seidel_in, succeeds, write_exr, write_moments_lens, write_plate,
};

const WIDTH: usize = 90;
const HEIGHT: usize = 60;

/// Writes an opaque plate of uniform grey: its left half 1 m away, its right half 5 m.
fn write_two_cards(path: &Path) {
    let even = vec![0.4; WIDTH * HEIGHT];
    let depth = |k: usize| if k % WIDTH < WIDTH / 2 { 1.0 } else { 5.0 };
    let channels = [
        ("R", even.clone()),
        ("G", even.clone()),
        ("B", even),
        ("A", vec![1.0; WIDTH * HEIGHT]),
        ("Z", (0..WIDTH * HEIGHT).map(depth).collect()),
    ];
    write_exr(path, WIDTH, HEIGHT, &channels);
}

fn farthest_from(samples: &[f32], value: f32) -> f32 {
    let apart = samples.iter().map(|v| (v - value).abs());
    apart.fold(0.0, f32::max)
}

#[test]
fn uniform_light_stays_uniform_and_opaque_at_a_depth_edge() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["R", "G", "B"]);
    write_two_cards(&folder.join("plate.exr"));
    let blurred = |extra: &str| {
        let line =
            format!("apply --lens @lens.json @plate.exr -o @out.exr --geometry none {extra}");
        succeeds(folder, &line);
        let read = |channel| read_channel(&folder.join("out.exr"), channel);
        (read("G"), read("A"))
    };
    for extra in [
        "--quality exact",
        "--quality final",
        "--no-fill-foreground",
        "--no-blur-inside",
    ] {
        let (green, alpha) = blurred(extra);
        assert!(farthest_from(&green, 0.4) < 1e-3, "{extra}");
        assert!(farthest_from(&alpha, 1.0) < 1e-4, "{extra}");
    }
    // Without occlusion it stays neither.
    let (_, alpha) = blurred("--occlusion off");
    assert!(farthest_from(&alpha, 1.0) > 0.01);
}

#[test]
fn holdouts_stop_the_blur_of_objects_behind_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["R", "G", "B"]);
    write_two_cards(&folder.join("plate.exr"));
    let upper = |k: usize| f32::from(u8::from(k / WIDTH < HEIGHT / 2));
    let matte: Vec<f32> = (0..WIDTH * HEIGHT).map(upper).collect();
    let two_metres = vec![2.0; WIDTH * HEIGHT];
    let channels = [("A", matte.clone()), ("Z", two_metres)];
    write_exr(&folder.join("matte.exr"), WIDTH, HEIGHT, &channels);
    let blurred = |extra: &str| {
        let line = format!("apply --lens @lens.json @plate.exr -o @out.exr {extra}");
        succeeds(folder, &line);
        read_channel(&folder.join("out.exr"), "G")
    };
    let whole = blurred("");
    let held = blurred("--holdout @matte.exr");
    for ((held, whole), matte) in held.iter().zip(&whole).zip(&matte) {
        assert!((held - whole * (1.0 - matte)).abs() < 1e-6);
    }
    let by_depth = blurred("--holdout @matte.exr:A --holdout-depth @matte.exr:Z");
    let at = |x: usize, y: usize| by_depth[y * WIDTH + x];
    assert!((at(8, 8) - 0.4).abs() < 1e-3, "in front: {}", at(8, 8));
    assert!(at(80, 8) < 1e-4, "behind: {}", at(80, 8));
    // Also with one distance for the whole plate.
    let behind = blurred("--distance 5 --holdout @matte.exr --holdout-depth @matte.exr:Z");
    assert_eq!(farthest_from(&behind[..WIDTH], 0.0), 0.0);
}

#[test]
fn invalid_holdouts_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["R", "G", "B"]);
    write_plate(&folder.join("plate.exr"), WIDTH, HEIGHT);
    write_exr(&folder.join("small.exr"), 9, 9, &[("A", vec![1.0; 81])]);
    let over = vec![1.5; WIDTH * HEIGHT];
    let channels = [("X", over.clone()), ("Y", over)];
    write_exr(&folder.join("matte.exr"), WIDTH, HEIGHT, &channels);
    for (extra, says) in [
        ("--holdout @small.exr", ["small.exr", "one size"]),
        ("--holdout @matte.exr", ["matte.exr", "no alpha"]),
        ("--holdout @matte.exr:Q", ["matte.exr", "X, Y"]),
        ("--holdout @matte.exr:X", ["channel X", "from 0 to 1"]),
    ] {
        let line = format!("apply --lens @lens.json @plate.exr -o @out.exr {extra}");
        must_refuse(folder, &line, &says);
    }
    for extra in ["--holdout-depth @z.exr", "--no-blur-inside --occlusion off"] {
        let line = format!("apply --lens @lens.json @plate.exr -o @out.exr {extra}");
        assert_eq!(seidel_in(folder, &line).status, 2, "{extra}");
    }
}
