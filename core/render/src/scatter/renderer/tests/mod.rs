//! The exact renderer against direct summation in double precision.

mod displacement;
mod pupil;

use crate::*;
use seidel_optics::field::Meridian;
use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
use seidel_optics::moments::MeridionalMoments;
use seidel_optics::psf::LocalBlur;
use seidel_optics::psf::{MirroredPair, PsfModel, SampleGrid, SkewNormal};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A lens given by a function.
struct Lens<F> {
    channel_count: usize,
    blur: F,
}

impl<F: Fn(usize, FieldPoint, f64) -> DisplacedBlur + Sync> BlurField for Lens<F> {
    fn frame(&self) -> Frame {
        Frame::new(24, 16, None).expect("a valid frame")
    }

    fn channel_count(&self) -> usize {
        self.channel_count
    }

    fn blur_at(&self, channel: usize, at: FieldPoint, vergence_per_m: f64) -> DisplacedBlur {
        (self.blur)(channel, at, vergence_per_m)
    }
}

/// A blur that grows with field, depth and channel, skewed and displaced outwards.
fn varying(channel: usize, at: FieldPoint, vergence: f64) -> DisplacedBlur {
    let (meridian, h) = (at.meridian(), at.radius());
    let size = (0.5 + 0.3 * channel as f64 + h + 1.5 * vergence.abs()).powi(2);
    let moments = MeridionalMoments {
        mu20: size * (1.0 + h),
        mu02: size,
        mu30: 0.7 * h * size.powf(1.5),
        mu12: 0.2 * h * size.powf(1.5),
    };
    let out = 0.8 * h * h * (1.0 + 0.2 * channel as f64);
    DisplacedBlur {
        blur: LocalBlur::from_moments(moments.in_image(meridian), meridian),
        displacement_px: (out * meridian.cos, out * meridian.sin),
    }
}

/// The same blur everywhere: variances (px²) along x and y, third moment along x, no displacement.
fn constant(mu20: f64, mu02: f64, mu30: f64) -> DisplacedBlur {
    let moments = MeridionalMoments {
        mu20,
        mu02,
        mu30,
        mu12: 0.0,
    };
    DisplacedBlur {
        blur: LocalBlur::from_moments(moments.in_image(Meridian::X), Meridian::X),
        displacement_px: (0.0, 0.0),
    }
}

fn scene<'a>(lens: &'a dyn BlurField, width: usize, height: usize) -> Scene<'a> {
    Scene {
        lens,
        model: &SkewNormal,
        width,
        height,
        map: PlateMap {
            origin: ImagePoint::new(2.0, 1.5),
            scale: 1.0,
        },
        vergence: VergencePass::Constant(0.0),
        edges: Edges::Mirror,
        displacement: Displacement::None,
    }
}

fn render(scene: &Scene, planes: &[Plane]) -> Vec<Vec<f32>> {
    let done = Scatter.render(scene, planes, &|_| true);
    done.expect("a valid scene").planes
}

/// An uneven plate with some zeros.
fn plate(width: usize, height: usize, seed: u32) -> Vec<f32> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1_u32 << 24) as f32
    };
    (0..width * height)
        .map(|_| (next() * 1.25 - 0.25).max(0.0))
        .collect()
}

fn total(plane: &[f32]) -> f64 {
    plane.iter().map(|&light| f64::from(light)).sum()
}

