//! The C ABI against the command: the same plate, lens and settings give the same samples, to the bit.

use std::ffi::CString;
use std::path::Path;
use std::ptr::{null, null_mut};

use seidel_c::*;

use crate::support::{read_channel, succeeds, write_exr, write_plate, write_pupil_lens};

const WIDTH: usize = 90;
const HEIGHT: usize = 64;
const NAMES: [&str; 4] = ["R", "G", "B", "A"];

/// Reads channels of `folder`/`file`, interleaved.
fn read(folder: &Path, file: &str, names: &[&str]) -> Vec<f32> {
    let planes = names
        .iter()
        .map(|name| read_channel(&folder.join(file), name));
    let planes: Vec<Vec<f32>> = planes.collect();
    let pixels = 0..planes[0].len();
    pixels
        .flat_map(|k| planes.iter().map(move |plane| plane[k]).collect::<Vec<_>>())
        .collect()
}

fn image(samples: &mut [f32], channels: usize) -> SeidelImage {
    SeidelImage {
        size: size_of::<SeidelImage>() as u64,
        data: samples.as_mut_ptr().cast(),
        row_bytes: (WIDTH * channels * 4) as i64,
        pixel_bytes: 0,
        channels: channels as u32,
        sample: SEIDEL_FLOAT,
        reserved: 0,
        rect: ALL,
    }
}

const ALL: SeidelRect = SeidelRect {
    left: 0,
    top: 0,
    width: WIDTH as i32,
    height: HEIGHT as i32,
};

/// An operation of the C ABI.
#[derive(Clone, Copy)]
enum Work {
    Apply,
    Remove,
    Relens,
}

fn well(status: SeidelStatus) {
    let mut words = [0_u8; 512];
    // SAFETY: the buffer has the stated length.
    unsafe { seidel_last_error(words.as_mut_ptr().cast(), words.len()) };
    let words = String::from_utf8_lossy(&words).into_owned();
    assert_eq!(status, SeidelStatus::Ok, "{words}");
}

fn opened(path: &Path) -> *mut SeidelLens {
    let path = CString::new(path.to_str().expect("UTF-8")).expect("no zero");
    let mut lens = null_mut();
    // SAFETY: both pointers are valid.
    well(unsafe { seidel_lens_open(path.as_ptr(), &mut lens) });
    lens
}

/// Renders `plate.exr` of `folder` by the C ABI.
fn by_abi(
    folder: &Path,
    work: Work,
    change: impl Fn(&mut SeidelSettings, &mut SeidelPlate),
) -> Vec<f32> {
    let mut source = read(folder, "plate.exr", &NAMES);
    let mut depth = read(folder, "plate.exr", &["Z"]);
    let mut out = vec![0.0; source.len()];
    let (source, depth) = (image(&mut source, 4), image(&mut depth, 1));
    let output = image(&mut out, 4);
    // SAFETY: every field is a number or a pointer, and zero is valid for both.
    let mut settings: SeidelSettings = unsafe { std::mem::zeroed() };
    settings.size = size_of::<SeidelSettings>() as u64;
    let mut plate = SeidelPlate {
        size: size_of::<SeidelPlate>() as u64,
        format: ALL,
        extent: ALL,
        source: &source,
        depth: &depth,
        matte: null(),
        matte_depth: null(),
        alphas: null(),
        mask: null(),
    };
    let lens = opened(&folder.join("lens.json"));
    // SAFETY: all pointers are valid.
    unsafe {
        well(seidel_settings_init(&mut settings));
        change(&mut settings, &mut plate);
        well(match work {
            Work::Apply => seidel_apply(lens, &settings, &plate, &output, null(), null()),
            Work::Remove => {
                seidel_remove(lens, &settings, &plate, &output, null(), null_mut(), null())
            }
            Work::Relens => {
                let other = opened(&folder.join("other.json"));
                let done = seidel_relens(lens, other, &settings, &plate, &output, null(), null());
                seidel_lens_release(other);
                done
            }
        });
        seidel_lens_release(lens);
    }
    out
}

fn by_command(folder: &Path, line: &str) -> Vec<f32> {
    succeeds(folder, &format!("{line} @plate.exr -o @out.exr"));
    read(folder, "out.exr", &NAMES)
}

