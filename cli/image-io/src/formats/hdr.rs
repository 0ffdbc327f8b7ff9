//! Radiance HDR files: RGB with a common exponent for the three samples of a pixel (RGBE).

use std::io::{Cursor, Write};
use std::path::Path;

use image::codecs::hdr::{HdrDecoder, HdrEncoder};
use image::{ImageDecoder, ImageError, Rgb};

use crate::atomic::write_atomically;
use crate::error::Result;
use crate::format::{Capabilities, Format};
use crate::image_file::{ImageFile, ImageFormat};
use crate::input::InputFile;
use crate::new_image::NewImage;
use crate::provenance::header_lines;
use crate::raster::{AssumedEncoding, Metadata, RasterImage, deinterleave};
use crate::rgbe::quantise_pixel;
use crate::samples::SampleFormat;

/// The Radiance HDR format.
pub(crate) struct Hdr;

pub(crate) const FORMAT: Format = Format {
    name: "Radiance HDR",
    short_name: "HDR",
    extensions: &["hdr"],
    magic: &[b"#?RADIAN", b"#?RGBE"],
    written_as: Some("shared exponents"),
    sample_format: |_, _| SampleFormat::Rgbe,
    capabilities: Capabilities::RGB,
};

impl ImageFormat for Hdr {
    fn read(&self, input: &InputFile) -> Result<ImageFile> {
        let bytes = input.read_all()?;
        let (provenance, lines): (Vec<_>, Vec<_>) = header_lines_of(&bytes)
            .into_iter()
            .partition(|line| header_lines::is_provenance_line(line));
        let refuse = |error: ImageError| match error {
            ImageError::Unsupported(what) => input.unsupported(
                &what.to_string(),
                "save it as RGBE from top to bottom and left to right",
            ),
            error => input.damaged(&error.to_string()),
        };
        // The strict decoder refuses `#?RGBE`.
        let decoder = HdrDecoder::new_nonstrict(Cursor::new(bytes)).map_err(refuse)?;
        let (width, height) = decoder.dimensions();
        let (width, height) = (width as usize, height as usize);
        // The decoder's floats, and planes of the same size.
        input.check_size("resolution", width, height, 3 * size_of::<f32>() * 2)?;
        let mut data = vec![0; decoder.total_bytes() as usize];
        decoder.read_image(&mut data).map_err(refuse)?;
        let samples: Vec<f32> = data
            .chunks_exact(4)
            .map(|b| f32::from_ne_bytes([b[0], b[1], b[2], b[3]]))
            .collect();
        drop(data);
        let planes = deinterleave(&samples, 3, |s| s);
        let (metadata, size) = (HdrMetadata { lines }, (width, height));
        Ok(RasterImage {
            texts: header_lines::texts(provenance.iter().map(Vec::as_slice)),
            ..RasterImage::new(input, metadata, SampleFormat::Rgbe, size, planes)
        }
        .into())
    }

    fn write_new(&self, path: &Path, image: NewImage) -> Result<Vec<String>> {
        image.into_raster(HdrMetadata::default()).write(path)
    }
}

/// The metadata of an HDR file.
#[derive(Debug, Clone, Default)]
struct HdrMetadata {
    /// The lines of the header, apart from those of the format and of provenance.
    lines: Vec<Vec<u8>>,
}

impl HdrMetadata {
    /// Returns the factor that samples were multiplied by; one if the header states none.
    fn exposure(&self) -> f64 {
        let stated = self.lines.iter().filter_map(|line| {
            let text = std::str::from_utf8(line).ok()?;
            text.strip_prefix("EXPOSURE=")?.trim().parse::<f64>().ok()
        });
        stated.product()
    }
}

impl Metadata for HdrMetadata {
    fn write(&self, path: &Path, image: &RasterImage) -> Result<()> {
        write(path, image, &self.lines)
    }

    fn remove_colour_space(&mut self) -> Vec<String> {
        let is_primaries = |line: &Vec<u8>| line.starts_with(b"PRIMARIES=");
        let removed = self.lines.iter().any(is_primaries);
        self.lines.retain(|line| !is_primaries(line));
        removed
            .then(|| "PRIMARIES".to_owned())
            .into_iter()
            .collect()
    }

    fn read_warning(&self, _assumed: AssumedEncoding) -> Option<String> {
        let exposure = self.exposure();
        (exposure != 1.0).then(|| {
            format!(
                "the HDR header states that samples were multiplied by {exposure} (EXPOSURE); this is not undone"
            )
        })
    }

    fn conversion_loss(&self, _kept: &[&str]) -> Option<String> {
        (!self.lines.is_empty()).then(|| "the header lines of the HDR".to_owned())
    }
}

/// Returns the lines of the header except the first and the format, which every file has.
fn header_lines_of(bytes: &[u8]) -> Vec<Vec<u8>> {
    let lines = bytes.split(|&b| b == b'\n').skip(1);
    let own = lines.take_while(|line| !line.is_empty());
    own.filter(|line| !line.starts_with(b"FORMAT="))
        .map(<[u8]>::to_vec)
        .collect()
}

/// Writes an HDR file with the further `lines` in its header, whole or not at all.
fn write(path: &Path, image: &RasterImage, lines: &[Vec<u8>]) -> Result<()> {
    let plane = |index: usize| &image.planes[index.min(image.planes.len() - 1)];
    let (red, green, blue) = (plane(0), plane(1), plane(2));
    let pixels: Vec<Rgb<f32>> = (0..image.width * image.height)
        .map(|i| Rgb(quantise_pixel([red[i], green[i], blue[i]])))
        .collect();
    let mut encoded = Vec::new();
    let result = HdrEncoder::new(&mut encoded).encode(&pixels, image.width, image.height);
    // The encoder's own header is replaced up to the format.
    let format = encoded.windows(7).position(|word| word == b"FORMAT=");
    write_atomically(path, |out| {
        result.map_err(|e| e.to_string())?;
        let failed = |e: std::io::Error| e.to_string();
        out.write_all(b"#?RADIANCE\n").map_err(failed)?;
        let provenance = header_lines::lines(&image.texts);
        let provenance = provenance.iter().map(String::as_bytes);
        for line in provenance.chain(lines.iter().map(Vec::as_slice)) {
            out.write_all(line).map_err(failed)?;
            out.write_all(b"\n").map_err(failed)?;
        }
        out.write_all(&encoded[format.unwrap_or(0)..])
            .map_err(failed)
    })
}
