//! `seidel apply` with focus controls: neutral values change nothing, each has its documented effect, and invalid ones
//! are refused.

use std::path::Path;

use crate::support::{
    must_refuse, must_refuse_options, read_channel, succeeds, write_exr, write_plate,
    write_pupil_lens,
};

fn rendered(folder: &Path, options: &str) -> Vec<f32> {
    let line = format!("apply --lens @lens.json @plate.exr -o @out.exr {options}");
    succeeds(folder, &line);
    read_channel(&folder.join("out.exr"), "G")
}

#[test]
fn neutral_controls_change_no_bit() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["R", "G", "B"]);
    write_plate(&folder.join("plate.exr"), 60, 40);
    let psf = "--psf skew-normal --lens-scale 1";
    let plain = rendered(folder, &format!("{psf} --focus-distance 2"));
    let named = format!(
        "{psf} --focus-plane 2 --depth-of-field 0 --front-multiplier 1 --back-multiplier 1 --maximum-size 500"
    );
    assert!(rendered(folder, &named) == plain);
    for options in [
        "--depth-of-field 1",
        "--front-multiplier 2",
        "--back-multiplier 0",
        "--maximum-size 1.8",
    ] {
        let line = format!("{psf} --focus-plane 2 {options}");
        assert!(rendered(folder, &line) != plain, "{options}");
    }
}

/// Second moment of a point light's image about the point, px².
fn spread(light: &[f32], width: usize) -> f64 {
    let total: f64 = light.iter().map(|v| f64::from(*v)).sum();
    let mean = |f: &dyn Fn(f64, f64) -> f64| {
        let weighed = light
            .iter()
            .enumerate()
            .map(|(k, v)| f64::from(*v) * f((k % width) as f64, (k / width) as f64));
        weighed.sum::<f64>() / total
    };
    let (x, y) = (mean(&|x, _| x), mean(&|_, y| y));
    mean(&|u, v| (u - x).powi(2) + (v - y).powi(2))
}

#[test]
fn a_point_light_has_the_blur_that_the_controls_give() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["Y"]);
    let (width, height) = (81, 61);
    let mut light = vec![0.0; width * height];
    light[30 * width + 40] = 1.0;
    write_exr(&folder.join("plate.exr"), width, height, &[("Y", light)]);
    let size = |options: &str| {
        let line = format!(
            "apply --lens @lens.json @plate.exr -o @out.exr --psf gaussian --lens-scale 1 --focus-plane 2 {options}"
        );
        succeeds(folder, &line);
        spread(&read_channel(&folder.join("out.exr"), "Y"), width)
    };
    let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-4;
    let focus = size("--distance 2");
    assert!(size("--distance 1") > 2.0 * focus);
    // Inside the range, which stays in focus.
    assert!(close(size("--distance 1.6 --depth-of-field 0.9"), focus));
    assert!(close(size("--distance 1 --front-multiplier 0"), focus));
    // 1/1.25 - 1/2 = 0.3 1/m; twice that is 1/m less half: an object at 1 / 1.1 m.
    let twice = size("--distance 1.25 --front-multiplier 2");
    assert!(close(twice, size("--distance 0.9090909090909")));
    assert!(close(
        size("--distance 5 --front-multiplier 2"),
        size("--distance 5")
    ));
    // The second moment of a round kernel is twice the variance along an axis.
    let held = size("--distance 0.5 --maximum-size 5");
    assert!(held < 2.0 * 2.5 * 2.5 * 1.001, "{held}");
    assert!(size("--distance 0.5") > 2.0 * held);
}

#[test]
fn a_maximum_below_the_blur_in_focus_is_that_of_the_focus() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["Y"]);
    write_plate(&folder.join("plate.exr"), 30, 20);
    let line = "apply --lens @lens.json @plate.exr --focus-plane 2 --psf gaussian";
    let small = succeeds(
        folder,
        &format!("{line} -o @small.exr --distance 0.5 --maximum-size 0.01"),
    );
    let warned = small.stderr.contains("everything is drawn as in focus");
    assert!(warned, "{}", small.stderr);
    succeeds(folder, &format!("{line} -o @focus.exr --distance 2"));
    let read = |name: &str| read_channel(&folder.join(name), "R");
    let pairs = read("small.exr").into_iter().zip(read("focus.exr"));
    assert!(
        pairs
            .into_iter()
            .all(|(a, b)| (a - b).abs() < 1e-3 * b + 1e-3)
    );
}

#[test]
fn invalid_values_are_refused_before_anything_is_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["Y"]);
    write_plate(&folder.join("plate.exr"), 30, 20);
    let line = "apply --lens @lens.json @plate.exr -o @no.exr --focus-plane 2";
    for (options, name) in [
        ("--depth-of-field -1", "--depth-of-field"),
        ("--front-multiplier 99", "--front-multiplier"),
        ("--back-multiplier NaN", "--back-multiplier"),
        ("--maximum-size 0", "--maximum-size"),
    ] {
        must_refuse_options(folder, &format!("{line} {options}"), &[name, "give"]);
    }
    let far = "apply --lens @lens.json @plate.exr -o @no.exr --focus-plane inf --depth-of-field 1";
    must_refuse(folder, far, &["depth of field", "infinity"]);
}
