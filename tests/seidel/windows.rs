//! `seidel apply` on plates with non-square pixels, and with data windows that differ from the display window.

use std::path::Path;

use exr::meta::attribute::IntegerBounds;
use exr::prelude::*;

use crate::support::{must_refuse, read_channel, succeeds, write_moments_lens, write_pupil_lens};

/// A rectangle: left, top, width and height, px.
type Rectangle = (i32, i32, usize, usize);

/// The windows of a plate.
struct Windows {
    data: Rectangle,
    display: Rectangle,
}

/// A smooth image. The lens's frame covers 150 x 100 px around (75, 50).
fn smooth(x: f64, y: f64) -> f64 {
    let wave = |at: f64, period: f64| (std::f64::consts::TAU * at / period).sin();
    0.5 + 0.2 * wave(x + 0.4 * y, 61.0) + 0.2 * wave(y - 0.3 * x, 47.0)
}

/// A detailed image on the same frame.
fn busy(x: f64, y: f64) -> f64 {
    let (column, row) = (x.floor() as i64, y.floor() as i64);
    let noise = ((column * 7919 + row * 104_729) % 101).unsigned_abs() as f64 / 101.0;
    let light = column.rem_euclid(23) == 5 && row.rem_euclid(19) == 7;
    noise + if light { 8.0 } else { 0.0 }
}

/// Samples an image in a data window, with pixels of a given aspect ratio.
fn sampled(of: fn(f64, f64) -> f64, data: Rectangle, aspect: usize) -> Vec<f32> {
    let (left, top, width, height) = data;
    let pixel = |k: usize| {
        let (column, row) = (left + (k % width) as i32, top + (k / width) as i32);
        let parts = (0..aspect).map(|part| {
            let x = f64::from(column) * aspect as f64 + part as f64 + 0.5;
            of(x, f64::from(row) + 0.5)
        });
        (parts.sum::<f64>() / aspect as f64) as f32
    };
    (0..width * height).map(pixel).collect()
}

fn write(path: &Path, windows: &Windows, aspect: f32, channels: &[(&str, Vec<f32>)]) {
    let Windows { data, display } = *windows;
    let list = channels
        .iter()
        .map(|(name, samples)| AnyChannel::new(*name, FlatSamples::F32(samples.clone())))
        .collect();
    let mut layer = Layer::new(
        (data.2, data.3),
        LayerAttributes::default(),
        Encoding::FAST_LOSSLESS,
        AnyChannels::sort(list),
    );
    layer.attributes.layer_position = Vec2(data.0, data.1);
    let mut image = Image::from_layer(layer);
    image.attributes.display_window =
        IntegerBounds::new((display.0, display.1), (display.2, display.3));
    image.attributes.pixel_aspect = aspect;
    image.write().to_file(path).expect("the folder is writable");
}

/// Crops `samples` of the window `from` to the window `to`.
fn cut(samples: &[f32], from: Rectangle, to: Rectangle) -> Vec<f32> {
    let (left, top) = ((to.0 - from.0) as usize, (to.1 - from.1) as usize);
    let rows = samples.chunks_exact(from.2).skip(top).take(to.3);
    rows.flat_map(|row| &row[left..left + to.2])
        .copied()
        .collect()
}

fn farthest(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f32::max)
}

/// Peak signal-to-noise ratio of two planes, dB, for a white of one.
fn decibels(a: &[f32], b: &[f32]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2));
    -10.0 * (squares.sum::<f64>() / a.len() as f64).log10()
}

/// The header without the channels.
fn header(path: &Path) -> impl PartialEq + std::fmt::Debug + use<> {
    let meta = MetaData::read_from_file(path, false).expect("readable");
    let header = meta.headers[0].clone();
    (
        header.shared_attributes,
        header.own_attributes,
        header.layer_size,
    )
}

