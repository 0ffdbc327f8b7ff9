//! `seidel remove --background`: the edges of a foreground become sharp where a clean plate shows what is behind it.

use std::fs;
use std::path::Path;

use crate::support::{
    must_refuse, read_channel, seidel_in, succeeds, write_exr, write_moments_lens,
};

const WIDTH: usize = 96;
const HEIGHT: usize = 80;
/// Columns of the foreground.
const CARD: std::ops::Range<usize> = 30..66;
/// Lens options: the foreground is blurred more than the background.
const LENS: &str = "--lens @lens.json --lens-scale 0.6";
const NEAR: f32 = 1.3;
const FAR: f32 = 4.0;

fn is_card(k: usize) -> bool {
    CARD.contains(&(k % WIDTH)) && (20..60).contains(&(k / WIDTH))
}

fn plane(sample: impl Fn(usize) -> f32) -> Vec<f32> {
    (0..WIDTH * HEIGHT).map(sample).collect()
}

/// Stripes of dark and light, which the foreground covers.
fn behind(k: usize) -> f32 {
    let (x, y) = (k % WIDTH, k / WIDTH);
    if (x / 7 + y / 9).is_multiple_of(2) {
        0.1
    } else {
        0.7
    }
}

fn in_front(k: usize) -> f32 {
    if (k / WIDTH / 6).is_multiple_of(2) {
        1.0
    } else {
        0.6
    }
}

/// Writes the lens, `clean.exr`, `plate.exr`, both with the lens's blur and their depth, and returns the sharp plate.
fn write_shot(folder: &Path) -> Vec<f32> {
    write_moments_lens(folder, &["Y"]);
    let far = plane(|_| FAR);
    let depth = plane(|k| if is_card(k) { NEAR } else { FAR });
    let truth = plane(|k| if is_card(k) { in_front(k) } else { behind(k) });
    let write = |name: &str, light: Vec<f32>, depth: &[f32]| {
        let channels = [("Y", light), ("Z", depth.to_vec())];
        write_exr(&folder.join(name), WIDTH, HEIGHT, &channels);
    };
    write("clean-sharp.exr", plane(behind), &far);
    write("truth.exr", truth.clone(), &depth);
    for line in [
        "apply @clean-sharp.exr -o @clean.exr",
        "apply @truth.exr -o @plate.exr --background @clean-sharp.exr",
    ] {
        succeeds(
            folder,
            &format!("{line} {LENS} --quality exact --edges extend"),
        );
    }
    truth
}

/// Root mean square error within eight pixels of the left and right edge of the foreground.
fn edge_error(path: &Path, truth: &[f32]) -> f64 {
    let samples = read_channel(path, "Y");
    let near_edge = |k: usize| {
        let (x, y) = (k % WIDTH, k / WIDTH);
        let columns = (x.abs_diff(CARD.start)).min(x.abs_diff(CARD.end));
        (20..60).contains(&y) && columns <= 8
    };
    let errors: Vec<f64> = (0..WIDTH * HEIGHT)
        .filter(|k| near_edge(*k))
        .map(|k| f64::from(samples[k] - truth[k]).powi(2))
        .collect();
    (errors.iter().sum::<f64>() / errors.len() as f64).sqrt()
}

#[test]
fn edges_of_the_foreground_become_sharp() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let truth = write_shot(folder);
    let line = format!("remove @plate.exr {LENS} --noise 0.002 --no-overscan");
    succeeds(folder, &format!("{line} -o @blurred-edges.exr"));
    succeeds(
        folder,
        &format!("{line} -o @sharp.exr --background @clean.exr"),
    );
    let error = |name: &str| edge_error(&folder.join(name), &truth);
    let (plate, without, with) = (
        error("plate.exr"),
        error("blurred-edges.exr"),
        error("sharp.exr"),
    );
    assert!(
        with < 0.6 * plate && with < 0.8 * without && without < 0.8 * plate,
        "{plate} {without} {with}"
    );
}

#[test]
fn bad_backgrounds_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_shot(folder);
    let flat = [("Y", plane(behind))];
    write_exr(&folder.join("flat.exr"), WIDTH, HEIGHT, &flat);
    write_exr(
        &folder.join("other.exr"),
        WIDTH,
        1,
        &[("Y", vec![0.5; WIDTH])],
    );
    fs::write(folder.join("broken.exr"), "no picture").expect("writable");
    let refused = |line: &str, parts: &[&str]| {
        must_refuse(folder, &format!("remove -o @x.exr {LENS} {line}"), parts);
    };
    refused("@plate.exr --background @missing.exr", &["missing.exr"]);
    refused("@plate.exr --background @broken.exr", &["broken.exr"]);
    refused(
        "@plate.exr --background @other.exr",
        &["other.exr", "dataWindow", "render both"],
    );
    refused(
        "@plate.exr --background @flat.exr",
        &["flat.exr", "depth", "--background-depth"],
    );
    refused(
        "@flat.exr --distance 2 --background @clean.exr",
        &["clean.exr", "one distance", "--depth"],
    );
    for (options, part) in [
        ("--background @clean.exr --only-chroma", "--only-chroma"),
        ("--background-depth @clean.exr", "--background"),
    ] {
        let line = format!("remove @plate.exr -o @x.exr {LENS} {options}");
        let outcome = seidel_in(folder, &line);
        assert_eq!(outcome.status, 2, "{options}");
        assert!(outcome.stderr.contains(part), "{}", outcome.stderr);
    }
}

/// A plate that is nowhere nearer than its background is solved at once, and a message says so.
#[test]
fn a_background_that_nothing_hides_changes_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_shot(folder);
    let line = format!("remove @clean.exr {LENS} --noise 0.002");
    succeeds(folder, &format!("{line} -o @alone.exr"));
    let outcome = succeeds(
        folder,
        &format!("{line} -o @sharp.exr --background @clean.exr"),
    );
    assert!(
        outcome.stderr.contains("nowhere nearer"),
        "{}",
        outcome.stderr
    );
    let of = |name: &str| read_channel(&folder.join(name), "Y");
    assert!(of("sharp.exr") == of("alone.exr"), "the same to the bit");
}
