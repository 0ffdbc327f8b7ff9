//! PNG files that state their transfer function.

use std::path::Path;

use super::metadata::{chunk, write_png};
use crate::plate::{PlateFile, PlateOptions};
use crate::samples::Encoding;

fn open(path: &Path, before: &[Vec<u8>]) -> PlateFile {
    write_png(path, png::BitDepth::Sixteen, before, &[]);
    PlateFile::open(path, &PlateOptions::default()).expect("opens")
}

fn gamma(value: u32) -> Vec<u8> {
    chunk(b"gAMA", &value.to_be_bytes())
}

/// Returns an iCCP chunk of an RGB profile whose curves are `curve`.
fn profile(curve: &[u8]) -> Vec<u8> {
    let mut icc = vec![0; 128];
    icc[12..24].copy_from_slice(b"mntrRGB XYZ ");
    icc[36..40].copy_from_slice(b"acsp");
    icc.extend(3_u32.to_be_bytes());
    let at = 128 + 4 + 3 * 12;
    for tag in [b"rTRC", b"gTRC", b"bTRC"] {
        icc.extend(tag);
        icc.extend((at as u32).to_be_bytes());
        icc.extend((curve.len() as u32).to_be_bytes());
    }
    icc.extend(curve);
    let size = (icc.len() as u32).to_be_bytes();
    icc[..4].copy_from_slice(&size);
    // A zlib stream of one stored block.
    let length = icc.len() as u16;
    let mut packed = b"name\0\0\x78\x01\x01".to_vec();
    packed.extend(length.to_le_bytes());
    packed.extend((!length).to_le_bytes());
    packed.extend(&icc);
    let sums = icc.iter().fold((1_u32, 0_u32), |(a, b), byte| {
        let a = (a + u32::from(*byte)) % 65_521;
        (a, (a + b) % 65_521)
    });
    packed.extend((sums.1 << 16 | sums.0).to_be_bytes());
    chunk(b"iCCP", &packed)
}

fn curve(values: &[u16]) -> Vec<u8> {
    let mut bytes = b"curv\0\0\0\0".to_vec();
    bytes.extend((values.len() as u32).to_be_bytes());
    bytes.extend(values.iter().flat_map(|v| v.to_be_bytes()));
    bytes
}

fn parametric(kind: u16, values: &[f64]) -> Vec<u8> {
    let mut bytes = b"para\0\0\0\0".to_vec();
    bytes.extend(kind.to_be_bytes());
    bytes.extend([0, 0]);
    bytes.extend(
        values
            .iter()
            .flat_map(|v| ((v * 65536.0).round() as i32).to_be_bytes()),
    );
    bytes
}

#[test]
fn the_stated_transfer_function_is_used_and_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.png");
    let srgb = [2.4, 1.0 / 1.055, 0.055 / 1.055, 1.0 / 12.92, 0.04045];
    let sampled: Vec<u16> = (0..1024)
        .map(|k| (Encoding::Srgb.decode(k as f32 / 1023.0) * 65535.0).round() as u16)
        .collect();
    let cicp = |transfer: u8| chunk(b"cICP", &[9, transfer, 0, 1]);
    // The linear value of the code 0.5, from the standards' own formulas.
    for (before, value, note) in [
        (vec![], 0.214_04, ""),
        (vec![gamma(45_455)], 0.214_04, ""),
        (vec![chunk(b"sRGB", &[0]), gamma(100_000)], 0.214_04, ""),
        (vec![cicp(13), gamma(100_000)], 0.214_04, ""),
        (vec![gamma(100_000)], 0.5, "linear"),
        (vec![gamma(99_999)], 0.5, "linear"),
        (vec![gamma(55_556)], 0.287_17, "1.8"),
        (vec![cicp(8)], 0.5, "linear"),
        (vec![cicp(1)], 0.259_59, "709"),
        // 92.246 cd/m2 over 203.
        (vec![cicp(16)], 0.454_41, "PQ"),
        // A twelfth over the linear value of the code 0.75.
        (vec![cicp(18)], 0.314_51, "HLG"),
        (vec![cicp(16), gamma(100_000)], 0.454_41, "PQ"),
        (vec![profile(&curve(&[])), gamma(45_455)], 0.5, "linear"),
        (vec![profile(&curve(&[256]))], 0.5, "linear"),
        (vec![profile(&curve(&[461]))], 0.286_98, "1.8"),
        (vec![profile(&curve(&sampled))], 0.214_04, ""),
        (vec![profile(&parametric(3, &srgb))], 0.214_04, ""),
        (vec![profile(&parametric(0, &[1.0]))], 0.5, "linear"),
        // Curves and values that are not known: sRGB, with a note.
        (
            vec![profile(&curve(&[0, 60_000, 65_535]))],
            0.214_04,
            "ICC profile",
        ),
        (vec![cicp(11)], 0.214_04, "cICP"),
        (vec![chunk(b"cICP", &[9, 16, 0, 0])], 0.214_04, "cICP"),
    ] {
        let plate = open(&path, &before);
        let encoding = plate.encoding().expect("a PNG");
        let is = encoding.decode(0.5);
        assert!((is - value).abs() < 4e-5, "{before:?}: {is} for {value}");
        assert!((encoding.encode(is) - 0.5).abs() < 1e-5, "{encoding}");
        let warnings = plate.read_warnings().concat();
        assert!(
            warnings.contains(note) && warnings.is_empty() == note.is_empty(),
            "{warnings}"
        );
        let options = PlateOptions {
            encoding: Some(Encoding::Srgb),
            ..PlateOptions::default()
        };
        let other = PlateFile::open(&path, &options).expect("opens");
        assert_eq!(other.encoding(), Some(Encoding::Srgb));
        if !note.is_empty() && note != "ICC profile" && note != "cICP" {
            assert!(other.read_warnings().concat().contains(note), "{before:?}");
        }
    }
}

#[test]
fn encodings_are_inverted_over_their_range() {
    for encoding in [
        Encoding::Pq,
        Encoding::Hlg,
        Encoding::Rec709,
        Encoding::Gamma { thousandths: 1800 },
    ] {
        for k in 0..=100 {
            let code = k as f32 / 100.0;
            let back = encoding.encode(encoding.decode(code));
            assert!(
                (back - code).abs() < 1e-5,
                "{encoding}: {code} gives {back}"
            );
        }
    }
}
