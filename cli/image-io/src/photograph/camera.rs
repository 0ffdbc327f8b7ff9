//! Data of camera and lens that the file of a photograph states: EXIF of TIFF, DNG and JPEG files, attributes of OpenEXR.

use std::path::Path;

use super::directory::{Directory, TiffBytes};
use super::{FILE_LIMIT_BYTES, read_start};
use crate::error::Result;
use crate::json::read_bytes;
use crate::lens_metadata::{self, FrameRecord, Quantity};

/// Camera and lens as a file states them; `None` for what it does not.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StatedCamera {
    /// Focal length, mm.
    pub focal_length_mm: Option<f64>,
    /// F-number; a T-number where nothing else is stated.
    pub f_number: Option<f64>,
    /// Distance in focus, m.
    pub focus_m: Option<f64>,
    /// Pixel pitch, µm.
    pub pixel_pitch_um: Option<f64>,
    /// Name of the lens.
    pub lens_model: Option<String>,
    /// Serial number of the lens.
    pub lens_serial_number: Option<String>,
}

/// First bytes of OpenEXR files.
const OPENEXR: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
/// Tags of EXIF 2.32.
const EXIF_DIRECTORY: u16 = 34665;
const F_NUMBER: u16 = 33437;
const SUBJECT_DISTANCE: u16 = 37382;
const FOCAL_LENGTH: u16 = 37386;
const FOCAL_PLANE_X_RESOLUTION: u16 = 41486;
const FOCAL_PLANE_UNIT: u16 = 41488;
const LENS_MODEL: u16 = 42036;
const LENS_SERIAL_NUMBER: u16 = 42037;
/// Millimetres of the units of the focal plane's resolution: an inch is assumed.
const INCH_MM: f64 = 25.4;
const UNITS_MM: [(usize, f64); 3] = [(3, 10.0), (4, 1.0), (5, 0.001)];
/// Ranges beyond which values are taken for damage or for a unit of another kind.
const FOCAL_LENGTHS_MM: (f64, f64) = (0.5, 5000.0);
const F_NUMBERS: (f64, f64) = (0.5, 256.0);
const DISTANCES_M: (f64, f64) = (0.01, 1e6);
const PITCHES_UM: (f64, f64) = (0.2, 100.0);

/// Returns what the photograph at `path`, `width` pixels wide, states; nothing for damaged metadata.
///
/// # Errors
/// A file that cannot be read.
pub fn stated_camera(path: &Path, width: usize) -> Result<StatedCamera> {
    let mut start = [0; 16];
    let length = read_start(path, &mut start)?;
    let start = &start[..length];
    let is_tiff = start.starts_with(b"II*\0") || start.starts_with(b"MM\0*");
    if is_tiff || start.starts_with(b"\xff\xd8") {
        let bytes = read_bytes(path, FILE_LIMIT_BYTES)?;
        let bytes = if is_tiff { &bytes } else { jpeg_exif(&bytes) };
        return Ok(of_exif(path, bytes).unwrap_or_default());
    }
    if !start.starts_with(&OPENEXR) {
        return Ok(StatedCamera::default());
    }
    let record = lens_metadata::of_exr_header(path)?;
    Ok(record.map_or_else(StatedCamera::default, |record| of_record(&record, width)))
}

/// Returns the TIFF structure in the EXIF segment of a JPEG file; nothing if it has none.
fn jpeg_exif(bytes: &[u8]) -> &[u8] {
    let mut at = 2;
    // Segments: a marker, a length that counts itself, and data.
    while let Some([0xff, marker, high, low]) = bytes.get(at..at + 4) {
        let end = at + 2 + usize::from(u16::from_be_bytes([*high, *low]));
        let data = bytes.get(at + 4..end).unwrap_or_default();
        if let (0xe1, Some(exif)) = (*marker, data.strip_prefix(b"Exif\0\0")) {
            return exif;
        }
        // The image begins, or a length is damaged.
        if *marker == 0xda || end <= at + 2 {
            break;
        }
        at = end;
    }
    &[]
}

fn of_exif(path: &Path, bytes: &[u8]) -> Option<StatedCamera> {
    let file = TiffBytes::new(path, bytes);
    let directories = file.directories().ok()?;
    let exif = directories.iter().find_map(|d| d.value(EXIF_DIRECTORY));
    let exif = file.directory(exif? as usize).ok()?;
    let within = |tag, range| in_range(exif.value(tag), range);
    Some(StatedCamera {
        focal_length_mm: within(FOCAL_LENGTH, FOCAL_LENGTHS_MM),
        f_number: within(F_NUMBER, F_NUMBERS),
        focus_m: within(SUBJECT_DISTANCE, DISTANCES_M),
        pixel_pitch_um: pitch_um(&exif),
        lens_model: exif.text(LENS_MODEL),
        lens_serial_number: exif.text(LENS_SERIAL_NUMBER),
    })
}

