//! `seidel apply` on elements over nothing: their blurred rim is kept, and nothing is folded back at the edges.

use std::path::Path;

use exr::meta::attribute::IntegerBounds;
use exr::prelude::*;

use crate::support::{read_channel, succeeds, write_exr, write_moments_lens};

/// Sides of the element's box and of the frame, px, and the radius of its disc.
const BOX: usize = 60;
const FRAME: (usize, usize) = (300, 200);
const RADIUS: f64 = 29.0;
/// The first pixel of the box in the frame.
const CORNER: (i32, i32) = (110, 60);

/// Coverage of a disc in the middle of a window of `size` pixels.
fn disc(size: (usize, usize), centre: (f64, f64)) -> Vec<f32> {
    let pixel = |k: usize| {
        let (x, y) = ((k % size.0) as f64 + 0.5, (k / size.0) as f64 + 0.5);
        let distance = (x - centre.0).hypot(y - centre.1);
        (RADIUS + 0.5 - distance).clamp(0.0, 1.0) as f32
    };
    (0..size.0 * size.1).map(pixel).collect()
}

/// Writes a disc with alpha, premultiplied, over a `data` window of the frame.
fn write(path: &Path, corner: (i32, i32), size: (usize, usize), alpha: &[f32]) {
    let grey: Vec<f32> = alpha.iter().map(|a| 0.5 * a).collect();
    let channel =
        |name: &str, samples: &[f32]| AnyChannel::new(name, FlatSamples::F32(samples.to_vec()));
    let list = ["R", "G", "B"].map(|name| channel(name, &grey));
    let list = list.into_iter().chain([channel("A", alpha)]).collect();
    let mut layer = Layer::new(
        size,
        LayerAttributes::default(),
        Encoding::FAST_LOSSLESS,
        AnyChannels::sort(list),
    );
    layer.attributes.layer_position = Vec2(corner.0, corner.1);
    let mut image = Image::from_layer(layer);
    image.attributes.display_window = IntegerBounds::new((0, 0), FRAME);
    image.write().to_file(path).expect("the folder is writable");
}

/// The data window of an EXR: its first pixel and its size.
fn data_window(path: &Path) -> ((i32, i32), (usize, usize)) {
    let image = read_first_flat_layer_from_file(path).expect("an EXR");
    let (at, size) = (
        image.layer_data.attributes.layer_position,
        image.layer_data.size,
    );
    ((at.0, at.1), (size.0, size.1))
}

/// A box around an element gives what the whole frame gives, to the pixel, with all of its light.
#[test]
fn a_box_about_an_element_grows_to_what_the_whole_frame_gives() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["R", "G", "B"]);
    let middle = BOX as f64 / 2.0;
    let (left, top) = (f64::from(CORNER.0), f64::from(CORNER.1));
    let in_box = disc((BOX, BOX), (middle, middle));
    let in_frame = disc(FRAME, (left + middle, top + middle));
    write(&folder.join("box.exr"), CORNER, (BOX, BOX), &in_box);
    write(&folder.join("frame.exr"), (0, 0), FRAME, &in_frame);
    let options = "--lens @lens.json --distance 0.8 --geometry none --quality exact";
    let outcome = succeeds(folder, &format!("apply {options} @box.exr -o @box-out.exr"));
    assert!(
        outcome.stderr.contains("--edges black"),
        "{}",
        outcome.stderr
    );
    succeeds(
        folder,
        &format!("apply {options} @frame.exr -o @frame-out.exr"),
    );
    let (corner, size) = data_window(&folder.join("box-out.exr"));
    assert!(
        corner.0 < CORNER.0 - 3 && corner.1 < CORNER.1 - 3,
        "{corner:?}"
    );
    assert!(size.0 > BOX + 6 && size.1 > BOX + 6, "{size:?}");
    let (frame_corner, frame_size) = data_window(&folder.join("frame-out.exr"));
    assert_eq!((frame_corner, frame_size), ((0, 0), FRAME));
    for channel in ["A", "G"] {
        let grown = read_channel(&folder.join("box-out.exr"), channel);
        let whole = read_channel(&folder.join("frame-out.exr"), channel);
        let mut seen = 0.0;
        for (k, sample) in grown.iter().enumerate() {
            let x = (corner.0 + (k % size.0) as i32) as usize;
            let y = (corner.1 + (k / size.0) as i32) as usize;
            let wanted = whole[y * FRAME.0 + x];
            assert!(
                (sample - wanted).abs() < 1e-5,
                "{channel} ({x}, {y}): {sample} {wanted}"
            );
            seen += f64::from(*sample);
        }
        let all: f64 = whole.iter().map(|v| f64::from(*v)).sum();
        assert!(
            (seen - all).abs() < 1e-4 * all,
            "{channel}: {seen} of {all}"
        );
    }
    // The middle of the box's edge, one pixel outside the disc, is about half covered: mirrored edges would double it.
    let grown = read_channel(&folder.join("box-out.exr"), "A");
    let at = (CORNER.1 + BOX as i32 / 2 - corner.1) as usize * size.0;
    let edge = grown[at + (CORNER.0 - corner.0) as usize];
    assert!((0.3..0.5).contains(&edge), "{edge}");
    let mirrored = "--edges mirror --expand off";
    succeeds(
        folder,
        &format!("apply {options} {mirrored} @box.exr -o @cropped.exr"),
    );
    let (corner, size) = data_window(&folder.join("cropped.exr"));
    assert_eq!((corner, size), (CORNER, (BOX, BOX)));
    let folded = read_channel(&folder.join("cropped.exr"), "A")[BOX / 2 * BOX];
    assert!(folded > 1.6 * edge, "{folded} {edge}");
}

