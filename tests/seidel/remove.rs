//! `seidel remove` and `seidel relens`: the result is sharper, `apply` restores the plate, and other data are untouched.

use std::fs;
use std::path::Path;

use crate::support::{
    Outcome, listing, must_refuse, read_channel, seidel_in, succeeds, write_exr,
    write_moments_lens, write_nearly_equal_lens, write_pupil_lens,
};

const WIDTH: usize = 96;
const HEIGHT: usize = 80;
const COLOURS: [&str; 3] = ["R", "G", "B"];
/// Lens options: blur of one to two px, with corners far off the axis.
const LENS: &str = "--lens @lens.json --lens-scale 0.6 --distance 1.6";

/// Returns a pseudo-random number from -1 to 1 with mean square 1/3.
fn noise(seed: usize) -> f32 {
    let mut state = (seed as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    state = (state ^ (state >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    state ^= state >> 32;
    (state % 20_001) as f32 / 10_000.0 - 1.0
}

/// Returns an image of discs and bars on a smooth background.
fn image(shade: f32) -> Vec<f32> {
    let pixel = |k: usize| {
        let (x, y) = ((k % WIDTH) as f32, (k / WIDTH) as f32);
        let disc = |cx: f32, cy: f32, r: f32| (x - cx).hypot(y - cy) < r;
        let light = if disc(30.0, 26.0, 11.0) {
            0.9
        } else if disc(66.0, 52.0, 16.0) {
            0.15
        } else if y > 60.0 && (x as usize / 5).is_multiple_of(2) {
            0.8
        } else {
            0.4 + 0.1 * (0.07 * x).sin()
        };
        shade * light
    };
    (0..WIDTH * HEIGHT).map(pixel).collect()
}

fn sharp() -> Vec<(&'static str, Vec<f32>)> {
    let colours = COLOURS.into_iter().zip([1.0, 0.8, 0.6]);
    let mut channels: Vec<_> = colours.map(|(name, s)| (name, image(s))).collect();
    channels.push(("A", vec![1.0; WIDTH * HEIGHT]));
    channels
}

fn noisy(samples: &mut [f32], size: f32, seed: usize) {
    for (k, sample) in samples.iter_mut().enumerate() {
        *sample += size * noise(seed + k);
    }
}

/// Writes the lens, `truth.exr`, and `plate.exr`, which is the truth with the lens's blur and grain.
fn write_test_files(folder: &Path, grain: f32) {
    write_moments_lens(folder, &COLOURS);
    write_exr(&folder.join("truth.exr"), WIDTH, HEIGHT, &sharp());
    let line = format!("apply @truth.exr -o @plate.exr --quality exact {LENS}");
    succeeds(folder, &line);
    let mut channels = sharp();
    for (index, (name, samples)) in channels.iter_mut().enumerate() {
        *samples = read_channel(&folder.join("plate.exr"), name);
        if *name != "A" {
            noisy(samples, grain, 100_000 * index);
        }
    }
    // A channel that is not a colour.
    let mask = (0..WIDTH * HEIGHT).map(|k| (k % 7) as f32).collect();
    channels.push(("mask.id", mask));
    write_exr(&folder.join("plate.exr"), WIDTH, HEIGHT, &channels);
}

/// Reads a channel inside the plate's own window.
fn on_plate(path: &Path, channel: &str) -> Vec<f32> {
    let plate = seidel_image_io::formats::exr::ExrImage::open(path).expect("readable");
    let id = plate.colour(None).expect("colour").colour[0];
    let window = plate.data_window(id);
    let (left, top) = (-window.x as usize, -window.y as usize);
    let samples = read_channel(path, channel);
    let rows = samples.chunks_exact(window.width).skip(top).take(HEIGHT);
    rows.flat_map(|row| &row[left..left + WIDTH])
        .copied()
        .collect()
}

fn decibels(a: &[f32], b: &[f32]) -> f64 {
    assert_eq!(a.len(), b.len());
    let squares = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2));
    -10.0 * (squares.sum::<f64>() / a.len() as f64).log10()
}

fn removed(folder: &Path, output: &str, options: &str) -> Outcome {
    let line = format!("remove @plate.exr -o @{output} {LENS} {options}");
    succeeds(folder, &line)
}

#[test]
fn plates_become_sharper_and_can_be_restored_up_to_their_edges() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_test_files(folder, 0.004);
    let outcome = removed(folder, "sharp.exr", "--grain solved");
    assert!(
        outcome
            .stderr
            .contains("noise, estimated from the plate: R "),
        "{}",
        outcome.stderr
    );
    removed(folder, "cropped.exr", "--grain solved --no-overscan");
    removed(folder, "grainy.exr", "");
    for (channel, (_, truth)) in COLOURS.iter().zip(sharp()) {
        let of = |name: &str| on_plate(&folder.join(name), channel);
        let before = decibels(&of("plate.exr"), &truth);
        let after = decibels(&of("sharp.exr"), &truth);
        let grainy = decibels(&of("grainy.exr"), &truth);
        assert!(after > before + 3.0, "{channel}: {before} {after}");
        assert!(grainy > before + 2.0, "{channel}: {before} {grainy}");
        assert_eq!(of("cropped.exr"), of("sharp.exr"));
        assert_ne!(of("grainy.exr"), of("sharp.exr"));
    }
    // Channels that are not colours are untouched.
    let mask = |name: &str| on_plate(&folder.join(name), "mask.id");
    assert_eq!(mask("sharp.exr"), mask("plate.exr"));
    let border = |samples: &[f32]| -> Vec<f32> {
        let inner = |k: usize| {
            (8..WIDTH - 8).contains(&(k % WIDTH)) && (8..HEIGHT - 8).contains(&(k / WIDTH))
        };
        let outer = (0..samples.len()).filter(|k| !inner(*k));
        outer.map(|k| samples[k]).collect()
    };
    let (mut back, mut at_border) = (Vec::new(), Vec::new());
    for name in ["sharp", "cropped"] {
        let line = format!("apply @{name}.exr -o @{name}-back.exr {LENS}");
        succeeds(folder, &line);
        let seen = on_plate(&folder.join(format!("{name}-back.exr")), "G");
        let plate = on_plate(&folder.join("plate.exr"), "G");
        back.push(decibels(&seen, &plate));
        at_border.push(decibels(&border(&seen), &border(&plate)));
    }
    // Accurate to the grain, 53 dB, where light from outside the plate is known as well.
    assert!(back[0] > 51.0 && back[0] > back[1], "{back:?}");
    assert!(
        at_border[0] > 51.0 && at_border[0] > at_border[1] + 1.5,
        "{at_border:?}"
    );
}

