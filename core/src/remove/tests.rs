//! Removal against pictures that are known, and the parts that it is made of.

use super::local::Local;
use super::prior::{Slopes, response};
use super::{Removal, noise};
use crate::field::{FieldPoint, Frame, ImagePoint};
use crate::moments::MeridionalMoments;
use crate::psf::{LocalBlur, SkewNormal};
use crate::render::{
    BlurField, Displacement, Edges, PlacedBlur, Plane, PlateMap, Renderer, Scatter, Scene,
    VergencePass,
};

const WIDTH: usize = 170;
const HEIGHT: usize = 150;
const WEIGHTS: [f64; 1] = [1.0];

/// Blur that grows from the centre out, longer along the meridian, skewed.
struct Growing(Frame);

impl BlurField for Growing {
    fn frame(&self) -> Frame {
        self.0
    }

    fn channel_count(&self) -> usize {
        1
    }

    fn blur_at(&self, _channel: usize, at: FieldPoint, _vergence_per_m: f64) -> PlacedBlur {
        let rho = at.radius() / self.0.corner_radius();
        let (radial, across) = (0.8 + 2.2 * rho * rho, 0.8 + 0.8 * rho * rho);
        let moments = MeridionalMoments {
            mu20: radial * radial,
            mu02: across * across,
            mu30: 0.3 * rho * radial.powi(3),
            mu12: 0.0,
        };
        let meridian = at.meridian();
        PlacedBlur {
            blur: LocalBlur::of_moments(moments.in_image(meridian), meridian),
            displacement_px: (0.0, 0.0),
        }
    }
}

fn lens() -> Growing {
    Growing(Frame::new(WIDTH as u32, HEIGHT as u32, None).expect("a frame"))
}

fn scene(lens: &Growing) -> Scene<'_> {
    Scene {
        lens,
        model: &SkewNormal,
        width: WIDTH,
        height: HEIGHT,
        map: PlateMap {
            origin: ImagePoint::new(0.0, 0.0),
            scale: 1.0,
        },
        vergence: VergencePass::Constant(0.0),
        edges: Edges::Mirror,
        displacement: Displacement::None,
    }
}

/// Normal deviates, the same on any machine.
struct Deviates(u64);

impl Deviates {
    fn share(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        ((self.0 >> 33) as f64 + 0.5) / (1_u64 << 31) as f64
    }

    fn next(&mut self) -> f64 {
        let length = (-2.0 * self.share().ln()).sqrt();
        length * (std::f64::consts::TAU * self.share()).cos()
    }
}

/// Discs over one another on a soft ground, from 0 to 1, as pictures have edges and even places.
fn sharp() -> Vec<f32> {
    let mut chance = Deviates(5);
    let discs: Vec<[f64; 4]> = (0..60)
        .map(|_| {
            let radius = 2.0 + 16.0 * chance.share().powi(3);
            [
                WIDTH as f64 * chance.share(),
                HEIGHT as f64 * chance.share(),
                radius,
                0.1 + 0.8 * chance.share(),
            ]
        })
        .collect();
    (0..WIDTH * HEIGHT)
        .map(|k| {
            let (x, y) = ((k % WIDTH) as f64, (k / WIDTH) as f64);
            let ground = 0.4 + 0.2 * (0.05 * x).sin() * (0.04 * y).cos();
            let inside = |disc: &&[f64; 4]| (x - disc[0]).hypot(y - disc[1]) < disc[2];
            discs
                .iter()
                .rev()
                .find(inside)
                .map_or(ground, |disc| disc[3]) as f32
        })
        .collect()
}

/// What the lens and `noise` make of a picture, by the exact renderer.
fn blurred(picture: &[f32], noise: f64) -> Vec<f32> {
    let lens = lens();
    let planes = [Plane {
        samples: picture,
        weights: &WEIGHTS,
    }];
    let mut plane = Scatter
        .render(&scene(&lens), &planes, &|_| true)
        .expect("a sound scene")
        .swap_remove(0);
    let mut deviates = Deviates(9);
    for sample in &mut plane {
        *sample += (noise * deviates.next()) as f32;
    }
    plane
}