/// The glow of an element ends nowhere but in darkness.
#[test]
fn a_box_about_an_element_grows_by_the_reach_of_bloom() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["R", "G", "B"]);
    let middle = BOX as f64 / 2.0;
    let in_box = disc((BOX, BOX), (middle, middle));
    write(&folder.join("box.exr"), CORNER, (BOX, BOX), &in_box);
    let line =
        "apply --lens @lens.json --distance 0.8 --bloom 0.5 --bloom-level 0.1 @box.exr -o @out.exr";
    succeeds(folder, &format!("{line} --bloom-radius 0.4"));
    let (corner, size) = data_window(&folder.join("out.exr"));
    // Radius of 1.2 px: half of the light is nearer, all of it within 14 times as much.
    assert!(corner.0 < CORNER.0 - 10 && size.0 > BOX + 20, "{corner:?}");
    let glow = read_channel(&folder.join("out.exr"), "G");
    let sum: f64 = glow.iter().map(|v| f64::from(*v)).sum();
    let all: f64 = in_box.iter().map(|a| 0.5 * f64::from(*a)).sum();
    assert!((sum / all - 1.0).abs() < 1e-4, "{sum} of {all}");
    let beside = glow[size.1 / 2 * size.0 + (CORNER.0 - 4 - corner.0) as usize];
    assert!(beside > 1e-4, "{beside}");
    assert!(glow[size.1 / 2 * size.0] < 1e-5);
}

/// Full frames, and elements that fill the frame, keep their windows; no light or alpha is negative.
#[test]
fn full_frames_do_not_grow_and_no_light_is_negative() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["R", "G", "B"]);
    write(
        &folder.join("frame.exr"),
        (0, 0),
        FRAME,
        &vec![1.0; FRAME.0 * FRAME.1],
    );
    let options = "--lens @lens.json --distance 0.8";
    let outcome = succeeds(folder, &format!("apply {options} @frame.exr -o @out.exr"));
    assert!(!outcome.stderr.contains("--edges"), "{}", outcome.stderr);
    assert_eq!(data_window(&folder.join("out.exr")), ((0, 0), FRAME));
    succeeds(
        folder,
        &format!("apply {options} --expand on @frame.exr -o @out.exr"),
    );
    assert!(data_window(&folder.join("out.exr")).0.0 < 0);
    // An element that the lower border cuts goes on below it.
    let cut = disc(FRAME, (150.0, FRAME.1 as f64));
    write(&folder.join("cut.exr"), (0, 0), FRAME, &cut);
    let outcome = succeeds(folder, &format!("apply {options} @cut.exr -o @out.exr"));
    assert!(
        outcome.stderr.contains("--edges extend"),
        "{}",
        outcome.stderr
    );
    let alpha = read_channel(&folder.join("out.exr"), "A");
    let (_, size) = data_window(&folder.join("out.exr"));
    let below = alpha[(size.1 - 1) * size.0 + size.0 / 2];
    assert!(below > 0.99, "{below}");
    let rim = disc((BOX, BOX), (BOX as f64 / 2.0, BOX as f64 / 2.0));
    write(&folder.join("box.exr"), CORNER, (BOX, BOX), &rim);
    for quality in ["draft", "final", "exact"] {
        succeeds(
            folder,
            &format!("apply {options} --quality {quality} @box.exr -o @out.exr"),
        );
        for channel in ["R", "A"] {
            let samples = read_channel(&folder.join("out.exr"), channel);
            let least = samples.iter().copied().fold(0.0, f32::min);
            assert!(least >= 0.0, "{quality} {channel}: {least}");
        }
    }
}

/// With depth and occlusion each pixel is a weighted mean, so its alpha is at most one.
#[test]
fn no_alpha_is_above_one_over_a_slope() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let (width, height) = (90, 70);
    let alpha = disc((width, height), (45.0, 35.0));
    let slope = |k: usize| 1.0 + (k % width) as f32 / 40.0;
    let depth = (0..alpha.len()).map(slope).collect();
    let mut channels: Vec<_> = ["R", "G", "B", "A"].map(|n| (n, alpha.clone())).into();
    channels.push(("Z", depth));
    write_exr(&folder.join("slope.exr"), width, height, &channels);
    for quality in ["draft", "final", "exact"] {
        let options = format!("--lens library:wide-zoom-16 --quality {quality}");
        succeeds(folder, &format!("apply {options} @slope.exr -o @out.exr"));
        let alpha = read_channel(&folder.join("out.exr"), "A");
        let most = alpha.into_iter().fold(0.0, f32::max);
        assert!((0.999..=1.0 + 1e-6).contains(&most), "{quality}: {most}");
    }
}

/// Formats without data windows are cropped, with a note.
#[test]
fn elements_in_formats_without_data_windows_are_cropped_with_a_note() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["R", "G", "B"]);
    let alpha = disc((BOX, BOX), (BOX as f64 / 2.0, BOX as f64 / 2.0));
    write(&folder.join("box.exr"), (0, 0), (BOX, BOX), &alpha);
    succeeds(
        folder,
        "apply --lens @lens.json --distance 0.8 --amount 0 @box.exr -o @box.png",
    );
    let options = "--lens @lens.json --distance 0.8";
    let outcome = succeeds(folder, &format!("apply {options} @box.png -o @out.png"));
    let note = outcome.stderr.contains("no data window") && outcome.stderr.contains("cropped");
    assert!(note, "{}", outcome.stderr);
}
