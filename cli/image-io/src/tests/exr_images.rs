//! OpenEXR images: everything but the replaced channels is written bit for bit.

use std::path::Path;

use exr::image::{AnyImage, FlatSamples, Levels};
use exr::meta::attribute::{AttributeValue, Chromaticities, SampleType, Text, TimeCode};
use exr::prelude::{Compression, Vec2, read_all_data_from_file};

use super::{floats, halves, image, part, patch, save};
use crate::formats::exr::{DepthOwner, ExrImage};
use crate::image_channel::{ChannelSpec, ImageChannel};
use crate::plate::{PlateFile, PlateOptions};
use crate::windows::ImageWindows;
use seidel_optics::Rectangle;

/// Returns all samples as bits, so that NaN payloads are compared too.
fn bits(image: &AnyImage, part: usize, channel: &str) -> Vec<u32> {
    let list = &image.layer_data[part].channel_data.list;
    let channel = list
        .iter()
        .find(|c| c.name.to_string() == channel)
        .expect("the channel");
    let Levels::Singular(samples) = &channel.sample_data else {
        panic!("one level");
    };
    match samples {
        FlatSamples::F16(s) => s.iter().map(|v| u32::from(v.to_bits())).collect(),
        FlatSamples::F32(s) => s.iter().map(|v| v.to_bits()).collect(),
        FlatSamples::U32(s) => s.clone(),
    }
}

/// An image of three parts: half colour with an AOV, float depth with NaN and infinity, and identifiers.
fn multi_part() -> AnyImage {
    let ids = FlatSamples::U32((0..24).map(|i| u32::MAX - i * 7).collect());
    let mut depth = (0..24).map(|i| i as f32).collect::<Vec<_>>();
    depth[3] = f32::INFINITY;
    depth[4] = f32::from_bits(0x7fc1_2345);
    let mut beauty = part(
        Some("rgba"),
        (6, 4),
        (-3, -2),
        Compression::PIZ,
        vec![
            ("R", halves(24)),
            ("G", halves(24)),
            ("B", halves(24)),
            ("A", halves(24)),
            ("diffuse.R", floats(24)),
            ("diffuse.G", floats(24)),
            ("diffuse.B", floats(24)),
        ],
    );
    let other = &mut beauty.attributes.other;
    other.insert("shot".into(), AttributeValue::Text("sh010".into()));
    other.insert("lens".into(), AttributeValue::FloatVec2(Vec2(35.0, 1.4)));
    other.insert(
        "studio".into(),
        AttributeValue::Custom {
            kind: "studioType".into(),
            bytes: vec![1_u8, 2, 3].into(),
        },
    );
    beauty.attributes.comments = Some("first".into());
    let z = part(
        Some("depth"),
        (6, 4),
        (-3, -2),
        Compression::ZIP1,
        vec![("Z", FlatSamples::F32(depth))],
    );
    let id = part(
        Some("id"),
        (6, 4),
        (-3, -2),
        Compression::RLE,
        vec![("id", ids)],
    );
    let mut all = image(vec![beauty, z, id]);
    all.attributes.time_code = Some(TimeCode::from_tv60_time(0x0102_0304, 7));
    all.attributes.chromaticities = Some(Chromaticities {
        red: Vec2(0.7, 0.3),
        green: Vec2(0.2, 0.7),
        blue: Vec2(0.1, 0.1),
        white: Vec2(0.3, 0.3),
    });
    all
}

/// Asserts that two images differ in no channel but those `changed`.
fn assert_unchanged_except(before: &AnyImage, after: &AnyImage, changed: &[&str]) {
    assert_eq!(before.attributes, after.attributes);
    assert_eq!(before.layer_data.len(), after.layer_data.len());
    for (index, (a, b)) in before.layer_data.iter().zip(&after.layer_data).enumerate() {
        assert_eq!(a.attributes, b.attributes);
        assert_eq!((a.size, a.encoding), (b.size, b.encoding));
        assert_eq!(a.channel_data.list.len(), b.channel_data.list.len());
        for channel in &a.channel_data.list {
            let name = channel.name.to_string();
            if !changed.contains(&name.as_str()) {
                assert_eq!(
                    bits(before, index, &name),
                    bits(after, index, &name),
                    "{name}"
                );
            }
        }
    }
}

