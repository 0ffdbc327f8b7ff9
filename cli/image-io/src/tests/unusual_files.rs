//! Valid files of unusual layouts. A reader reads them, or names the layout that it does not support; it calls none damaged.

use std::path::Path;

use exr::prelude::Compression;

use super::{floats, image, part, save};
use crate::formats::exr::ExrImage;
use crate::plate::{PlateFile, PlateOptions};

/// Returns a little-endian TIFF of `tags`, with `data` at `count` equal offsets that `offset_tag` states.
fn tiff(tags: &[(u16, Vec<u32>)], offset_tag: u16, count: usize, data: &[u8]) -> Vec<u8> {
    let mut tags = tags.to_vec();
    tags.push((offset_tag, vec![8; count]));
    tags.sort_unstable();
    let at = 8 + data.len() as u32;
    let mut bytes = [&b"II*\0"[..], &at.to_le_bytes(), data].concat();
    bytes.extend((tags.len() as u16).to_le_bytes());
    let mut beyond = at + 2 + 12 * tags.len() as u32 + 4;
    let mut tail = Vec::new();
    for (tag, values) in tags {
        let number = values.len() as u32;
        bytes.extend([&tag.to_le_bytes()[..], &[4, 0], &number.to_le_bytes()].concat());
        if let [only] = values[..] {
            bytes.extend(only.to_le_bytes());
        } else {
            bytes.extend(beyond.to_le_bytes());
            beyond += 4 * number;
            tail.extend(values.iter().flat_map(|v| v.to_le_bytes()));
        }
    }
    bytes.extend([0; 4]);
    bytes.extend(tail);
    bytes
}

fn one(tags: &[(u16, u32)]) -> Vec<(u16, Vec<u32>)> {
    tags.iter()
        .map(|(tag, value)| (*tag, vec![*value]))
        .collect()
}

fn grey(compression: u32, bits: u32) -> Vec<(u16, Vec<u32>)> {
    let bytes = 256 * bits / 8;
    one(&[
        (256, 16),
        (257, 16),
        (258, bits),
        (259, compression),
        (262, 1),
        (277, 1),
        (278, 16),
        (279, bytes),
    ])
}

fn refused(path: &Path, bytes: &[u8]) -> String {
    std::fs::write(path, bytes).expect("writes");
    let error = PlateFile::open(path, &PlateOptions::default())
        .expect_err("not supported")
        .to_string();
    assert!(
        error.contains("not supported") && error.contains("save it"),
        "{error}"
    );
    error
}

#[test]
fn layouts_of_tiff_that_are_not_read_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.tif");
    let old = refused(&path, &tiff(&grey(5, 8), 273, 1, &[0, 1, 2, 3, 4, 5, 6, 7]));
    assert!(old.contains("LZW as before TIFF 6.0"), "{old}");
    let deep = refused(&path, &tiff(&grey(1, 24), 273, 1, &[0; 768]));
    assert!(deep.contains("24 bits"), "{deep}");
    let mut planar = one(&[
        (256, 20),
        (257, 16),
        (259, 1),
        (262, 2),
        (277, 3),
        (284, 2),
        (322, 32),
        (323, 32),
    ]);
    planar.extend([(258, vec![8; 3]), (325, vec![1024; 3])]);
    let tiles = refused(&path, &tiff(&planar, 324, 3, &[0; 1024]));
    assert!(tiles.contains("tiles of 32 x 32"), "{tiles}");
}

#[test]
fn the_orientation_of_a_tiff_is_noted() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.tif");
    for (orientation, count) in [(1, 0), (6, 1)] {
        let mut tags = grey(1, 8);
        tags.push((274, vec![orientation]));
        std::fs::write(&path, tiff(&tags, 273, 1, &[9; 256])).expect("writes");
        let plate = PlateFile::open(&path, &PlateOptions::default()).expect("opens");
        assert_eq!(
            plate.read_warnings().len(),
            count,
            "{:?}",
            plate.read_warnings()
        );
    }
}

#[test]
fn blocks_are_found_without_their_offsets() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("in.exr");
    let count = 7_u64;
    for compression in [Compression::ZIP1, Compression::Uncompressed] {
        let channels = vec![("Y", floats(35)), ("Z", floats(35))];
        let one = part(None, (5, count as usize), (0, 0), compression, channels);
        save(&image(vec![one]), &path);
        let whole = ExrImage::open(&path).expect("opens");
        let mut bytes = std::fs::read(&path).expect("a file");
        // The first block stands behind the offsets.
        let is_table = |at: &usize| bytes[*at..*at + 8] == (*at as u64 + 8 * count).to_le_bytes();
        let table = (8..bytes.len() - 8).find(is_table).expect("offsets");
        for zeros in [1, count as usize] {
            bytes[table..table + 8 * zeros].fill(0);
            std::fs::write(&path, &bytes).expect("writes");
            let image = ExrImage::open(&path).expect("whole blocks");
            for (own, was) in image.channels().iter().zip(whole.channels()) {
                assert_eq!(image.samples(own.id), whole.samples(was.id));
            }
        }
        bytes.truncate(bytes.len() - 3);
        std::fs::write(&path, &bytes).expect("writes");
        assert!(ExrImage::open(&path).is_err(), "truncated");
    }
}
