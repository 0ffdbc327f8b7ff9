//! The fast renderer against the exact one, and its properties.

mod adjoint;
mod highlights;
mod kept_kernels;
mod properties;
mod random_lenses;
mod sparse;
mod strips;
mod windows;

use super::{Gather, Quality};
use crate::{
    BlurField, DisplacedBlur, Displacement, Edges, Plane, PlateMap, Renderer, Scatter, Scene,
    VergencePass,
};
use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
use seidel_optics::lens::{LocalPupil, ReducedNumbers, Wavefront};
use seidel_optics::moments::MeridionalMoments;
use seidel_optics::psf::{Gaussian, LocalBlur, PHI, PsfModel, Pupil, SkewNormal};

/// A lens whose blur grows with field radius and is radial, skewed and displaced.
pub(super) struct TestLens {
    pub(super) frame: Frame,
    pub(super) corner_sigma_px: f64,
    /// Ratio of the standard deviation in the centre to that in the corners.
    pub(super) centre: f64,
    pub(super) skew: f64,
    pub(super) rays: bool,
}

impl BlurField for TestLens {
    fn frame(&self) -> Frame {
        self.frame
    }

    fn channel_count(&self) -> usize {
        3
    }

    fn blur_at(&self, channel: usize, at: FieldPoint, _vergence_per_m: f64) -> DisplacedBlur {
        let strength = [0.9, 1.0, 1.15][channel] * self.corner_sigma_px;
        let rho = at.radius() / self.frame.corner_radius();
        let sigma = |edge: f64| strength * (self.centre + (edge - self.centre) * rho * rho);
        let meridian = at.meridian();
        let blur = if self.rays {
            let numbers = ReducedNumbers {
                alpha: 2.0 * sigma(1.0),
                beta: 0.1 * strength,
                gamma: 0.1 * strength * rho,
                delta: 0.2 * strength * rho,
                phi: 0.0,
            };
            let round = LocalPupil::circular(Wavefront::third_order(&numbers, at), 0.1);
            LocalBlur::from_pupil(round, meridian)
        } else {
            let (along, across) = (sigma(1.0), sigma(0.6));
            let moments = MeridionalMoments {
                mu20: along * along,
                mu02: across * across,
                mu30: PHI * (self.skew * rho * along).powi(3),
                mu12: 0.0,
            };
            LocalBlur::from_moments(moments.in_image(meridian), meridian)
        };
        let drift = (channel as f64 - 1.0) * 1.5 * rho;
        DisplacedBlur {
            blur,
            displacement_px: (drift * meridian.cos, drift * meridian.sin),
        }
    }
}

pub(super) const WIDTH: usize = 150;
pub(super) const HEIGHT: usize = 110;

pub(super) fn lens(corner_sigma_px: f64) -> TestLens {
    TestLens {
        // A crop from the middle of a larger frame, off its axis.
        frame: Frame::new(1200, 800, None).expect("a frame"),
        corner_sigma_px,
        centre: 0.25,
        skew: 0.9,
        rays: false,
    }
}

pub(super) fn scene<'a>(lens: &'a TestLens, model: &'a dyn PsfModel) -> Scene<'a> {
    Scene {
        lens,
        model,
        width: WIDTH,
        height: HEIGHT,
        map: PlateMap {
            origin: ImagePoint::new(830.0, 210.0),
            scale: 1.0,
        },
        vergence: VergencePass::Constant(0.0),
        edges: Edges::Mirror,
        displacement: Displacement::Lateral,
    }
}

pub(super) fn plate(seed: u32) -> Vec<f32> {
    plate_of(seed, WIDTH, HEIGHT)
}

/// Returns edges, waves and noise, from 0 to 1.
pub(super) fn plate_of(seed: u32, width: usize, height: usize) -> Vec<f32> {
    let mut state = seed.wrapping_mul(747_796_405).wrapping_add(1);
    (0..width * height)
        .map(|index| {
            let (x, y) = ((index % width) as f64, (index / width) as f64);
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = f64::from(state >> 8) / f64::from(1 << 24);
            let checks = f64::from(((x / 19.0 + y / 31.0) as u32 + 1) % 2);
            let wave = 0.5 + 0.5 * (0.13 * x + 0.07 * y).sin();
            (0.4 * checks + 0.4 * wave + 0.2 * noise) as f32
        })
        .collect()
}

pub(super) const WEIGHTS: [[f64; 3]; 2] = [[0.0, 0.0, 1.0], [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0]];

pub(super) fn render(renderer: &dyn Renderer, scene: &Scene, samples: &[f32]) -> Vec<Vec<f32>> {
    let planes = WEIGHTS.each_ref().map(|weights| Plane { samples, weights });
    renderer
        .render(scene, &planes, &|_| true)
        .expect("a sound scene")
        .planes
}

