//! Edges of charts that the tests draw themselves.

use seidel_optics::distance::ObjectDistance;
use seidel_optics::edges::Edge;
use seidel_optics::error::{Error, ErrorKind};
use seidel_optics::mosaic::Mosaic;
use seidel_optics::numeric::SplitMix64;
use seidel_optics::psf::normal_cdf;

use super::{EdgeSettings, MeasuredEdges, measure_edges};
use crate::Calibration;
use crate::photograph::{Photograph, SampleErrors};
use crate::rejection::Reason;

const WIDTH: usize = 240;
const HEIGHT: usize = 180;
/// Rays of a point.
const RAYS: usize = 80;
/// Variance of the Gaussian blur, the pixel's area included, px².
const BLUR: f64 = 0.4 + 1.0 / 12.0;
const GAIN: f64 = 0.5;
const WHITE: f64 = 15_000.0;

/// A chart of squares at `pitch` px, turned by `turn`.
#[derive(Clone, Copy)]
struct Chart {
    pitch: f64,
    half: f64,
    turn: f64,
    /// Light of paper and of squares, electrons.
    paper: f64,
    ink: f64,
    /// Radius of the disc and amount of coma, px.
    disc: f64,
    coma: f64,
}

const CHART: Chart = Chart {
    pitch: 44.0,
    half: 15.0,
    turn: 0.14,
    paper: 20_000.0,
    ink: 1_500.0,
    disc: 2.6,
    coma: 0.8,
};

impl Chart {
    /// Returns the landing points of rays from their centroid: a disc with coma along x, the same everywhere.
    fn rays(&self) -> Vec<[f64; 2]> {
        let mut rays: Vec<[f64; 2]> = (0..RAYS)
            .map(|k| {
                let radius = ((k as f64 + 0.5) / RAYS as f64).sqrt();
                let (sin, cos) = (2.399_963_229_728_653 * k as f64).sin_cos();
                let (x, y) = (radius * cos, radius * sin);
                let square = radius * radius;
                [
                    self.disc * x + self.coma * (square + 2.0 * x * x),
                    self.disc * y + self.coma * 2.0 * x * y,
                ]
            })
            .collect();
        let count = rays.len() as f64;
        let mean = [0, 1].map(|a| rays.iter().map(|r| r[a]).sum::<f64>() / count);
        rays.iter_mut()
            .for_each(|r| *r = [r[0] - mean[0], r[1] - mean[1]]);
        rays
    }

    /// Returns the light of the chart at every pixel, electrons.
    fn light(&self) -> Vec<f64> {
        let (sin, cos) = self.turn.sin_cos();
        let width = BLUR.sqrt();
        let rays = self.rays();
        let at = |x: f64, y: f64| {
            let mut covered = 0.0;
            for ray in &rays {
                let (x, y) = (x - ray[0], y - ray[1]);
                let (u, v) = (cos * x + sin * y, cos * y - sin * x);
                let inside = |w: f64| {
                    let off = w - ((w / self.pitch).floor() + 0.5) * self.pitch;
                    normal_cdf((off + self.half) / width) - normal_cdf((off - self.half) / width)
                };
                covered += inside(u) * inside(v);
            }
            let share = covered / rays.len() as f64;
            let uneven = 1.0 + 0.2 * (x / WIDTH as f64 - 0.5);
            uneven * (self.paper + (self.ink - self.paper) * share)
        };
        (0..WIDTH * HEIGHT)
            .map(|k| at((k % WIDTH) as f64 + 0.5, (k / WIDTH) as f64 + 0.5))
            .collect()
    }

    /// Returns the variance without the pixel's area and the third moment along `normal`.
    fn moments(&self, normal: [f64; 2]) -> [f64; 2] {
        let rays = self.rays();
        let mean = |n: i32| {
            let along = rays
                .iter()
                .map(|r| (r[0] * normal[0] + r[1] * normal[1]).powi(n));
            along.sum::<f64>() / rays.len() as f64
        };
        [mean(2) + BLUR - 1.0 / 12.0, mean(3)]
    }
}

