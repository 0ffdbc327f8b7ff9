//! Pictures through processors: alpha, numbers that are none, threads.

use std::sync::Arc;

use seidel_colour::{Alphas, Config, Processor, Report, Source};

fn processor(from: &str, to: &str) -> Arc<Processor> {
    let config = Config::load(&Source::Own).unwrap();
    config.processor(from, to).unwrap()
}

/// What becomes of one pixel without alpha.
fn one(processor: &Processor, pixel: [f32; 3]) -> [f32; 3] {
    let mut row = pixel;
    assert_eq!(
        processor.rows(&mut row, 3, false).unwrap(),
        Report::default()
    );
    row
}

#[test]
fn a_number_that_is_none_stays_in_its_channel() {
    let to_linear = processor("ARRI LogC4", "ACEScg");
    let clean = one(&to_linear, [0.4, 0.0, 0.3]);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut planes = vec![vec![0.4], vec![bad], vec![0.3]];
        let report = to_linear.planes(&mut planes, Alphas::Straight).unwrap();
        assert_eq!((report.scrubbed, report.unheld), (1, 0));
        assert_eq!([planes[0][0], planes[1][0], planes[2][0]], clean);
        let mut row = [0.4, bad, 0.3, 0.7];
        assert_eq!(to_linear.rows(&mut row, 4, false).unwrap(), report);
        assert_eq!(row, [clean[0], clean[1], clean[2], 0.7]);
    }
}

#[test]
fn numbers_that_the_other_space_has_not_are_counted() {
    let to_linear = processor("ARRI LogC4", "Linear ARRI Wide Gamut 4");
    let mut planes = vec![vec![0.4], vec![1e6], vec![0.3]];
    let report = to_linear.planes(&mut planes, Alphas::Straight).unwrap();
    assert_eq!((report.scrubbed, report.unheld), (0, 1));
    assert!(planes[0][0] > 0.0 && planes[1][0] == 0.0 && planes[2][0] > 0.0);
}

#[test]
fn colour_is_divided_by_its_alpha_before_and_multiplied_after() {
    let to_linear = processor("S-Log3 S-Gamut3", "ACEScg");
    let straight = [0.5, 0.4, 0.6];
    let want = one(&to_linear, straight);
    for alpha in [1.0, 0.5, 0.125] {
        let mut planes: Vec<Vec<f32>> = straight.iter().map(|v| vec![v * alpha]).collect();
        let alphas = [alpha];
        let report = to_linear
            .planes(&mut planes, Alphas::Shared(&alphas))
            .unwrap();
        assert_eq!(report, Report::default());
        for (plane, want) in planes.iter().zip(want) {
            assert_eq!(plane[0], want * alpha);
        }
        let mut row = [0.5 * alpha, 0.4 * alpha, 0.6 * alpha, alpha];
        assert_eq!(
            to_linear.rows(&mut row, 4, true).unwrap(),
            Report::default()
        );
        assert_eq!(row, [planes[0][0], planes[1][0], planes[2][0], alpha]);
    }
    let each = [vec![0.5], vec![0.25], vec![1.0]];
    let mut planes = vec![vec![0.25], vec![0.1], vec![0.6]];
    let report = to_linear.planes(&mut planes, Alphas::Each(&each)).unwrap();
    assert_eq!(report, Report::default());
    assert_eq!(planes[0][0], want[0] * 0.5);
    assert_eq!(planes[1][0], want[1] * 0.25);
    assert_eq!(planes[2][0], want[2]);
}

#[test]
fn where_nothing_is_nothing_comes() {
    let to_linear = processor("S-Log3 S-Gamut3", "ACEScg");
    assert!(one(&to_linear, [0.0; 3])[0] != 0.0);
    let mut planes = vec![vec![0.0, 0.5], vec![0.0, 0.5], vec![0.0, 0.5]];
    let report = to_linear
        .planes(&mut planes, Alphas::Shared(&[0.0, 0.0]))
        .unwrap();
    assert_eq!(report, Report::default());
    assert!(planes.iter().all(|plane| plane[0] == 0.0));
    // Light without cover is light alone.
    assert_eq!(planes[0][1], one(&to_linear, [0.5; 3])[0]);
}