#[test]
fn zero_strength_leaves_the_plate_bit_identical() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_test_files(folder, 0.004);
    let blue = |name: &str| on_plate(&folder.join(name), "B");
    for options in ["--strength 0", "--amount 0"] {
        removed(folder, "same.exr", options);
        for channel in ["R", "G", "B", "A", "mask.id"] {
            let of = |name: &str| read_channel(&folder.join(name), channel);
            assert_eq!(of("same.exr"), of("plate.exr"), "{options} {channel}");
        }
    }
    // Strength 0.5 is the mean of plate and result.
    removed(folder, "sharp.exr", "");
    removed(folder, "half.exr", "--strength 0.5");
    let ends = blue("plate.exr").into_iter().zip(blue("sharp.exr"));
    for ((before, after), mean) in ends.zip(blue("half.exr")) {
        assert!((0.5 * (before + after) - mean).abs() < 1e-6);
    }
}

/// Alpha is deblurred and stays between 0 and 1; clipped samples are reported.
#[test]
fn alpha_and_clipped_light() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_test_files(folder, 0.002);
    let covered: Vec<f32> = (0..WIDTH * HEIGHT)
        .map(|k| f32::from(u8::from((24..70).contains(&(k % WIDTH)))))
        .collect();
    let light = |shade: f32| covered.iter().map(|a| 3.0 * shade * a).collect::<Vec<_>>();
    let channels = [
        ("R", light(1.0)),
        ("G", light(0.5)),
        ("B", light(0.2)),
        ("A", covered.clone()),
    ];
    write_exr(&folder.join("truth.exr"), WIDTH, HEIGHT, &channels);
    succeeds(
        folder,
        &format!("apply @truth.exr -o @plate.exr {LENS} --edges mirror"),
    );
    let outcome = removed(folder, "sharp.exr", "--noise 0.001,0.002,0.003 --clip 2.5");
    assert!(
        outcome
            .stderr
            .contains("as given: R 1.000e-3, G 2.000e-3, B 3.000e-3"),
        "{}",
        outcome.stderr
    );
    assert!(
        outcome.stderr.contains("clipped: R ")
            && outcome.stderr.contains("from 2.5000 up")
            && outcome
                .stderr
                .contains("% of the picture keeps its blur: clipped samples "),
        "{}",
        outcome.stderr
    );
    let alpha = on_plate(&folder.join("sharp.exr"), "A");
    assert!(alpha.iter().all(|a| (0.0..=1.0).contains(a)));
    let before = on_plate(&folder.join("plate.exr"), "A");
    let (before, after) = (decibels(&before, &covered), decibels(&alpha, &covered));
    assert!(after > before + 1.0, "{before} {after}");
    let outcome = removed(folder, "open.exr", "--clip none");
    assert!(!outcome.stderr.contains("clipped"), "{}", outcome.stderr);
}

