//! OpenEXR files: every compression, scan lines and tiles, mip maps, several parts, deep.

use std::io::Cursor;
use std::path::Path;

use exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image, Layer, Levels};
use exr::math::RoundingMode;
use exr::meta::attribute::{AttributeValue, LineOrder, Text};
use exr::prelude::{Compression, LayerAttributes, Vec2, WritableImage};
use half::f16;
use seidel_image_io::formats::exr::{NewChannel, write_channels};
use seidel_image_io::windows::ImageWindows;

use super::{HEIGHT, WIDTH, plane, read};

/// Writes a plate with depth: R, G, B, A and Z.
pub(crate) fn write_plate(path: &Path) {
    let planes: Vec<Vec<f32>> = (0..3).map(plane).collect();
    let alpha = vec![1.0; WIDTH * HEIGHT];
    let depth: Vec<f32> = (0..WIDTH * HEIGHT)
        .map(|k| 1.5 + (k % WIDTH) as f32 * 0.1)
        .collect();
    let named = ["R", "G", "B"]
        .into_iter()
        .zip(&planes)
        .chain([("A", &alpha), ("Z", &depth)]);
    let channels: Vec<NewChannel> = named
        .map(|(name, samples)| NewChannel {
            name,
            samples,
            half: name != "Z",
        })
        .collect();
    let windows = ImageWindows::of_size(WIDTH, HEIGHT);
    write_channels(path, windows, &channels).unwrap_or_else(|e| panic!("{e}"));
}

/// Returns files of every kind.
pub(crate) fn files(folder: &Path) -> Vec<Vec<u8>> {
    let plate = folder.join("seed.exr");
    write_plate(&plate);
    let mut files = vec![read(&plate)];
    let methods = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
        Compression::B44,
        Compression::B44A,
        Compression::DWAA(None),
        Compression::DWAB(None),
    ];
    let tiles = Blocks::Tiles(Vec2(16, 8));
    for method in methods {
        files.push(encoded(vec![layer("", method, Blocks::ScanLines)]));
        files.push(encoded(vec![layer("", method, tiles)]));
    }
    let parts = ["left", "right"].map(|name| layer(name, Compression::ZIP16, Blocks::ScanLines));
    files.push(encoded(parts.into()));
    let parts = [
        layer("rgba", Compression::PIZ, Blocks::ScanLines),
        layer("tiled", Compression::RLE, tiles),
    ];
    files.push(encoded(parts.into()));
    files.push(mip_maps());
    files.push(deep());
    files
}

type Part = Layer<AnyChannels<FlatSamples>>;

fn attributes(name: &str) -> LayerAttributes {
    let mut attributes = LayerAttributes {
        layer_name: (!name.is_empty()).then(|| Text::from(name)),
        owner: Some(Text::from("attack")),
        ..LayerAttributes::default()
    };
    let mut add = |name: &str, value| attributes.other.insert(Text::from(name), value);
    add("slate", AttributeValue::Text(Text::from("a take")));
    add("count", AttributeValue::I32(7));
    add("scale", AttributeValue::F32(0.5));
    add("shift", AttributeValue::FloatVec2(Vec2(0.5, 2.0)));
    attributes
}

fn layer(name: &str, compression: Compression, blocks: Blocks) -> Part {
    let halves = |k| FlatSamples::F16(plane(k).into_iter().map(f16::from_f32).collect());
    let channels = vec![
        AnyChannel::new("R", halves(0)),
        AnyChannel::new("G", halves(1)),
        AnyChannel::new("B", halves(2)),
        AnyChannel::new("Z", FlatSamples::F32(plane(3))),
        AnyChannel::new(
            "id",
            FlatSamples::U32((0..(WIDTH * HEIGHT) as u32).collect()),
        ),
    ];
    let encoding = Encoding {
        compression,
        blocks,
        line_order: LineOrder::Increasing,
    };
    let channels = AnyChannels::sort(channels.into_iter().collect());
    Layer::new((WIDTH, HEIGHT), attributes(name), encoding, channels)
}

