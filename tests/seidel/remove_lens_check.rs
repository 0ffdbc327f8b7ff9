//! `--lens-check`: from a plate with less blur than its lens, only that blur is removed, with a warning.

use std::fs;
use std::path::Path;

use crate::support::{
    Outcome, read_channel, seidel_in, succeeds, write_exr, write_moments_lens,
    write_nearly_equal_lens,
};

const WIDTH: usize = 200;
const HEIGHT: usize = 170;
/// Lens options: blur of two to four px.
const LENS: &str = "--lens @lens.json --lens-scale 1 --distance 1.6 --no-overscan";

/// A generator of pseudo-random numbers from 0 to 1.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f32 {
        self.0 = (self.0)
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (self.0 >> 40) as f32 / (1_u64 << 24) as f32
    }
}

/// Returns an image of overlapping discs and bars on a smooth background, some with fine texture.
fn image(seed: u64) -> Vec<f32> {
    let mut chance = Chance(seed);
    let things: Vec<[f32; 6]> = (0..90)
        .map(|_| {
            let size = 2.0 + 20.0 * chance.next().powi(3);
            let slim = if chance.next() < 0.5 { 1.0 } else { 0.25 };
            [
                WIDTH as f32 * chance.next(),
                HEIGHT as f32 * chance.next(),
                size,
                size * slim,
                0.05 + 0.85 * chance.next(),
                0.1 * (chance.next() - 0.5).max(0.0),
            ]
        })
        .collect();
    let pixel = |k: usize| {
        let (x, y) = ((k % WIDTH) as f32, (k / WIDTH) as f32);
        let texture = chance.next() - 0.5;
        let inside = |t: &&[f32; 6]| ((x - t[0]) / t[2]).hypot((y - t[1]) / t[3]) < 1.0;
        let thing = things.iter().find(inside);
        thing.map_or(0.4 + 0.1 * (0.05 * x).sin(), |t| t[4] + t[5] * texture)
    };
    (0..WIDTH * HEIGHT).map(pixel).collect()
}

/// Writes `truth.exr` and `plate`, which is the truth blurred by the lens at `amount` and with noise.
pub(crate) fn write_plate(folder: &Path, plate: &str, channels: &[&str], amount: f64) {
    let (truth, plate) = (folder.join("truth.exr"), folder.join(plate));
    let planes = |of: &dyn Fn(u64, &str) -> Vec<f32>| {
        let named = channels.iter().zip(1..);
        named
            .map(|(name, seed)| (*name, of(seed, name)))
            .collect::<Vec<_>>()
    };
    write_exr(&truth, WIDTH, HEIGHT, &planes(&|seed, _| image(seed)));
    let line = format!(
        "apply @truth.exr -o @seen.exr --quality exact --lens @lens.json --lens-scale 1 --distance 1.6 --amount {amount}"
    );
    succeeds(folder, &line);
    let noisy = planes(&|seed, name| {
        let mut chance = Chance(1000 + seed);
        let mut seen = read_channel(&folder.join("seen.exr"), name);
        for sample in &mut seen {
            let sum: f32 = (0..4).map(|_| chance.next() - 0.5).sum();
            *sample += 0.004 * sum;
        }
        seen
    });
    write_exr(&plate, WIDTH, HEIGHT, &noisy);
}

fn removed(folder: &Path, output: &str, options: &str) -> Outcome {
    let line = format!("remove @plate.exr -o @{output} {LENS} {options}");
    succeeds(folder, &line)
}

fn root_mean_square(folder: &Path, file: &str, channel: &str) -> f64 {
    let of = |name: &str| read_channel(&folder.join(name), channel);
    let (is, ought) = (of(file), of("truth.exr"));
    assert_eq!(is.len(), ought.len());
    let squares = is.iter().zip(&ought).map(|(a, b)| f64::from(a - b).powi(2));
    (squares.sum::<f64>() / is.len() as f64).sqrt()
}

