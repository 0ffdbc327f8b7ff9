//! `seidel remove --residual` and `seidel apply --residual`: removing and reapplying a lens restores the plate.

use std::fs;
use std::path::Path;

use exr::prelude::*;

use crate::support::{
    must_refuse, read_channel, seidel_in, succeeds, write_exr, write_moments_lens, write_pupil_lens,
};

const WIDTH: usize = 72;
const HEIGHT: usize = 60;
const COLOURS: [&str; 3] = ["R", "G", "B"];

fn samples(shade: f32, seed: usize) -> Vec<f32> {
    let pixel = |k: usize| {
        let (x, y) = ((k % WIDTH) as f32, (k / WIDTH) as f32);
        let disc = (x - 30.0).hypot(y - 26.0) < 11.0;
        let light = if disc {
            0.9
        } else {
            0.4 + 0.1 * (0.3 * x + 0.1 * y).sin()
        };
        // Grain.
        let hash = ((k + seed) as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
        shade * light + 0.012 * ((hash % 1000) as f32 / 1000.0 - 0.5)
    };
    (0..WIDTH * HEIGHT).map(pixel).collect()
}

/// Writes a plate with grain, alpha and depth, its colour in half floats or floats.
fn write_plate(path: &Path, half: bool) {
    let colour = |(name, shade): (&str, f32)| {
        let light = samples(shade, (100.0 * shade) as usize);
        let samples = if half {
            FlatSamples::F16(light.iter().map(|v| f16::from_f32(*v)).collect())
        } else {
            FlatSamples::F32(light)
        };
        AnyChannel::new(name, samples)
    };
    let shades = COLOURS.into_iter().zip([1.0, 0.8, 0.6]);
    let mut list: Vec<_> = shades.map(colour).collect();
    let of = |f: &dyn Fn(usize) -> f32| FlatSamples::F32((0..WIDTH * HEIGHT).map(f).collect());
    let alpha = of(&|k| if k % WIDTH > 20 { 1.0 } else { 0.5 });
    list.push(AnyChannel::new("A", alpha));
    let depth = of(&|k| if k % WIDTH > 40 { 4.0 } else { 1.4 });
    list.push(AnyChannel::new("Z", depth));
    let layer = Layer::new(
        (WIDTH, HEIGHT),
        LayerAttributes::default(),
        Encoding::FAST_LOSSLESS,
        AnyChannels::sort(list.into()),
    );
    let image = Image::from_layer(layer);
    image.write().to_file(path).expect("writable");
}

fn farthest(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len());
    let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    apart.fold(0.0, f32::max)
}

/// Removes the lens and reapplies it; returns the largest error of any channel, for a peak of about one.
fn round_trip(folder: &Path, file: &str, sight: &str) -> f32 {
    let line = format!("remove @{file} -o @sharp-{file} --residual @rest.exr {sight}");
    succeeds(folder, &line);
    let line = format!("apply @sharp-{file} -o @back-{file} --residual @rest.exr {sight}");
    let outcome = succeeds(folder, &line);
    assert!(
        !outcome.stderr.contains("other settings"),
        "{}",
        outcome.stderr
    );
    let off = |channel: &&str| {
        let of = |name: &str| read_channel(&folder.join(name), channel);
        assert_ne!(of(&format!("sharp-{file}")), of(file));
        farthest(&of(&format!("back-{file}")), &of(file))
    };
    ["R", "G", "B", "A"].iter().map(off).fold(0.0, f32::max)
}

#[test]
fn removing_and_reapplying_restores_the_plate() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    for rays in [false, true] {
        if rays {
            write_pupil_lens(folder, &COLOURS);
        } else {
            write_moments_lens(folder, &COLOURS);
        }
        for half in [false, true] {
            write_plate(&folder.join("plate.exr"), half);
            // One distance; the plate's own depth with occlusion; without overscan; half strength.
            for options in ["--distance 1.6", "", "--distance 1.6 --geometry full"] {
                let sight = format!("--lens @lens.json --lens-scale 0.6 {options}");
                let off = round_trip(folder, "plate.exr", &sight);
                assert!(off < 1e-6, "rays {rays}, half {half}, {options}: {off}");
            }
        }
    }
    // Everything else is restored, including windows.
    let of = |name: &str| read_channel(&folder.join(name), "Z");
    assert_eq!(of("back-plate.exr"), of("plate.exr"));
    let size = |name: &str| {
        let meta = MetaData::read_from_file(folder.join(name), false).expect("readable");
        (
            meta.headers[0].layer_size,
            meta.headers[0].own_attributes.layer_position,
        )
    };
    assert_eq!(size("back-plate.exr"), size("plate.exr"));
    assert_ne!(size("sharp-plate.exr"), size("plate.exr"));
}

#[test]
fn integer_plates_are_restored_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &COLOURS);
    let light = samples(1.0, 3);
    let rgb = image::RgbImage::from_fn(WIDTH as u32, HEIGHT as u32, |x, y| {
        let code = (250.0 * light[y as usize * WIDTH + x as usize]) as u8;
        image::Rgb([code, code / 2, 255 - code])
    });
    rgb.save(folder.join("plate.png")).expect("writable");
    let sight = "--lens @lens.json --lens-scale 0.6 --distance 1.6";
    let line = format!("remove @plate.png -o @sharp.png --residual @rest.exr {sight}");
    succeeds(folder, &line);
    let line = format!("apply @sharp.png -o @back.png --residual @rest.exr {sight}");
    succeeds(folder, &line);
    let of = |name: &str| image::open(folder.join(name)).expect("readable").to_rgb8();
    assert!(of("back.png") == rgb && of("sharp.png") != rgb);
}

