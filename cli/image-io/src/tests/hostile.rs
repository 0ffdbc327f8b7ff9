//! Property tests of all readers on damaged and hostile files: errors, never panics.

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use exr::prelude::Compression;
use proptest::prelude::*;

use super::dpx_files::DpxBuilder;
use super::metadata::{usual_chunks, write_png, write_tiff};
use super::{floats, halves, image, part, patch, save};
use crate::description::Description;
use crate::format::Format;
use crate::formats::dpx::byte_order::ByteOrder;
use crate::formats::exr::{DepthOwner, ExrImage};
use crate::image_channel::ImageChannel;
use crate::observation_set::{ReadOptions, read};
use crate::plate::{PlateFile, PlateOptions};
use crate::raster::RasterImage;
use crate::tile_image;

/// The bytes of valid files of every format.
static VALID: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = |name: &str| folder.path().join(name);
    let mut names = Vec::new();
    for compression in [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
        Compression::B44,
        Compression::DWAA(None),
    ] {
        let channels = vec![("A", floats(40)), ("G", halves(40))];
        let whole = image(vec![
            part(Some("a"), (8, 5), (0, 0), compression, channels),
            part(
                Some("b"),
                (8, 5),
                (0, 0),
                compression,
                vec![("Z", floats(40))],
            ),
        ]);
        let name = format!("{}.exr", names.len());
        save(&whole, &path(&name));
        names.push(name);
    }
    for name in ["a.png", "b.tif"] {
        image::DynamicImage::new_rgb16(8, 5)
            .save(path(name))
            .expect("saves");
        names.push(name.to_owned());
    }
    let planes = vec![vec![0.5; 40]; 3];
    crate::formats::tiff::write_float(&path("c.tif"), 8, 5, planes).expect("saves");
    names.push("c.tif".to_owned());
    for (descriptor, bits, packing) in [(50, 10, 1), (51, 16, 0), (6, 8, 0)] {
        let order = if bits == 10 {
            ByteOrder::Big
        } else {
            ByteOrder::Little
        };
        let mut made = DpxBuilder::new(order, 8, 5, 16).element(descriptor, bits, packing);
        made.bytes.extend([0x5a; 8 * 5 * 8]);
        let name = format!("{bits}.dpx");
        made.save(&path(&name));
        names.push(name);
    }
    image::DynamicImage::new_rgb32f(9, 5)
        .save(path("d.hdr"))
        .expect("saves");
    image::DynamicImage::new_rgb8(8, 5)
        .save(path("e.jpg"))
        .expect("saves");
    // With many metadata, and contiguous samples.
    write_png(&path("f.png"), png::BitDepth::Sixteen, &usual_chunks(), &[]);
    write_tiff(&path("g.tif"));
    let mut made = DpxBuilder::new(ByteOrder::Little, 8, 5, 0).element(50, 12, 0);
    made.bytes.extend([0x5a; 5 * 36]);
    made.save(&path("12.dpx"));
    names.extend(["d.hdr", "e.jpg", "f.png", "g.tif", "12.dpx"].map(str::to_owned));
    let plate = PlateFile::open(&path("a.png"), &PlateOptions::default()).expect("opens");
    for format in Format::writable() {
        let name = format!("converted.{}", format.extension());
        plate.write(&path(&name)).expect("writes");
        names.push(name);
    }
    names
        .iter()
        .map(|n| fs::read(path(n)).expect("reads"))
        .collect()
});

/// Offsets of the header fields that determine how a DPX is read, four bytes each.
const DPX_FIELDS: [usize; 13] = [0, 4, 16, 768, 772, 776, 780, 800, 804, 808, 812, 816, 1628];

/// Reads a file in every way. Only a panic or an abort fails the test.
fn read_in_every_way(path: &Path) {
    let _ = PlateFile::open(path, &PlateOptions::default());
    let _ = ImageChannel::read_depth(path, None, DepthOwner::Unknown);
    let _ = Description::read(path);
    if let Ok(plate) = RasterImage::open(path) {
        // Writes all metadata that were read.
        let _ = plate.write(&path.with_extension("out"));
    }
    let _ = tile_image::read(path, &["Y".to_owned()]);
}

/// Returns the offset of the leader of the first DWA chunk of a file.
fn dwa_leader(bytes: &[u8]) -> usize {
    // Row 0 as 32 bits, the length of the chunk as 32 bits, and version 2 as 64 bits.
    let is_chunk = |w: &[u8]| w[..4] == [0; 4] && w[4] > 0 && w[8..] == [2, 0, 0, 0, 0, 0, 0, 0];
    let chunk = bytes.windows(16).position(is_chunk);
    chunk.expect("a compressed chunk") + 8
}

