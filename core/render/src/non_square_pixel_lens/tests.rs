//! Non-square pixels against plates of square pixels at twice the width.

use crate::*;
use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
use seidel_optics::lens::{LocalPupil, ReducedNumbers, Stop, Wavefront};
use seidel_optics::moments::MeridionalMoments;
use seidel_optics::psf::{
    ALL, Gaussian, LocalBlur, MirroredPair, PHI, PsfModel, Pupil, SampleGrid as Tile, SkewNormal,
};
use seidel_optics::sensor::{Halo, Sensor};

/// A lens whose blur grows off the axis and is radial, skewed and displaced.
struct TestLens {
    rays: bool,
}

impl BlurField for TestLens {
    fn frame(&self) -> Frame {
        Frame::new(1200, 800, None).expect("a frame")
    }

    fn channel_count(&self) -> usize {
        3
    }

    fn blur_at(&self, channel: usize, at: FieldPoint, _: f64) -> DisplacedBlur {
        let strength = [0.9, 1.0, 1.15][channel];
        let h = at.radius();
        let blur = if self.rays {
            let numbers = ReducedNumbers {
                alpha: 8.0 * strength,
                beta: 1.0,
                gamma: 3.0 * strength,
                delta: 4.0,
                phi: -2.0,
            };
            let rays = Wavefront::third_order(&numbers, at);
            LocalBlur::from_pupil(LocalPupil::circular(rays, 0.3), at.meridian())
        } else {
            let (along, across) = (strength * (2.5 + 4.0 * h * h), strength * (2.5 + h * h));
            let moments = MeridionalMoments {
                mu20: along * along,
                mu02: across * across,
                mu30: PHI * (0.9 * h.min(1.0) * along).powi(3),
                mu12: 4.0 * h,
            };
            LocalBlur::from_moments(moments.in_image(at.meridian()), at.meridian())
        };
        let drift = channel as f64 - 0.5;
        DisplacedBlur {
            blur,
            displacement_px: (2.0 * drift * at.x, 3.0 * drift * at.y),
        }
    }
}

fn lens(rays: bool) -> TestLens {
    TestLens { rays }
}

const ORIGIN: ImagePoint = ImagePoint::new(700.0, 130.0);
const HEIGHT: usize = 64;
/// Columns of square pixels.
const WIDTH: usize = 128;

/// A smooth picture at a point, px from the plate's corner.
fn picture(x: f64, y: f64) -> f64 {
    let wave = |at: f64, period: f64| (std::f64::consts::TAU * at / period).sin();
    0.5 + 0.2 * wave(x + 0.4 * y, 61.0) + 0.15 * wave(y - 0.3 * x, 47.0) + 0.1 * wave(x, 83.0)
}

/// The plate on pixels `aspect` wide, each the mean of its square ones.
fn plate(aspect: usize) -> Vec<f32> {
    let columns = WIDTH / aspect;
    let mean = |k: usize| {
        let (column, row) = (k % columns, k / columns);
        let square =
            (0..aspect).map(|s| picture((column * aspect + s) as f64 + 0.5, row as f64 + 0.5));
        square.sum::<f64>() / aspect as f64
    };
    (0..columns * HEIGHT).map(|k| mean(k) as f32).collect()
}

/// Renders `samples` on pixels `aspect` times as wide as high.
fn rendered(
    renderer: &dyn Renderer,
    lens: &TestLens,
    model: &dyn PsfModel,
    aspect: usize,
    samples: &[f32],
) -> Vec<Vec<f32>> {
    let wide = NonSquarePixelLens::new(lens, aspect as f64).expect("an aspect");
    let lens: &dyn BlurField = if aspect == 1 { lens } else { &wide };
    let scene = scene(lens, model, aspect);
    let weights = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    let planes = weights.each_ref().map(|weights| Plane { samples, weights });
    renderer
        .render(&scene, &planes, &|_| true)
        .expect("a sound scene")
        .planes
}

fn scene<'a>(lens: &'a dyn BlurField, model: &'a dyn PsfModel, aspect: usize) -> Scene<'a> {
    Scene {
        lens,
        model,
        width: WIDTH / aspect,
        height: HEIGHT,
        map: PlateMap {
            origin: ImagePoint::new(ORIGIN.x_px / aspect as f64, ORIGIN.y_px),
            scale: 1.0,
        },
        vergence: VergencePass::Constant(0.0),
        edges: Edges::Mirror,
        displacement: Displacement::Full,
    }
}