/// The definition of rendering, summed directly in double precision.
fn brute_force(scene: &Scene, planes: &[Plane]) -> Vec<Vec<f64>> {
    let (width, height) = (scene.width as i64, scene.height as i64);
    let mut out = vec![vec![0.0; scene.pixel_count()]; planes.len()];
    for index in 0..scene.pixel_count() {
        let (column, row) = (index % scene.width, index / scene.width);
        let x = scene.map.origin.x_px + (column as f64 + 0.5) / scene.map.scale;
        let y = scene.map.origin.y_px + (row as f64 + 0.5) / scene.map.scale;
        let at = scene.lens.frame().field_point(ImagePoint::new(x, y));
        let channels: Vec<_> = (0..scene.lens.channel_count())
            .map(|channel| scene.lens.blur_at(channel, at, scene.vergence_at(index)))
            .collect();
        for (channel, placed) in channels.iter().enumerate() {
            let mut shift = (0.0, 0.0);
            let mut blur = placed.blur.rescaled(scene.map.scale);
            if scene.displacement != Displacement::None {
                let (x, y) = placed.displacement_px;
                let count = channels.len() as f64;
                let mean = if scene.displacement == Displacement::Lateral {
                    let sum = |f: fn(&DisplacedBlur) -> f64| channels.iter().map(f).sum::<f64>();
                    (
                        sum(|placed| placed.displacement_px.0) / count,
                        sum(|placed| placed.displacement_px.1) / count,
                    )
                } else {
                    (0.0, 0.0)
                };
                shift = (
                    (x - mean.0) * scene.map.scale,
                    (y - mean.1) * scene.map.scale,
                );
                // That of linear interpolation, up to a limit.
                let variance = [shift.0, shift.1].map(|shift: f64| {
                    let part = shift.rem_euclid(1.0);
                    part * (1.0 - part)
                });
                let variance = variance[0].max(variance[1]).min(0.1);
                blur.moments = blur.moments.with_least_variance(variance);
            }
            let reach = scene.model.kernel_bounds(&blur);
            let left = (shift.0 - reach.left_px).floor();
            let top = (shift.1 - reach.up_px).floor();
            let window = SampleGrid {
                first_x_px: left - shift.0,
                first_y_px: top - shift.1,
                width: (shift.0 + reach.right_px - left) as usize + 2,
                height: (shift.1 + reach.down_px - top) as usize + 2,
            };
            let mut weights = vec![0.0; window.len()];
            scene.model.sample(&blur, &window, &mut weights);
            let sum: f64 = weights.iter().sum();
            for (k, weight) in weights.iter().enumerate() {
                let mut x = column as i64 + left as i64 + (k % window.width) as i64;
                let mut y = row as i64 + top as i64 + (k / window.width) as i64;
                if scene.edges == Edges::Mirror {
                    while !(0..width).contains(&x) {
                        x = if x < 0 { -1 - x } else { 2 * width - 1 - x };
                    }
                    while !(0..height).contains(&y) {
                        y = if y < 0 { -1 - y } else { 2 * height - 1 - y };
                    }
                } else if !(0..width).contains(&x) || !(0..height).contains(&y) {
                    continue;
                }
                for (out, plane) in out.iter_mut().zip(planes) {
                    out[(y * width + x) as usize] +=
                        f64::from(plane.samples[index]) * plane.weights[channel] * weight / sum;
                }
            }
        }
    }
    out
}

fn assert_close(got: &[Vec<f32>], want: &[Vec<f64>], largest_error: f64, case: &str) {
    for (plane, (got, want)) in got.iter().zip(want).enumerate() {
        for (index, (got, want)) in got.iter().zip(want).enumerate() {
            let error = (f64::from(*got) - want).abs();
            assert!(
                error <= largest_error,
                "{case}: plane {plane}, sample {index} is {got}, not {want}"
            );
        }
    }
}

#[test]
fn agrees_with_direct_summation() {
    let lens = Lens {
        channel_count: 2,
        blur: varying,
    };
    let (width, height) = (19, 11);
    let (first, second) = (plate(width, height, 1), plate(width, height, 2));
    let alpha = plate(width, height, 3);
    let depth: Vec<f32> = plate(width, height, 4).iter().map(|v| v - 0.4).collect();
    let planes = [
        Plane {
            samples: &first,
            weights: &[1.0, 0.0],
        },
        Plane {
            samples: &second,
            weights: &[0.0, 1.0],
        },
        Plane {
            samples: &alpha,
            weights: &[0.5, 0.5],
        },
    ];
    let models: [&dyn PsfModel; 2] = [&SkewNormal, &MirroredPair];
    for model in models {
        for edges in [Edges::Mirror, Edges::Black] {
            for displacement in [
                Displacement::None,
                Displacement::Lateral,
                Displacement::Full,
            ] {
                for vergence in [VergencePass::Constant(0.3), VergencePass::PerPixel(&depth)] {
                    for scale in [1.0, 0.4, 1.7] {
                        let mut scene = scene(&lens, width, height);
                        (scene.model, scene.vergence) = (model, vergence);
                        (scene.edges, scene.displacement) = (edges, displacement);
                        scene.map.scale = scale;
                        let case = format!(
                            "{} {edges:?} {displacement:?} {vergence:?} x {scale}",
                            model.id()
                        );
                        let want = brute_force(&scene, &planes);
                        // The truncated tail of kernels, and a millionth of the peak.
                        assert_close(&render(&scene, &planes), &want, 4e-6, &case);
                    }
                }
            }
        }
    }
}

