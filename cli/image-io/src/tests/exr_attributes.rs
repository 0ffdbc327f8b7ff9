//! Attributes of OpenEXR files that have a standard name and another type than the standard's.

use std::path::Path;

use exr::meta::attribute::{AttributeValue, Text};
use exr::prelude::{Compression, Vec2};

use super::{floats, image, part, patch, save};
use crate::formats::exr::ExrImage;
use crate::plate::{PlateFile, PlateOptions};

/// Writes a picture with an attribute whose name ends in another letter, and corrects that letter.
fn write(path: &Path, name: &str, value: AttributeValue) {
    let mut one = part(
        None,
        (3, 2),
        (0, 0),
        Compression::ZIP1,
        vec![("Y", floats(6))],
    );
    let stand_in = format!("{}~", &name[..name.len() - 1]);
    one.attributes
        .other
        .insert(Text::from(stand_in.as_str()), value);
    save(&image(vec![one]), path);
    patch(path, stand_in.as_bytes(), name.as_bytes());
}

/// Returns the bytes of an attribute in a file, with name, type and size.
fn stored(path: &Path, name: &str) -> Option<Vec<u8>> {
    let bytes = std::fs::read(path).expect("a file");
    let start = [name.as_bytes(), b"\0"].concat();
    let at = bytes.windows(start.len()).position(|own| own == start)?;
    let kind_end = at + start.len() + bytes[at + start.len()..].iter().position(|b| *b == 0)? + 1;
    let size = i32::from_le_bytes(bytes[kind_end..kind_end + 4].try_into().ok()?) as usize;
    Some(bytes[at..kind_end + 4 + size].to_vec())
}

fn text(value: &str) -> AttributeValue {
    AttributeValue::Text(Text::from(value))
}

#[test]
fn standard_attributes_of_another_type_come_out_as_they_went_in() {
    let folder = tempfile::tempdir().expect("a folder");
    let (source, target) = (folder.path().join("in.exr"), folder.path().join("out.exr"));
    for (name, value) in [
        ("framesPerSecond", AttributeValue::F32(24.0)),
        ("framesPerSecond", AttributeValue::IntVec2(Vec2(24, 1))),
        ("timeCode", text("01:02:03:04")),
        ("multiView", text("left,right")),
        ("owner", AttributeValue::I32(1)),
        ("expTime", text("1/48")),
        ("view", AttributeValue::I32(0)),
        ("near", AttributeValue::F64(0.1)),
        ("preview", text("none")),
        ("keyCode", text("abc")),
        ("envmap", AttributeValue::I32(0)),
        ("chromaticities", text("rec709")),
        ("maxSamplesPerPixel", text("4")),
        ("maxSamplesPerPixel", AttributeValue::I32(4)),
        ("version", AttributeValue::I32(1)),
        ("version", text("1.2")),
        ("tiles", text("none")),
        ("dwaCompressionLevel", AttributeValue::F32(45.0)),
    ] {
        write(&source, name, value);
        let plate = PlateFile::open(&source, &PlateOptions::default()).expect("opens");
        plate.check_output(&target).expect("known before the work");
        plate.write(&target).expect("writes");
        assert_eq!(stored(&source, name), stored(&target, name), "{name}");
        assert!(stored(&target, name).is_some(), "{name}");
        let again = ExrImage::open(&target).expect("opens again");
        assert!(again.colour(None).is_ok());
    }
}

#[test]
fn required_attributes_of_another_type_are_refused_when_they_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let source = folder.path().join("in.exr");
    write(&source, "pixelAspectRatio", AttributeValue::F64(1.0));
    let error = ExrImage::open(&source)
        .expect_err("two pixel aspects")
        .to_string();
    assert!(
        error.contains("pixelAspectRatio") && error.contains("float"),
        "{error}"
    );
}

#[test]
fn what_cannot_be_written_again_is_known_before_the_work() {
    let folder = tempfile::tempdir().expect("a folder");
    let (source, target) = (folder.path().join("in.exr"), folder.path().join("out.exr"));
    let one = part(
        None,
        (3, 2),
        (0, 0),
        Compression::ZIP1,
        vec![("Y", floats(6))],
    );
    save(&image(vec![one]), &source);
    // The library reads a pixel aspect of zero and refuses to write it.
    let name = b"pixelAspectRatio\0float\0\x04\0\0\0";
    let from = [&name[..], &1_f32.to_le_bytes()].concat();
    patch(&source, &from, &[&name[..], &0_f32.to_le_bytes()].concat());
    let plate = PlateFile::open(&source, &PlateOptions::default()).expect("opens");
    let error = plate
        .check_output(&target)
        .expect_err("no pixel aspect")
        .to_string();
    assert!(
        error.contains("in.exr") && error.contains("pixel aspect"),
        "{error}"
    );
}