#[test]
fn anamorphic_plates_are_blurred_in_square_proportions() {
    for rays in [false, true] {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        if rays {
            write_pupil_lens(folder, &["R", "G", "B"]);
        } else {
            write_moments_lens(folder, &["R", "G", "B"]);
        }
        let (square, wide) = ((0, 0, 150, 100), (0, 0, 75, 100));
        let colours = |samples: Vec<f32>| ["R", "G", "B"].map(|name| (name, samples.clone()));
        let plates = [
            ("square", square, 1),
            ("wide", wide, 2),
            ("unstated", wide, 2),
        ];
        for (name, window, aspect) in plates {
            let stated_aspect = if name == "unstated" {
                1.0
            } else {
                aspect as f32
            };
            let path = folder.join(format!("{name}.exr"));
            write(
                &path,
                &Windows {
                    data: window,
                    display: window,
                },
                stated_aspect,
                &colours(sampled(smooth, window, aspect)),
            );
        }
        let model = if rays { "pupil" } else { "mirrored-pair" };
        let blurred = |name: &str, extra: &str| {
            let line = format!(
                "apply --lens @lens.json @{name}.exr -o @out.exr --distance 0.7 --geometry full --psf {model} --no-provenance {extra}"
            );
            succeeds(folder, &line);
            assert_eq!(
                header(&folder.join(format!("{name}.exr"))),
                header(&folder.join("out.exr"))
            );
            ["R", "B"].map(|channel| read_channel(&folder.join("out.exr"), channel))
        };
        let wide = blurred("wide", "--quality exact");
        assert_eq!(
            wide,
            blurred("unstated", "--quality exact --pixel-aspect 2")
        );
        let by_mistake = blurred("wide", "--quality exact --pixel-aspect 1");
        assert_eq!(by_mistake, blurred("unstated", "--quality exact"));
        let fast = blurred("wide", "--quality final");
        let want = blurred("square", "--quality exact").map(|samples| {
            let pairs = samples.chunks_exact(2);
            pairs
                .map(|pair| 0.5 * (pair[0] + pair[1]))
                .collect::<Vec<f32>>()
        });
        for k in 0..2 {
            let off = decibels(&wide[k], &want[k]);
            // Neighbouring pixels share a `pupil` kernel, which leaves ripples.
            assert!(off > if rays { 50.0 } else { 60.0 }, "{model}: {off}");
            let mistaken = decibels(&by_mistake[k], &want[k]);
            assert!(mistaken < off - 10.0, "{model}: {mistaken} {off}");
            let fast = decibels(&fast[k], &wide[k]);
            assert!(fast > 50.0, "{model}: {fast}");
        }
    }
}

/// The axis offset and depth along the ray account for the pixel aspect ratio.
#[test]
fn axis_and_depth_account_for_anamorphic_pixels() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["Y"]);
    let depth = |x: f64, y: f64| 1.0 + 0.002 * x + 0.001 * y;
    for (name, window, aspect) in [
        ("square", (0, 0, 150, 100), 1),
        ("wide", (0, 0, 75, 100), 2),
    ] {
        let channels = [
            ("Y", sampled(smooth, window, aspect)),
            ("Z", sampled(depth, window, aspect)),
        ];
        write(
            &folder.join(format!("{name}.exr")),
            &Windows {
                data: window,
                display: window,
            },
            aspect as f32,
            &channels,
        );
    }
    let blurred = |name: &str, extra: &str| {
        let line = format!(
            "apply --lens @lens.json @{name}.exr -o @out.exr --quality exact --occlusion off --no-depth-check {extra}"
        );
        succeeds(folder, &line);
        read_channel(&folder.join("out.exr"), "Y")
    };
    let halved = |samples: Vec<f32>| -> Vec<f32> {
        let pairs = samples.chunks_exact(2);
        pairs.map(|pair| 0.5 * (pair[0] + pair[1])).collect()
    };
    // Half as many pixels along x, and as many along y.
    let wide = blurred("wide", "--along-ray 40 --axis-offset 12,9");
    let square = halved(blurred("square", "--along-ray 80 --axis-offset 24,9"));
    let off = farthest(&wide, &square);
    assert!(off < 2e-3, "{off}");
    for wrong in [
        "--along-ray 80 --axis-offset 12,9",
        "--along-ray 40 --axis-offset 40,9",
    ] {
        assert!(
            farthest(&blurred("wide", wrong), &square) > 1.5 * off,
            "{wrong}"
        );
    }
    for bad in ["--pixel-aspect 40", "--pixel-aspect 0.01"] {
        let line = format!("apply --lens @lens.json @wide.exr -o @bad.exr --distance 1 {bad}");
        must_refuse(folder, &line, &["--pixel-aspect", "1/16"]);
    }
}