/// The amount that a message states.
fn amount_in(words: &str) -> f64 {
    let (_, after) = words.split_once("--amount ").expect("an amount");
    let number = after.split([',', ' ', ';']).next().expect("a number");
    number.parse().expect("a number")
}

/// A phrase of the check's messages alone.
const PHRASE: &str = "of the lens's blur";

#[test]
fn a_plate_with_less_blur_than_the_lens_does_not_ring() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    for (channels, noise) in [
        (["Y"].as_slice(), ""),
        (&["R", "G", "B"], "--noise 0.002,0.003,0.002"),
    ] {
        write_moments_lens(folder, channels);
        write_plate(folder, "plate.exr", channels, 0.7);
        let message = removed(folder, "less.exr", &format!("--grain solved {noise}")).stderr;
        let off = format!("--grain solved {noise} --lens-check off");
        assert!(!removed(folder, "all.exr", &off).stderr.contains(PHRASE));
        assert!(
            message.contains("of the lens's blur: removed that much; put it back with --amount 0."),
            "{message}"
        );
        let amount = amount_in(&message);
        assert!((0.63..0.77).contains(&amount), "{message}");
        for channel in channels {
            let of = |file: &str| root_mean_square(folder, file, channel);
            let (plate, less, all) = (of("plate.exr"), of("less.exr"), of("all.exr"));
            assert!(
                less < 0.5 * all && less < 0.8 * plate,
                "{channel}: {plate} {less} {all}"
            );
        }
    }
}

#[test]
fn the_right_lens_is_not_adjusted_and_smaller_amounts_are_kept() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["Y"]);
    write_plate(folder, "plate.exr", &["Y"], 1.0);
    let message = removed(folder, "checked.exr", "").stderr;
    assert!(!message.contains(PHRASE), "{message}");
    removed(folder, "off.exr", "--lens-check off");
    let of = |name: &str| read_channel(&folder.join(name), "Y");
    assert!(of("checked.exr") == of("off.exr"));
    write_plate(folder, "plate.exr", &["Y"], 0.7);
    for options in ["--amount 0", "--strength 0"] {
        let message = removed(folder, "same.exr", options).stderr;
        assert!(!message.contains(PHRASE), "{message}");
        assert!(of("same.exr") == of("plate.exr"));
    }
    let outcome = seidel_in(
        folder,
        &format!("remove @plate.exr -o @x.exr {LENS} --lens-check maybe"),
    );
    assert_eq!(outcome.status, 2);
    assert!(
        outcome.stderr.contains("adjust, warn, off"),
        "{}",
        outcome.stderr
    );
}

/// The check never removes more than the lens's blur.
#[test]
fn warnings_change_nothing_and_no_more_is_removed_than_the_lens_has() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["Y"]);
    let of = |name: &str| read_channel(&folder.join(name), "Y");
    let adjust: (&str, &str) = ("", "removed no more than the lens's");
    let warn = ("--lens-check warn", "removed no more than the lens's");
    let rings = ("--lens-check warn", "which may ring");
    for (blur, least, cases) in [(1.4, 1.2, [adjust, warn].as_slice()), (0.7, 0.6, &[rings])] {
        write_plate(folder, "plate.exr", &["Y"], blur);
        removed(folder, "off.exr", "--lens-check off");
        for (options, words) in cases {
            let message = removed(folder, "report.exr", options).stderr;
            assert!(
                message.contains(PHRASE) && message.contains(words),
                "{message}"
            );
            let amount = amount_in(&message);
            assert!((least..least + 0.35).contains(&amount), "{message}");
            assert!(of("report.exr") == of("off.exr"), "{options}");
        }
    }
}

