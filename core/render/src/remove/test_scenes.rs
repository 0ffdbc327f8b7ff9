//! Lenses, pictures and plates for tests of removal.

use super::{Removal, Removed};
use crate::{
    BlurField, DisplacedBlur, Displacement, Edges, Plane, PlateMap, Renderer, Scatter, Scene,
    VergencePass,
};
use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
use seidel_optics::moments::MeridionalMoments;
use seidel_optics::psf::{LocalBlur, SkewNormal};

pub(super) const WIDTH: usize = 170;
pub(super) const HEIGHT: usize = 150;
pub(super) const WEIGHTS: [f64; 1] = [1.0];

/// Blur that grows from the centre out, longer along the meridian, skewed; `strength` times as large, and as much larger
/// again a unit of vergence.
pub(super) struct Growing {
    pub(super) frame: Frame,
    pub(super) strength: f64,
}

impl BlurField for Growing {
    fn frame(&self) -> Frame {
        self.frame
    }

    fn channel_count(&self) -> usize {
        1
    }

    fn blur_at(&self, _channel: usize, at: FieldPoint, vergence_per_m: f64) -> DisplacedBlur {
        let rho = at.radius() / self.frame.corner_radius();
        let strength = self.strength * (1.0 + vergence_per_m);
        let radial = strength * (0.8 + 1.4 * rho * rho);
        let across = strength * (0.8 + 0.6 * rho * rho);
        let moments = MeridionalMoments {
            mu20: radial * radial,
            mu02: across * across,
            mu30: 0.3 * rho * radial.powi(3),
            mu12: 0.0,
        };
        let meridian = at.meridian();
        DisplacedBlur {
            blur: LocalBlur::from_moments(moments.in_image(meridian), meridian),
            displacement_px: (0.0, 0.0),
        }
    }
}

pub(super) fn lens(strength: f64) -> Growing {
    Growing {
        frame: Frame::new(WIDTH as u32, HEIGHT as u32, None).expect("a frame"),
        strength,
    }
}

pub(super) fn scene(lens: &Growing) -> Scene<'_> {
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
pub(super) struct Deviates(pub(super) u64);

impl Deviates {
    pub(super) fn share(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        ((self.0 >> 33) as f64 + 0.5) / (1_u64 << 31) as f64
    }

    pub(super) fn next(&mut self) -> f64 {
        let length = (-2.0 * self.share().ln()).sqrt();
        length * (std::f64::consts::TAU * self.share()).cos()
    }
}

/// Discs over one another on a soft ground, from 0 to 1, as pictures have edges and even places.
pub(super) fn discs(width: usize, height: usize) -> Vec<f32> {
    let mut chance = Deviates(5);
    let discs: Vec<[f64; 4]> = (0..60)
        .map(|_| {
            let radius = 2.0 + 16.0 * chance.share().powi(3);
            let (x, y) = (chance.share(), chance.share());
            [
                width as f64 * x,
                height as f64 * y,
                radius,
                0.1 + 0.8 * chance.share(),
            ]
        })
        .collect();
    (0..width * height)
        .map(|k| {
            let (x, y) = ((k % width) as f64, (k / width) as f64);
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

/// Waves of all directions and lengths from 4 px up, long ones strongest, from 0 to 1: no edges.
pub(super) fn texture(width: usize, height: usize) -> Vec<f32> {
    let mut chance = Deviates(7);
    let waves: Vec<[f64; 4]> = (0..120)
        .map(|_| {
            let length = 4.0 * 8.0_f64.powf(chance.share());
            let turn = std::f64::consts::PI * chance.share();
            let (x, y) = (turn.cos() / length, turn.sin() / length);
            [x, y, chance.share(), 0.002 * length]
        })
        .collect();
    let at = |k: usize| {
        let (x, y) = ((k % width) as f64, (k / width) as f64);
        let wave = |[by_x, by_y, phase, height]: &[f64; 4]| {
            height * (std::f64::consts::TAU * (by_x * x + by_y * y + phase)).sin()
        };
        (0.5 + waves.iter().map(wave).sum::<f64>()).clamp(0.0, 1.0) as f32
    };
    (0..width * height).map(at).collect()
}

/// What `renderer` and noise make of a picture.
pub(super) fn seen(
    scene: &Scene,
    renderer: &dyn Renderer,
    picture: &[f32],
    noise: f64,
) -> Vec<f32> {
    let planes = [Plane {
        samples: picture,
        weights: &WEIGHTS,
    }];
    let rendered = renderer.render(scene, &planes, &|_| true);
    let mut plane = rendered.expect("a sound scene").planes.swap_remove(0);
    let mut deviates = Deviates(9);
    for sample in &mut plane {
        *sample += (noise * deviates.next()) as f32;
    }
    plane
}

/// The discs as the exact renderer and noise have them, mirrored beyond the edges.
pub(super) fn plate(noise: f64) -> Vec<f32> {
    let lens = lens(1.0);
    seen(&scene(&lens), &Scatter, &discs(WIDTH, HEIGHT), noise)
}

pub(super) fn removed(scene: &Scene, samples: &[f32], removal: Removal) -> Removed {
    let planes = [Plane {
        samples,
        weights: &WEIGHTS,
    }];
    let removed = removal.remove(scene, &planes, &|_| true);
    removed.expect("a sound scene").swap_remove(0)
}

/// The plate's part of what comes back.
pub(super) fn sharpened(scene: &Scene, samples: &[f32], removal: Removal) -> Vec<f32> {
    let removed = removed(scene, samples, removal);
    removed.canvas.cropped(&removed.sharp)
}

pub(super) fn psnr_db(found: &[f32], right: &[f32]) -> f64 {
    let squares = found
        .iter()
        .zip(right)
        .map(|(a, b)| f64::from(a - b).powi(2));
    -10.0 * (squares.sum::<f64>() / found.len() as f64).log10()
}
