//! Conversion of images: alpha, non-finite samples, grey, threads, invalid sizes.

use std::sync::Arc;

use seidel_colour::PixelLayout::{Rgb, RgbaPremultiplied, RgbaStraight};
use seidel_colour::{Alphas, Config, ConversionReport, Processor, SamplePlace, Source};

/// The report of a conversion in which every sample had a value.
const CLEAN: ConversionReport = ConversionReport {
    non_finite: 0,
    unrepresentable: 0,
    first_unrepresentable: None,
};

fn processor(from: &str, to: &str) -> Arc<Processor> {
    let config = Config::load(&Source::Embedded).unwrap();
    config.processor(from, to).unwrap()
}

/// Converts planes and returns the report.
fn convert(processor: &Processor, planes: &mut [Vec<f32>], alphas: Alphas) -> ConversionReport {
    processor.convert_planes(planes, alphas).unwrap()
}

/// Converts one pixel without alpha.
fn convert_one(processor: &Processor, mut pixel: [f32; 3]) -> [f32; 3] {
    assert_eq!(processor.convert_pixels(&mut pixel, Rgb).unwrap(), CLEAN);
    pixel
}

#[test]
fn non_finite_samples_become_zero_before_channels_mix() {
    let to_linear = processor("ARRI LogC4", "ACEScg");
    let clean = convert_one(&to_linear, [0.4, 0.0, 0.3]);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut planes = [vec![0.4], vec![bad], vec![0.3]];
        let report = convert(&to_linear, &mut planes, Alphas::Straight);
        assert_eq!((report.non_finite, report.unrepresentable), (1, 0));
        assert_eq!([planes[0][0], planes[1][0], planes[2][0]], clean);
        let mut pixel = [0.4, bad, 0.3, 0.7];
        let result = to_linear.convert_pixels(&mut pixel, RgbaStraight);
        assert_eq!(result.unwrap(), report);
        assert_eq!(pixel, [clean[0], clean[1], clean[2], 0.7]);
    }
}

#[test]
fn samples_without_a_value_in_the_target_space_are_counted() {
    let to_linear = processor("ARRI LogC4", "Linear ARRI Wide Gamut 4");
    let mut planes = [vec![0.4], vec![1e6], vec![0.3]];
    let report = convert(&to_linear, &mut planes, Alphas::Straight);
    assert_eq!((report.non_finite, report.unrepresentable), (0, 1));
    assert!(planes[0][0] > 0.0 && planes[1][0] == 0.0 && planes[2][0] > 0.0);
}

#[test]
fn the_first_sample_without_a_value_is_named() {
    let to_linear = processor("ARRI LogC4", "Linear ARRI Wide Gamut 4");
    // In several chunks, which threads convert in any order.
    let mut planes = vec![vec![0.4; 20_000]; 3];
    planes[2][4100] = 1e6;
    planes[1][19_000] = 1e6;
    let mut pixels: Vec<f32> = (0..20_000)
        .flat_map(|i| [planes[0][i], planes[1][i], planes[2][i]])
        .collect();
    let report = convert(&to_linear, &mut planes, Alphas::Straight);
    assert_eq!(report.unrepresentable, 2);
    let first = Some(SamplePlace {
        pixel: 4100,
        channel: 2,
    });
    assert_eq!(report.first_unrepresentable, first);
    let interleaved = to_linear.convert_pixels(&mut pixels, Rgb);
    assert_eq!(interleaved.unwrap(), report);
}

#[test]
fn light_times_alpha_that_overflows_has_no_value() {
    let to_linear = processor("ARRI LogC4", "ACEScg");
    let mut planes = [vec![1e30], vec![1e30], vec![1e30]];
    let report = convert(&to_linear, &mut planes, Alphas::Shared(&[1e30]));
    assert_eq!(report, CLEAN, "code 1 is light of 470");
    let mut planes = [vec![1e38], vec![1e38], vec![1e38]];
    let report = convert(&to_linear, &mut planes, Alphas::Shared(&[1e38]));
    assert_eq!(report.unrepresentable, 3);
    assert!(planes.iter().all(|plane| plane[0] == 0.0));
}

#[test]
fn premultiplied_colour_is_converted_straight() {
    let to_linear = processor("S-Log3 S-Gamut3", "ACEScg");
    let straight = [0.5, 0.4, 0.6];
    let want = convert_one(&to_linear, straight);
    for alpha in [1.0, 0.5, 0.125] {
        let mut planes = straight.map(|v| vec![v * alpha]);
        let report = convert(&to_linear, &mut planes, Alphas::Shared(&[alpha]));
        assert_eq!(report, CLEAN);
        for (plane, want) in planes.iter().zip(want) {
            assert_eq!(plane[0], want * alpha);
        }
        let mut pixel = [0.5 * alpha, 0.4 * alpha, 0.6 * alpha, alpha];
        let report = to_linear.convert_pixels(&mut pixel, RgbaPremultiplied);
        assert_eq!(report.unwrap(), CLEAN);
        assert_eq!(pixel, [planes[0][0], planes[1][0], planes[2][0], alpha]);
    }
    let alphas = [vec![0.5], vec![0.25], vec![1.0]];
    let mut planes = [vec![0.25], vec![0.1], vec![0.6]];
    let report = convert(&to_linear, &mut planes, Alphas::PerPlane(&alphas));
    assert_eq!(report, CLEAN);
    assert_eq!(planes[0][0], want[0] * 0.5);
    assert_eq!(planes[1][0], want[1] * 0.25);
    assert_eq!(planes[2][0], want[2]);
}

