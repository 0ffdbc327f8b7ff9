//! The exact light at a few pixels against whole exact renders.

use super::unfolded;
use crate::scatter::accumulators::fold;
use crate::*;
use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
use seidel_optics::lens::{LocalPupil, ReducedNumbers, Wavefront};
use seidel_optics::moments::MeridionalMoments;
use seidel_optics::psf::LocalBlur;
use seidel_optics::psf::{Gaussian, Pupil, SkewNormal};

const WIDTH: usize = 41;
const HEIGHT: usize = 29;

/// Uniform numbers from 0 to 1.
struct Dice(u32);

impl Dice {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(self.0 >> 8) / f64::from(1 << 24)
    }
}

/// Two channels of a lens that differs from seed to seed: standard deviations in px from below half a
/// pixel to about nine.
struct RandomLens {
    centre: f64,
    growth: f64,
    skew: f64,
    outwards: f64,
}

impl RandomLens {
    fn new(seed: u32) -> Self {
        let mut dice = Dice(seed);
        dice.next();
        Self {
            centre: 0.3 + 2.0 * dice.next(),
            growth: 5.0 * dice.next(),
            skew: 1.6 * dice.next() - 0.8,
            outwards: 3.0 * dice.next() - 1.5,
        }
    }
}

impl BlurField for RandomLens {
    fn frame(&self) -> Frame {
        Frame::new(WIDTH as u32, HEIGHT as u32, None).expect("a valid frame")
    }

    fn channel_count(&self) -> usize {
        2
    }

    fn blur_at(&self, channel: usize, at: FieldPoint, vergence: f64) -> DisplacedBlur {
        let (meridian, h) = (at.meridian(), at.radius());
        let strength = 1.0 + 0.2 * channel as f64;
        let size = strength * (self.centre + self.growth * h * h + vergence.abs());
        let moments = MeridionalMoments {
            mu20: size * size * (1.0 + 0.4 * h),
            mu02: size * size,
            mu30: self.skew * h * size.powi(3),
            mu12: 0.0,
        };
        let out = strength * self.outwards * h * h;
        DisplacedBlur {
            blur: LocalBlur::from_moments(moments.in_image(meridian), meridian),
            displacement_px: (out * meridian.cos, out * meridian.sin),
        }
    }
}

/// One channel of rays, from small to some 8 px in radius.
struct Rays;

impl BlurField for Rays {
    fn frame(&self) -> Frame {
        Frame::new(WIDTH as u32, HEIGHT as u32, None).expect("a valid frame")
    }

    fn channel_count(&self) -> usize {
        1
    }

    fn blur_at(&self, _: usize, at: FieldPoint, _: f64) -> DisplacedBlur {
        let numbers = ReducedNumbers {
            alpha: 3.0,
            beta: 0.5,
            gamma: 1.5,
            delta: 3.0,
            phi: -0.6,
        };
        let pupil = LocalPupil::circular(Wavefront::third_order(&numbers, at), 0.1);
        DisplacedBlur {
            blur: LocalBlur::from_pupil(pupil, at.meridian()),
            displacement_px: (0.3 * at.x, 0.3 * at.y),
        }
    }
}

fn scene<'a>(lens: &'a dyn BlurField, model: &'a dyn seidel_optics::psf::PsfModel) -> Scene<'a> {
    Scene {
        lens,
        model,
        width: WIDTH,
        height: HEIGHT,
        map: PlateMap {
            origin: ImagePoint::new(0.0, 0.0),
            scale: 1.0,
        },
        vergence: VergencePass::Constant(0.2),
        edges: Edges::Black,
        displacement: Displacement::None,
    }
}

fn plate(seed: u32) -> Vec<f32> {
    let mut dice = Dice(seed);
    let mut sample = || 0.02 + dice.next().powi(4) as f32;
    (0..WIDTH * HEIGHT).map(|_| sample()).collect()
}

/// Corners and other pixels, one of them twice, unsorted.
fn pixels() -> Vec<(usize, usize)> {
    let mut pixels: Vec<_> = (0..40).map(|k| (k * 17 % WIDTH, k * 23 % HEIGHT)).collect();
    pixels.extend([(0, 0), (WIDTH - 1, HEIGHT - 1), (WIDTH - 1, 0), (17, 23)]);
    pixels
}

/// Largest relative difference from the exact renderer.
fn worst(scene: &Scene, plane: &Plane) -> f64 {
    let got = exact_at_pixels(scene, plane, &pixels(), 1).expect("a valid scene");
    let exact = Scatter.render(scene, &[*plane], &|_| true);
    let exact = &exact.expect("a valid scene").planes[0];
    let differences = got.iter().zip(pixels()).map(|(got, (column, row))| {
        let want = f64::from(exact[row * WIDTH + column]);
        (got / want - 1.0).abs()
    });
    differences.fold(0.0, f64::max)
}

