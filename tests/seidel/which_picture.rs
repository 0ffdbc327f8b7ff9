//! `seidel apply` on EXR files with several parts, layers, views and windows: the right picture is blurred by its own depth.

use std::path::Path;

use exr::meta::attribute::{IntegerBounds, Text};
use exr::prelude::*;

use crate::support::{must_refuse, read_channel, seidel_in, succeeds, write_moments_lens};

const SIZE: (usize, usize) = (48, 40);
/// Distances of the eyes, m: the left is nearer.
const LEFT_M: f32 = 1.2;
const RIGHT_M: f32 = 4.0;

fn checks(shift: usize) -> Vec<f32> {
    let pixel = |k: usize| {
        let (x, y) = (k % SIZE.0 + shift, k / SIZE.0);
        ((x / 6 + y / 6) % 2) as f32 * 0.8 + 0.1
    };
    (0..SIZE.0 * SIZE.1).map(pixel).collect()
}

fn level(value: f32) -> Vec<f32> {
    vec![value; SIZE.0 * SIZE.1]
}

/// A part: its name, its view, the corner of its data window, and its channels.
struct Part<'a> {
    name: &'a str,
    view: &'a str,
    corner: (i32, i32),
    channels: Vec<(&'a str, Vec<f32>)>,
}

impl<'a> Part<'a> {
    fn new(name: &'a str, view: &'a str, channels: Vec<(&'a str, Vec<f32>)>) -> Self {
        Self {
            name,
            view,
            corner: (0, 0),
            channels,
        }
    }
}

fn colours(samples: &[f32]) -> Vec<(&'static str, Vec<f32>)> {
    ["R", "G", "B"]
        .map(|name| (name, samples.to_vec()))
        .to_vec()
}

fn save(path: &Path, display: (usize, usize), parts: Vec<Part>) {
    let some = |text: &str| (!text.is_empty()).then(|| Text::from(text));
    let layer = |part: Part| {
        let list = part.channels.into_iter();
        let list = list.map(|(name, samples)| AnyChannel::new(name, FlatSamples::F32(samples)));
        let mut layer = Layer::new(
            SIZE,
            LayerAttributes::default(),
            Encoding::FAST_LOSSLESS,
            AnyChannels::sort(list.collect()),
        );
        layer.attributes.layer_name = some(part.name);
        layer.attributes.view_name = some(part.view);
        layer.attributes.layer_position = Vec2(part.corner.0, part.corner.1);
        layer
    };
    let attributes = ImageAttributes::new(IntegerBounds::new((0, 0), display));
    let layers: SmallVec<_> = parts.into_iter().map(layer).collect();
    let image = Image::from_layers(attributes, layers);
    image.write().to_file(path).expect("the folder is writable");
}

/// Returns the samples of the channel that `seidel info` calls `name`, such as `part:R`.
fn samples(path: &Path, name: &str) -> Vec<f32> {
    let image = seidel_image_io::formats::exr::ExrImage::open(path).expect("readable");
    let mut channels = image.channels().into_iter();
    let id = channels
        .find(|own| image.full_name_of(own.id) == name)
        .expect("the channel")
        .id;
    image.samples(id)
}

/// Writes a stereo file of four parts, and each eye as a file of its own.
fn write_eyes(folder: &Path) {
    let (left, right) = (checks(0), checks(3));
    let depth = |value| vec![("Z", level(value))];
    let parts = vec![
        Part::new("depth.left", "left", depth(LEFT_M)),
        Part::new("rgba.left", "left", colours(&left)),
        Part::new("rgba.right", "right", colours(&right)),
        Part::new("depth.right", "right", depth(RIGHT_M)),
    ];
    save(&folder.join("both.exr"), SIZE, parts);
    for (name, samples, depth_m) in [("left", left, LEFT_M), ("right", right, RIGHT_M)] {
        let mut channels = colours(&samples);
        channels.push(("Z", level(depth_m)));
        save(
            &folder.join(format!("{name}.exr")),
            SIZE,
            vec![Part::new("", "", channels)],
        );
    }
}

const APPLY: &str = "apply --lens @lens.json --no-depth-check --no-provenance --quality exact";

#[test]
fn each_eye_of_a_stereo_file_is_blurred_by_its_own_depth() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["R", "G", "B"]);
    write_eyes(folder);
    for eye in ["both", "left", "right"] {
        succeeds(folder, &format!("{APPLY} @{eye}.exr -o @{eye}-out.exr"));
    }
    let both = folder.join("both-out.exr");
    for eye in ["left", "right"] {
        let alone = read_channel(&folder.join(format!("{eye}-out.exr")), "R");
        assert_eq!(samples(&both, &format!("rgba.{eye}:R")), alone, "{eye}");
        assert_ne!(
            samples(&folder.join("both.exr"), &format!("rgba.{eye}:R")),
            alone
        );
    }
    // One eye; the depth named as `info` and messages name it.
    let line = format!("{APPLY} --view right @both.exr -o @one.exr");
    let outcome = succeeds(folder, &line);
    assert!(
        outcome.stderr.contains("views that stay as they are: left"),
        "{}",
        outcome.stderr
    );
    let file = folder.join("both.exr");
    let named = format!("{line} --depth {}:depth.right:Z", file.display());
    let one = samples(&folder.join("one.exr"), "rgba.right:R");
    succeeds(folder, &named);
    assert_eq!(samples(&folder.join("one.exr"), "rgba.right:R"), one);
    assert_eq!(samples(&both, "rgba.right:R"), one);
    assert_eq!(samples(&folder.join("one.exr"), "rgba.left:R"), checks(0));
    // One picture holds one eye.
    let outcome = succeeds(folder, &format!("{APPLY} @both.exr -o @both.png"));
    assert!(
        outcome.stderr.contains("the other views are left out"),
        "{}",
        outcome.stderr
    );
    must_refuse(
        folder,
        &format!("{APPLY} --view middle @both.exr -o @no.exr"),
        &["both.exr", "left, right", "--view"],
    );
    let removed = "remove --lens @lens.json @both.exr -o @no.exr --residual @rest.exr";
    must_refuse(folder, removed, &["both.exr", "2 views", "--residual"]);
    let outcome = seidel_in(folder, "info @both.exr");
    for part in [
        "plate: R, G, B (view left)",
        "plate: R, G, B (view right)",
        "depth of the plate: Z",
    ] {
        assert!(outcome.stdout.contains(part), "{}", outcome.stdout);
    }
}