#[test]
fn empty_pixels_stay_zero_and_emission_is_not_divided() {
    let to_linear = processor("S-Log3 S-Gamut3", "ACEScg");
    assert!(convert_one(&to_linear, [0.0; 3])[0] != 0.0);
    let mut planes = [vec![0.0, 0.5], vec![0.0, 0.5], vec![0.0, 0.5]];
    let report = convert(&to_linear, &mut planes, Alphas::Shared(&[0.0, 0.0]));
    assert_eq!(report, CLEAN);
    assert!(planes.iter().all(|plane| plane[0] == 0.0));
    assert_eq!(planes[0][1], convert_one(&to_linear, [0.5; 3])[0]);
}

#[test]
fn grey_is_converted_as_three_equal_channels() {
    let to_linear = processor("ARRI LogC3 (EI800)", "ACEScg");
    let codes = [-0.1, 0.391, 0.8];
    let mut grey = [codes.to_vec()];
    assert_eq!(convert(&to_linear, &mut grey, Alphas::Straight), CLEAN);
    for (grey, code) in grey[0].iter().zip(codes) {
        assert_eq!(*grey, convert_one(&to_linear, [code; 3])[1]);
    }
    assert!((grey[0][1] - 0.18).abs() < 1e-3);
    grey[0][0] = f32::NAN;
    let report = convert(&to_linear, &mut grey, Alphas::Straight);
    assert_eq!(report.non_finite, 1);
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let to_linear = processor("CanonLog3 CinemaGamut D55", "ACEScg");
    let plane = |k: u32| -> Vec<f32> {
        let sample = |i: u32| (i.wrapping_mul(2_654_435_761 + k) >> 8) as f32 / 16_777_216.0;
        (0..20_011).map(sample).collect()
    };
    let planes: Vec<Vec<f32>> = (0..3).map(plane).collect();
    let alpha = plane(7);
    let convert_on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let mut planes = planes.clone();
        let report = pool.install(|| convert(&to_linear, &mut planes, Alphas::Shared(&alpha)));
        assert_eq!(report, CLEAN);
        planes
    };
    let want = convert_on(1);
    assert_eq!(want, convert_on(3));
    let mut pixels: Vec<f32> = Vec::new();
    for i in 0..alpha.len() {
        pixels.extend([planes[0][i], planes[1][i], planes[2][i], alpha[i]]);
    }
    let mut serial = pixels.clone();
    let report = to_linear.convert_pixels(&mut pixels, RgbaPremultiplied);
    assert_eq!(report.unwrap(), CLEAN);
    let report = to_linear.convert_pixels_serial(&mut serial, RgbaPremultiplied);
    assert_eq!(report.unwrap(), CLEAN);
    assert_eq!(serial, pixels);
    for (i, pixel) in pixels.chunks(4).enumerate() {
        assert_eq!(pixel[..3], [want[0][i], want[1][i], want[2][i]]);
    }
}

#[test]
fn data_are_not_converted() {
    let raw = processor("Raw", "ACEScg");
    assert!(raw.is_no_op());
    let mut planes = [vec![f32::NAN, 5.0]];
    assert_eq!(convert(&raw, &mut planes, Alphas::Straight), CLEAN);
    assert!(planes[0][0].is_nan() && planes[0][1] == 5.0);
}

#[test]
fn invalid_sizes_are_rejected() {
    let processor = processor("ACEScct", "ACEScg");
    let fails = |planes: &mut [Vec<f32>], alphas| processor.convert_planes(planes, alphas).is_err();
    assert!(fails(&mut [vec![0.0], vec![0.0]], Alphas::Straight));
    let mut uneven = [vec![0.0], vec![0.0, 0.0], vec![0.0]];
    assert!(fails(&mut uneven, Alphas::Straight));
    let mut planes = [vec![0.0], vec![0.0], vec![0.0]];
    assert!(fails(&mut planes, Alphas::Shared(&[])));
    assert!(fails(&mut planes, Alphas::PerPlane(&[vec![1.0]])));
    assert!(processor.convert_pixels(&mut [0.0; 5], Rgb).is_err());
    assert!(
        processor
            .convert_pixels(&mut [0.0; 6], RgbaStraight)
            .is_err()
    );
    assert!(processor.convert_pixels_serial(&mut [0.0; 5], Rgb).is_err());
}