/// The first frame decides for all, whatever the others show. Amounts of a table are multiplied by its result.
#[test]
fn the_first_frame_decides_for_all() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["Y"]);
    for (frame, amount) in [(7, 0.7), (8, 1.0), (9, 0.7)] {
        write_plate(folder, &format!("plate.{frame}.exr"), &["Y"], amount);
    }
    fs::write(folder.join("table.csv"), "frame,amount\n7,1\n8,0.9\n9,1\n").expect("writable");
    let of = |name: &str| read_channel(&folder.join(name), "Y");
    let alone = |frame: u32, amount: f64| {
        let line = format!(
            "remove @plate.{frame}.exr -o @alone.exr {LENS} --lens-check off --amount {amount}"
        );
        succeeds(folder, &line);
        of("alone.exr")
    };
    let run = |options: &str| {
        let line = format!("remove @plate.%d.exr -o @out.%d.exr {LENS} {options}");
        succeeds(folder, &line).stderr
    };
    let message = run("--frames 7-8 --animate @table.csv");
    let first = "frame 7: the plate shows about ";
    assert!(
        message.contains(first) && message.contains("removed that much from all frames"),
        "{message}"
    );
    let (_, times) = message
        .split_once("with the amounts of --animate times ")
        .expect("a factor");
    let share: f64 = (times.split(',').next().expect("a number"))
        .parse()
        .expect("a number");
    assert!((0.63..0.77).contains(&share), "{message}");
    let second = format!(
        "frame 8: removed {:.0} % of the lens's blur, as frame 7 shows it",
        100.0 * share
    );
    assert!(message.contains(&second), "{message}");
    let tenths = (1e4 * 0.9 * share).round() / 1e4;
    assert!(of("out.7.exr") == alone(7, share));
    assert!(of("out.8.exr") == alone(8, tenths));
    let message = run("--frames 8-9 --memory 1 --threads 1");
    assert!(!message.contains(PHRASE), "{message}");
    assert!(of("out.9.exr") == alone(9, 1.0));
}

#[test]
fn the_reported_amount_restores_the_plate() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["Y"]);
    write_plate(folder, "plate.exr", &["Y"], 0.6);
    let sight = "--lens @lens.json --lens-scale 1 --distance 1.6";
    let line = format!("remove @plate.exr -o @sharp.exr --residual @rest.exr {sight} --amount 0.9");
    let message = succeeds(folder, &line).stderr;
    assert!(
        message.contains("of the lens's blur at --amount 0.9: "),
        "{message}"
    );
    let (_, report) = message.split_once("put it back with ").expect("how");
    let amount = amount_in(report);
    assert!((0.52..0.68).contains(&amount), "{message}");
    let back = |amount: f64| {
        let line =
            format!("apply @sharp.exr -o @back.exr --residual @rest.exr {sight} --amount {amount}");
        let message = succeeds(folder, &line).stderr;
        let of = |name: &str| read_channel(&folder.join(name), "Y");
        let apart = of("back.exr").into_iter().zip(of("plate.exr"));
        let farthest = apart.fold(0.0, |most: f32, (a, b)| most.max((a - b).abs()));
        (farthest, message)
    };
    let (farthest, message) = back(amount);
    assert!(
        farthest < 1e-6 && !message.contains("other settings"),
        "{farthest} {message}"
    );
    let (farthest, message) = back(0.9);
    assert!(
        farthest > 1e-3 && message.contains(&format!("amount was {amount}, is 0.9")),
        "{farthest} {message}"
    );
}

#[test]
fn the_target_lens_of_relens_is_not_adjusted() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["Y"]);
    write_plate(folder, "plate.exr", &["Y"], 0.7);
    // A lens of the same design: the images differ only by the error of the removal.
    write_nearly_equal_lens(folder, "lens.json", "from.json");
    let sight = "--lens-scale 1 --distance 1.6";
    let line = format!("apply @truth.exr -o @want.exr --lens @lens.json {sight} --edges extend");
    succeeds(folder, &line);
    fs::rename(folder.join("want.exr"), folder.join("truth.exr")).expect("movable");
    let relens = |output: &str, options: &str| {
        let line = format!(
            "relens @plate.exr -o @{output} --from @from.json --to @lens.json {sight} {options}"
        );
        succeeds(folder, &line).stderr
    };
    let message = relens("less.exr", "");
    assert!(
        message.contains("of the lens's blur: removed that much; use --lens-check off"),
        "{message}"
    );
    let message = relens("all.exr", "--lens-check warn");
    assert!(
        message.contains("which may ring; check its profile"),
        "{message}"
    );
    let all = read_channel(&folder.join("all.exr"), "Y");
    let message = relens("all.exr", "--lens-check off");
    assert!(all == read_channel(&folder.join("all.exr"), "Y"));
    assert!(!message.contains(PHRASE), "{message}");
    let of = |file: &str| root_mean_square(folder, file, "Y");
    let (less, all) = (of("less.exr"), of("all.exr"));
    assert!(less < 0.5 * all, "{less} {all}");
}

