//! `seidel apply --verbose`: the methods used for a frame, and its error against the exact renderer.

use std::path::Path;

use crate::support::{read_channel, succeeds, write_exr, write_moments_lens};

const WIDTH: usize = 120;
const HEIGHT: usize = 80;

fn colours(path: &Path) -> Vec<f32> {
    ["R", "G", "B"]
        .iter()
        .flat_map(|name| read_channel(path, name))
        .collect()
}

/// Writes a plate full of edges and grain, on a plane from 1 m to 5 m.
fn write_busy(path: &Path) {
    let plane = |of: &dyn Fn(usize, usize) -> f32| -> Vec<f32> {
        (0..WIDTH * HEIGHT)
            .map(|k| of(k % WIDTH, k / WIDTH))
            .collect()
    };
    let colour = |shade: f32| {
        plane(&move |x, y| {
            let grain = ((x * 7919 + y * 104_729) % 101) as f32 / 101.0;
            let checks = ((x / 11 + y / 7) % 2) as f32;
            shade * (grain + checks)
        })
    };
    let channels = [
        ("R", colour(1.0)),
        ("G", colour(0.8)),
        ("B", colour(0.5)),
        ("A", plane(&|_, _| 1.0)),
        (
            "Z",
            plane(&|_, y| 1.0 / (1.0 - 0.8 * y as f32 / HEIGHT as f32)),
        ),
    ];
    write_exr(path, WIDTH, HEIGHT, &channels);
}

/// Returns the figure in dB of a message.
fn decibels(message: &str) -> f64 {
    let after = message.split("PSNR ").nth(1).expect("an estimate");
    let number = after.split(' ').next().expect("a number");
    number.parse().expect("a number")
}

#[test]
fn the_reported_error_is_that_of_the_plate() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["R", "G", "B"]);
    write_busy(&folder.join("plate.exr"));
    let peak = colours(&folder.join("plate.exr"))
        .into_iter()
        .fold(0.0, f32::max);
    let mut worst = 0.0_f64;
    let blurred = |options: &str| {
        let line = format!("apply --lens @lens.json @plate.exr -o @out.exr {options}");
        let outcome = succeeds(folder, &line);
        (colours(&folder.join("out.exr")), outcome.stderr)
    };
    for (options, says) in [
        ("--distance 0.9", "one distance"),
        ("--distance 0.9 --edges extend", "one distance"),
        (
            "--distance 0.9 --edges black --pixel-aspect 2",
            "one distance",
        ),
        ("", "slices of depth with occlusion in "),
        ("--edges black", "slices of depth with occlusion in "),
    ] {
        let (exact, words) = blurred(&format!("{options} --quality exact --verbose"));
        assert!(
            words.contains("rendered by scatter, quality exact"),
            "{words}"
        );
        assert!(
            words.contains("nothing to estimate") && words.contains(says),
            "{words}"
        );
        for quality in ["final", "draft"] {
            let (fast, words) = blurred(&format!("{options} --quality {quality} --verbose"));
            let heading = format!("rendered by gather, quality {quality}, psf skew-normal, edges ");
            for part in [
                heading.as_str(),
                says,
                "level 0 (1/1 resolution): ",
                "small lights",
            ] {
                assert!(words.contains(part), "`{part}` in {words}");
            }
            let squares = fast
                .iter()
                .zip(&exact)
                .map(|(a, b)| f64::from(a - b).powi(2));
            let mean = squares.sum::<f64>() / fast.len() as f64;
            let truth = 10.0 * (f64::from(peak).powi(2) / mean).log10();
            let reported = decibels(&words);
            worst = worst.max((reported - truth).abs());
            // --verbose changes no sample, and without it nothing is printed.
            let (same, unasked) = blurred(&format!("{options} --quality {quality}"));
            assert_eq!(fast, same);
            assert!(!unasked.contains("rendered by"), "{unasked}");
        }
    }
    assert!(worst < 3.0, "{worst} dB");
    let (_, words) = blurred("--occlusion off --verbose");
    assert!(
        words.contains("every pixel at its distance, no occlusion"),
        "{words}"
    );
    let (_, words) = blurred("--amount 0 --verbose");
    assert!(words.contains("the plate stays as it is"), "{words}");
}