#[test]
fn kernels_larger_than_the_plate_fold_repeatedly() {
    let lens = Lens {
        channel_count: 1,
        blur: |_, _, _| constant(400.0, 30.0, 4000.0),
    };
    let samples = plate(7, 3, 5);
    let planes = [Plane {
        samples: &samples,
        weights: &[1.0],
    }];
    let scene = scene(&lens, 7, 3);
    let got = render(&scene, &planes);
    assert_close(&got, &brute_force(&scene, &planes), 2e-6, "folded");
    assert!((total(&got[0]) / total(&samples) - 1.0).abs() < 1e-6);
}

#[test]
fn mirrored_edges_keep_all_light() {
    let lens = Lens {
        channel_count: 1,
        blur: |_, at: FieldPoint, _| DisplacedBlur {
            displacement_px: (40.0 * at.x.sin(), -9.0 * at.y),
            ..varying(0, FieldPoint::new(at.x / 200.0, at.y / 200.0), 0.0)
        },
    };
    for (width, height, displacement) in [
        (1000, 1000, Displacement::Full),
        (150, 90, Displacement::None),
    ] {
        let samples = plate(width, height, 6);
        let planes = [Plane {
            samples: &samples,
            weights: &[1.0],
        }];
        let mut scene = scene(&lens, width, height);
        scene.displacement = displacement;
        let kept = total(&render(&scene, &planes)[0]) / total(&samples);
        assert!((kept - 1.0).abs() < 1e-6, "{displacement:?}: {kept}");
        scene.edges = Edges::Black;
        let kept = total(&render(&scene, &planes)[0]) / total(&samples);
        assert!(kept < 0.999, "{displacement:?}: {kept}");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let lens = Lens {
        channel_count: 2,
        blur: varying,
    };
    let (width, height) = (23, 150);
    let samples = plate(width, height, 7);
    let planes = [
        Plane {
            samples: &samples,
            weights: &[0.0, 1.0],
        },
        Plane {
            samples: &samples,
            weights: &[0.5, 0.5],
        },
    ];
    let mut scene = scene(&lens, width, height);
    scene.map.scale = 4.0;
    scene.displacement = Displacement::Full;
    let with_threads = |count| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build();
        pool.expect("a pool").install(|| render(&scene, &planes))
    };
    let bits = |planes: Vec<Vec<f32>>| -> Vec<Vec<u32>> {
        let plane_bits = |plane: Vec<f32>| plane.into_iter().map(f32::to_bits).collect();
        planes.into_iter().map(plane_bits).collect()
    };
    let one = bits(with_threads(1));
    for count in [2, 3] {
        assert!(one == bits(with_threads(count)), "{count} threads differ");
    }
}