#[test]
fn everything_that_is_not_replaced_is_written_bit_for_bit() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let (source, target) = (folder.path().join("in.exr"), folder.path().join("out.exr"));
    save(&multi_part(), &source);
    let original = read_all_data_from_file(&source).expect("reads");
    let mut plate = ExrImage::open(&source).expect("opens");
    assert!(plate.warnings().is_empty(), "{:?}", plate.warnings());
    plate.write(&target).expect("writes");
    assert_unchanged_except(
        &original,
        &read_all_data_from_file(&target).expect("reads"),
        &[],
    );

    let group = plate.colour(None).expect("R, G, B");
    assert_eq!(group.names, ["R", "G", "B"]);
    assert!(group.alpha.is_some());
    let window = plate.data_window(group.colour[0]);
    assert_eq!(
        (window.x, window.y, window.width, window.height),
        (-3, -2, 6, 4)
    );
    assert_eq!(plate.display_window().width, 20);
    let mut samples = vec![0.1; 24];
    (samples[0], samples[1], samples[2]) = (1e6, -1e6, f32::NAN);
    plate
        .replace(group.colour[0], &samples)
        .expect("24 samples");
    assert!(plate.replace(group.colour[0], &samples[1..]).is_err());
    plate.write(&target).expect("writes");
    let after = read_all_data_from_file(&target).expect("reads");
    assert_unchanged_except(&original, &after, &["R"]);
    let red = bits(&after, 0, "R");
    assert_eq!(red[0], 0x7bff, "saturates at 65504");
    assert_eq!(red[1], 0xfbff);
    assert_eq!(red[5], u32::from(half::f16::from_f32(0.1).to_bits()));
    assert!(
        plate.warnings()[0].contains("2 samples"),
        "{:?}",
        plate.warnings()
    );
    let mut plate = PlateFile::open(&source, &PlateOptions::default()).expect("opens");
    plate
        .set_colour(&[samples, vec![0.1; 24], vec![0.1; 24]])
        .expect("24 samples");
    assert_eq!(plate.non_finite()[0].first, (2, 0));
}

#[test]
fn channels_are_found_by_layer_part_and_name() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("in.exr");
    save(&multi_part(), &path);
    let plate = ExrImage::open(&path).expect("opens");
    let group = plate.colour(Some("diffuse")).expect("dotted layer");
    assert_eq!(plate.channel_name(group.colour[2]), "diffuse.B");
    assert_eq!(group.alpha, None);
    let group = plate.colour(Some("rgba")).expect("part");
    assert_eq!(plate.channel_name(group.colour[0]), "R");
    let error = plate.colour(Some("specular")).expect_err("no such layer");
    assert!(error.to_string().contains("rgba:diffuse.R"), "{error}");
    assert!(error.to_string().contains("--layer"), "{error}");
    let z = plate.depth_channel(None, DepthOwner::Unknown).expect("Z");
    assert_eq!(plate.channel_name(z), "Z");
    assert_eq!(
        plate
            .depth_channel(Some("depth:z"), DepthOwner::Unknown)
            .expect("any case"),
        z
    );
    let id = plate
        .depth_channel(Some("id"), DepthOwner::Unknown)
        .expect("by name");
    assert_eq!(
        plate
            .channels()
            .iter()
            .find(|c| c.id == id)
            .expect("it")
            .sample_type,
        SampleType::U32
    );
    let error = plate
        .depth_channel(Some("W"), DepthOwner::Unknown)
        .expect_err("no such channel");
    assert!(error.to_string().contains("depth:Z"), "{error}");
}

#[test]
fn monochrome_and_lower_case_channels_are_found() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("in.exr");
    let open = |channels: Vec<&'static str>| {
        let channels = channels.into_iter().map(|n| (n, floats(6))).collect();
        save(
            &image(vec![part(
                None,
                (3, 2),
                (0, 0),
                Compression::ZIP16,
                channels,
            )]),
            &path,
        );
        ExrImage::open(&path).expect("opens")
    };
    assert_eq!(open(vec!["Y"]).colour(None).expect("Y").names, ["Y"]);
    let grey = open(vec!["Y"]);
    assert!(
        grey.depth_channel(None, DepthOwner::Unknown).is_err(),
        "its colour"
    );
    assert_eq!(
        ImageChannel::read_depth(&path, None, DepthOwner::Unknown)
            .expect("the only channel")
            .channel,
        "Y"
    );
    assert_eq!(
        open(vec!["b", "g", "r"]).colour(None).expect("rgb").names,
        ["R", "G", "B"]
    );
    let error = open(vec!["BY", "RY", "Y"])
        .colour(None)
        .expect_err("luminance and chroma");
    assert!(error.to_string().contains("BY, RY, Y"), "{error}");
    assert!(
        open(vec!["diffuse.B", "diffuse.G", "diffuse.R"])
            .colour(None)
            .is_err()
    );
    let mask = open(vec!["B", "G", "R", "matte"])
        .colour(Some("matte"))
        .expect("one channel");
    assert_eq!(mask.names, ["Y"]);
}

