//! Pictures moved by known transforms are registered.

use super::*;
use seidel_optics::field::ImagePoint;
use seidel_optics::numeric::SplitMix64;

/// Smooth random waves, evaluated anywhere.
struct Waves(Vec<[f64; 4]>);

impl Waves {
    fn new() -> Self {
        let mut random = SplitMix64::new(3);
        let mut draw = |least: f64, most: f64| least + (most - least) * random.unit();
        Self(
            (0..150)
                .map(|_| {
                    [
                        draw(-0.9, 0.9),
                        draw(-0.9, 0.9),
                        draw(0.0, std::f64::consts::TAU),
                        draw(0.2, 1.0),
                    ]
                })
                .collect(),
        )
    }

    fn picture(&self, width: usize, height: usize, of: &Similarity) -> Picture {
        let samples = (0..width * height).map(|k| {
            let (x, y) = (k % width, k / width);
            let at = of.apply(ImagePoint::new(x as f64 + 0.5, y as f64 + 0.5));
            let waves = self.0.iter();
            waves
                .map(|[u, v, phase, size]| size * (u * at.x_px + v * at.y_px + phase).sin())
                .sum::<f64>() as f32
        });
        Picture {
            width,
            height,
            samples: samples.collect(),
        }
    }
}

/// Asserts that a picture is registered to its version moved by `truth`, within `tolerance_px` in the corners.
fn registers(truth: Similarity, size: (usize, usize), tolerance_px: f64) {
    let waves = Waves::new();
    let from = waves.picture(420, 300, &Similarity::IDENTITY);
    let to = waves.picture(size.0, size.1, &truth.inverse());
    let found = register(&from, &to).expect("one scene").transform;
    for (x, y) in [(0.0, 0.0), (420.0, 0.0), (0.0, 300.0), (420.0, 300.0)] {
        let corner = ImagePoint::new(x, y);
        let (got, want) = (found.apply(corner), truth.apply(corner));
        let off = (got.x_px - want.x_px).hypot(got.y_px - want.y_px);
        assert!(off < tolerance_px, "{off}: {found:?} {truth:?}");
    }
}

#[test]
fn shifts_scales_and_crops_are_found() {
    registers(Similarity::shift(7.3, -4.6), (420, 300), 0.1);
    registers(Similarity::shift(-60.0, -41.0), (300, 220), 0.1);
    let (sin, cos) = 0.004_f64.sin_cos();
    let turned = Similarity {
        a: 1.003 * cos,
        b: 1.003 * sin,
        shift_px: [2.0, 1.0],
    };
    registers(turned, (420, 300), 0.3);
    let half = Similarity {
        a: 0.8,
        ..Similarity::IDENTITY
    };
    registers(half, (336, 240), 0.5);
}

#[test]
fn pictures_of_different_scenes_are_refused() {
    let mut random = SplitMix64::new(8);
    let mut noise = || Picture {
        width: 320,
        height: 200,
        samples: (0..320 * 200).map(|_| random.unit() as f32).collect(),
    };
    let error = register(&noise(), &noise()).expect_err("nothing in common");
    assert_eq!(error.kind(), ErrorKind::InsufficientData);
    assert!(error.problem.contains("common detail"), "{error}");
}