#[test]
fn absurd_sizes_in_dwa_chunks_are_refused_before_memory_is_allocated() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("a.exr");
    for method in [Compression::DWAA(None), Compression::DWAB(None)] {
        let smooth = |scale: f32| {
            let samples = (0..64 * 40).map(|k| half::f16::from_f32(scale * (k % 64) as f32));
            exr::image::FlatSamples::F16(samples.collect())
        };
        let names = ["A", "B", "G", "R", "Z"].map(|name| (name, smooth(0.01)));
        let channels = names.into_iter().collect();
        save(
            &image(vec![part(None, (64, 40), (0, 0), method, channels)]),
            &path,
        );
        let sound = fs::read(&path).expect("reads");
        PlateFile::open(&path, &PlateOptions::default()).expect("a sound file");
        let leader = dwa_leader(&sound);
        // All counters but the version and the kind of entropy coding.
        for counter in 1..10 {
            for claim in [1 << 40, 1 << 62, u64::MAX] {
                let at = leader + 8 * counter;
                let mut bytes = sound.clone();
                bytes[at..at + 8].copy_from_slice(&u64::to_le_bytes(claim));
                fs::write(&path, bytes).expect("writes");
                let error = PlateFile::open(&path, &PlateOptions::default()).expect_err("absurd");
                let text = error.to_string();
                assert!(text.contains("a.exr: is damaged"), "{text}");
                assert!(text.contains(" of a DWA chunk is "), "{counter}: {text}");
            }
        }
    }
}

#[test]
fn absurd_sizes_are_refused_before_memory_is_allocated() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("a.exr");
    save(
        &image(vec![part(
            None,
            (8, 5),
            (0, 0),
            Compression::ZIP16,
            vec![("Y", floats(40))],
        )]),
        &path,
    );
    let window = |x: i32, y: i32| [0, 0, x, y].map(i32::to_le_bytes).concat();
    let sound = [&b"dataWindow\0box2i\0\x10\0\0\0"[..], &window(7, 4)].concat();
    let original = fs::read(&path).expect("reads");
    for (x, y) in [
        (i32::MAX - 1, i32::MAX - 1),
        (i32::MAX - 1, 4),
        (200_000, 200_000),
        (-1, -1),
    ] {
        fs::write(&path, &original).expect("writes");
        let claim = [&b"dataWindow\0box2i\0\x10\0\0\0"[..], &window(x, y)].concat();
        patch(&path, &sound, &claim);
        let error = PlateFile::open(&path, &PlateOptions::default()).expect_err("absurd");
        assert!(error.to_string().contains("a.exr"), "{error}");
        assert!(tile_image::read(&path, &["Y".to_owned()]).is_err());
    }
    let path = folder.path().join("a.tif");
    image::DynamicImage::new_luma16(0x1234, 1)
        .save(&path)
        .expect("saves");
    let bytes = fs::read(&path).expect("reads");
    let width = bytes
        .windows(4)
        .position(|w| w == [0x34, 0x12, 0, 0])
        .expect("the width");
    for claim in [u32::MAX, 200_000] {
        let mut bytes = bytes.clone();
        bytes[width..width + 4].copy_from_slice(&claim.to_le_bytes());
        fs::write(&path, bytes).expect("writes");
        assert!(RasterImage::open(&path).is_err());
    }
}

