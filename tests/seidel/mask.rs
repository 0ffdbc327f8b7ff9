//! `seidel apply` with a mask, a mix, and a pixel to focus on.

use std::path::Path;

use crate::support::{
    must_refuse, must_refuse_options, read_channel, seidel_in, succeeds, write_exr,
    write_pupil_lens,
};

const WIDTH: usize = 48;
const HEIGHT: usize = 32;

/// A plate of two surfaces, at 2 m on the left and 4 m on the right, and a mask that is 0, 1/2 and 1 from top to bottom.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    write_pupil_lens(folder.path(), &["R", "G", "B"]);
    let plane = |of: &dyn Fn(usize, usize) -> f32| -> Vec<f32> {
        (0..WIDTH * HEIGHT)
            .map(|k| of(k % WIDTH, k / WIDTH))
            .collect()
    };
    let colour = |shade: f32| plane(&|x, y| shade * (0.2 + 0.6 * ((x / 5 + y / 4) % 2) as f32));
    let depth = plane(&|x, _| if x < WIDTH / 2 { 2.0 } else { 4.0 });
    let channels = [
        ("R", colour(1.0)),
        ("G", colour(0.7)),
        ("B", colour(0.4)),
        ("Z", depth),
    ];
    write_exr(&folder.path().join("plate.exr"), WIDTH, HEIGHT, &channels);
    let mask = plane(&|_, y| [0.0, 0.5, 1.0][(3 * y / HEIGHT).min(2)]);
    write_exr(
        &folder.path().join("mask.exr"),
        WIDTH,
        HEIGHT,
        &[("A", mask)],
    );
    folder
}

fn green(folder: &Path, options: &str) -> Vec<f32> {
    succeeds(
        folder,
        &format!("apply --lens @lens.json @plate.exr -o @out.exr {options}"),
    );
    read_channel(&folder.join("out.exr"), "G")
}

#[test]
fn masked_pixels_keep_the_plate() {
    let folder = folder();
    let folder = folder.path();
    let plate = read_channel(&folder.join("plate.exr"), "G");
    let mask = read_channel(&folder.join("mask.exr"), "A");
    let blurred = green(folder, "");
    let options = ["--invert-mask", "", "--mix 0.5"];
    let [inverted, masked, mixed] =
        options.map(|option| green(folder, &format!("--mask @mask.exr {option}")));
    assert!(plate != blurred);
    let info = succeeds(folder, "info @out.exr").stdout;
    for words in [
        "mask: mask.exr",
        "mix: 0.5",
        "depth-kind and unit: distance, 1 m a unit",
    ] {
        assert!(info.contains(words), "{words}: {info}");
    }
    for k in 0..plate.len() {
        let between = |weight: f32| plate[k] + weight * (blurred[k] - plate[k]);
        assert!((masked[k] - between(mask[k])).abs() < 1e-6, "{k}");
        assert!((inverted[k] - between(1.0 - mask[k])).abs() < 1e-6, "{k}");
        assert!((mixed[k] - between(0.5 * mask[k])).abs() < 1e-6, "{k}");
    }
    let line = "apply --lens @lens.json @plate.exr -o @out2.exr --mask @plate.exr:Z";
    must_refuse(folder, line, &["plate.exr", "mask, pixel (0, 0)", "is 2"]);
}

#[test]
fn the_lens_is_focused_on_the_pixel() {
    let folder = folder();
    let folder = folder.path();
    for (at, metres) in [("4,9", 2), ("40.5,9", 4)] {
        let picked = green(folder, &format!("--focus-at {at}"));
        assert!(
            picked == green(folder, &format!("--focus-distance {metres}")),
            "{at}"
        );
    }
    // A table follows an object.
    std::fs::copy(folder.join("plate.exr"), folder.join("plate.7.exr")).expect("writable");
    std::fs::write(
        folder.join("track.csv"),
        "frame,focus-at.x,focus-at.y\n6,4,9\n8,76,9\n",
    )
    .expect("writable");
    let line =
        "apply --lens @lens.json @plate.%d.exr -o @out.%d.exr --frames 7 --animate @track.csv";
    let printed = succeeds(folder, line).stderr;
    assert!(printed.contains("focused at 4.000 m"), "{printed}");
    assert!(read_channel(&folder.join("out.7.exr"), "G") == green(folder, "--focus-distance 4"));
    let line = "apply --lens @lens.json @plate.exr -o @no.exr --focus-at";
    must_refuse(
        folder,
        &format!("{line} 48,9"),
        &["plate.exr", "--focus-at 48,9", "48x32"],
    );
    let both = seidel_in(folder, &format!("{line} 4,9 --focus-distance 2"));
    assert_eq!(both.status, 2, "{}", both.stderr);
}

#[test]
fn circles_of_confusion_and_focus_are_written_as_numbers() {
    let folder = folder();
    let folder = folder.path();
    let coc = green(folder, "--show coc-px --focus-distance 3 --amount 8");
    let (left, right) = (coc[9 * WIDTH + 4], coc[9 * WIDTH + 40]);
    assert!(left < -1.0 && right > 1.0, "{left} {right}");
    let matte = green(
        folder,
        "--show focus-matte --focus-distance 2 --amount 8 --focus-tolerance 0.5",
    );
    assert!(matte[9 * WIDTH + 4] == 1.0 && matte[9 * WIDTH + 40] == 0.0);
    let wide = green(
        folder,
        "--show focus-matte --focus-distance 2 --amount 8 --focus-tolerance 500",
    );
    assert!(wide.iter().all(|sample| *sample == 1.0));
    let line = "apply --lens @lens.json @plate.exr -o @no.png --show coc-px";
    must_refuse_options(folder, line, &["--show coc-px", ".exr"]);
}