fn decibels(a: &[f32], b: &[f32]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2));
    -10.0 * (squares.sum::<f64>() / a.len() as f64).log10()
}

fn halved(samples: &[f32]) -> Vec<f32> {
    samples
        .chunks_exact(2)
        .map(|pair| 0.5 * (pair[0] + pair[1]))
        .collect()
}

#[test]
fn wide_pixels_show_the_mean_of_the_square_ones() {
    for (rays, model, bound) in [
        (false, &Gaussian as &dyn PsfModel, 60.0),
        (false, &SkewNormal, 60.0),
        (false, &MirroredPair, 60.0),
        (true, &Pupil, 50.0),
    ] {
        let lens = lens(rays);
        let square = rendered(&Scatter, &lens, model, 1, &plate(1));
        let wide = rendered(&Scatter, &lens, model, 2, &plate(2));
        let fast = rendered(&Gather::default(), &lens, model, 2, &plate(2));
        for ((square, wide), fast) in square.iter().zip(&wide).zip(&fast) {
            let want = halved(square);
            let id = model.id();
            let db = decibels(&want, wide);
            assert!(db > bound, "{id}: {db} dB");
            // Half or twice the blur would fail.
            assert!(db > 15.0 + decibels(&want, &plate(2)), "{id}: {db} dB");
            assert!(
                decibels(wide, fast) > 50.0,
                "{id}: {} dB",
                decibels(wide, fast)
            );
        }
    }
}

#[test]
fn moments_of_kernels_scale_with_the_pixel_aspect() {
    for (rays, model) in [(false, &SkewNormal as &dyn PsfModel), (true, &Pupil)] {
        let lens = lens(rays);
        let drawn = |aspect: usize| {
            let (columns, column) = (WIDTH / aspect, 64 / aspect);
            let mut samples = vec![0.0; columns * HEIGHT];
            samples[32 * columns + column] = 1.0;
            let light = rendered(&Scatter, &lens, model, aspect, &samples).remove(0);
            let sum = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
                let terms = light.iter().enumerate();
                terms
                    .map(|(k, v)| f64::from(*v) * f((k % columns) as f64, (k / columns) as f64))
                    .sum()
            };
            let (energy, x, y) = (sum(&|_, _| 1.0), sum(&|x, _| x), sum(&|_, y| y));
            assert!((energy - 1.0).abs() < 1e-5, "{energy}");
            let moment = |p: i32, q: i32| sum(&|u, v| (u - x).powi(p) * (v - y).powi(q));
            [moment(2, 0), moment(1, 1), moment(0, 2), moment(3, 0)]
        };
        let square = drawn(1);
        {
            let aspect = 2;
            let got = drawn(aspect);
            let a = aspect as f64;
            // Ray-traced kernels are integrated over the pixels of each shape.
            let pixel = if rays {
                (1.0 - 1.0 / (a * a)) / 12.0
            } else {
                0.0
            };
            let want = [
                square[0] / (a * a) + pixel,
                square[1] / a,
                square[2],
                square[3] / (a * a * a),
            ];
            for (got, want) in got.iter().zip(want) {
                let off = (got - want).abs();
                assert!(off < 0.02 * want.abs() + 0.02, "{aspect}: {got} {want}");
            }
        }
    }
}

#[test]
fn square_pixels_change_no_bit() {
    let lens = lens(true);
    let one = NonSquarePixelLens::new(&lens, 1.0).expect("an aspect");
    let samples = plate(1);
    let planes = [Plane {
        samples: &samples,
        weights: &[0.2, 0.3, 0.5],
    }];
    let by = |lens: &dyn BlurField, model| {
        let done = Scatter.render(&scene(lens, model, 1), &planes, &|_| true);
        done.expect("a sound scene").planes
    };
    for model in [&MirroredPair as &dyn PsfModel, &Pupil] {
        assert_eq!(by(&one, model), by(&lens, model), "{}", model.id());
    }
    for bad in [0.0, -1.0, 17.0, f64::NAN, f64::INFINITY] {
        assert!(NonSquarePixelLens::new(&lens, bad).is_err(), "{bad}");
    }
}