#[test]
fn a_point_becomes_its_kernel_without_mirroring() {
    let lens = Lens {
        channel_count: 1,
        blur: |_, _, _| constant(9.0, 4.0, 0.9 * 27.0),
    };
    let (width, height) = (61, 41);
    let mut samples = vec![0.0; width * height];
    samples[20 * width + 30] = 1e4;
    let planes = [Plane {
        samples: &samples,
        weights: &[1.0],
    }];
    let got = render(&scene(&lens, width, height), &planes);
    let mut third = 0.0;
    let mut first = 0.0;
    for (index, light) in got[0].iter().enumerate() {
        let (x, y) = ((index % width) as f64 - 30.0, (index / width) as f64 - 20.0);
        let blur = constant(9.0, 4.0, 0.9 * 27.0).blur;
        let mut want = [0.0];
        let window = SampleGrid {
            first_x_px: x,
            first_y_px: y,
            width: 1,
            height: 1,
        };
        SkewNormal.sample(&blur, &window, &mut want);
        assert!((f64::from(*light) - 1e4 * want[0]).abs() < 1e4 * 1e-6);
        first += f64::from(*light) * x;
        third += f64::from(*light) * x.powi(3);
    }
    assert!((total(&got[0]) / 1e4 - 1.0).abs() < 1e-6);
    // The centroid stays and the tail points along +x: the kernel is not mirrored.
    assert!(first.abs() / 1e4 < 1e-3);
    assert!((third / 1e4 - 0.9 * 27.0).abs() < 0.05);
}

/// A sharp source beside a blurred one stays sharp.
#[test]
fn every_source_has_its_own_kernel() {
    let lens = Lens {
        channel_count: 1,
        blur: |_, at: FieldPoint, _| {
            let variance = if at.x < 0.0 { 1e-3 } else { 4.0 };
            constant(variance, variance, 0.0)
        },
    };
    let (width, height) = (24, 16);
    let mut scene = scene(&lens, width, height);
    scene.map.origin = ImagePoint::new(0.0, 0.0);
    let mut samples = vec![0.0; width * height];
    let at = |x: usize, y: usize| y * width + x;
    samples[at(11, 8)] = 1.0;
    let sharp = render(
        &scene,
        &[Plane {
            samples: &samples,
            weights: &[1.0],
        }],
    );
    assert_eq!(sharp[0], samples);
    samples[at(11, 8)] = 0.0;
    samples[at(12, 8)] = 1.0;
    let soft = render(
        &scene,
        &[Plane {
            samples: &samples,
            weights: &[1.0],
        }],
    );
    assert!(soft[0][at(11, 8)] > 0.03 && soft[0][at(12, 8)] < 0.05);
}

#[test]
fn an_even_plate_stays_even() {
    let lens = Lens {
        channel_count: 3,
        blur: |_, _, _| constant(6.0, 2.0, 9.0),
    };
    let (width, height) = (80, 70);
    let samples = vec![0.5; width * height];
    let third = 1.0 / 3.0;
    let planes = [Plane {
        samples: &samples,
        weights: &[third, third, third],
    }];
    let mut scene = scene(&lens, width, height);
    for edges in [Edges::Black, Edges::Mirror] {
        scene.edges = edges;
        let got = render(&scene, &planes);
        for row in 20..50 {
            for column in 20..60 {
                let light = got[0][row * width + column];
                assert!((light - 0.5).abs() < 2e-7, "{light} at ({column}, {row})");
            }
        }
        let corner = got[0][0];
        assert!(match edges {
            Edges::Black => corner < 0.3,
            Edges::Mirror => (corner - 0.5).abs() < 0.1,
        });
    }
}

/// Sums of hundreds of thousands of terms must not lose digits.
#[test]
fn large_kernels_lose_no_light() {
    let lens = Lens {
        channel_count: 1,
        blur: |_, _, _| constant(900.0, 900.0, 0.0),
    };
    let (width, height) = (160, 120);
    let samples = vec![1.0; width * height];
    let planes = [Plane {
        samples: &samples,
        weights: &[1.0],
    }];
    let got = render(&scene(&lens, width, height), &planes);
    for light in &got[0] {
        assert!((light - 1.0).abs() < 1e-6, "{light}");
    }
}

