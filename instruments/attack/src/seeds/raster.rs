//! PNG, TIFF, DPX, HDR and JPEG files.

use std::fs::File;
use std::io::Cursor;
use std::path::Path;

use image::{DynamicImage, ImageBuffer, ImageFormat, Rgb, Rgba};
use seidel_image_io::plate::{PlateFile, PlateOptions};
use tiff::encoder::{Compression, Predictor, TiffEncoder, colortype};

use super::{HEIGHT, WIDTH, exr::write_plate, plane, read, sample};

fn code(x: u32, y: u32, channel: usize) -> f32 {
    sample(x as usize, y as usize, channel)
}

fn rgb8() -> DynamicImage {
    let image = ImageBuffer::from_fn(WIDTH as u32, HEIGHT as u32, |x, y| {
        Rgb([0, 1, 2].map(|k| (255.0 * code(x, y, k)) as u8))
    });
    DynamicImage::ImageRgb8(image)
}

fn rgba16() -> DynamicImage {
    let image = ImageBuffer::from_fn(WIDTH as u32, HEIGHT as u32, |x, y| {
        Rgba([0, 1, 2, 3].map(|k| (65535.0 * code(x, y, k)) as u16))
    });
    DynamicImage::ImageRgba16(image)
}

fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let written = image.write_to(&mut bytes, format);
    written.unwrap_or_else(|e| panic!("{e}"));
    bytes.into_inner()
}

/// Returns the plate as the program itself writes it in the format of `name`.
fn converted(folder: &Path, name: &str) -> Vec<u8> {
    let (plate, out) = (folder.join("seed.exr"), folder.join(name));
    write_plate(&plate);
    let opened = PlateFile::open(&plate, &PlateOptions::default());
    let written = opened.and_then(|plate| plate.write(&out));
    written.unwrap_or_else(|e| panic!("{e}"));
    read(&out)
}

/// PNG of 8 and 16 bits, grey, with alpha, with text and with a palette.
pub(crate) fn png(folder: &Path) -> Vec<Vec<u8>> {
    let grey = DynamicImage::ImageLuma16(rgba16().to_luma16());
    let mut palette = Vec::new();
    let mut encoder = png::Encoder::new(&mut palette, WIDTH as u32, HEIGHT as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Sixteen);
    encoder.set_source_gamma(png::ScaledFloat::new(0.45455));
    let texts = encoder
        .add_text_chunk("Title".to_owned(), "a picture".to_owned())
        .and_then(|()| encoder.add_itxt_chunk("Author".to_owned(), "attack".to_owned()))
        .and_then(|()| encoder.add_ztxt_chunk("Comment".to_owned(), "text ".repeat(30)));
    texts.unwrap_or_else(|e| panic!("{e}"));
    let samples: Vec<u8> = (0..WIDTH * HEIGHT * 6).map(|k| (k * 37) as u8).collect();
    let written = encoder
        .write_header()
        .and_then(|mut writer| writer.write_image_data(&samples));
    written.unwrap_or_else(|e| panic!("{e}"));
    vec![
        encoded(&rgb8(), ImageFormat::Png),
        encoded(&rgba16(), ImageFormat::Png),
        encoded(&grey, ImageFormat::Png),
        palette,
        converted(folder, "seed.png"),
    ]
}

/// TIFF with LZW, deflate, PackBits and floats.
pub(crate) fn tiff(folder: &Path) -> Vec<Vec<u8>> {
    let codes = rgb8().into_rgb16().into_raw();
    let mut files = Vec::new();
    for compression in [
        Compression::Uncompressed,
        Compression::Lzw,
        Compression::Deflate(tiff::encoder::DeflateLevel::Fast),
        Compression::Packbits,
    ] {
        for predictor in [Predictor::None, Predictor::Horizontal] {
            let mut bytes = Cursor::new(Vec::new());
            let written = TiffEncoder::new(&mut bytes).and_then(|encoder| {
                let mut encoder = encoder
                    .with_compression(compression)
                    .with_predictor(predictor);
                let size = (WIDTH as u32, HEIGHT as u32);
                encoder.write_image::<colortype::RGB16>(size.0, size.1, &codes)
            });
            if written.is_ok() {
                files.push(bytes.into_inner());
            }
        }
    }
    let floats: Vec<f32> = (0..3).flat_map(plane).collect();
    let mut bytes = Cursor::new(Vec::new());
    let written = TiffEncoder::new(&mut bytes).and_then(|mut encoder| {
        encoder.write_image::<colortype::RGB32Float>(WIDTH as u32, HEIGHT as u32, &floats)
    });
    written.unwrap_or_else(|e| panic!("{e}"));
    files.push(bytes.into_inner());
    files.push(converted(folder, "seed.tif"));
    files
}

/// DPX of 10 and 16 bits and both byte orders, from headers composed here.
pub(crate) fn dpx(folder: &Path) -> Vec<Vec<u8>> {
    let mut files = vec![converted(folder, "seed.dpx")];
    // Descriptor, bits and packing of an element.
    for [descriptor, bits, packing] in [
        [50_u8, 10, 1],
        [50, 16, 0],
        [51, 16, 0],
        [6, 8, 0],
        [50, 12, 0],
    ] {
        for is_big in [true, false] {
            let mut bytes = vec![0xff; 2048];
            bytes[..4].copy_from_slice(if is_big { b"SDPX" } else { b"XPDS" });
            let mut put = |at: usize, value: u32, size: usize| {
                let encoded = if is_big {
                    value.to_be_bytes()[4 - size..].to_vec()
                } else {
                    value.to_le_bytes()[..size].to_vec()
                };
                bytes[at..at + size].copy_from_slice(&encoded);
            };
            for (at, value) in [
                (4, 2048),
                (32, 0),
                (772, WIDTH as u32),
                (776, HEIGHT as u32),
                (780, 0),
                (808, 2048),
                (812, 0),
            ] {
                put(at, value, 4);
            }
            for (at, value) in [(768, 0), (770, 1), (804, u32::from(packing)), (806, 0)] {
                put(at, value, 2);
            }
            bytes[800] = descriptor;
            bytes[801] = 2;
            bytes[803] = bits;
            bytes.extend((0..WIDTH * HEIGHT * 8).map(|k| (k * 29) as u8));
            files.push(bytes);
        }
    }
    files
}

/// Radiance HDR, run-length encoded and converted.
pub(crate) fn hdr(folder: &Path) -> Vec<Vec<u8>> {
    let image = DynamicImage::ImageRgb32F(rgb8().into_rgb32f());
    vec![
        encoded(&image, ImageFormat::Hdr),
        converted(folder, "seed.hdr"),
    ]
}

/// JPEG in colour and in grey.
pub(crate) fn jpeg() -> Vec<Vec<u8>> {
    let grey = DynamicImage::ImageLuma8(rgb8().into_luma8());
    vec![
        encoded(&rgb8(), ImageFormat::Jpeg),
        encoded(&grey, ImageFormat::Jpeg),
    ]
}

/// Creates a file with the bytes, for a command.
pub(crate) fn write(path: &Path, bytes: &[u8]) {
    use std::io::Write as _;
    let written = File::create(path).and_then(|mut file| file.write_all(bytes));
    written.unwrap_or_else(|e| panic!("{}: {e}", path.display()));
}