#[test]
fn single_pixels_agree_with_the_exact_renderer() {
    for (rays, model) in [(false, &MirroredPair as &dyn PsfModel), (true, &Pupil)] {
        let lens = lens(rays);
        let wide = NonSquarePixelLens::new(&lens, 2.0).expect("an aspect");
        let samples = plate(2);
        let plane = Plane {
            samples: &samples,
            weights: &[0.2, 0.3, 0.5],
        };
        let scene = scene(&wide, model, 2);
        let all = Scatter
            .render(&scene, &[plane], &|_| true)
            .expect("sound")
            .planes
            .remove(0);
        let pixels = [(0, 0), (63, 63), (30, 40), (3, 50)];
        let spots = exact_at_pixels(&scene, &plane, &pixels, 1).expect("sound");
        for ((x, y), spot) in pixels.iter().zip(spots) {
            assert!((spot - f64::from(all[y * 64 + x])).abs() < 2e-5);
        }
    }
}

/// Models of moments: the density at (x, y) on wide pixels is that of square ones at (a x, y), times a.
#[test]
fn densities_stretch_with_the_pixel_aspect() {
    let at = FieldPoint::new(0.6, -0.7);
    let moments = MeridionalMoments {
        mu20: 30.0,
        mu02: 14.0,
        mu30: 90.0,
        mu12: 25.0,
    };
    let square = LocalBlur::from_moments(moments.in_image(at.meridian()), at.meridian());
    for aspect in [2.0, 0.5] {
        let wide = square.on_wider_pixels(aspect);
        for model in ALL.iter().filter(|model| !model.needs_rays()) {
            for (x, y) in [(0.0, 0.0), (2.0, 1.0), (-3.0, 4.0), (1.0, -5.0)] {
                let density = |blur: &LocalBlur, x: f64| {
                    let window = Tile {
                        first_x_px: x,
                        first_y_px: y,
                        width: 1,
                        height: 1,
                    };
                    let mut out = [0.0];
                    model.sample(blur, &window, &mut out);
                    out[0]
                };
                let (got, want) = (density(&wide, x), aspect * density(&square, aspect * x));
                let id = model.id();
                assert!(
                    (got - want).abs() < 1e-9 * (1.0 + want),
                    "{id}: {got} {want}"
                );
            }
        }
    }
}

/// With rays, waves, blur and all sensor effects, a wide pixel is the sum of its two square ones.
#[test]
fn ray_traced_kernels_equal_pairs_of_square_pixels() {
    let numbers = ReducedNumbers {
        alpha: 14.0,
        beta: -2.0,
        gamma: 3.0,
        delta: 1.0,
        phi: -2.0,
    };
    let at = FieldPoint::new(0.5, -0.7);
    let plain = LocalPupil::circular(Wavefront::third_order(&numbers, at), 1.5);
    let mut clipped = plain.clone();
    clipped.clip(Stop {
        centre: [0.5, 0.2],
        radius: 1.0,
    });
    let mut wavy = plain.clone();
    wavy.wave_px = 3.0;
    let mut seen = plain.clone();
    seen.sensor = Sensor {
        streak_px: [5.0, 3.0],
        box_px: [2.0, 1.0],
        copies_px: [3.0, 2.0],
        halo: Halo {
            share: 0.2,
            radius_px: 5.0,
            steepness: 2.6,
            ..Halo::default()
        },
        ..Sensor::default()
    };
    for (name, pupil, bound) in [
        ("rays", plain, 1e-4),
        ("stops", clipped, 1e-4),
        ("waves", wavy, 1e-5),
        ("sensor", seen, 1e-5),
    ] {
        let square = LocalBlur::from_pupil(pupil, at.meridian());
        let wide = square.on_wider_pixels(2.0);
        let (columns, rows) = (64, 64);
        let draw = |blur: &LocalBlur, count: usize| {
            let tile = Tile {
                first_x_px: 0.5 - count as f64 / 2.0,
                first_y_px: 0.5 - rows as f64 / 2.0,
                width: count,
                height: rows,
            };
            let mut out = vec![0.0; tile.len()];
            Pupil.sample(blur, &tile, &mut out);
            out
        };
        let (fine, got) = (draw(&square, 2 * columns), draw(&wide, columns));
        let want: Vec<f64> = fine.chunks_exact(2).map(|pair| pair[0] + pair[1]).collect();
        let energy =
            |of: &dyn Fn(usize) -> f64| (0..want.len()).map(|k| of(k).powi(2)).sum::<f64>();
        let apart = energy(&|k| got[k] - want[k]) / energy(&|k| want[k]);
        let lost = got.iter().sum::<f64>() - want.iter().sum::<f64>();
        assert!(apart < bound && lost.abs() < 3e-3, "{name}: {apart} {lost}");
        // The bounds hold the light.
        let reach = Pupil.kernel_bounds(&wide);
        assert!(
            reach.left_px < 0.75 * Pupil.kernel_bounds(&square).left_px,
            "{name}"
        );
    }
}