/// Maps have the plate's window and channels, whatever the window of the result.
#[test]
fn maps_have_confidence_and_noise_gain() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_test_files(folder, 0.004);
    let maps = "--confidence @c.exr --noise-gain @n.exr";
    removed(folder, "sharp.exr", maps);
    for channel in COLOURS {
        let seen = read_channel(&folder.join("c.exr"), channel);
        assert_eq!(seen.len(), WIDTH * HEIGHT);
        assert!(seen.iter().all(|v| (0.0..=1.0).contains(v)));
        let mean = seen.iter().sum::<f32>() / seen.len() as f32;
        assert!(mean > 0.02 && mean < 0.98, "{mean}");
        let gain = read_channel(&folder.join("n.exr"), channel);
        assert_eq!(gain.len(), WIDTH * HEIGHT);
        assert!(gain.iter().all(|v| v.is_finite() && *v >= 0.0));
        assert!(gain.iter().any(|v| *v > 0.0));
    }
    removed(folder, "same.exr", &format!("--strength 0 {maps}"));
    for name in ["c.exr", "n.exr"] {
        let ones = read_channel(&folder.join(name), "G");
        assert_eq!(ones, vec![1.0; WIDTH * HEIGHT]);
    }
}

/// The colours of the sharp image differ by a factor only, so that fringes are what else differs on the plate.
#[test]
fn only_chroma_takes_fringes_off_and_does_not_sharpen() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_test_files(folder, 0.001);
    removed(folder, "clean.exr", "--only-chroma");
    let of = |name: &str, channel: &str, shade: f32| -> Vec<f32> {
        let samples = on_plate(&folder.join(name), channel);
        samples.iter().map(|v| v / shade).collect()
    };
    // Light from beyond the edges is unknown: there fringes stay.
    let border = 12;
    let inner = |samples: Vec<f32>| -> Vec<f32> {
        let rows = samples.chunks_exact(WIDTH).take(HEIGHT - border);
        let rows = rows.skip(border);
        rows.flat_map(|row| row[border..WIDTH - border].to_vec())
            .collect()
    };
    let apart = |name: &str| decibels(&inner(of(name, "R", 1.0)), &inner(of(name, "B", 0.6)));
    let (before, after) = (apart("plate.exr"), apart("clean.exr"));
    assert!(after > before + 10.0, "{before} {after}");
    assert_eq!(of("clean.exr", "G", 0.8), of("plate.exr", "G", 0.8));
    let line = format!("remove @plate.exr -o @x.exr {LENS} --only-chroma --residual @r.exr");
    let outcome = seidel_in(folder, &line);
    assert_eq!(outcome.status, 2);
    assert!(
        outcome.stderr.contains("--only-chroma"),
        "{}",
        outcome.stderr
    );
}

