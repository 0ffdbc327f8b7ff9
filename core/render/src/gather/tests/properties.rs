//! Properties of the fast renderer: linearity, conservation of light and translation.

use super::{HEIGHT, WEIGHTS, WIDTH, lens, plate, render, scene};
use crate::{BlurField, DisplacedBlur, Gather, Plane, PlateMap, Renderer, Scene};
use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
use seidel_optics::moments::MeridionalMoments;
use seidel_optics::psf::{Gaussian, LocalBlur, SkewNormal};
use std::ops::Range;

/// A lens with the same skewed blur everywhere.
struct UniformLens {
    frame: Frame,
    sigma_px: f64,
}

impl BlurField for UniformLens {
    fn frame(&self) -> Frame {
        self.frame
    }

    fn channel_count(&self) -> usize {
        3
    }

    fn blur_at(&self, channel: usize, _at: FieldPoint, _vergence_per_m: f64) -> DisplacedBlur {
        let meridian = FieldPoint::new(0.6, 0.8).meridian();
        let sigma = [0.9, 1.0, 1.15][channel] * self.sigma_px;
        let moments = MeridionalMoments {
            mu20: sigma * sigma,
            mu02: 0.7 * sigma * sigma,
            mu30: 0.2 * sigma.powi(3),
            mu12: 0.0,
        };
        DisplacedBlur {
            blur: LocalBlur::from_moments(moments.in_image(meridian), meridian),
            displacement_px: (0.3 * channel as f64, -0.2),
        }
    }
}

fn peak(planes: &[Vec<f32>]) -> f32 {
    planes.iter().flatten().copied().fold(0.0, f32::max)
}

/// Planes of one width.
struct Planes<'a> {
    samples: &'a [Vec<f32>],
    width: usize,
}

/// A comparison of part of some planes with other planes.
struct Comparison<'a> {
    planes: Planes<'a>,
    other: Planes<'a>,
    /// Columns and rows by which the same part lies further on in `other`.
    offset: (usize, usize),
    /// Columns of the part.
    columns: Range<usize>,
    /// Rows of the part.
    rows: Range<usize>,
}

impl Comparison<'_> {
    fn largest_difference(&self) -> f32 {
        let mut largest = 0.0_f32;
        for (plane, other) in self.planes.samples.iter().zip(self.other.samples) {
            for y in self.rows.clone() {
                for x in self.columns.clone() {
                    let there = (y + self.offset.1) * self.other.width + x + self.offset.0;
                    let difference = plane[y * self.planes.width + x] - other[there];
                    largest = largest.max(difference.abs());
                }
            }
        }
        largest
    }
}

/// Also with highlights.
#[test]
fn rendering_is_linear() {
    let lens = lens(5.0);
    let scene = scene(&lens, &SkewNormal);
    let (mut x, mut y) = (plate(1), plate(2));
    x[40 * WIDTH + 37] = 1e3;
    y[80 * WIDTH + 99] = 3e3;
    for (a, b) in [(2.0, 0.5), (0.25, 1.0)] {
        let both: Vec<f32> = x.iter().zip(&y).map(|(x, y)| a * x + b * y).collect();
        let of = |samples: &[f32]| render(&Gather::default(), &scene, samples);
        let (x, y, both) = (of(&x), of(&y), of(&both));
        let peak = peak(&both);
        for ((x, y), both) in x.iter().zip(&y).zip(&both) {
            for ((x, y), both) in x.iter().zip(y).zip(both) {
                assert!((a * x + b * y - both).abs() < 1e-5 * peak);
            }
        }
    }
}

/// Also with lights at the edge, and where wide blur is folded more than once.
#[test]
fn mirrored_edges_keep_all_light() {
    let mut samples = plate(3);
    for place in [0, WIDTH - 1, 50 * WIDTH, WIDTH * HEIGHT - 1] {
        samples[place] = 500.0;
    }
    let total: f64 = samples.iter().map(|v| f64::from(*v)).sum();
    for sigma in [1.5, 6.0, 40.0] {
        let lens = lens(sigma);
        for plane in render(&Gather::default(), &scene(&lens, &SkewNormal), &samples) {
            let kept = plane.iter().map(|v| f64::from(*v)).sum::<f64>() / total;
            assert!((kept - 1.0).abs() < 1e-3, "{sigma}: {kept}");
        }
    }
}

/// Exactly for whole pixels of the coarsest level, and to 60 dB for others.
#[test]
fn pictures_move_with_the_plate() {
    for (sigma, by, bound) in [
        (1.5, (5, 3), 1e-5),
        (1.5, (8, 8), 1e-5),
        (6.0, (16, 8), 1e-5),
        (6.0, (5, 3), 1e-3),
    ] {
        let even = UniformLens {
            frame: Frame::new(1200, 800, None).expect("a frame"),
            sigma_px: sigma,
        };
        let other = lens(sigma);
        let scene = Scene {
            lens: &even,
            ..scene(&other, &Gaussian)
        };
        let samples = plate(5);
        let mut moved = vec![0.0; WIDTH * HEIGHT];
        for y in by.1..HEIGHT {
            for x in by.0..WIDTH {
                moved[y * WIDTH + x] = samples[(y - by.1) * WIDTH + x - by.0];
            }
        }
        let of = |samples: &[f32]| render(&Gather::default(), &scene, samples);
        let (still, moved) = (of(&samples), of(&moved));
        let margin = (7.0 * sigma) as usize;
        let comparison = Comparison {
            planes: Planes {
                samples: &still,
                width: WIDTH,
            },
            other: Planes {
                samples: &moved,
                width: WIDTH,
            },
            offset: by,
            columns: margin..WIDTH - by.0 - margin,
            rows: margin..HEIGHT - by.1 - margin,
        };
        let found = comparison.largest_difference() / peak(&still);
        assert!(found < bound, "{sigma} by {by:?}: {found}");
    }
}

/// Tiles and highlight blocks of the crop lie elsewhere than those of the whole.
#[test]
fn a_crop_with_a_margin_equals_the_whole() {
    for (sigma, margin) in [(2.0, 12), (5.0, 30)] {
        let lens = lens(sigma);
        let whole = scene(&lens, &SkewNormal);
        let mut samples = plate(2);
        samples[60 * WIDTH + 70] = 1e4;
        let (left, top, width, height) = (13, 7, 119, 95);
        let cut: Vec<f32> = (0..width * height)
            .map(|k| samples[(top + k / width) * WIDTH + left + k % width])
            .collect();
        let origin = whole.map.origin;
        let crop = Scene {
            width,
            height,
            map: PlateMap {
                origin: ImagePoint::new(origin.x_px + left as f64, origin.y_px + top as f64),
                scale: 1.0,
            },
            ..scene(&lens, &SkewNormal)
        };
        let planes = WEIGHTS.each_ref().map(|weights| Plane {
            samples: &cut,
            weights,
        });
        let part = Gather::default().render(&crop, &planes, &|_| true);
        let part = part.expect("a sound scene").planes;
        let all = render(&Gather::default(), &whole, &samples);
        let comparison = Comparison {
            planes: Planes {
                samples: &part,
                width,
            },
            other: Planes {
                samples: &all,
                width: WIDTH,
            },
            offset: (left, top),
            columns: margin..width - margin,
            rows: margin..height - margin,
        };
        let found = comparison.largest_difference();
        // Relative to the plate's white, not to the light, which is thousands of times as bright.
        assert!(found < 1e-3, "{sigma}: {found}");
    }
}