/// Exposes `light` through a mosaic, with photon and read noise.
fn expose(light: &[f64], seed: u64) -> Photograph {
    let mut random = SplitMix64::new(seed);
    let mut normal = || {
        let radius = (-2.0 * (1.0 - random.unit()).ln()).sqrt();
        radius * (std::f64::consts::TAU * random.unit()).cos()
    };
    let mosaic = Mosaic::parse("RGGB").expect("a pattern");
    let counts = light.iter().enumerate().map(|(k, light)| {
        let colour = mosaic.colour_at(k % WIDTH, k / WIDTH);
        let electrons = light * if colour == 'G' { 1.0 } else { 0.6 };
        let noisy = electrons + electrons.sqrt() * normal() + 4.0 * normal();
        (noisy * GAIN).round().min(WHITE) as f32
    });
    Photograph {
        name: "chart.dng".to_owned(),
        width: WIDTH,
        height: HEIGHT,
        planes: vec![counts.collect()],
        channels: ["R", "G", "B"].map(str::to_owned).to_vec(),
        mosaic: Some(mosaic),
        white: WHITE as f32 * 0.998,
        distance: ObjectDistance::Metres(2.0),
        gain: None,
        errors: SampleErrors {
            quantum: 1.0,
            ..SampleErrors::default()
        },
        bad: Vec::new(),
    }
}

fn measured(photograph: Photograph) -> Result<MeasuredEdges, Error> {
    measure_edges(
        vec![photograph],
        &Calibration::default(),
        &EdgeSettings::default(),
    )
}

#[test]
fn moments_along_the_normals_are_those_of_the_rays_within_their_stated_errors() {
    let mut photograph = expose(&CHART.light(), 3);
    // Defective pixels do not spoil the edges that they lie on.
    for k in 0..20 {
        photograph.planes[0][(37 + 2111 * k) % (WIDTH * HEIGHT)] += 6000.0;
    }
    let set = measured(photograph).expect("edges");
    let greens: Vec<&Edge> = set.set.edges.iter().filter(|e| e.channel == 1).collect();
    assert!(greens.len() >= 40, "{} {:?}", greens.len(), set.left_out);
    let (mut within, mut all, mut worst) = ([0; 2], 0, 0.0_f64);
    for edge in &set.set.edges {
        let [variance, third] = CHART.moments(edge.normal);
        all += 1;
        within[0] += usize::from((edge.variance_px2 - variance).abs() < 1.96 * edge.variance_sigma);
        within[1] += usize::from((edge.third_px3 - third).abs() < 1.96 * edge.third_sigma);
        if edge.channel == 1 {
            worst = worst.max((edge.variance_px2 / variance - 1.0).abs());
        }
        // The normals are those of the squares, towards the paper.
        let turned = edge.normal[1].atan2(edge.normal[0]) - CHART.turn;
        let quarter = turned / std::f64::consts::FRAC_PI_2;
        assert!((quarter - quarter.round()).abs() < 0.01, "{edge:?}");
    }
    for within in within {
        let share = f64::from(within as u32) / f64::from(all);
        assert!((0.88..=0.995).contains(&share), "{share} of {all}");
    }
    assert!(worst < 0.2, "{worst}");
    let gain = set.gain.expect("from the noise");
    assert!((gain / GAIN - 1.0).abs() < 0.15, "{gain}");
}