#[track_caller]
fn are_the_same(abi: &[f32], command: &[f32], folder: &Path) {
    assert_eq!(abi.len(), command.len());
    let apart = abi
        .iter()
        .zip(command)
        .position(|(a, b)| a.to_bits() != b.to_bits());
    assert_eq!(
        apart,
        None,
        "{:?} {:?}",
        apart.map(|k| abi[k]),
        apart.map(|k| command[k])
    );
    assert_ne!(abi, read(folder, "plate.exr", &NAMES), "something was done");
}

#[test]
fn apply_gives_the_same_samples() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["R", "G", "B"]);
    write_plate(&folder.join("plate.exr"), WIDTH, HEIGHT);
    let common = "apply --lens @lens.json --psf skew-normal --no-depth-check";
    let model = c"skew-normal".as_ptr();
    let abi = by_abi(folder, Work::Apply, |s, _| s.psf_model = model);
    are_the_same(&abi, &by_command(folder, common), folder);
    let line = format!(
        "{common} --amount 1.5 --channel-scale R=1.2,B=0.9 --axis-offset 5,-3 --geometry full \
         --focus-distance 2 --f-number 2.8 --depth-of-field 0.2 --front-multiplier 1.5 \
         --back-multiplier 0.5 --maximum-size 8 --edges extend --alpha unpremultiplied \
         --pixel-aspect 2 --lens-scale 0.4 --depth-unit 0.9 --along-ray 70 --no-fill-foreground"
    );
    let scales = [1.2, 1.0, 0.9];
    let abi = by_abi(folder, Work::Apply, |s, _| {
        s.psf_model = model;
        s.amount = 1.5;
        (s.channel_scales, s.channel_scale_count) = (scales.as_ptr(), 3);
        (s.axis_offset_x, s.axis_offset_y) = (5.0, -3.0);
        s.geometry = SEIDEL_GEOMETRY_FULL;
        (s.focus_distance, s.f_number) = (2.0, 2.8);
        (s.depth_of_field, s.front_multiplier, s.back_multiplier) = (0.2, 1.5, 0.5);
        s.maximum_size = 8.0;
        s.edges = SEIDEL_EDGES_NEAREST;
        s.alpha = SEIDEL_ALPHA_UNPREMULTIPLIED;
        (s.pixel_aspect, s.lens_scale) = (2.0, 0.4);
        (s.depth_unit, s.along_ray) = (0.9, 70.0);
        s.fill_foreground = 0;
    });
    are_the_same(&abi, &by_command(folder, &line), folder);
    let mut mask: Vec<f32> = (0..WIDTH * HEIGHT).map(|k| (k % 7) as f32 / 8.0).collect();
    write_exr(
        &folder.join("mask.exr"),
        WIDTH,
        HEIGHT,
        &[("A", mask.clone())],
    );
    let mask = image(&mut mask, 1);
    let line = format!("{common} --mask @mask.exr --mix 0.75");
    let abi = by_abi(folder, Work::Apply, |s, plate| {
        (s.psf_model, s.mix) = (model, 0.75);
        plate.mask = &mask;
    });
    are_the_same(&abi, &by_command(folder, &line), folder);
    let line = format!("{common} --distance 1.5 --quality draft --edges black");
    let abi = by_abi(folder, Work::Apply, |s, plate| {
        s.psf_model = model;
        s.distance = 1.5;
        plate.depth = null();
        (s.quality, s.edges) = (SEIDEL_QUALITY_DRAFT, SEIDEL_EDGES_BLACK);
    });
    are_the_same(&abi, &by_command(folder, &line), folder);
}