/// No image is this sharp after the lens's blur.
#[test]
fn a_lens_that_does_not_explain_the_plate_is_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_test_files(folder, 0.004);
    let warning = "the lens does not explain the plate";
    let outcome = removed(folder, "sharp.exr", "--clip none");
    assert!(!outcome.stderr.contains(warning), "{}", outcome.stderr);
    let line = format!("remove @truth.exr -o @sharp.exr --clip none --noise 0.002 {LENS}");
    let outcome = succeeds(folder, &line);
    assert!(
        outcome.stderr.contains(warning) && outcome.stderr.contains("check the profile"),
        "{}",
        outcome.stderr
    );
}

/// Integer plates keep their type and size.
#[test]
fn png_plates_are_cropped() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &COLOURS);
    let truth = image(1.0);
    let code = |k: usize| (255.0 * truth[k]) as u8;
    let rgb = image::RgbImage::from_fn(WIDTH as u32, HEIGHT as u32, |x, y| {
        image::Rgb([code(y as usize * WIDTH + x as usize); 3])
    });
    rgb.save(folder.join("truth.png")).expect("writable");
    succeeds(folder, &format!("apply @truth.png -o @plate.png {LENS}"));
    let line =
        format!("remove @plate.png -o @sharp.png --grain solved --clip none --noise 0.0012 {LENS}");
    let message = succeeds(folder, &line);
    let of = |name: &str| -> Vec<f32> {
        let picture = image::open(folder.join(name)).expect("readable").to_rgb8();
        assert_eq!(picture.dimensions(), (WIDTH as u32, HEIGHT as u32));
        picture
            .pixels()
            .map(|p| f32::from(p.0[1]) / 255.0)
            .collect()
    };
    let truth = of("truth.png");
    let (before, after) = (
        decibels(&of("plate.png"), &truth),
        decibels(&of("sharp.png"), &truth),
    );
    assert!(after > before + 4.0, "{before} {after} {}", message.stderr);
}

/// Depth passes and mattes are extended with the overscan.
#[test]
fn depth_is_extended_beyond_the_plate() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_test_files(folder, 0.002);
    let depth = (0..WIDTH * HEIGHT).map(|k| if k % WIDTH < 50 { 1.3 } else { 4.0 });
    let depth: Vec<f32> = depth.collect();
    write_exr(
        &folder.join("z.exr"),
        WIDTH,
        HEIGHT,
        &[("Z", depth.clone())],
    );
    write_exr(
        &folder.join("matte.exr"),
        WIDTH,
        HEIGHT,
        &[("A", vec![0.0; WIDTH * HEIGHT])],
    );
    let z = folder.join("z.exr");
    let sight = format!("--lens @lens.json --lens-scale 0.6 --depth {}", z.display());
    let line = format!("apply @truth.exr -o @plate.exr --quality exact {sight}");
    succeeds(folder, &line);
    let line = format!("remove @plate.exr -o @sharp.exr --noise 0.003 --clip none {sight}");
    let outcome = succeeds(folder, &line);
    assert!(
        outcome.stderr.contains("spans 1.3000 m"),
        "{}",
        outcome.stderr
    );
    let truth = on_plate(&folder.join("truth.exr"), "R");
    let of = |name: &str| decibels(&on_plate(&folder.join(name), "R"), &truth);
    assert!(
        of("sharp.exr") > of("plate.exr") + 1.5,
        "{} {}",
        of("plate.exr"),
        of("sharp.exr")
    );
    let holdout = folder.join("matte.exr");
    let line = format!(
        "apply @sharp.exr -o @back.exr --holdout {} {sight}",
        holdout.display()
    );
    let outcome = succeeds(folder, &line);
    let message = outcome
        .stderr
        .matches("extended by its edge pixels")
        .count();
    assert_eq!(message, 2, "{}", outcome.stderr);
    let back = on_plate(&folder.join("back.exr"), "R");
    let db = decibels(&back, &on_plate(&folder.join("plate.exr"), "R"));
    assert!(db > 35.0, "{db}");
}

