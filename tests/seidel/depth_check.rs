//! `seidel apply` checks the first depth pass: it warns about a wrong convention and not about a correct one.

use std::path::Path;

use crate::support::{read_channel, seidel_in, succeeds, write_exr, write_moments_lens};

const SIZE: (usize, usize) = (160, 90);
/// Half a field of view of 38.7 degrees across the width.
const FOCAL_PX: f64 = 100.0;

/// Distances along the axis and along the ray, m, of a floor, two walls and a slanted roof. Each is a plane, so that the
/// reciprocal of the distance along the axis is linear in image coordinates.
fn room() -> Vec<(f64, f64)> {
    let (width, height) = SIZE;
    (0..width * height)
        .map(|k| {
            let x = ((k % width) as f64 + 0.5 - width as f64 / 2.0) / FOCAL_PX;
            let y = ((k / width) as f64 + 0.5 - height as f64 / 2.0) / FOCAL_PX;
            let floor = (y + 0.02 * x) / 1.1;
            let roof = (0.1 * x - y) / 1.6;
            let wall = (1.0 + 0.3 * x) / 6.0;
            let side = (-x + 0.1) / 1.9;
            let z = 1.0 / floor.max(roof).max(wall).max(side);
            (z, z * (1.0 + x * x + y * y).sqrt())
        })
        .collect()
}

fn write(path: &Path, depth: &dyn Fn(f64, f64) -> f64) {
    write_room(path, &["Y"], depth);
}

/// Writes a plate of the room with these colours, all alike, and as Z what `depth` gives for both distances of a pixel.
pub(crate) fn write_room(path: &Path, colours: &[&str], depth: &dyn Fn(f64, f64) -> f64) {
    let pixels = room();
    let depth = pixels.iter().map(|(z, ray)| depth(*z, *ray) as f32);
    let light: Vec<f32> = (0..pixels.len()).map(|k| 0.5 + (k % 3) as f32).collect();
    let colours = colours.iter().map(|name| (*name, light.clone()));
    let channels: Vec<_> = colours.chain([("Z", depth.collect())]).collect();
    write_exr(path, SIZE.0, SIZE.1, &channels);
}

#[test]
fn a_colour_of_the_plate_is_reported_as_no_depth() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["Y"]);
    write(&folder.join("plate.exr"), &|z, _| z);
    let line = "apply --lens @lens.json @plate.exr -o @out.exr --amount 0 --depth @plate.exr:Y";
    let message = succeeds(folder, line).stderr;
    assert!(
        message.contains("equals a colour of the plate"),
        "{message}"
    );
    assert!(message.contains("(--depth FILE:CHANNEL)"), "{message}");
}

#[test]
fn wrong_conventions_are_reported_and_correct_ones_are_not() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["Y"]);
    let message = |options: &str| {
        // The check needs no blur.
        let line = format!("apply --lens @lens.json @plate.exr -o @out.exr --amount 0 {options}");
        succeeds(folder, &line).stderr
    };
    let plate = folder.join("plate.exr");
    write(&plate, &|z, _| z);
    for options in ["", "--lens-scale 0.5", "--axis-offset 20,-10"] {
        assert!(
            !message(options).contains("doubtful"),
            "{}",
            message(options)
        );
    }
    let inverse = message("--depth-kind inverse");
    assert!(
        inverse.contains("doubtful") && inverse.contains("(--depth-kind) distance"),
        "{inverse}"
    );
    let kilometres = message("--depth-unit 0.001");
    assert!(
        kilometres.contains("doubtful") && kilometres.contains("--depth-unit"),
        "{kilometres}"
    );
    assert!(!message("--depth-kind inverse --no-depth-check").contains("doubtful"));
    write(&plate, &|z, _| 1.0 / z);
    let metres = message("");
    assert!(
        metres.contains("doubtful") && metres.contains("(--depth-kind) inverse"),
        "{metres}"
    );
    assert!(!message("--depth-kind inverse").contains("doubtful"));
}

#[test]
fn distances_along_the_ray_are_reported_and_can_be_converted() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["Y"]);
    write(&folder.join("axis.exr"), &|z, _| z);
    write(&folder.join("ray.exr"), &|_, ray| ray);
    let rendered = |plate: &str, options: &str| {
        let line = format!("apply --lens @lens.json @{plate} -o @out.exr {options}");
        let message = succeeds(folder, &line).stderr;
        (message, read_channel(&folder.join("out.exr"), "Y"))
    };
    let (message, _) = rendered("ray.exr", "--amount 0");
    assert!(
        message.contains("doubtful") && message.contains("--along-ray"),
        "{message}"
    );
    let (message, turned) = rendered("ray.exr", "--along-ray 100");
    assert!(!message.contains("doubtful"), "{message}");
    let (_, want) = rendered("axis.exr", "");
    let apart = turned.iter().zip(&want).map(|(a, b)| (a - b).abs());
    assert!(apart.fold(0.0, f32::max) < 1e-6);
    let line = "apply --lens @lens.json @ray.exr -o @no.exr --along-ray=-4";
    crate::support::must_refuse(folder, line, &["-4"]);
}

#[test]
fn only_the_first_frame_of_a_run_is_checked() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["Y"]);
    for frame in 3..6 {
        write(&folder.join(format!("plate.{frame}.exr")), &|z, _| 1.0 / z);
    }
    let line = "apply --lens @lens.json @plate.%d.exr -o @out.%d.exr --frames 3-5 --amount 0";
    let outcome = seidel_in(folder, line);
    assert_eq!(outcome.stderr.matches("doubtful").count(), 1);
    assert!(outcome.stderr.contains("note: frame 3: depth "));
}

#[test]
fn the_depth_of_another_picture_and_names_that_say_more_are_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["Y"]);
    // Cards of several shades before a wall, in no symmetric places.
    let cards = [
        (20, 16, 100, 80, 1.0),
        (120, 40, 60, 100, 1.5),
        (200, 10, 90, 60, 2.2),
        (190, 90, 50, 80, 1.2),
    ];
    let (width, height) = (2 * SIZE.0, 2 * SIZE.1);
    let (mut light, mut depth) = (vec![0.3_f32; width * height], vec![4.0_f32; width * height]);
    for (left, top, columns, rows, z) in cards {
        for row in top..top + rows {
            let start = row * width + left;
            light[start..start + columns].fill(0.4 * z);
            depth[start..start + columns].fill(z);
        }
    }
    let upside_down: Vec<f32> = depth.chunks(width).rev().flatten().copied().collect();
    let channels = [
        ("Y", light),
        ("Z", depth.clone()),
        ("upside.down", upside_down),
        ("depth_filtered.Z", depth),
    ];
    write_exr(&folder.join("plate.exr"), width, height, &channels);
    let message = |depth: &str| {
        let line = format!("apply --lens @lens.json @plate.exr -o @out.exr --amount 0 {depth}");
        succeeds(folder, &line).stderr
    };
    let right = message("");
    assert!(!right.contains("doubtful"), "{right}");
    let wrong = message("--depth @plate.exr:upside.down");
    for part in ["doubtful", "upside down", "of the same eye"] {
        assert!(wrong.contains(part), "{wrong}");
    }
    let filtered = message("--depth @plate.exr:depth_filtered.Z");
    assert!(filtered.contains("is filtered"), "{filtered}");
    let off = message("--depth @plate.exr:upside.down --no-depth-check");
    assert!(!off.contains("doubtful"), "{off}");
}