#[test]
fn looks_give_the_same_samples() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["R", "G", "B"]);
    write_plate(&folder.join("plate.exr"), WIDTH, HEIGHT);
    let is_white = |k: usize| k % 12 < 8 && k / 12 > 1;
    let aperture: Vec<f32> = (0..120).map(|k| f32::from(u8::from(is_white(k)))).collect();
    let bytes = aperture.iter().map(|v| 255 * (*v as u8)).collect();
    let picture = image::GrayImage::from_raw(12, 10, bytes).expect("whole rows");
    picture.save(folder.join("iris.png")).expect("writable");
    let line = "apply --lens @lens.json --distance 1.5 --psf skew-normal --blades 5 --roundness 0.3 \
                --rotation 20 --aperture-picture @iris.png --squeeze 1.5 --obstruction 0.2 --cats-eye 0.3 \
                --spherical 0.5 --axial-colour 2 --lateral-colour 0.5 --tilt 6 --tilt-direction -60 --bloom 0.4 \
                --bloom-level 0.3 --bloom-radius 2";
    let abi = by_abi(folder, Work::Apply, |s, plate| {
        s.psf_model = c"skew-normal".as_ptr();
        s.distance = 1.5;
        plate.depth = null();
        (s.blades, s.roundness, s.rotation) = (5, 0.3, 20.0);
        (s.aperture, s.aperture_width, s.aperture_count) = (aperture.as_ptr(), 12, 120);
        (s.squeeze, s.obstruction, s.cats_eye) = (1.5, 0.2, 0.3);
        (s.spherical, s.axial_colour, s.lateral_colour) = (0.5, 2.0, 0.5);
        (s.tilt, s.tilt_direction) = (6.0, -60.0);
        (s.bloom, s.bloom_level, s.bloom_radius) = (0.4, 0.3, 2.0);
    });
    are_the_same(&abi, &by_command(folder, line), folder);
}

#[test]
fn remove_and_relens_give_the_same_samples() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["R", "G", "B"]);
    std::fs::rename(folder.join("lens.json"), folder.join("other.json")).expect("writable");
    write_pupil_lens(folder, &["R", "G", "B"]);
    // A second lens, with the defocus of one channel in all of them.
    let text = std::fs::read_to_string(folder.join("other.json")).expect("readable");
    let mut lens = seidel_core::LensProfile::from_json(&text).expect("a lens");
    if let seidel_core::profile::LensDescription::Pupil(channels) = &mut lens.description {
        for channel in channels {
            channel.alpha = seidel_optics::lens::VergenceSeries::new(vec![6.0, 3.0]);
        }
    }
    std::fs::write(folder.join("other.json"), lens.to_json()).expect("writable");
    let wave = |k: usize, period: f32| (std::f32::consts::TAU * k as f32 / period).sin();
    let plane = |shade: f32| -> Vec<f32> {
        let pixel = |k: usize| {
            let edge = if (k % WIDTH / 20 + k / WIDTH / 15).is_multiple_of(2) {
                0.3
            } else {
                0.0
            };
            shade * (0.4 + edge + 0.1 * wave(k % WIDTH, 31.0) + 0.1 * wave(k / WIDTH, 23.0))
        };
        (0..WIDTH * HEIGHT).map(pixel).collect()
    };
    let ones = vec![1.0; WIDTH * HEIGHT];
    let channels = [
        ("R", plane(1.0)),
        ("G", plane(0.8)),
        ("B", plane(0.6)),
        ("A", ones.clone()),
        ("Z", ones),
    ];
    write_exr(&folder.join("plate.exr"), WIDTH, HEIGHT, &channels);
    let model = c"gaussian".as_ptr();
    let common = "--psf gaussian --distance 1.6 --noise 0.002";
    let set = |s: &mut SeidelSettings, plate: &mut SeidelPlate| {
        s.psf_model = model;
        s.distance = 1.6;
        plate.depth = null();
        s.noise[0] = 0.002;
    };
    let line =
        format!("remove --lens @lens.json {common} --strength 0.7 --clip 1.05 --no-overscan");
    let abi = by_abi(folder, Work::Remove, |s, plate| {
        set(s, plate);
        s.strength = 0.7;
        (s.clip, s.clip_level) = (SEIDEL_CLIP_LEVEL, 1.05);
        // The plate was taken with the lens as measured.
        (s.squeeze, s.bloom) = (1.5, 0.5);
    });
    are_the_same(&abi, &by_command(folder, &line), folder);
    let sides = "--from-f-number 2.8 --to-focus-distance 2";
    let line = format!("relens --from @lens.json --to @other.json {common} --squeeze 1.5 {sides}");
    let abi = by_abi(folder, Work::Relens, |s, plate| {
        set(s, plate);
        s.squeeze = 1.5;
        (s.from_f_number, s.to_focus_distance) = (2.8, 2.0);
    });
    are_the_same(&abi, &by_command(folder, &line), folder);
}