pub(super) fn psnr_db(ours: &[Vec<f32>], exact: &[Vec<f32>]) -> f64 {
    let pairs = || ours.iter().flatten().zip(exact.iter().flatten());
    let squares: f64 = pairs().map(|(a, b)| f64::from(a - b).powi(2)).sum();
    -10.0 * (squares / pairs().count() as f64).log10()
}

fn close(model: &dyn PsfModel, lens: &TestLens, quality: Quality, edges: Edges) -> f64 {
    let scene = Scene {
        edges,
        ..scene(lens, model)
    };
    let samples = plate(3);
    let exact = render(&Scatter, &scene, &samples);
    psnr_db(
        &render(
            &Gather {
                quality,
                kernels: None,
            },
            &scene,
            &samples,
        ),
        &exact,
    )
}

#[test]
fn moment_models_meet_the_stated_psnr() {
    for (sigma, bound) in [(1.6, 75.0), (5.0, 75.0), (16.0, 60.0)] {
        for edges in [Edges::Mirror, Edges::Black] {
            for model in [&Gaussian as &dyn PsfModel, &SkewNormal] {
                let found = close(model, &lens(sigma), Quality::Final, edges);
                assert!(found > bound, "{} {sigma} {edges:?}: {found}", model.id());
                let draft = close(model, &lens(sigma), Quality::Draft, edges);
                assert!(draft > 45.0, "{} {sigma} draft: {draft}", model.id());
            }
        }
    }
}

/// On a plate that its levels divide, light is folded back before it is upsampled.
#[test]
fn wide_blurs_are_folded_early_and_meet_the_stated_psnr() {
    let lens = lens(24.0);
    let scene = Scene {
        width: 152,
        height: 104,
        ..scene(&lens, &Gaussian)
    };
    let samples = plate(4)[..152 * 104].to_vec();
    let exact = render(&Scatter, &scene, &samples);
    let found = psnr_db(&render(&Gather::default(), &scene, &samples), &exact);
    assert!(found > 60.0, "{found}");
}

#[test]
fn ray_traced_kernels_meet_the_stated_psnr() {
    for sigma in [3.0, 9.0] {
        let lens = TestLens {
            rays: true,
            ..lens(sigma)
        };
        let found = close(&Pupil, &lens, Quality::Final, Edges::Mirror);
        // The exact renderer itself shares such kernels: 57 dB against one kernel per pixel.
        assert!(found > 50.0, "{sigma}: {found}");
    }
}

#[test]
fn light_is_kept_and_an_even_plate_stays_even() {
    let lens = lens(7.0);
    let scene = scene(&lens, &SkewNormal);
    let samples = plate(9);
    let total: f64 = samples.iter().map(|v| f64::from(*v)).sum();
    for plane in render(&Gather::default(), &scene, &samples) {
        let blurred: f64 = plane.iter().map(|v| f64::from(*v)).sum();
        assert!((blurred / total - 1.0).abs() < 3e-4, "{}", blurred / total);
    }
}

/// The same to the bit for any number of threads.
#[test]
fn the_result_does_not_depend_on_threads() {
    let lens = lens(9.0);
    let scene = scene(&lens, &SkewNormal);
    let samples = plate(5);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().expect("a pool");
        pool.install(|| render(&Gather::default(), &scene, &samples))
    };
    assert_eq!(with(1), with(5));
}

/// Dark tiles are skipped around a light too large to be a highlight, and no light is lost.
#[test]
fn a_single_light_is_rendered_completely() {
    let lens = lens(6.0);
    let scene = scene(&lens, &SkewNormal);
    for place in [0, 73 * WIDTH + 20, WIDTH * (HEIGHT - 4) - 5] {
        let mut samples = vec![0.0; WIDTH * HEIGHT];
        for row in 0..5 {
            samples[place + row * WIDTH..][..5].fill(1e4);
        }
        let found = render(&Gather::default(), &scene, &samples);
        let exact = render(&Scatter, &scene, &samples);
        for (found, exact) in found.iter().zip(&exact) {
            let peak = exact.iter().copied().fold(0.0, f32::max);
            let apart = found.iter().zip(exact).map(|(a, b)| (a - b).abs());
            let worst = apart.fold(0.0, f32::max);
            assert!(worst < 0.01 * peak, "{place}: {worst} of {peak}");
        }
    }
}

#[test]
fn a_cancelled_render_is_an_error() {
    let lens = lens(3.0);
    let samples = plate(1);
    let planes = [Plane {
        samples: &samples,
        weights: &WEIGHTS[0],
    }];
    let stopped = Gather::default().render(&scene(&lens, &SkewNormal), &planes, &|_| false);
    assert_eq!(stopped, Err(crate::cancelled()));
}
