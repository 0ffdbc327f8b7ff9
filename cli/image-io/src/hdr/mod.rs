//! Radiance HDR files: RGB whose three samples share an exponent (RGBE).

use std::io::{Cursor, Read, Write};
use std::path::Path;

use image::codecs::hdr::{HdrDecoder, HdrEncoder};
use image::{ImageDecoder, ImageError, Rgb};

use crate::atomic::write_whole;
use crate::error::{FileError, Result};
use crate::flat_plate::{Container, FlatPlate, SampleDepth, names};
use crate::guard::caught;
use crate::limits::{Limits, open};
use crate::text_lines;

/// The largest sample that the format holds: 255/256 of 2^127.
pub(crate) const MOST: f32 = 255.0 / 256.0 * 1.701_411_8e38;

/// Pixels darker than this are black.
const LEAST: f32 = f32::MIN_POSITIVE;

/// The samples of a pixel as the format holds them: eight bits of the brightest, the others as fine; 0 to [`MOST`].
pub(crate) fn held(pixel: [f32; 3]) -> [f32; 3] {
    let pixel = pixel.map(|v| if v > 0.0 { v.min(MOST) } else { 0.0 });
    let most = pixel.iter().copied().fold(0.0, f32::max);
    if most < LEAST {
        return [0.0; 3];
    }
    // Steps of 1/256 of the power of two above the brightest; one more where that rounds up to it.
    let mut step = f64::from(most).log2().floor().exp2() / 128.0;
    if (f64::from(most) / step).round() > 255.0 && most < MOST / 2.0 {
        step *= 2.0;
    }
    pixel.map(|v| ((f64::from(v) / step).round().min(255.0) * step) as f32)
}

/// Reads an HDR file.
pub(crate) fn read(path: &Path, limits: Limits) -> Result<FlatPlate> {
    caught(|| read_unguarded(path, limits)).unwrap_or_else(|panic| Err(damaged(path, &panic)))
}

fn read_unguarded(path: &Path, limits: Limits) -> Result<FlatPlate> {
    let (mut file, length) = open(path)?;
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)
        .map_err(|e| FileError::io(path, "be read", &e))?;
    let (texts, lines): (Vec<_>, Vec<_>) = header_lines(&bytes)
        .into_iter()
        .partition(|line| text_lines::is_own(line));
    let refuse = |error: ImageError| match error {
        ImageError::Unsupported(what) => FileError::new(
            path,
            "",
            format!("is an HDR of a kind that is not supported ({what})"),
            "save it as RGBE from top to bottom and left to right",
        ),
        error => damaged(path, &error.to_string()),
    };
    // Not strict, so that `#?RGBE` will do.
    let decoder = HdrDecoder::new_nonstrict(Cursor::new(bytes)).map_err(refuse)?;
    let (width, height) = decoder.dimensions();
    let (width, height) = (width as usize, height as usize);
    limits.check_sides(path, "resolution", width, height)?;
    let total = decoder.total_bytes();
    limits.check_bytes(path, "resolution", u128::from(total) * 2, length)?;
    let mut data = vec![0; total as usize];
    decoder.read_image(&mut data).map_err(refuse)?;
    let samples: Vec<f32> = data
        .chunks_exact(4)
        .map(|b| f32::from_ne_bytes([b[0], b[1], b[2], b[3]]))
        .collect();
    drop(data);
    let planes = FlatPlate::planes_of(&samples, 3, |s| s);
    Ok(FlatPlate {
        path: path.to_path_buf(),
        container: Container::Hdr { lines },
        texts: text_lines::texts(texts.iter().map(Vec::as_slice)),
        depth: SampleDepth::Rgbe,
        width,
        height,
        names: names(true, false),
        planes,
        changed: false,
        notes: Vec::new(),
    })
}

/// The lines of a header but for those that every file has, as they stand.
fn header_lines(bytes: &[u8]) -> Vec<Vec<u8>> {
    let lines = bytes.split(|&b| b == b'\n').skip(1);
    let own = lines.take_while(|line| !line.is_empty());
    own.filter(|line| !line.starts_with(b"FORMAT="))
        .map(<[u8]>::to_vec)
        .collect()
}

/// What the header says its samples were multiplied by; one where it says nothing.
pub(crate) fn exposure(lines: &[Vec<u8>]) -> f64 {
    let stated = lines.iter().filter_map(|line| {
        let text = std::str::from_utf8(line).ok()?;
        text.strip_prefix("EXPOSURE=")?.trim().parse::<f64>().ok()
    });
    stated.product()
}

/// Writes an HDR file whole or not at all, with the `lines` of its header.
pub(crate) fn write(path: &Path, plate: &FlatPlate, lines: &[Vec<u8>]) -> Result<()> {
    let plane = |index: usize| &plate.planes[index.min(plate.planes.len() - 1)];
    let (red, green, blue) = (plane(0), plane(1), plane(2));
    let pixels: Vec<Rgb<f32>> = (0..plate.width * plate.height)
        .map(|i| Rgb(held([red[i], green[i], blue[i]])))
        .collect();
    let mut coded = Vec::new();
    let encoder = HdrEncoder::new(&mut coded);
    let result = encoder.encode(&pixels, plate.width, plate.height);
    // The header is our own up to the format.
    let format = coded.windows(7).position(|word| word == b"FORMAT=");
    write_whole(path, |out| {
        result.map_err(|e| e.to_string())?;
        let failed = |e: std::io::Error| e.to_string();
        out.write_all(b"#?RADIANCE\n").map_err(failed)?;
        let own = text_lines::lines(&plate.texts);
        let own = own.iter().map(String::as_bytes);
        for line in own.chain(lines.iter().map(Vec::as_slice)) {
            out.write_all(line).map_err(failed)?;
            out.write_all(b"\n").map_err(failed)?;
        }
        out.write_all(&coded[format.unwrap_or(0)..]).map_err(failed)
    })
}

fn damaged(path: &Path, what: &str) -> FileError {
    FileError::new(
        path,
        "",
        format!("is no readable HDR ({what})"),
        "save or copy the file again",
    )
}
