//! Time code, frame rate and what else EXR and DPX both have a place for: from one to the other and back.

use std::fs;
use std::path::Path;

use exr::image::FlatSamples;
use exr::meta::attribute::{AttributeValue, Text, TimeCode};
use exr::prelude::Compression;

use super::dpx_plates::Made;
use super::{image, part, save};
use crate::description::Description;
use crate::exr::plate::ExrPlate;
use crate::plate::{Plate, PlateOptions};

/// 01:02:03;04 with user bits 8 7 6 5 4 3 2 1.
fn code() -> TimeCode {
    TimeCode::from_tv60_time(0x0102_0344, 0x1234_5678)
}

/// Where on a film the picture is: 1 2 345678 9 10, and 3 perforations a frame.
fn film() -> AttributeValue {
    AttributeValue::Custom {
        // That of key codes while the library writes them.
        kind: Text::from("keycodX"),
        bytes: [1, 2, 345_678, 9, 10, 3, 64]
            .iter()
            .flat_map(|v: &i32| v.to_le_bytes())
            .collect(),
    }
}

/// An EXR that says all of it, and a comment.
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
        ("keyCodX", film()),
        ("shutterAngle", AttributeValue::F32(172.8)),
    ] {
        own.other.insert(Text::from(name), value);
    }
    let mut image = image(vec![part]);
    image.attributes.time_code = Some(code());
    save(&image, path);
}

fn open(path: &Path) -> Plate {
    Plate::open(path, &PlateOptions::default()).expect("opens")
}

#[test]
fn they_go_from_exr_to_dpx_and_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    write_exr(&path("a.exr"), "nobody");
    let said = open(&path("a.exr")).write(&path("a.dpx")).expect("writes");
    let said = said.join("\n");
    let names = "timeCode, framesPerSecond, owner, capDate, cameraModel, cameraSerialNumber, shutterAngle, keyCode";
    assert!(
        said.contains(&format!(
            "attributes of the EXR are left out but for {names}"
        )),
        "{said}"
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
    let lines = Description::of(&path("a.dpx")).expect("opens").lines();
    for line in [
        "time code: 01:02:03:04 drop frame",
        "frame rate: 23.976025",
        "copyright: nobody",
        "input device: a camera",
        "shutter angle: 172.8",
    ] {
        assert!(lines.iter().any(|own| own.contains(line)), "{lines:?}");
    }
    let said = open(&path("a.dpx")).write(&path("b.exr")).expect("writes");
    let said = said.join("\n");
    assert!(
        said.contains(&format!("header of the DPX but for {names}")),
        "{said}"
    );
    let (was, is) = (
        ExrPlate::open(&path("a.exr")),
        ExrPlate::open(&path("b.exr")),
    );
    let facts = |plate: ExrPlate| {
        let id = plate.channels()[0].id;
        plate.facts(id)
    };
    let (mut was, is) = (facts(was.expect("opens")), facts(is.expect("opens")));
    assert_eq!(was.names().len(), 8);
    // What DPX does not say of film.
    let code = was.key_code.as_mut().expect("a key code");
    assert_eq!(
        (code.film_roll_prefix, code.perforations_per_frame),
        (345_678, 3)
    );
    code.perforations_per_frame = 4;
    assert_eq!(is, was);
    // Other formats say so too.
    let said = open(&path("a.exr")).write(&path("a.tif")).expect("writes");
    assert!(said.contains(&"the attributes of the EXR are left out".to_owned()));
}

#[test]
fn what_does_not_fit_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    write_exr(&path("a.exr"), &"long ".repeat(60));
    let said = open(&path("a.exr")).write(&path("a.dpx")).expect("writes");
    assert!(
        said.contains(
            &"DPX has no room for owner, the perforations per frame and count of keyCode: left out"
                .to_owned()
        ),
        "{said:?}"
    );
    let lines = Description::of(&path("a.dpx")).expect("opens").lines();
    assert!(!lines.concat().contains("long"), "{lines:?}");
}

#[test]
fn codes_and_rates_that_are_none_are_not_taken_for_some() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, exr) = (folder.path().join("a.dpx"), folder.path().join("a.exr"));
    let facts = |big_endian: bool, code: u32, film: f32, television: f32| {
        let mut made = Made::new(big_endian, (1, 1), 0).element(50, 16, 0);
        made.put32(1920, code);
        made.put32(1724, film.to_bits());
        made.put32(1940, television.to_bits());
        made.words16(&[1, 2, 3]).save(&path);
        open(&path).write(&exr).expect("writes");
        let plate = ExrPlate::open(&exr).expect("opens");
        plate.facts(plate.channels()[0].id)
    };
    for big_endian in [true, false] {
        let sound = facts(big_endian, 0x2359_5924, f32::NAN, 25.0);
        let code = sound.time_code.expect("a code");
        assert_eq!(
            (code.hours, code.minutes, code.seconds, code.frame),
            (23, 59, 59, 24)
        );
        assert_eq!(code.binary_groups, [0; 8]);
        assert_eq!(sound.frame_rate, Some((25, 1)));
        assert_eq!(sound.names(), ["timeCode", "framesPerSecond"]);
        assert_eq!(
            facts(big_endian, 0, 24.0, 25.0).frame_rate,
            Some((24, 1)),
            "film's first"
        );
        for bad in [u32::MAX, 0x2459_5900, 0x0a00_0000, 0x0060_0000, 0x0000_0030] {
            let facts = facts(big_endian, bad, f32::INFINITY, -24.0);
            assert!(facts.names().is_empty(), "{bad:x}: {facts:?}");
        }
    }
}