fn removed(samples: &[f32], removal: Removal) -> Vec<f32> {
    let lens = lens();
    let planes = [Plane {
        samples,
        weights: &WEIGHTS,
    }];
    let removed = removal.remove(&scene(&lens), &planes, &|_| true);
    removed.expect("a sound scene").swap_remove(0).plane
}

fn psnr_db(found: &[f32], right: &[f32]) -> f64 {
    let squares = found
        .iter()
        .zip(right)
        .map(|(a, b)| f64::from(a - b).powi(2));
    -10.0 * (squares.sum::<f64>() / found.len() as f64).log10()
}

/// Above the best that Wiener filters by local spectra reach, their one number chosen by the truth.
#[test]
fn more_comes_back_than_by_wiener_filters() {
    let sharp = sharp();
    let lens = lens();
    let local = Local::new(&scene(&lens), &WEIGHTS, 0.0).expect("a lens");
    for (noise, least_gain) in [(0.001, 5.0), (0.01, 3.5)] {
        let plate = blurred(&sharp, noise);
        let before = psnr_db(&plate, &sharp);
        let wiener = |by_slope: bool| {
            let tried = (-60..0).map(|k| {
                let prior = 10.0_f32.powf(k as f32 / 10.0);
                let filter = |h: rustfft::num_complex::Complex<f32>, slope: f32| {
                    let damping = if by_slope { prior * slope } else { prior };
                    h.conj() / (h.norm_sqr() + damping + 1e-9)
                };
                psnr_db(&local.filtered(&plate, false, filter), &sharp)
            });
            tried.fold(f64::NEG_INFINITY, f64::max)
        };
        let best = wiener(false).max(wiener(true));
        let found = psnr_db(&removed(&plate, Removal::default()), &sharp);
        for q in [crate::render::Quality::Draft, crate::render::Quality::Final] {
            for rounds in [0, 2, 4, 8, 16] {
                eprintln!(
                    "{noise} {q:?} {rounds} {}",
                    psnr_db(
                        &removed(
                            &plate,
                            Removal {
                                quality: q,
                                rounds,
                                ..Default::default()
                            }
                        ),
                        &sharp
                    ) - before
                );
            }
        }
        assert!(
            found > before + least_gain && found > best + 0.5,
            "noise {noise}: {before} before, {best} by Wiener, {found} found"
        );
    }
}

#[test]
fn noise_is_told_from_the_plate() {
    let sharp = sharp();
    for noise in [0.01, 0.03] {
        let told = noise::deviation(&blurred(&sharp, noise), WIDTH);
        assert!((told / noise - 1.0).abs() < 0.1, "{noise}: {told}");
    }
    assert_eq!(noise::deviation(&[], 0), 0.0);
    assert_eq!(noise::deviation(&[1.0, 2.0, 3.0], 3), 0.0);
}

/// What has no detail is given back as it is.
#[test]
fn even_planes_stay_as_they_are() {
    let removal = Removal {
        noise: Some(0.001),
        ..Removal::default()
    };
    for level in [0.0_f32, 0.7, 40.0] {
        let found = removed(&vec![level; WIDTH * HEIGHT], removal);
        let worst = found.iter().map(|v| (v - level).abs()).fold(0.0, f32::max);
        assert!(worst <= 3e-3 * level, "{level}: {worst}");
    }
}

/// The same whatever unit light is in.
#[test]
fn light_has_no_unit() {
    let plate = blurred(&sharp(), 0.004);
    let bright: Vec<f32> = plate.iter().map(|v| 64.0 * v).collect();
    let (one, other) = (
        removed(&plate, Removal::default()),
        removed(&bright, Removal::default()),
    );
    let apart = one.iter().zip(&other).map(|(a, b)| (a - b / 64.0).abs());
    let worst = apart.fold(0.0, f32::max);
    assert!(worst < 1e-3, "{worst}");
}

#[test]
fn threads_change_nothing() {
    let plate = blurred(&sharp(), 0.01);
    let removal = Removal {
        rounds: 2,
        ..Removal::default()
    };
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().expect("a pool");
        pool.install(|| removed(&plate, removal))
    };
    assert!(with(1) == with(3));
}