/// Painted areas appear through the lens without their earlier content; elsewhere the plate is restored.
#[test]
fn painted_areas_are_new_and_the_rest_is_restored() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &COLOURS);
    write_plate(&folder.join("plate.exr"), false);
    let sight = "--lens @lens.json --lens-scale 0.6 --distance 1.6";
    let line =
        format!("remove @plate.exr -o @sharp.exr --no-overscan --residual @rest.exr {sight}");
    succeeds(folder, &line);
    let painted = |x: usize, y: usize| (40..64).contains(&x) && (16..44).contains(&y);
    let channels = ["R", "G", "B", "A"].map(|name| {
        let mut samples = read_channel(&folder.join("sharp.exr"), name);
        for (k, sample) in samples.iter_mut().enumerate() {
            if name != "A" && painted(k % WIDTH, k / WIDTH) {
                *sample = 1.5;
            }
        }
        (name, samples)
    });
    write_exr(&folder.join("painted.exr"), WIDTH, HEIGHT, &channels);
    for (output, residual) in [("kept", "--residual @rest.exr"), ("plain", "")] {
        let line = format!("apply @painted.exr -o @{output}.exr {residual} {sight}");
        succeeds(folder, &line);
    }
    let of = |name: &str| read_channel(&folder.join(name), "R");
    let (plate, kept, plain) = (of("plate.exr"), of("kept.exr"), of("plain.exr"));
    let (mut inside, mut outside) = (0.0_f32, 0.0_f32);
    for k in 0..WIDTH * HEIGHT {
        let (x, y) = (k % WIDTH, k / WIDTH);
        let reach = 10;
        if (40 + reach..64 - reach).contains(&x) && (16 + reach..44 - reach).contains(&y) {
            inside = inside.max((kept[k] - plain[k]).abs());
        }
        if !((40 - reach..64 + reach).contains(&x) && (16 - reach..44 + reach).contains(&y)) {
            outside = outside.max((kept[k] - plate[k]).abs());
        }
    }
    assert!(inside < 1e-4, "{inside}");
    assert!(outside < 1e-4, "{outside}");
    assert!(farthest(&plain, &plate) > 0.3);
}

#[test]
fn sequences_have_one_residual_per_frame() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &COLOURS);
    for frame in [1, 2] {
        write_plate(&folder.join(format!("plate.{frame:04}.exr")), frame == 1);
    }
    let sight = "--lens @lens.json --lens-scale 0.6 --distance 1.6 --frames 1-2";
    let one = format!("remove @plate.%04d.exr -o @s.%04d.exr --residual @r.exr {sight}");
    let outcome = seidel_in(folder, &one);
    assert_eq!(outcome.status, 2);
    assert!(
        outcome.stderr.contains("--residual needs a frame pattern"),
        "{}",
        outcome.stderr
    );
    let line = format!("remove @plate.%04d.exr -o @s.%04d.exr --residual @r.%04d.exr {sight}");
    let outcome = succeeds(folder, &line);
    assert_eq!(outcome.stdout.matches("wrote").count(), 4);
    // A frame is complete when all its files exist.
    fs::remove_file(folder.join("r.0002.exr")).expect("removable");
    let outcome = succeeds(folder, &format!("{line} --skip-existing"));
    assert!(
        outcome
            .stderr
            .contains("1 of 2 frames are finished and kept"),
        "{}",
        outcome.stderr
    );
    let line = format!("apply @s.%04d.exr -o @b.%04d.exr --residual @r.%04d.exr {sight}");
    succeeds(folder, &line);
    for frame in [1, 2] {
        let of = |name: &str| read_channel(&folder.join(format!("{name}.{frame:04}.exr")), "G");
        assert!(farthest(&of("b"), &of("plate")) < 1e-6);
    }
}

#[test]
fn residuals_of_other_plates_are_refused_and_other_settings_are_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &COLOURS);
    write_plate(&folder.join("plate.exr"), false);
    let sight = "--lens @lens.json --lens-scale 0.6";
    let line =
        format!("remove @plate.exr -o @sharp.exr --residual @rest.exr --distance 1.6 {sight}");
    succeeds(folder, &line);
    let apply = |input: &str, residual: &str| {
        format!("apply @{input} -o @x.exr --residual @{residual} --distance 1.6 {sight}")
    };
    must_refuse(
        folder,
        &apply("plate.exr", "rest.exr"),
        &["rest.exr", "dataWindow", "72x60 at (0, 0)", "seidel remove"],
    );
    must_refuse(
        folder,
        &apply("sharp.exr", "plate.exr"),
        &["plate.exr", "sharp.R", "not a residual"],
    );
    must_refuse(folder, &apply("sharp.exr", "no.exr"), &["no.exr"]);
    let same = format!("remove @plate.exr -o @same.exr --residual @same.exr --distance 1 {sight}");
    must_refuse(folder, &same, &["two outputs"]);
    let other = format!("remove @plate.exr -o @y.exr --residual @y.png --distance 1 {sight}");
    must_refuse(folder, &other, &["y.png", "EXR"]);
    let line = format!(
        "apply @sharp.exr -o @x.exr --residual @rest.exr --distance 2 --edges black --amount 0.9 {sight}"
    );
    let outcome = succeeds(folder, &line);
    for part in [
        "edges was mirror, is black",
        "amount was 1, is 0.9",
        "distance was",
    ] {
        assert!(outcome.stderr.contains(part), "{part}: {}", outcome.stderr);
    }
}