#[test]
fn the_c_abi_returns_the_share_that_the_command_uses() {
    use seidel_c::*;
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let channels = ["R", "G", "B"];
    write_moments_lens(folder, &channels);
    write_plate(folder, "plate.exr", &channels, 0.7);
    let wanted = amount_in(&removed(folder, "less.exr", "").stderr);
    let planes = channels.map(|name| read_channel(&folder.join("plate.exr"), name));
    let mut samples: Vec<f32> = (0..WIDTH * HEIGHT)
        .flat_map(|k| [0, 1, 2].map(|c: usize| planes[c][k]))
        .collect();
    let rect = SeidelRect {
        left: 0,
        top: 0,
        width: WIDTH as i32,
        height: HEIGHT as i32,
    };
    let source = SeidelImage {
        size: size_of::<SeidelImage>() as u64,
        data: samples.as_mut_ptr().cast(),
        row_bytes: (12 * WIDTH) as i64,
        pixel_bytes: 0,
        channels: 3,
        sample: SEIDEL_FLOAT,
        reserved: 0,
        rect,
    };
    let plate = SeidelPlate {
        size: size_of::<SeidelPlate>() as u64,
        format: rect,
        extent: rect,
        source: &raw const source,
        depth: std::ptr::null(),
        matte: std::ptr::null(),
        matte_depth: std::ptr::null(),
        alphas: std::ptr::null(),
        mask: std::ptr::null(),
    };
    let path = folder.join("lens.json").display().to_string();
    let path = std::ffi::CString::new(path).expect("no zero");
    // SAFETY: every field is a number or a pointer, and zero is valid for both; all pointers are valid.
    let (share, refused) = unsafe {
        let mut settings: SeidelSettings = std::mem::zeroed();
        settings.size = size_of::<SeidelSettings>() as u64;
        assert_eq!(seidel_settings_init(&raw mut settings), SeidelStatus::Ok);
        (settings.lens_scale, settings.distance) = (1.0, 1.6);
        let (mut lens, mut share) = (std::ptr::null_mut(), f64::NAN);
        let opened = seidel_lens_open(path.as_ptr(), &raw mut lens);
        assert_eq!(opened, SeidelStatus::Ok);
        let none = std::ptr::null();
        let checked = seidel_check_lens(lens, &settings, &plate, &raw mut share, none);
        assert_eq!(checked, SeidelStatus::Ok);
        settings.amount = 0.0;
        let refused = seidel_check_lens(lens, &settings, &plate, &raw mut share, none);
        seidel_lens_release(lens);
        (share, refused)
    };
    assert!((share - wanted).abs() < 0.005, "{share}, not {wanted}");
    assert_eq!(refused, SeidelStatus::Argument);
}

/// The check would find half the blur or less: the plate has none.
#[test]
fn relens_from_a_lens_to_itself_returns_the_plate() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["Y"]);
    let sharp = image(1);
    write_exr(
        &folder.join("plate.exr"),
        WIDTH,
        HEIGHT,
        &[("Y", sharp.clone())],
    );
    let line = "relens @plate.exr -o @same.exr --from @lens.json --to @lens.json --lens-scale 1 --distance 1.6";
    let run = succeeds(folder, line);
    assert!(
        run.stderr.contains("both lenses are the same"),
        "{}",
        run.stderr
    );
    assert!(read_channel(&folder.join("same.exr"), "Y") == sharp);
}