#[test]
fn grey_is_what_three_equal_channels_are() {
    let to_linear = processor("ARRI LogC3 (EI800)", "ACEScg");
    let codes = [-0.1, 0.391, 0.8];
    let mut grey = vec![codes.to_vec()];
    assert_eq!(
        to_linear.planes(&mut grey, Alphas::Straight).unwrap(),
        Report::default()
    );
    for (grey, code) in grey[0].iter().zip(codes) {
        assert_eq!(*grey, one(&to_linear, [code; 3])[1]);
    }
    assert!((grey[0][1] - 0.18).abs() < 1e-3);
    grey[0][0] = f32::NAN;
    assert_eq!(
        to_linear
            .planes(&mut grey, Alphas::Straight)
            .unwrap()
            .scrubbed,
        1
    );
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let to_linear = processor("CanonLog3 CinemaGamut D55", "ACEScg");
    let plane = |k: u32| -> Vec<f32> {
        let sample = |i: u32| (i.wrapping_mul(2_654_435_761 + k) >> 8) as f32 / 16_777_216.0;
        (0..20_011).map(sample).collect()
    };
    let planes: Vec<Vec<f32>> = (0..3).map(plane).collect();
    let alpha = plane(7);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let mut planes = planes.clone();
        let report = pool.install(|| to_linear.planes(&mut planes, Alphas::Shared(&alpha)));
        assert_eq!(report.unwrap(), Report::default());
        planes
    };
    let alone = on(1);
    assert_eq!(alone, on(3));
    let mut rows: Vec<f32> = Vec::new();
    for i in 0..alpha.len() {
        rows.extend([planes[0][i], planes[1][i], planes[2][i], alpha[i]]);
    }
    let mut here = rows.clone();
    assert_eq!(
        to_linear.rows(&mut rows, 4, true).unwrap(),
        Report::default()
    );
    assert_eq!(
        to_linear.rows_here(&mut here, 4, true).unwrap(),
        Report::default()
    );
    assert_eq!(here, rows);
    for (i, pixel) in rows.chunks(4).enumerate() {
        assert_eq!(pixel[..3], [alone[0][i], alone[1][i], alone[2][i]]);
    }
}

#[test]
fn data_are_left_alone() {
    let raw = processor("Raw", "ACEScg");
    assert!(raw.is_no_op());
    let mut planes = vec![vec![f32::NAN, 5.0]];
    assert_eq!(
        raw.planes(&mut planes, Alphas::Straight).unwrap(),
        Report::default()
    );
    assert!(planes[0][0].is_nan() && planes[0][1] == 5.0);
}

#[test]
fn planes_that_do_not_fit_are_refused() {
    let to_linear = processor("ACEScct", "ACEScg");
    assert!(
        to_linear
            .planes(&mut [vec![0.0], vec![0.0]], Alphas::Straight)
            .is_err()
    );
    let mut uneven = [vec![0.0], vec![0.0, 0.0], vec![0.0]];
    assert!(to_linear.planes(&mut uneven, Alphas::Straight).is_err());
    let mut planes = [vec![0.0], vec![0.0], vec![0.0]];
    assert!(to_linear.planes(&mut planes, Alphas::Shared(&[])).is_err());
    assert!(
        to_linear
            .planes(&mut planes, Alphas::Each(&[vec![1.0]]))
            .is_err()
    );
    assert!(to_linear.rows(&mut [0.0; 5], 3, false).is_err());
    assert!(to_linear.rows(&mut [0.0; 4], 2, false).is_err());
    assert!(to_linear.rows_here(&mut [0.0; 5], 3, false).is_err());
}