#[test]
fn lossy_parts_are_written_with_zip_and_a_warning() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let (source, target) = (folder.path().join("in.exr"), folder.path().join("out.exr"));
    for (compression, samples, lossy) in [
        (Compression::B44, halves(60), true),
        (Compression::B44A, halves(60), true),
        (Compression::DWAA(Some(45.0)), halves(60), true),
        (Compression::PXR24, floats(60), true),
        (Compression::PXR24, halves(60), false),
        (Compression::ZIP1, floats(60), false),
    ] {
        save(
            &image(vec![part(
                None,
                (10, 6),
                (0, 0),
                compression,
                vec![("Y", samples)],
            )]),
            &source,
        );
        let read = read_all_data_from_file(&source).expect("reads");
        let plate = ExrImage::open(&source).expect("opens");
        plate.write(&target).expect("writes");
        let after = read_all_data_from_file(&target).expect("reads");
        assert_eq!(bits(&read, 0, "Y"), bits(&after, 0, "Y"), "{compression}");
        let expected = if lossy {
            Compression::ZIP16
        } else {
            compression
        };
        assert_eq!(after.layer_data[0].encoding.compression, expected);
        assert_eq!(
            plate.warnings().len(),
            usize::from(lossy),
            "{:?}",
            plate.warnings()
        );
    }
}

#[test]
fn film_key_codes_are_kept() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let (source, target) = (folder.path().join("in.exr"), folder.path().join("out.exr"));
    let mut all = image(vec![part(
        None,
        (3, 2),
        (0, 0),
        Compression::ZIP16,
        vec![("Y", floats(6))],
    )]);
    // The library writes wrong key codes, so correct ones are written as custom attributes and patched.
    let codes: Vec<u8> = [11_i32, 22, 33, 44, 55, 4, 64]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    for name in ["keyCodY", "scanned"] {
        all.layer_data[0].attributes.other.insert(
            name.into(),
            AttributeValue::Custom {
                kind: "keycodY".into(),
                bytes: codes.clone().into(),
            },
        );
    }
    save(&all, &source);
    patch(&source, b"keyCodY\0keycodY\0", b"keyCode\0keycode\0");
    patch(&source, b"scanned\0keycodY\0", b"scanned\0keycode\0");
    let read = read_all_data_from_file(&source).expect("reads");
    assert!(
        read.layer_data[0].attributes.film_key_code.is_some(),
        "the test's own file"
    );

    let plate = ExrImage::open(&source).expect("opens");
    plate.write(&target).expect("writes");
    let after = read_all_data_from_file(&target).expect("a valid file");
    let attributes = &after.layer_data[0].attributes;
    let code = attributes.film_key_code.expect("a key code");
    assert_eq!(Some(code), read.layer_data[0].attributes.film_key_code);
    assert_eq!((code.count, code.perforations_per_count), (44, 64));
    assert_eq!(
        attributes.other.get(&Text::from("scanned")),
        Some(&AttributeValue::KeyCode(code))
    );
    assert_eq!(bits(&read, 0, "Y"), bits(&after, 0, "Y"));
    assert_eq!(plate.warnings(), Vec::<String>::new());
    // All seven numbers, and the length of the format.
    let bytes = std::fs::read(&target).expect("a file");
    let whole = [&b"keyCode\0keycode\0\x1c\0\0\0"[..], &codes].concat();
    assert!(bytes.windows(whole.len()).any(|part| part == whole));
}

/// Returns a display window of half the size.
fn display_of_half(display: Rectangle) -> Rectangle {
    Rectangle {
        width: display.width / 2,
        height: display.height / 2,
        ..display
    }
}