#[test]
fn truncated_files_are_refused_at_every_length() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("a.bin");
    for valid in VALID.iter() {
        fs::write(&path, valid).expect("writes");
        assert!(
            PlateFile::open(&path, &PlateOptions::default()).is_ok()
                || ImageChannel::read_depth(&path, Some("Z"), DepthOwner::Unknown).is_ok()
        );
        for length in (0..valid.len()).step_by(7) {
            fs::write(&path, &valid[..length]).expect("writes");
            read_in_every_way(&path);
            if valid.starts_with(&[0x76, 0x2f]) {
                assert!(
                    ImageChannel::read_depth(&path, Some("Z"), DepthOwner::Unknown).is_err(),
                    "{length}"
                );
            }
            if valid.starts_with(b"#?RADIANCE") || valid.starts_with(&[0xff, 0xd8]) {
                assert!(RasterImage::open(&path).is_err(), "{length}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn damaged_images_never_panic(
        which in 0..VALID.len(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..12),
        header in any::<bool>(),
    ) {
        let folder = tempfile::tempdir().expect("temporary folder");
        let mut bytes = VALID[which].clone();
        for (at, value) in changes {
            // Half of the cases damage only the header, where the sizes and offsets are.
            let span = if header { bytes.len().min(700) } else { bytes.len() };
            let at = at.index(span);
            bytes[at] = value;
        }
        let path = folder.path().join("a.bin");
        fs::write(&path, &bytes).expect("writes");
        read_in_every_way(&path);
    }

    #[test]
    fn damaged_dpx_headers_are_read_or_refused(
        which in 10_usize..13,
        changes in prop::collection::vec((0_usize..DPX_FIELDS.len(), 0_usize..4, any::<u8>()), 1..4),
        cut in any::<Option<prop::sample::Index>>(),
    ) {
        let folder = tempfile::tempdir().expect("temporary folder");
        let mut bytes = VALID[which].clone();
        for (field, byte, value) in changes {
            bytes[DPX_FIELDS[field] + byte] = value;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        let path = folder.path().join("a.dpx");
        fs::write(&path, &bytes).expect("writes");
        read_in_every_way(&path);
        match PlateFile::open(&path, &PlateOptions::default()) {
            // An image that is read can be written and read again.
            Ok(plate) => {
                let out = folder.path().join("b.dpx");
                plate.write(&out).expect("writes");
                let back = PlateFile::open(&out, &PlateOptions::default()).expect("reads");
                prop_assert!(back.colour() == plate.colour());
            }
            Err(error) => {
                let error = error.to_string();
                prop_assert!(error.contains("a.dpx") && error.contains("; "), "{}", error);
            }
        }
    }

    #[test]
    fn random_bytes_never_panic(
        which in 0..VALID.len(),
        keep in 0_usize..64,
        tail in prop::collection::vec(any::<u8>(), 0..300),
    ) {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("a.bin");
        let mut bytes = VALID[which][..keep.min(VALID[which].len())].to_vec();
        bytes.extend(tail);
        fs::write(&path, &bytes).expect("writes");
        read_in_every_way(&path);
    }

    #[test]
    fn damaged_manifests_never_panic(
        changes in prop::collection::vec(
            (any::<prop::sample::Index>(), prop::sample::select(b"\"{}[]:,.-0e9nNaN/\\x \xff".to_vec())), 0..6),
        cut in any::<Option<prop::sample::Index>>(),
    ) {
        let folder = tempfile::tempdir().expect("temporary folder");
        let mut text = br#"{"format": "psf-observations", "version": 1, "image_size": [64, 48],
            "optical_axis": [32, 24], "channels": ["R", "G"], "pixel_pitch_um": 4.0,
            "camera": {"focal_length_mm": 50, "focus_distance_m": null, "wavelength_nm": {"R": 620}},
            "observations": [{"file": "a.exr", "x": 1.5, "y": 2e0, "depth_m": null, "ideal_x": 1,
            "ideal_y": 2, "noise_sigma": {"R": 0.1}, "background": 0.0, "saturated": false}]}"#.to_vec();
        for (at, byte) in changes {
            let at = at.index(text.len());
            text[at] = byte;
        }
        if let Some(cut) = cut {
            text.truncate(cut.index(text.len()));
        }
        fs::write(folder.path().join("manifest.json"), text).expect("writes");
        for skip_bad in [false, true] {
            let error = read(folder.path(), ReadOptions { skip_bad }).expect_err("no tile is there");
            prop_assert!(error.to_string().contains("manifest.json"));
        }
    }
}

/// Returns a flat picture of one channel.
fn flat(path: &Path) {
    let one = part(
        None,
        (10, 6),
        (0, 0),
        Compression::ZIP1,
        vec![("Y", floats(60))],
    );
    save(&image(vec![one]), path);
}

#[test]
fn deep_files_that_lost_their_type_are_refused() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("in.exr");
    flat(&path);
    let mut bytes = std::fs::read(&path).expect("readable");
    // Bit 11 of version and flags: the file holds deep pixels.
    bytes[5] |= 8;
    std::fs::write(&path, bytes).expect("writable");
    let error = ExrImage::open(&path).expect_err("refused").to_string();
    assert!(error.contains("deep"), "{error}");
}

#[test]
fn attributes_without_a_type_are_refused() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("in.exr");
    flat(&path);
    // The width of the screen window loses the end of its name, and has no type and no length then.
    patch(
        &path,
        b"screenWindowWidth\0",
        b"screenWin\0\0\0\0\0\0\0\x02\0",
    );
    let error = ExrImage::open(&path).expect_err("refused").to_string();
    assert!(
        error.contains("attribute `screenWin` has no name or type"),
        "{error}"
    );
}

#[test]
fn the_sample_count_of_deep_pixels_is_kept_in_flat_files() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let (path, out) = (folder.path().join("in.exr"), folder.path().join("out.exr"));
    let mut one = part(
        None,
        (10, 6),
        (0, 0),
        Compression::ZIP1,
        vec![("Y", floats(60))],
    );
    let name = exr::meta::attribute::Text::from("maxSamplesPerPixeX");
    one.attributes
        .other
        .insert(name, exr::meta::attribute::AttributeValue::I32(3));
    save(&image(vec![one]), &path);
    patch(&path, b"maxSamplesPerPixeX", b"maxSamplesPerPixel");
    let image = ExrImage::open(&path).expect("flat");
    image.write(&out).expect("writable");
    for file in [&path, &out] {
        let described = crate::description::Description::read(file).expect("readable");
        let found = described.parts[0].attributes.iter();
        let found = found.filter(|(name, value)| name == "maxSamplesPerPixel" && value == "3");
        assert_eq!(found.count(), 1, "{file:?}");
    }
}