fn pitch_um(exif: &Directory) -> Option<f64> {
    let unit = exif.whole(FOCAL_PLANE_UNIT, 2);
    let unit_mm = UNITS_MM.iter().find(|(code, _)| *code == unit);
    let unit_mm = unit_mm.map_or(INCH_MM, |(_, mm)| *mm);
    let pixels = exif.value(FOCAL_PLANE_X_RESOLUTION)?;
    in_range(Some(1000.0 * unit_mm / pixels), PITCHES_UM)
}

fn of_record(record: &FrameRecord, width: usize) -> StatedCamera {
    let value = |quantity, range| {
        let reading = record.preferred(quantity, None)?;
        in_range(Some(record.usable_value(reading, None)), range)
    };
    let film_back_mm = value(Quantity::FilmBack, (f64::MIN_POSITIVE, f64::MAX));
    let pitch_um = film_back_mm.map(|mm| 1000.0 * mm / width as f64);
    let identity = |name| record.identity.get(name).cloned();
    StatedCamera {
        focal_length_mm: value(Quantity::FocalLength, FOCAL_LENGTHS_MM),
        f_number: value(Quantity::FNumber, F_NUMBERS),
        focus_m: value(Quantity::Focus, (DISTANCES_M.0, f64::INFINITY)),
        pixel_pitch_um: in_range(pitch_um, PITCHES_UM),
        lens_model: identity("lens model"),
        lens_serial_number: identity("lens serial number"),
    }
}

fn in_range(value: Option<f64>, (least, most): (f64, f64)) -> Option<f64> {
    value.filter(|v| (least..=most).contains(v))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a little-endian TIFF file with an EXIF directory of these rational numbers, a unit of the focal plane, and a lens.
    fn exif(rationals: &[(u16, [u32; 2])], unit: u16, lens: &str) -> Vec<u8> {
        let count = rationals.len() as u16 + 2;
        let mut bytes = b"II*\0\x08\0\0\0\x01\0".to_vec();
        let start = 26 + 2 + 12 * u32::from(count) + 4;
        let entry = |tag: u16, kind: u16, count: u32, value: u32| {
            let mut entry = tag.to_le_bytes().to_vec();
            entry.extend(kind.to_le_bytes());
            entry.extend(count.to_le_bytes());
            entry.extend(value.to_le_bytes());
            entry
        };
        bytes.extend(entry(EXIF_DIRECTORY, 4, 1, 26));
        bytes.extend([0; 4]);
        bytes.extend(count.to_le_bytes());
        let mut data = Vec::new();
        for (tag, parts) in rationals {
            bytes.extend(entry(*tag, 5, 1, start + data.len() as u32));
            data.extend(parts.iter().flat_map(|part| part.to_le_bytes()));
        }
        bytes.extend(entry(FOCAL_PLANE_UNIT, 3, 1, u32::from(unit)));
        let text = [lens.as_bytes(), b"\0"].concat();
        bytes.extend(entry(
            LENS_MODEL,
            2,
            text.len() as u32,
            start + data.len() as u32,
        ));
        bytes.extend([0; 4]);
        data.extend(text);
        bytes.extend(data);
        bytes
    }

    fn camera_of(bytes: &[u8]) -> StatedCamera {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.dng");
        std::fs::write(&path, bytes).expect("writes");
        stated_camera(&path, 640).expect("readable")
    }

    #[test]
    fn exif_states_the_camera() {
        let rationals = [
            (F_NUMBER, [28, 10]),
            (FOCAL_LENGTH, [50, 1]),
            (SUBJECT_DISTANCE, [u32::MAX, 1]),
            // 2500 pixels a centimetre: 4 µm.
            (FOCAL_PLANE_X_RESOLUTION, [2500, 1]),
        ];
        let bytes = exif(&rationals, 3, "A 50 mm lens");
        let expected = StatedCamera {
            focal_length_mm: Some(50.0),
            f_number: Some(2.8),
            // Infinity as some cameras write it, and damage as well.
            focus_m: None,
            pixel_pitch_um: Some(4.0),
            lens_model: Some("A 50 mm lens".to_owned()),
            lens_serial_number: None,
        };
        assert_eq!(camera_of(&bytes), expected);
        // The same in a JPEG file, behind another segment.
        let segment = |marker: u8, data: &[u8]| {
            let length = (data.len() as u16 + 2).to_be_bytes();
            [&[0xff, marker], &length[..], data].concat()
        };
        let exif = segment(0xe1, &[b"Exif\0\0", &bytes[..]].concat());
        let jpeg = [&b"\xff\xd8"[..], &segment(0xe0, b"JFIF\0"), &exif].concat();
        assert_eq!(camera_of(&jpeg), expected);
    }

    #[test]
    fn damaged_metadata_state_nothing() {
        let bytes = exif(&[(F_NUMBER, [0, 0]), (FOCAL_LENGTH, [9, 0])], 2, "     ");
        assert_eq!(camera_of(&bytes), StatedCamera::default());
        for length in 8..bytes.len() {
            camera_of(&bytes[..length]);
        }
        assert_eq!(
            camera_of(b"\xff\xd8\xff\xe1\0\0Exif\0\0"),
            StatedCamera::default()
        );
    }
}