fn encoded(parts: Vec<Part>) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let mut image = Image {
        attributes: exr::prelude::ImageAttributes::with_size((WIDTH, HEIGHT)),
        layer_data: exr::prelude::SmallVec::<[Part; 2]>::from_vec(parts),
    };
    image.attributes.pixel_aspect = 1.0;
    let written = image.write().to_buffered(&mut bytes);
    written.unwrap_or_else(|e| panic!("{e}"));
    bytes.into_inner()
}

/// A picture with smaller versions of itself.
fn mip_maps() -> Vec<u8> {
    let sizes = std::iter::successors(Some((WIDTH, HEIGHT)), |&(w, h)| {
        (w > 1 || h > 1).then(|| ((w / 2).max(1), (h / 2).max(1)))
    });
    let data: Vec<FlatSamples> = sizes
        .map(|(w, h)| FlatSamples::F32(vec![0.5; w * h]))
        .collect();
    let levels = Levels::Mip {
        rounding_mode: RoundingMode::Down,
        level_data: data,
    };
    let list = ["B", "G", "R"].map(|name| AnyChannel::new(name, levels.clone()));
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::Tiles(Vec2(16, 16)),
        line_order: LineOrder::Increasing,
    };
    let channels = AnyChannels::sort(list.into_iter().collect());
    let layer = Layer::new((WIDTH, HEIGHT), attributes(""), encoding, channels);
    let mut bytes = Cursor::new(Vec::new());
    let written = Image::from_layer(layer).write().to_buffered(&mut bytes);
    written.unwrap_or_else(|e| panic!("{e}"));
    bytes.into_inner()
}

/// Type of a deep part in its header.
pub(crate) const DEEP: &[u8] = b"deepscanline";

/// A deep picture, composed here because no writer of deep pictures is among the dependencies: one sample a pixel.
fn deep() -> Vec<u8> {
    let mut bytes = vec![0x76, 0x2f, 0x31, 0x01, 2, 0x08, 0, 0];
    let mut add = |name: &str, kind: &str, value: &[u8]| {
        bytes.extend(format!("{name}\0{kind}\0").bytes());
        bytes.extend((value.len() as i32).to_le_bytes());
        bytes.extend(value);
    };
    // Float samples, without subsampling.
    let channel = [
        &b"Z\0"[..],
        &[2, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0],
    ]
    .concat();
    let window = [0, 0, WIDTH as i32 - 1, HEIGHT as i32 - 1]
        .map(i32::to_le_bytes)
        .concat();
    add("channels", "chlist", &[&channel[..], &[0]].concat());
    add("chunkCount", "int", &(HEIGHT as i32).to_le_bytes());
    add("compression", "compression", &[0]);
    add("dataWindow", "box2i", &window);
    add("displayWindow", "box2i", &window);
    add("lineOrder", "lineOrder", &[0]);
    add("maxSamplesPerPixel", "int", &1_i32.to_le_bytes());
    add("pixelAspectRatio", "float", &1.0_f32.to_le_bytes());
    add("screenWindowCenter", "v2f", &[0; 8]);
    add("screenWindowWidth", "float", &1.0_f32.to_le_bytes());
    add("type", "string", DEEP);
    add("version", "int", &1_i32.to_le_bytes());
    bytes.push(0);
    let chunk = 4 + 3 * 8 + 8 * WIDTH;
    let first = bytes.len() + 8 * HEIGHT;
    for row in 0..HEIGHT {
        bytes.extend(((first + row * chunk) as u64).to_le_bytes());
    }
    for row in 0..HEIGHT {
        bytes.extend((row as i32).to_le_bytes());
        for length in [4 * WIDTH, 4 * WIDTH, 4 * WIDTH] {
            bytes.extend((length as u64).to_le_bytes());
        }
        bytes.extend((1..=WIDTH as i32).flat_map(i32::to_le_bytes));
        bytes.extend((0..WIDTH).flat_map(|x| (x as f32).to_le_bytes()));
    }
    bytes
}
