//! Metadata that both EXR and DPX store, converted from one to the other and back.

use std::fs;
use std::path::Path;

use exr::image::FlatSamples;
use exr::meta::attribute::{AttributeValue, Text, TimeCode};
use exr::prelude::Compression;

use super::dpx_files::DpxBuilder;
use super::{image, part, patch, save};
use crate::description::Description;
use crate::formats::dpx::byte_order::ByteOrder;
use crate::formats::exr::ExrImage;
use crate::plate::{PlateFile, PlateOptions};

/// 01:02:03;04 with user bits 8 7 6 5 4 3 2 1.
fn code() -> TimeCode {
    TimeCode::from_tv60_time(0x0102_0344, 0x1234_5678)
}

/// A film key code: 1 2 345678 9 10, with 3 perforations per frame.
fn key_code() -> AttributeValue {
    AttributeValue::Custom {
        kind: Text::from("keycodX"),
        bytes: [1, 2, 345_678, 9, 10, 3, 64]
            .iter()
            .flat_map(|v: &i32| v.to_le_bytes())
            .collect(),
    }
}

/// Writes an EXR with all common metadata, and a comment.
fn write_exr(path: &Path, owner: &str) {
    let planes = ["B", "G", "R"].map(|n| (n, FlatSamples::F32(vec![0.25; 200])));
    let mut part = part(None, (20, 10), (0, 0), Compression::ZIP16, planes.to_vec());
    let own = &mut part.attributes;
    own.frames_per_second = Some((24_000, 1001));
    own.owner = Some(Text::from(owner));
    own.capture_date = Some(Text::from("2026:11:22 10:00:00"));
    own.comments = Some(Text::from("a comment"));
    for (name, value) in [
        ("cameraModel", AttributeValue::Text(Text::from("a camera"))),
        (
            "cameraSerialNumber",
            AttributeValue::Text(Text::from("007")),
        ),
        ("keyCodX", key_code()),
        ("shutterAngle", AttributeValue::F32(172.8)),
    ] {
        own.other.insert(Text::from(name), value);
    }
    let mut image = image(vec![part]);
    image.attributes.time_code = Some(code());
    save(&image, path);
    // The library writes wrong key codes.
    patch(path, b"keyCodX\0keycodX\0", b"keyCode\0keycode\0");
}

fn open(path: &Path) -> PlateFile {
    PlateFile::open(path, &PlateOptions::default()).expect("opens")
}

#[test]
fn common_metadata_round_trip_through_dpx() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    write_exr(&path("a.exr"), "nobody");
    let warnings = open(&path("a.exr")).write(&path("a.dpx")).expect("writes");
    let warnings = warnings.join("\n");
    let names = "timeCode, framesPerSecond, owner, capDate, cameraModel, cameraSerialNumber, shutterAngle, keyCode";
    assert!(
        warnings.contains(&format!(
            "attributes of the EXR are left out except {names}"
        )),
        "{warnings}"
    );
    let file = fs::read(path("a.dpx")).expect("reads");
    let rate = 23.976_025_f32.to_be_bytes();
    for (at, bytes) in [
        (1920, &[1, 2, 3, 0x44][..]),
        (1924, &[0x12, 0x34, 0x56, 0x78]),
        (1724, &rate),
        (1940, &rate),
        (460, b"nobody\0"),
        (136, b"2026:11:22:10:00:00\0"),
        (1532, b"2026:11:22:10:00:00\0"),
        (1556, b"a camera\0"),
        (1588, b"007\0"),
        (1664, b"0102103456780009"),
        (1728, &172.8_f32.to_be_bytes()),
    ] {
        assert_eq!(&file[at..at + bytes.len()], bytes, "{at}");
    }
    let lines = Description::read(&path("a.dpx")).expect("opens").lines();
    for line in [
        "time code: 01:02:03:04 drop frame",
        "frame rate: 23.976025",
        "copyright: nobody",
        "input device: a camera",
        "shutter angle: 172.8",
    ] {
        assert!(lines.iter().any(|own| own.contains(line)), "{lines:?}");
    }
    let warnings = open(&path("a.dpx")).write(&path("b.exr")).expect("writes");
    let warnings = warnings.join("\n");
    assert!(
        warnings.contains(&format!("header of the DPX, except {names}")),
        "{warnings}"
    );
    let (was, is) = (
        ExrImage::open(&path("a.exr")),
        ExrImage::open(&path("b.exr")),
    );
    let common = |plate: ExrImage| {
        let id = plate.channels()[0].id;
        plate.common(id)
    };
    let (mut was, is) = (common(was.expect("opens")), common(is.expect("opens")));
    assert_eq!(was.names().len(), 8);
    // DPX does not store the perforations.
    let code = was.key_code.as_mut().expect("a key code");
    assert_eq!(
        (code.film_roll_prefix, code.perforations_per_frame),
        (345_678, 3)
    );
    code.perforations_per_frame = 4;
    assert_eq!(is, was);
    // Other formats store none.
    let warnings = open(&path("a.exr")).write(&path("a.tif")).expect("writes");
    assert!(warnings.contains(&"the attributes of the EXR are left out".to_owned()));
}

#[test]
fn metadata_that_do_not_fit_cause_a_warning() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    write_exr(&path("a.exr"), &"long ".repeat(60));
    let warnings = open(&path("a.exr")).write(&path("a.dpx")).expect("writes");
    assert!(
        warnings.contains(
            &"DPX has no room for owner, the perforations per frame and count of keyCode: left out"
                .to_owned()
        ),
        "{warnings:?}"
    );
    let lines = Description::read(&path("a.dpx")).expect("opens").lines();
    assert!(!lines.concat().contains("long"), "{lines:?}");
}

#[test]
fn invalid_time_codes_and_rates_are_ignored() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, exr) = (folder.path().join("a.dpx"), folder.path().join("a.exr"));
    let common = |order: ByteOrder, code: u32, film: f32, television: f32| {
        let mut made = DpxBuilder::new(order, 1, 1, 0).element(50, 16, 0);
        made.put32(1920, code);
        made.put32(1724, film.to_bits());
        made.put32(1940, television.to_bits());
        made.words16(&[1, 2, 3]).save(&path);
        open(&path).write(&exr).expect("writes");
        let plate = ExrImage::open(&exr).expect("opens");
        plate.common(plate.channels()[0].id)
    };
    for order in [ByteOrder::Big, ByteOrder::Little] {
        let valid = common(order, 0x2359_5924, f32::NAN, 25.0);
        let code = valid.time_code.expect("a code");
        assert_eq!(
            (code.hours, code.minutes, code.seconds, code.frame),
            (23, 59, 59, 24)
        );
        assert_eq!(code.binary_groups, [0; 8]);
        assert_eq!(valid.frame_rate, Some((25, 1)));
        assert_eq!(valid.names(), ["timeCode", "framesPerSecond"]);
        assert_eq!(
            common(order, 0, 24.0, 25.0).frame_rate,
            Some((24, 1)),
            "the film rate takes precedence"
        );
        for bad in [u32::MAX, 0x2459_5900, 0x0a00_0000, 0x0060_0000, 0x0000_0030] {
            let common = common(order, bad, f32::INFINITY, -24.0);
            assert!(common.names().is_empty(), "{bad:x}: {common:?}");
        }
    }
}
