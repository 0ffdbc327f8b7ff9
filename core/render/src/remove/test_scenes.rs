//! Lenses, sharp images and plates for tests of removal.

use super::{Deconvolver, SharpPlane};
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

/// A lens whose blur grows from the centre outwards, radially more than tangentially, with skewness. Its size is `strength`
/// times (1 + vergence in 1/m).
pub(super) struct GrowingBlur {
    pub(super) frame: Frame,
    pub(super) strength: f64,
}

impl BlurField for GrowingBlur {
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
        let tangential = strength * (0.8 + 0.6 * rho * rho);
        let moments = MeridionalMoments {
            mu20: radial * radial,
            mu02: tangential * tangential,
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

pub(super) fn lens(strength: f64) -> GrowingBlur {
    GrowingBlur {
        frame: Frame::new(WIDTH as u32, HEIGHT as u32, None).expect("a valid frame"),
        strength,
    }
}

pub(super) fn scene(lens: &GrowingBlur) -> Scene<'_> {
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

/// Normal deviates from a linear congruential generator, the same on any machine.
pub(super) struct NormalDeviates(pub(super) u64);

impl NormalDeviates {
    /// Returns a number uniform in (0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        ((self.0 >> 33) as f64 + 0.5) / (1_u64 << 31) as f64
    }

    pub(super) fn next(&mut self) -> f64 {
        let radius = (-2.0 * self.unit().ln()).sqrt();
        radius * (std::f64::consts::TAU * self.unit()).cos()
    }

    /// Returns a plane of `count` deviates.
    pub(super) fn plane(&mut self, count: usize) -> Vec<f32> {
        (0..count).map(|_| self.next() as f32).collect()
    }
}

/// Draws overlapping discs on a smooth background, from 0 to 1: edges between uniform areas.
pub(super) fn discs(width: usize, height: usize) -> Vec<f32> {
    let mut deviates = NormalDeviates(5);
    let discs: Vec<[f64; 4]> = (0..60)
        .map(|_| {
            let radius = 2.0 + 16.0 * deviates.unit().powi(3);
            let (x, y) = (deviates.unit(), deviates.unit());
            [
                width as f64 * x,
                height as f64 * y,
                radius,
                0.1 + 0.8 * deviates.unit(),
            ]
        })
        .collect();
    (0..width * height)
        .map(|k| {
            let (x, y) = ((k % width) as f64, (k / width) as f64);
            let background = 0.4 + 0.2 * (0.05 * x).sin() * (0.04 * y).cos();
            let inside = |disc: &&[f64; 4]| (x - disc[0]).hypot(y - disc[1]) < disc[2];
            discs
                .iter()
                .rev()
                .find(inside)
                .map_or(background, |disc| disc[3]) as f32
        })
        .collect()
}

/// Sums waves of all directions with wavelengths from 4 to 32 px, long ones strongest, from 0 to 1: texture without edges.
pub(super) fn texture(width: usize, height: usize) -> Vec<f32> {
    let mut deviates = NormalDeviates(7);
    let waves: Vec<[f64; 4]> = (0..120)
        .map(|_| {
            let length = 4.0 * 8.0_f64.powf(deviates.unit());
            let angle = std::f64::consts::PI * deviates.unit();
            let (x, y) = (angle.cos() / length, angle.sin() / length);
            [x, y, deviates.unit(), 0.002 * length]
        })
        .collect();
    let at = |k: usize| {
        let (x, y) = ((k % width) as f64, (k / width) as f64);
        let wave = |[frequency_x, frequency_y, phase, amplitude]: &[f64; 4]| {
            amplitude * (std::f64::consts::TAU * (frequency_x * x + frequency_y * y + phase)).sin()
        };
        (0.5 + waves.iter().map(wave).sum::<f64>()).clamp(0.0, 1.0) as f32
    };
    (0..width * height).map(at).collect()
}

/// Renders `image` with `renderer` and adds noise.
pub(super) fn blurred(
    scene: &Scene,
    renderer: &dyn Renderer,
    image: &[f32],
    noise: f64,
) -> Vec<f32> {
    let planes = [Plane {
        samples: image,
        weights: &WEIGHTS,
    }];
    let rendered = renderer.render(scene, &planes, &|_| true);
    let mut plane = rendered.expect("a valid scene").planes.swap_remove(0);
    let mut deviates = NormalDeviates(9);
    for sample in &mut plane {
        *sample += (noise * deviates.next()) as f32;
    }
    plane
}

/// Returns the plate of the discs, blurred by the exact renderer with mirrored edges, with noise.
pub(super) fn plate(noise: f64) -> Vec<f32> {
    let lens = lens(1.0);
    blurred(&scene(&lens), &Scatter, &discs(WIDTH, HEIGHT), noise)
}

/// Removes the blur of `samples`.
pub(super) fn remove(scene: &Scene, samples: &[f32], deconvolver: Deconvolver) -> SharpPlane {
    let planes = [Plane {
        samples,
        weights: &WEIGHTS,
    }];
    let removed = deconvolver.remove(scene, &planes, &|_| true);
    removed.expect("a valid scene").swap_remove(0)
}

/// Removes the blur of `samples` and crops the result to the plate.
pub(super) fn sharpen(scene: &Scene, samples: &[f32], deconvolver: Deconvolver) -> Vec<f32> {
    let plane = remove(scene, samples, deconvolver);
    plane.canvas.crop(&plane.sharp)
}

/// Returns the peak signal-to-noise ratio of `found` against the `truth`, for a peak of 1.
pub(super) fn psnr_db(found: &[f32], truth: &[f32]) -> f64 {
    let squares = found
        .iter()
        .zip(truth)
        .map(|(a, b)| f64::from(a - b).powi(2));
    -10.0 * (squares.sum::<f64>() / found.len() as f64).log10()
}