#[test]
fn depth_passes_are_fitted_to_the_plate() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("in.exr");
    save(&multi_part(), &path);
    let pass = ImageChannel::read_depth(&path, None, DepthOwner::Unknown).expect("Z");
    assert_eq!((pass.channel.as_str(), pass.samples[7]), ("depth:Z", 7.0));
    let inner = Rectangle {
        x: -2,
        y: -1,
        width: 2,
        height: 2,
    };
    let fit = |data: Rectangle, display: Rectangle| pass.fit_to(ImageWindows { data, display });
    let display = pass.windows.display;
    let cropped = fit(inner, display).expect("inside");
    assert_eq!(cropped.samples, [7.0, 8.0, 13.0, 14.0]);
    assert_eq!(cropped.warning, None);
    let moved = Rectangle {
        x: 0,
        y: 0,
        width: 6,
        height: 4,
    };
    assert_eq!(fit(moved, moved).expect("same size").samples.len(), 24);
    let wider = Rectangle { width: 7, ..moved };
    let error = fit(wider, wider).expect_err("not covered");
    assert!(error.to_string().contains("7x4"), "{error}");
    // It would cover a plate of a smaller frame, but shows another part of the scene or another scale of it.
    let smaller = display_of_half(display);
    let error = fit(inner, smaller).expect_err("another frame").to_string();
    for window in [display, smaller] {
        assert!(error.contains(&window.to_string()), "{error}");
    }
    // Overscan of the same frame.
    let expanded = pass.windows.data.expanded(2, 1);
    let extended = fit(expanded, display).expect("the same frame");
    assert!(
        extended
            .warning
            .is_some_and(|warning| warning.contains("extended"))
    );
    let rows: Vec<&[f32]> = extended.samples.chunks_exact(10).collect();
    assert_eq!(rows.len(), 6);
    assert_eq!(rows[0][..5], rows[1][..5]);
    assert_eq!(
        rows[2],
        [6.0, 6.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 11.0, 11.0]
    );
    assert_eq!(rows[5][9], 23.0);
    for (text, file, channel) in [
        ("z.exr", "z.exr", None),
        ("z.exr:depth.Z", "z.exr", Some("depth.Z")),
        ("C:/a/z.exr", "C:/a/z.exr", None),
        ("C:\\a\\z.exr:Z", "C:\\a\\z.exr", Some("Z")),
        ("C:z.exr", "C:z.exr", None),
        ("a:b/z.exr", "a:b/z.exr", None),
        ("z.%04d.exr:part:Z", "z.%04d.exr", Some("part:Z")),
        (
            "C:\\a\\z.exr:left.main:Z",
            "C:\\a\\z.exr",
            Some("left.main:Z"),
        ),
        ("z.tif:Shadow/Z", "z.tif", Some("Shadow/Z")),
        ("no_name:Z", "no_name", Some("Z")),
        ("z.exr:", "z.exr:", None),
    ] {
        let spec = ChannelSpec::parse(text);
        assert_eq!(
            (spec.file.as_path(), spec.channel.as_deref()),
            (Path::new(file), channel),
            "{text}"
        );
    }
}

#[test]
fn unsupported_formats_and_missing_files_are_refused() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("in.exr");
    save(&multi_part(), &path);
    let mut plate = PlateFile::open(&path, &PlateOptions::default()).expect("opens");
    assert!(plate.has_alpha());
    let planes = plate.colour();
    plate.set_colour(&planes).expect("same planes");
    let error = plate
        .write(Path::new("out.jpg"))
        .expect_err("never written");
    assert!(error.to_string().contains(".exr"), "{error}");
    let missing = PlateFile::open(&folder.path().join("no.exr"), &PlateOptions::default());
    assert!(missing.expect_err("no file").to_string().contains("no.exr"));
    let text = folder.path().join("a.jpg");
    std::fs::write(&text, "no picture").expect("writes");
    let error = PlateFile::open(&text, &PlateOptions::default()).expect_err("no picture");
    assert!(error.to_string().contains("OpenEXR (.exr), PNG"), "{error}");
}

#[test]
fn mip_levels_are_dropped_when_a_channel_of_their_part_changes() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let (source, target) = (folder.path().join("in.exr"), folder.path().join("out.exr"));
    let mut all = image(vec![part(
        None,
        (4, 4),
        (0, 0),
        Compression::ZIP16,
        vec![("Y", floats(16)), ("Z", floats(16))],
    )]);
    let layer = &mut all.layer_data[0];
    layer.encoding.blocks = exr::image::Blocks::Tiles(Vec2(2, 2));
    for channel in &mut layer.channel_data.list {
        channel.sample_data = Levels::Mip {
            rounding_mode: exr::math::RoundingMode::Down,
            level_data: vec![floats(16), floats(4), floats(1)],
        };
    }
    save(&all, &source);
    let mut plate = ExrImage::open(&source).expect("opens");
    plate.write(&target).expect("writes");
    let whole = read_all_data_from_file(&target).expect("reads");
    assert_eq!(
        whole.layer_data[0].channel_data,
        all.layer_data[0].channel_data
    );
    let grey = plate.colour(None).expect("Y").colour[0];
    plate.replace(grey, &[0.5; 16]).expect("16 samples");
    assert!(
        plate.warnings()[0].contains("mip"),
        "{:?}",
        plate.warnings()
    );
    plate.write(&target).expect("writes");
    let after = read_all_data_from_file(&target).expect("reads");
    assert_eq!(bits(&after, 0, "Y"), [0.5_f32.to_bits(); 16]);
    let FlatSamples::F32(depth) = floats(16) else {
        panic!("floats")
    };
    assert_eq!(
        bits(&after, 0, "Z"),
        depth.iter().map(|v| v.to_bits()).collect::<Vec<_>>()
    );
}