#[test]
fn sequences_resume_and_failed_frames_do_not_stop_others() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["Y"]);
    write_nearly_equal_lens(folder, "lens.json", "other.json");
    for frame in 1..=3 {
        let light = image(0.2 * frame as f32)[..48 * 40].to_vec();
        let path = folder.join(format!("plate.{frame:04}.exr"));
        write_exr(&path, 48, 40, &[("Y", light)]);
    }
    fs::write(folder.join("plate.0002.exr"), "no picture").expect("writable");
    for command in [
        "remove --lens @lens.json",
        "relens --from @lens.json --to @other.json",
    ] {
        let line = format!(
            "{command} @plate.%04d.exr -o @out.%04d.exr --frames 1-3 --distance 2 --lens-scale 0.5"
        );
        let before = listing(folder).len();
        let outcome = seidel_in(folder, &line);
        assert_eq!(outcome.status, 1, "{}", outcome.stderr);
        assert_eq!(outcome.stdout.matches("wrote").count(), 2);
        assert!(
            outcome.stderr.contains("frame 1: noise"),
            "{}",
            outcome.stderr
        );
        let (_, end) = outcome
            .stderr
            .split_once("1 of 3 frames failed:")
            .expect("a list at the end");
        assert!(
            end.contains("frame 2: ") && end.contains("plate.0002.exr"),
            "{end}"
        );
        assert_eq!(listing(folder).len(), before + 2, "nothing half-written");
        // The order of chunks depends on threads, so files may differ and samples may not.
        let first = read_channel(&folder.join("out.0001.exr"), "Y");
        let again = seidel_in(folder, &format!("{line} --skip-existing"));
        assert!(
            again.stderr.contains("2 of 3 frames are finished and kept"),
            "{}",
            again.stderr
        );
        seidel_in(folder, &format!("{line} --memory 1 --threads 1"));
        let anew = read_channel(&folder.join("out.0001.exr"), "Y");
        assert!(
            anew == first,
            "the same to the bit for any number of threads"
        );
        for frame in [1, 3] {
            fs::remove_file(folder.join(format!("out.{frame:04}.exr"))).expect("removable");
        }
    }
}

#[test]
fn bad_input_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_test_files(folder, 0.004);
    for bad in ["--noise -1", "--noise much", "--clip low", "--strength 2"] {
        let outcome = seidel_in(folder, &format!("remove @plate.exr -o @x.exr {LENS} {bad}"));
        assert_eq!(outcome.status, 2, "{bad}");
        assert!(outcome.stderr.contains("give"), "{bad}: {}", outcome.stderr);
    }
    let line = format!("remove @plate.exr -o @x.exr {LENS} --noise 0.1,0.2");
    must_refuse(
        folder,
        &line,
        &["plate.exr", "--noise", "2 values", "3 colours"],
    );
    must_refuse(
        folder,
        "remove @plate.exr -o @x.exr --lens @no.json --distance 1",
        &["no.json"],
    );
    must_refuse(
        folder,
        "relens @plate.exr -o @x.exr --from @lens.json --to @no.json --distance 1",
        &["no.json"],
    );
    must_refuse(
        folder,
        &format!("remove @plate.exr -o @plate.exr {LENS}"),
        &["would be overwritten"],
    );
}

/// The result is nearer to the second lens's image of the truth than the plate is.
#[test]
fn a_plate_gets_the_blur_of_another_lens() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_test_files(folder, 0.002);
    fs::rename(folder.join("lens.json"), folder.join("from.json")).expect("movable");
    write_pupil_lens(folder, &COLOURS);
    let sight = "--lens-scale 0.6 --distance 1.6";
    let line = format!("apply @truth.exr -o @want.exr --lens @lens.json {sight} --edges extend");
    succeeds(folder, &line);
    let line = format!("relens @plate.exr -o @got.exr --from @from.json --to @lens.json {sight}");
    let outcome = succeeds(folder, &line);
    assert!(
        outcome.stderr.contains("noise, estimated"),
        "{}",
        outcome.stderr
    );
    for channel in COLOURS {
        let of = |name: &str| read_channel(&folder.join(name), channel);
        let want = of("want.exr");
        let (before, after) = (
            decibels(&of("plate.exr"), &want),
            decibels(&of("got.exr"), &want),
        );
        assert!(
            after > before + 1.5,
            "{channel}: {before} {after} {}",
            outcome.stderr
        );
    }
    let of = |name: &str| read_channel(&folder.join(name), "mask.id");
    assert_eq!(of("got.exr"), of("plate.exr"));
}
