//! PNG and TIFF images: round trips, and warnings about what the formats cannot hold.

use image::{ImageBuffer, Luma, LumaA, Rgb, Rgba};

use crate::formats::exr::DepthOwner;
use crate::image_channel::ImageChannel;
use crate::plate::{PlateFile, PlateOptions};
use crate::raster::RasterImage;
use crate::samples::{Encoding, SampleFormat};

/// Returns a 16-bit value that differs between pixels and channels.
fn value(x: u32, y: u32, channel: u32) -> u16 {
    (x * 9001 + y * 257 + channel * 31_000) as u16
}

#[test]
fn integers_round_trip() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let (source, target) = (folder.path().join("in"), folder.path().join("out"));
    for extension in ["png", "tif"] {
        let (source, target) = (
            source.with_extension(extension),
            target.with_extension(extension),
        );
        let rgba16 = ImageBuffer::from_fn(5, 4, |x, y| Rgba([0, 1, 2, 3].map(|c| value(x, y, c))));
        let rgb8 = ImageBuffer::from_fn(5, 4, |x, y| Rgb([0, 1, 2].map(|c| value(x, y, c) as u8)));
        let l16 = ImageBuffer::from_fn(5, 4, |x, y| Luma([value(x, y, 0)]));
        let mut pictures = vec![
            (
                image::DynamicImage::ImageRgba16(rgba16),
                SampleFormat::U16,
                4,
            ),
            (image::DynamicImage::ImageRgb8(rgb8), SampleFormat::U8, 3),
            (image::DynamicImage::ImageLuma16(l16), SampleFormat::U16, 1),
        ];
        if extension == "png" {
            let la = ImageBuffer::from_fn(5, 4, |x, y| LumaA([value(x, y, 0) as u8, 77]));
            pictures.push((image::DynamicImage::ImageLumaA8(la), SampleFormat::U8, 2));
        }
        for (picture, sample_format, channels) in pictures {
            picture.save(&source).expect("the test's own file");
            let plate = RasterImage::open(&source).expect("opens");
            assert_eq!(
                (plate.sample_format(), plate.names().len()),
                (sample_format, channels)
            );
            let warnings = plate.write(&target).expect("writes");
            assert!(warnings.is_empty(), "{warnings:?}");
            assert_eq!(image::open(&target).expect("reads"), picture, "{extension}");
            // Through the sRGB transfer function and back.
            let mut plate = PlateFile::open(&source, &PlateOptions::default()).expect("opens");
            plate.set_colour(&plate.colour()).expect("same planes");
            plate.write(&target).expect("writes");
            assert_eq!(image::open(&target).expect("reads"), picture, "{extension}");
        }
    }
}

#[test]
fn float_tiff_keeps_every_bit_and_integers_warn_of_clipping() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let (source, target) = (folder.path().join("in.tif"), folder.path().join("out.tif"));
    let wild = [-1.5_f32, 0.0, 1e-30, 70000.0, 3.0e38, 0.1];
    crate::formats::tiff::write_float(&source, 3, 2, vec![wild.to_vec(); 3]).expect("writes");
    let plate = RasterImage::open(&source).expect("opens");
    assert_eq!(plate.sample_format(), SampleFormat::F32);
    assert!(plate.write(&target).expect("writes").is_empty());
    let back = RasterImage::open(&target).expect("opens");
    assert_eq!(back.plane("B"), Some(&wild[..]));
    assert_eq!(
        ImageChannel::read_depth(&target, None, DepthOwner::Unknown)
            .expect("equal channels")
            .samples,
        wild
    );

    let png = folder.path().join("p.png");
    image::DynamicImage::new_luma16(3, 2)
        .save(&png)
        .expect("the test's own file");
    let mut plate = RasterImage::open(&png).expect("opens");
    plate
        .replace("Y", vec![-0.5, 1.5, 2.0, f32::NAN, 0.5, 1.0])
        .expect("six");
    let warnings = plate.write(&png).expect("writes");
    assert_eq!(warnings.len(), 3, "{warnings:?}");
    assert!(warnings[1].contains("2 samples over 1"), "{warnings:?}");
    let back = RasterImage::open(&png).expect("opens");
    assert_eq!(back.plane("Y").expect("Y")[..4], [0.0, 1.0, 1.0, 0.0]);
    assert!(plate.replace("Y", vec![0.0]).is_err() && plate.replace("R", vec![0.0; 6]).is_err());
}

#[test]
fn eight_bits_are_too_coarse_for_depth() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("z.png");
    image::DynamicImage::new_luma8(3, 2)
        .save(&path)
        .expect("the test's own file");
    let error = ImageChannel::read_depth(&path, None, DepthOwner::Unknown).expect_err("8 bits");
    assert!(error.to_string().contains("too coarse"), "{error}");
    image::DynamicImage::new_luma16(3, 2)
        .save(&path)
        .expect("the test's own file");
    assert_eq!(
        ImageChannel::read_depth(&path, None, DepthOwner::Unknown)
            .expect("16 bits")
            .samples,
        [0.0; 6]
    );
}

#[test]
fn srgb_matches_published_points_and_inverts() {
    // IEC 61966-2-1: code 0.5 is 0.21404 linear, 18 % grey is code 0.46136.
    assert!((Encoding::Srgb.decode(0.5) - 0.214_041).abs() < 1e-6);
    assert!((Encoding::Srgb.encode(0.18) - 0.461_356).abs() < 1e-6);
    for code in (-200..=1200).map(|i| i as f32 / 1000.0) {
        let back = Encoding::Srgb.encode(Encoding::Srgb.decode(code));
        assert!((back - code).abs() < 2e-6, "{code} became {back}");
        assert_eq!(Encoding::Linear.decode(code), code);
    }
}