#[test]
fn moment_models_agree_with_the_exact_renderer() {
    let models: [&dyn seidel_optics::psf::PsfModel; 2] = [&Gaussian, &SkewNormal];
    for seed in 0..6 {
        let lens = RandomLens::new(seed);
        let samples = plate(seed + 100);
        let depth: Vec<f32> = plate(seed + 200).iter().map(|v| 2.0 * v).collect();
        for model in models {
            for edges in [Edges::Black, Edges::Mirror] {
                let mut scene = scene(&lens, model);
                scene.edges = edges;
                for (displacement, weights) in [
                    (Displacement::None, [0.0, 1.0]),
                    (Displacement::Lateral, [1.0, 0.0]),
                    (Displacement::Full, [0.6, 0.4]),
                ] {
                    scene.displacement = displacement;
                    if displacement == Displacement::Full {
                        scene.vergence = VergencePass::PerPixel(&depth);
                    }
                    let plane = Plane {
                        samples: &samples,
                        weights: &weights,
                    };
                    let off = worst(&scene, &plane);
                    let case = format!("{} {edges:?} {displacement:?}", model.id());
                    assert!(off < 1e-5, "{case}, seed {seed}: {off:e}");
                }
            }
        }
    }
}

#[test]
fn ray_traced_kernels_agree_exactly_and_cells_nearly() {
    let samples = plate(7);
    let plane = Plane {
        samples: &samples,
        weights: &[1.0],
    };
    for (edges, displacement) in [
        (Edges::Black, Displacement::None),
        (Edges::Mirror, Displacement::Lateral),
        (Edges::Mirror, Displacement::Full),
    ] {
        let mut scene = scene(&Rays, &Pupil);
        (scene.edges, scene.displacement) = (edges, displacement);
        let off = worst(&scene, &plane);
        assert!(off < 1e-5, "{edges:?} {displacement:?}: {off:e}");
        let exact = exact_at_pixels(&scene, &plane, &pixels(), 1).expect("valid");
        let db = |side: usize| {
            let got = exact_at_pixels(&scene, &plane, &pixels(), side).expect("valid");
            let squares = got.iter().zip(&exact).map(|(a, b)| (a - b).powi(2));
            -10.0 * (squares.sum::<f64>() / exact.len() as f64).log10()
        };
        let (two, eight) = (db(2), db(8));
        assert!(two > 50.0 && two > eight + 10.0, "{two} dB and {eight} dB");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let (lens, samples) = (RandomLens::new(3), plate(3));
    let scene = scene(&lens, &SkewNormal);
    let plane = Plane {
        samples: &samples,
        weights: &[0.5, 0.5],
    };
    let with_threads = |count| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build();
        let at = || exact_at_pixels(&scene, &plane, &pixels(), 1).expect("valid");
        let light = pool.expect("a pool").install(at);
        light.into_iter().map(f64::to_bits).collect::<Vec<_>>()
    };
    assert_eq!(with_threads(1), with_threads(3));
}

#[test]
fn invalid_requests_are_refused() {
    let samples = plate(1);
    let (plane, depth) = (
        Plane {
            samples: &samples,
            weights: &[1.0],
        },
        vec![0.1; WIDTH * HEIGHT],
    );
    let mut scene = scene(&Rays, &Pupil);
    assert!(exact_at_pixels(&scene, &plane, &[(WIDTH, 0)], 1).is_err());
    assert!(exact_at_pixels(&scene, &plane, &[(0, HEIGHT)], 1).is_err());
    assert!(exact_at_pixels(&scene, &plane, &[(0, 0)], 0).is_err());
    scene.vergence = VergencePass::PerPixel(&depth);
    assert!(exact_at_pixels(&scene, &plane, &[(0, 0)], 4).is_err());
    assert!(exact_at_pixels(&scene, &plane, &[(0, 0)], 1).is_ok());
    let bare = Plane {
        samples: &samples[1..],
        ..plane
    };
    assert!(exact_at_pixels(&scene, &bare, &[(0, 0)], 1).is_err());
}

#[test]
fn unfolding_inverts_folding() {
    for (size, edges) in [(1, Edges::Mirror), (3, Edges::Mirror), (3, Edges::Black)] {
        for index in 0..size {
            let mut got: Vec<_> = unfolded(index, size, edges, &(-9..=11)).collect();
            got.sort_unstable();
            let lands = |place: &i32| fold(*place, size, edges) == Some(index);
            assert_eq!(got, (-9..=11).filter(lands).collect::<Vec<_>>());
        }
    }
}