#[test]
fn a_guess_among_equals_is_refused_with_the_choice() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["R", "G", "B"]);
    let part = |name| Part::new(name, "", colours(&checks(0)));
    let two = |name| {
        vec![
            part("shot"),
            part("other"),
            Part::new(name, "", vec![("Z", level(2.0))]),
        ]
    };
    save(&folder.join("two.exr"), SIZE, two("depth"));
    must_refuse(
        folder,
        &format!("{APPLY} @two.exr -o @no.exr"),
        &["two.exr", "shot:R, other:R", "--layer"],
    );
    succeeds(
        folder,
        &format!("{APPLY} --layer other @two.exr -o @out.exr"),
    );
    assert_eq!(samples(&folder.join("out.exr"), "shot:R"), checks(0));
    assert_ne!(samples(&folder.join("out.exr"), "other:R"), checks(0));
    let depths = vec![
        part("rgba"),
        Part::new("Pz", "", vec![("Y", level(2.0))]),
        Part::new("depth", "", vec![("Z", level(3.0))]),
    ];
    save(&folder.join("depths.exr"), SIZE, depths);
    must_refuse(
        folder,
        &format!("{APPLY} @depths.exr -o @no.exr"),
        &["depths.exr", "Pz:Y, depth:Z", "--depth"],
    );
    // The depth of the part itself comes first, and others are named.
    let mut own = colours(&checks(0));
    own.push(("Z", level(2.0)));
    let near = vec![
        Part::new("rgba", "", own),
        Part::new("depth", "", vec![("Z", level(3.0))]),
    ];
    save(&folder.join("near.exr"), SIZE, near);
    let outcome = succeeds(folder, &format!("{APPLY} @near.exr -o @out.exr"));
    assert!(
        outcome.stderr.contains("may be depth, and differ: depth:Z"),
        "{}",
        outcome.stderr
    );
    let outcome = seidel_in(folder, "info @two.exr");
    assert!(
        outcome.stdout.contains("name it with --layer"),
        "{}",
        outcome.stdout
    );
}

#[test]
fn a_depth_window_at_another_origin_is_a_shift() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["R", "G", "B"]);
    // An edge of depth at column 20 of its own window, which begins at column 8.
    let step = |at: usize| -> Vec<f32> {
        let pixel = |k: usize| if k % SIZE.0 < at { LEFT_M } else { RIGHT_M };
        (0..SIZE.0 * SIZE.1).map(pixel).collect()
    };
    let frame = (SIZE.0 + 8, SIZE.1);
    for (name, corner, depth) in [("moved", (8, 0), step(20)), ("same", (0, 0), step(28))] {
        let depth = Part {
            corner,
            ..Part::new("depth", "", vec![("Z", depth)])
        };
        let parts = vec![Part::new("rgba", "", colours(&checks(0))), depth];
        save(&folder.join(format!("{name}.exr")), frame, parts);
        succeeds(folder, &format!("{APPLY} @{name}.exr -o @{name}-out.exr"));
    }
    let result = |name: &str| samples(&folder.join(name), "rgba:R");
    assert_eq!(result("moved-out.exr"), result("same-out.exr"));
}

#[test]
fn other_channels_are_zero_where_the_data_window_grows() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_moments_lens(folder, &["R", "G", "B"]);
    let alpha: Vec<f32> = (0..SIZE.0 * SIZE.1)
        .map(|k| {
            let (x, y) = (k % SIZE.0, k / SIZE.0);
            f32::from(u8::from(
                (1..SIZE.0 - 1).contains(&x) && (1..SIZE.1 - 1).contains(&y),
            ))
        })
        .collect();
    let mut channels = colours(&alpha);
    channels.extend([
        ("A", alpha),
        ("Z", level(0.8)),
        ("crypto00.G", level(1.0)),
        ("id", level(7.0)),
        ("N.X", level(0.5)),
    ]);
    let part = Part {
        corner: (100, 80),
        ..Part::new("", "", channels)
    };
    save(&folder.join("a.exr"), (300, 200), vec![part]);
    for (option, beyond) in [("", 0.0), ("--extend-channels", 7.0)] {
        succeeds(folder, &format!("{APPLY} {option} @a.exr -o @out.exr"));
        let out = folder.join("out.exr");
        let id = read_channel(&out, "id");
        assert!(id.len() > SIZE.0 * SIZE.1, "it grew");
        assert_eq!(id[0], beyond);
        assert_eq!(
            id.iter().filter(|v| **v != beyond).count(),
            if beyond == 0.0 { SIZE.0 * SIZE.1 } else { 0 }
        );
        assert_eq!(read_channel(&out, "crypto00.G")[0], beyond / 7.0);
        assert_eq!(read_channel(&out, "N.X")[0], beyond / 14.0);
        assert_eq!(read_channel(&out, "Z")[0], 0.8, "depth is extended");
    }
}