#[test]
fn invalid_input_is_refused_by_name() {
    let lens = Lens {
        channel_count: 1,
        blur: varying,
    };
    let scene = scene(&lens, 4, 3);
    let good = vec![1.0; 12];
    let mut bad = good.clone();
    bad[6] = f32::NAN;
    let plane = |samples| Plane {
        samples,
        weights: &[1.0],
    };
    let refusal = |planes: &[Plane]| {
        let result = Scatter.render(&scene, planes, &|_| true);
        result.expect_err("refused").to_string()
    };
    let message = refusal(&[plane(&good), plane(&bad)]);
    assert!(
        message.starts_with("plane 1, pixel (2, 1): is NaN"),
        "{message}"
    );
    assert!(refusal(&[plane(&good[1..])]).contains("has 11 samples"));
    let unweighted = Plane {
        samples: &good,
        weights: &[],
    };
    assert!(refusal(&[unweighted]).contains("channel weights"));
    let mut depth = good.clone();
    depth[0] = f32::INFINITY;
    let deep = Scene {
        vergence: VergencePass::PerPixel(&depth),
        ..scene
    };
    let result = Scatter.render(&deep, &[plane(&good)], &|_| true);
    let message = result.expect_err("refused").to_string();
    assert!(message.contains("depth pass, pixel (0, 0)"), "{message}");
}

#[test]
fn a_blur_that_cannot_be_drawn_is_refused() {
    let far = DisplacedBlur {
        displacement_px: (0.0, f64::INFINITY),
        ..constant(1.0, 1.0, 0.0)
    };
    for bad in [
        constant(f64::NAN, 1.0, 0.0),
        constant(1e12, 1.0, 0.0),
        constant(1e12, -1e12, 0.0),
        constant(1.0, 1.0, f64::INFINITY),
        far,
    ] {
        let lens = Lens {
            channel_count: 1,
            blur: |_, _, _| bad.clone(),
        };
        let samples = vec![1.0; 12];
        let planes = [Plane {
            samples: &samples,
            weights: &[1.0],
        }];
        let result = Scatter.render(&scene(&lens, 4, 3), &planes, &|_| true);
        let message = result.expect_err("refused").to_string();
        assert!(
            message.contains("lens channel 0 at plate pixel"),
            "{message}"
        );
    }
}

/// Fitted moments need not be those of any real density; their kernels still keep all light.
#[test]
fn unphysical_moments_keep_all_light() {
    let models = || seidel_optics::psf::ALL.iter().filter(|m| !m.needs_rays());
    for (blur, model) in [
        constant(0.0, 0.0, 0.0),
        constant(-3.0, 2.0, 1.0),
        constant(-1.0, -1.0, 1e30),
        constant(1e-9, 200.0, -1e300),
    ]
    .into_iter()
    .flat_map(|blur| models().map(move |model| (blur.clone(), model)))
    {
        let lens = Lens {
            channel_count: 1,
            blur: |_, _, _| blur.clone(),
        };
        let samples = plate(6, 5, 8);
        let planes = [Plane {
            samples: &samples,
            weights: &[1.0],
        }];
        let mut scene = scene(&lens, 6, 5);
        scene.model = *model;
        let kept = total(&render(&scene, &planes)[0]) / total(&samples);
        assert!((kept - 1.0).abs() < 1e-6, "{} {blur:?}: {kept}", model.id());
    }
}

#[test]
fn black_pixels_are_skipped_and_renders_can_be_cancelled() {
    let asked = AtomicUsize::new(0);
    let lens = Lens {
        channel_count: 1,
        blur: |channel, at, vergence| {
            asked.fetch_add(1, Ordering::Relaxed);
            varying(channel, at, vergence)
        },
    };
    let (width, height) = (20, 64);
    let mut samples = vec![0.0; width * height];
    let scene = scene(&lens, width, height);
    let weights: &[f64] = &[1.0];
    let dark = [Plane {
        samples: &samples,
        weights,
    }];
    let last = std::sync::Mutex::new(0.0_f64);
    let done = Scatter.render(&scene, &dark, &|share| {
        let mut last = last.lock().expect("not poisoned");
        *last = last.max(share);
        true
    });
    assert!(
        done.expect("rendered").planes[0]
            .iter()
            .all(|&light| light == 0.0)
    );
    assert_eq!(asked.load(Ordering::Relaxed), 0);
    assert_eq!(*last.lock().expect("not poisoned"), 1.0);
    samples.fill(1.0);
    let lit = [Plane {
        samples: &samples,
        weights,
    }];
    assert_eq!(Scatter.render(&scene, &lit, &|_| false), Err(cancelled()));
    assert!(asked.load(Ordering::Relaxed) < width * height);
}
