//! Radiance HDR files: RGB with a common exponent for the three samples of a pixel (RGBE).

use std::io::{Cursor, Write};
use std::path::Path;

use image::codecs::hdr::{HdrDecoder, HdrEncoder};
use image::{ImageDecoder, ImageError, Rgb};

use crate::atomic::write_atomically;
use crate::error::Result;
use crate::format::{
    AlphaSupport, Capabilities, Format, FormatInfo, GreySupport, ImageFile, ImageFormat,
};
use crate::input::InputFile;
use crate::metadata::{AssumedEncoding, Metadata};
use crate::plate::NewImage;
use crate::provenance::header_lines;
use crate::raster::{RasterImage, channel_names, deinterleave};
use crate::samples::SampleFormat;

/// The Radiance HDR format.
pub(crate) struct Hdr;

impl ImageFormat for Hdr {
    fn info(&self) -> &'static FormatInfo {
        &FormatInfo {
            id: Format::Hdr,
            name: "Radiance HDR",
            extensions: &["hdr"],
            magic: &[b"#?RADIAN", b"#?RGBE"],
            capabilities: Capabilities {
                writable: true,
                layers: false,
                data_window: false,
                pixel_aspect: false,
                alpha: AlphaSupport::None,
                grey: GreySupport::Never,
                icc_profile: false,
                texts: false,
                common_metadata: false,
            },
        }
    }

    fn sample_format(&self, _source: SampleFormat, _channels: usize) -> SampleFormat {
        SampleFormat::Rgbe
    }

    fn read(&self, input: &InputFile) -> Result<ImageFile> {
        read(input).map(ImageFile::Raster)
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
    fn format(&self) -> Format {
        Format::Hdr
    }

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

/// The largest sample that the format represents: 255/256 of 2^127.
pub(crate) const MAX_SAMPLE: f32 = 255.0 / 256.0 * 1.701_411_8e38;

/// Pixels whose samples are all smaller are stored as black.
const MIN_SAMPLE: f32 = f32::MIN_POSITIVE;

/// Quantises a pixel to RGBE: eight bits of the largest sample, the same step for the others, clipped to 0 to
/// [`MAX_SAMPLE`].
pub(crate) fn quantise_pixel(pixel: [f32; 3]) -> [f32; 3] {
    let pixel = pixel.map(|v| if v > 0.0 { v.min(MAX_SAMPLE) } else { 0.0 });
    let max = pixel.iter().copied().fold(0.0, f32::max);
    if max < MIN_SAMPLE {
        return [0.0; 3];
    }
    // Steps of 1/256 of the power of two above the maximum; the next power where the maximum rounds up to it.
    let mut step = f64::from(max).log2().floor().exp2() / 128.0;
    if (f64::from(max) / step).round() > 255.0 && max < MAX_SAMPLE / 2.0 {
        step *= 2.0;
    }
    pixel.map(|v| ((f64::from(v) / step).round().min(255.0) * step) as f32)
}

fn read(input: &InputFile) -> Result<RasterImage> {
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
    Ok(RasterImage {
        path: input.path.to_path_buf(),
        metadata: Box::new(HdrMetadata { lines }),
        texts: header_lines::texts(provenance.iter().map(Vec::as_slice)),
        sample_format: SampleFormat::Rgbe,
        width,
        height,
        names: channel_names(3),
        planes: deinterleave(&samples, 3, |s| s),
        changed: false,
        warnings: Vec::new(),
    })
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