/// With overscan the result equals a larger frame, cropped to the display window.
#[test]
fn overscan_is_used_and_kept() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["R", "G", "B"]);
    let display: Rectangle = (0, 0, 150, 100);
    // Different on each side, and not starting at zero.
    let (overscan, larger) = ((-60, -50, 260, 190), (-75, -75, 300, 250));
    let channels = |window: Rectangle| {
        let light = sampled(busy, window, 1);
        let depth = sampled(|x, y| if x + y < 120.0 { 1.0 } else { 3.0 }, window, 1);
        let mut all = ["R", "G", "B"].map(|name| (name, light.clone())).to_vec();
        all.push(("A", vec![1.0; light.len()]));
        all.push(("Z", depth));
        all
    };
    let write_plate = |name: &str, data, display| {
        write(
            &folder.join(name),
            &Windows { data, display },
            1.0,
            &channels(data),
        );
    };
    write_plate("overscan.exr", overscan, display);
    write_plate("larger.exr", larger, larger);
    write_plate("cropped.exr", display, display);
    let blurred = |name: &str, extra: &str| {
        let line = format!(
            "apply --lens @lens.json @{name}.exr -o @{name}-out.exr --no-provenance {extra}"
        );
        succeeds(folder, &line);
        ["R", "B"].map(|c| read_channel(&folder.join(format!("{name}-out.exr")), c))
    };
    // The display window is as wide as the lens's frame of 300 px.
    let scale = "--lens-scale 0.5";
    for (options, bound) in [
        ("--distance 0.8 --quality exact", 1e-5),
        ("--distance 0.8 --quality final", 5e-3),
        ("--quality exact", 1e-4),
    ] {
        let over = blurred("overscan", options);
        let wanted = blurred("larger", &format!("{options} {scale}"));
        let without = blurred("cropped", options);
        for k in 0..2 {
            let want = cut(&wanted[k], larger, display);
            let off = farthest(&cut(&over[k], overscan, display), &want);
            assert!(off < bound, "{options}: {off}");
            // Without overscan the edge differs.
            assert!(farthest(&without[k], &want) > 0.05, "{options}");
        }
    }
    assert_eq!(
        header(&folder.join("overscan.exr")),
        header(&folder.join("overscan-out.exr"))
    );
}

/// A data window smaller than the display window is surrounded by black and keeps its place in the field.
#[test]
fn small_data_windows_keep_their_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["R", "G", "B"]);
    let (display, small): (Rectangle, Rectangle) = ((10, -20, 150, 100), (90, -5, 60, 40));
    let light = sampled(busy, small, 1);
    let mut whole = vec![0.0; display.2 * display.3];
    for (k, v) in light.iter().enumerate() {
        let (x, y) = (80 + k % small.2, 15 + k / small.2);
        whole[y * display.2 + x] = *v;
    }
    let colours = |samples: &[f32]| ["R", "G", "B"].map(|name| (name, samples.to_vec()));
    write(
        &folder.join("small.exr"),
        &Windows {
            data: small,
            display,
        },
        1.0,
        &colours(&light),
    );
    write(
        &folder.join("whole.exr"),
        &Windows {
            data: display,
            display,
        },
        1.0,
        &colours(&whole),
    );
    let blurred = |name: &str, quality: &str| {
        let line = format!(
            "apply --lens @lens.json @{name}.exr -o @{name}-out.exr --distance 0.8 --edges black --no-provenance --quality {quality}"
        );
        succeeds(folder, &line);
        ["R", "B"].map(|c| read_channel(&folder.join(format!("{name}-out.exr")), c))
    };
    for (quality, bound) in [("exact", 1e-5), ("final", 5e-3)] {
        let (part, all) = (blurred("small", quality), blurred("whole", quality));
        for k in 0..2 {
            let off = farthest(&part[k], &cut(&all[k], display, small));
            assert!(off < bound, "{quality}: {off}");
        }
        // Red and blue differ, because the place is off the optical axis.
        assert!(farthest(&part[0], &part[1]) > 0.01);
    }
    assert_eq!(
        header(&folder.join("small.exr")),
        header(&folder.join("small-out.exr"))
    );
}
