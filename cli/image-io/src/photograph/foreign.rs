//! Files that hold no photograph to measure as they are, with the command that makes one of them.

use std::path::Path;

use crate::error::FileError;

/// A family of formats that are not read.
struct Family {
    problem: &'static str,
    remedy: &'static str,
}

const RAW: Family = Family {
    problem: "is a raw photograph of a camera's own format",
    remedy: "convert it first: `dnglab convert IN OUT.dng`, or `dcraw -D -4 -T IN` and give --cfa",
};
const CINEMA_RAW: Family = Family {
    problem: "is raw footage of a camera's own format",
    remedy: "write one frame as linear OpenEXR, or as 16-bit TIFF with its log curve for --encoding, with the maker's own program or a grading program, without sharpening and noise reduction",
};
const MOVIE: Family = Family {
    problem: "is a movie",
    remedy: "write one frame: `ffmpeg -ss 1 -i IN -frames:v 1 -pix_fmt rgb48le OUT.tif`, and give the log curve of the camera to --encoding",
};
const HEIF: Family = Family {
    problem: "is a picture developed by a phone or camera",
    remedy: "photograph raw (ProRAW or another DNG); else convert it: `heif-dec IN OUT.png`, and give --encoding srgb, with larger errors",
};

/// Formats by the extension of their files.
const BY_EXTENSION: [(&str, &str, &Family); 24] = [
    ("cr2", "Canon CR2", &RAW),
    ("cr3", "Canon CR3", &RAW),
    ("crw", "Canon CRW", &RAW),
    ("nef", "Nikon NEF", &RAW),
    ("nrw", "Nikon NRW", &RAW),
    ("arw", "Sony ARW", &RAW),
    ("sr2", "Sony SR2", &RAW),
    ("raf", "Fujifilm RAF", &RAW),
    ("orf", "Olympus ORF", &RAW),
    ("rw2", "Panasonic RW2", &RAW),
    ("pef", "Pentax PEF", &RAW),
    ("srw", "Samsung SRW", &RAW),
    ("iiq", "Phase One IIQ", &RAW),
    ("3fr", "Hasselblad 3FR", &RAW),
    ("ari", "ARRIRAW", &CINEMA_RAW),
    ("r3d", "RED R3D", &CINEMA_RAW),
    ("braw", "Blackmagic RAW", &CINEMA_RAW),
    ("crm", "Canon RAW Light", &CINEMA_RAW),
    ("mov", "QuickTime", &MOVIE),
    ("mp4", "MPEG-4", &MOVIE),
    ("mxf", "MXF", &MOVIE),
    ("heic", "HEIC", &HEIF),
    ("heif", "HEIF", &HEIF),
    ("avif", "AVIF", &HEIF),
];

/// Formats by the bytes at an offset.
const BY_CONTENT: [(usize, &[u8], &str, &Family); 13] = [
    (0, b"FUJIFILMCCD-RAW", "Fujifilm RAF", &RAW),
    (0, b"IIRO", "Olympus ORF", &RAW),
    (0, b"IIU\0", "Panasonic RW2", &RAW),
    (4, b"ftypcrx", "Canon CR3", &RAW),
    (0, b"ARRI", "ARRIRAW", &CINEMA_RAW),
    (4, b"RED", "RED R3D", &CINEMA_RAW),
    (4, b"ftyphei", "HEIC", &HEIF),
    (4, b"ftypmif1", "HEIF", &HEIF),
    (4, b"ftypavif", "AVIF", &HEIF),
    (4, b"ftyp", "MPEG-4 or QuickTime", &MOVIE),
    (4, b"moov", "QuickTime", &MOVIE),
    (4, b"wide", "QuickTime", &MOVIE),
    (0, b"\x06\x0e\x2b\x34", "MXF", &MOVIE),
];

/// Returns the error of a file that begins with `start` and holds no photograph to measure; `None` for others.
pub(super) fn refuse(path: &Path, start: &[u8], extension: &str) -> Option<FileError> {
    let by_content = BY_CONTENT.iter().find(|(offset, magic, ..)| {
        let bytes = start.get(*offset..);
        bytes.is_some_and(|bytes| bytes.starts_with(magic))
    });
    let by_extension = BY_EXTENSION.iter().find(|(e, ..)| *e == extension);
    let (name, family) = (by_content.map(|(_, _, name, family)| (name, family)))
        .or(by_extension.map(|(_, name, family)| (name, family)))?;
    let problem = format!("{} ({name})", family.problem);
    Some(FileError::new(path, "", problem, family.remedy))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_that_are_no_photographs_name_the_command_that_makes_one() {
        let of = |start: &[u8], extension: &str| {
            let error = refuse(Path::new("a.file"), start, extension);
            error.map(|error| error.to_string()).unwrap_or_default()
        };
        for (start, extension, parts) in [
            (&b"\0\0\0\x14ftypqt  "[..], "mov", ["QuickTime", "ffmpeg"]),
            (b"\0\0\0\x20ftypisom", "", ["a movie", "--encoding"]),
            (b"\0\0\0\x24ftypheic", "jpg", ["HEIC", "heif-dec"]),
            (b"\0\0\0\x18ftypcrx ", "", ["Canon CR3", "dnglab convert"]),
            (b"\x06\x0e\x2b\x34\x02\x05", "", ["MXF", "ffmpeg"]),
            (b"MM\0*", "nef", ["Nikon NEF", "dnglab convert"]),
            (b"anything", "r3d", ["RED R3D", "OpenEXR"]),
        ] {
            let text = of(start, extension);
            assert!(
                parts.iter().all(|part| text.contains(part)),
                "{extension}: {text}"
            );
        }
        assert_eq!(of(b"\x89PNG\r\n\x1a\n", "png"), "");
        assert_eq!(of(b"v/1\x01", "exr"), "");
    }
}