#[test]
fn edges_that_are_no_use_are_left_out_with_the_reason() {
    let mut light = CHART.light();
    // Overexposed on the right, and hardly any contrast at the bottom left.
    for (k, light) in light.iter_mut().enumerate() {
        let (x, y) = (k % WIDTH, k / WIDTH);
        if x > 170 {
            *light *= 1.8;
        } else if y > 110 && x < 80 {
            *light = 0.94 * CHART.paper + 0.06 * *light;
        }
    }
    let set = measured(expose(&light, 4)).expect("some edges");
    let found = |why: Reason| -> Vec<[f64; 2]> {
        let of = set.left_out.iter().filter(|l| l.why == why);
        of.map(|l| [l.x, l.y]).collect()
    };
    let clipped = found(Reason::Clipped);
    assert!(
        clipped.len() > 4 && clipped.iter().all(|p| p[0] > 150.0),
        "{:?}",
        set.left_out
    );
    assert!(!found(Reason::LowContrast).is_empty(), "{:?}", set.left_out);
    assert!(!found(Reason::Border).is_empty(), "{:?}", set.left_out);
    assert!(set.set.edges.iter().all(|e| e.mid.x_px < 175.0));
}

#[test]
fn photographs_without_usable_edges_are_refused_with_the_reason() {
    let flat = measured(expose(&[3000.0; WIDTH * HEIGHT], 5)).expect_err("no edge");
    assert!(flat.to_string().contains("none found"), "{flat}");
    assert_eq!(flat.kind(), ErrorKind::InsufficientData);
    let small = Chart {
        pitch: 18.0,
        half: 5.0,
        ..CHART
    };
    let small = measured(expose(&small.light(), 5)).expect_err("small squares");
    assert!(small.to_string().contains("short_edge"), "{small}");
    let error = measured(sharpened(0.7)).expect_err("sharpened");
    assert!(error.to_string().contains("sharpened"), "{error}");
}

/// Returns the exposed chart after an unsharp mask of `amount`, as cameras apply it.
fn sharpened(amount: f32) -> Photograph {
    let mut photograph = expose(&CHART.light(), 6);
    let before = photograph.planes[0].clone();
    for y in 4..HEIGHT - 4 {
        for x in 4..WIDTH - 4 {
            let near = [-4_i64, -2, 2, 4].iter().map(|d| {
                let along = (y * WIDTH) as i64 + x as i64 + d;
                let across = (y as i64 + d) * WIDTH as i64 + x as i64;
                before[along as usize] + before[across as usize]
            });
            let mean = near.sum::<f32>() / 8.0;
            let here = before[y * WIDTH + x];
            photograph.planes[0][y * WIDTH + x] = here + amount * (here - mean);
        }
    }
    photograph
}

#[test]
fn weak_sharpening_shows_in_the_mean_of_all_edges() {
    let error = measured(sharpened(0.12))
        .expect_err("sharpened")
        .to_string();
    assert!(
        error.contains("in the mean of") && error.contains(" % of the step"),
        "{error}"
    );
    assert!(measured(sharpened(0.0)).is_ok());
}

/// Codes of a display without noise: even areas are flat, and every step of a code is a contour.
#[test]
fn eight_bits_without_noise_are_measured() {
    let decode = |code: f64| ((code + 0.055) / 1.055).powf(2.4);
    let encode = |linear: f64| 1.055 * linear.powf(1.0 / 2.4) - 0.055;
    let plane = CHART.light().into_iter().map(|light| {
        let code = (255.0 * encode(light / 25_000.0)).round() / 255.0;
        (255.0 * decode(code)) as f32
    });
    let set = measured(Photograph {
        planes: vec![plane.collect()],
        channels: vec!["Y".to_owned()],
        mosaic: None,
        white: 254.0,
        errors: SampleErrors::EIGHT_BIT,
        ..expose(&CHART.light(), 1)
    });
    let set = set.expect("edges");
    assert!(
        set.set.edges.len() >= 30,
        "{} {:?}",
        set.set.edges.len(),
        set.left_out.len()
    );
    for edge in &set.set.edges {
        let [variance, _] = CHART.moments(edge.normal);
        let error = (edge.variance_px2 - variance).abs();
        assert!(
            error < 0.15 * variance && error < edge.variance_sigma,
            "{edge:?}"
        );
    }
}