#[test]
fn what_cannot_be_is_refused() {
    let lens = lens();
    let plate = vec![0.5; WIDTH * HEIGHT];
    let planes = [Plane {
        samples: &plate,
        weights: &WEIGHTS,
    }];
    let default = Removal::default();
    let refused = |scene: &Scene, removal: Removal, go_on: bool| {
        let error = removal.remove(scene, &planes, &|_| go_on);
        error.expect_err("refused").to_string()
    };
    let sound = scene(&lens);
    let noise = Some(f64::NAN);
    assert!(refused(&sound, Removal { noise, ..default }, true).contains("noise"));
    let pass = vec![0.1; WIDTH * HEIGHT];
    let varying = Scene {
        vergence: VergencePass::PerPixel(&pass),
        ..sound
    };
    assert!(refused(&varying, default, true).contains("vergence"));
    let stopped = crate::render::stopped().to_string();
    assert_eq!(refused(&scene(&lens), default, false), stopped);
}

#[test]
fn squares_put_together_are_the_plane() {
    let lens = lens();
    let local = Local::new(&scene(&lens), &WEIGHTS, 0.0).expect("a lens");
    let plane = sharp();
    let same = local.filtered(&plane, false, |_, _| 1.0.into());
    let apart = plane.iter().zip(&same).map(|(a, b)| (a - b).abs());
    assert!(apart.fold(0.0, f32::max) < 1e-5);
}

#[test]
fn slopes_are_gathered_by_their_adjoint() {
    let mut chance = Deviates(3);
    let mut plane = || -> Vec<f32> { (0..WIDTH * HEIGHT).map(|_| chance.next() as f32).collect() };
    let (x, y) = (plane(), plane());
    let (of_x, of_y) = (Slopes::of(&x, WIDTH), Slopes::of(&y, WIDTH));
    let pairs = x.iter().zip(of_y.gathered(WIDTH));
    let back: f64 = pairs.map(|(a, b)| f64::from(*a) * f64::from(b)).sum();
    let scale = (of_x.dot(&of_x) * of_y.dot(&of_y)).sqrt();
    assert!((of_x.dot(&of_y) - back).abs() < 1e-6 * scale);
}

/// D^T D of a wave is the wave, as much stronger as told.
#[test]
fn waves_have_the_slopes_told() {
    let (u, v) = (0.11, 0.23);
    let turn = |k: usize| std::f64::consts::TAU * (u * (k % WIDTH) as f64 + v * (k / WIDTH) as f64);
    let wave: Vec<f32> = (0..WIDTH * HEIGHT).map(|k| turn(k).cos() as f32).collect();
    let found = Slopes::of(&wave, WIDTH).gathered(WIDTH);
    let at = 70 * WIDTH + 80;
    for k in at..at + 9 {
        let wanted = response(u, v) * f64::from(wave[k]);
        assert!((f64::from(found[k]) - wanted).abs() < 1e-4, "{k}");
    }
}
#[test]
fn dbg_adjoint() {
    use crate::render::{Operator, Quality};
    let a_lens = lens();
    for q in [Quality::Draft, Quality::Final] {
        let op = Operator::new(&scene(&a_lens), &[vec![1.0]], q).unwrap();
        let mut chance = Deviates(3);
        let mut plane =
            || -> Vec<f32> { (0..WIDTH * HEIGHT).map(|_| chance.next() as f32).collect() };
        let (x, y) = (plane(), plane());
        let ax = op.apply(&[x.clone()]).unwrap().swap_remove(0);
        let aty = op.adjoint(&[y.clone()]).unwrap().swap_remove(0);
        let dot = |a: &[f32], b: &[f32]| {
            a.iter()
                .zip(b)
                .map(|(a, b)| f64::from(*a) * f64::from(*b))
                .sum::<f64>()
        };
        let exact = Scatter
            .render(
                &scene(&a_lens),
                &[Plane {
                    samples: &x,
                    weights: &WEIGHTS,
                }],
                &|_| true,
            )
            .unwrap()
            .swap_remove(0);
        eprintln!(
            "ADJ {q:?} {} {} psnr {}",
            dot(&ax, &y),
            dot(&x, &aty),
            psnr_db(&ax, &exact)
        );
    }
}
