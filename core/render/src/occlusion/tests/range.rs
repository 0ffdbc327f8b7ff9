//! Light and alpha stay within their range, in random scenes of cards, lamps, wires, leaves and soft mattes.

use super::*;
use crate::{Gather, Quality};
use seidel_optics::numeric::SplitMix64;

/// Brightness of lamps.
const LAMP: f32 = 1e5;

/// Returns a random number from `least` to `most`.
fn between(random: &mut SplitMix64, least: f32, most: f32) -> f32 {
    least + (most - least) * random.unit() as f32
}

/// A premultiplied plate with vergences.
struct Plate {
    red: Vec<f32>,
    green: Vec<f32>,
    blue: Vec<f32>,
    alpha: Vec<f32>,
    vergence: Vec<f32>,
}

impl Plate {
    fn new(background: [f32; 2]) -> Self {
        let [alpha, vergence] = background;
        let of = |value: f32| vec![value; WIDTH * HEIGHT];
        Self {
            red: of(0.2 * alpha),
            green: of(0.3 * alpha),
            blue: of(0.1 * alpha),
            alpha: of(alpha),
            vergence: of(vergence),
        }
    }

    /// Composites a surface of `colour` at `vergence` over the plate, with the coverage that `cover` returns for a point.
    fn add(&mut self, colour: [f32; 3], vergence: f32, cover: impl Fn(f32, f32) -> f32) {
        for index in 0..WIDTH * HEIGHT {
            let at = |k: usize| k as f32 + 0.5;
            let a = cover(at(index % WIDTH), at(index / WIDTH)).clamp(0.0, 1.0);
            let planes = [&mut self.red, &mut self.green, &mut self.blue];
            for (plane, colour) in planes.into_iter().zip(colour) {
                plane[index] = (1.0 - a) * plane[index] + a * colour;
            }
            self.alpha[index] = (1.0 - a) * self.alpha[index] + a;
            if a > 0.5 {
                self.vergence[index] = vergence;
            }
        }
    }

    /// Draws a random scene.
    fn random(seed: u64) -> Self {
        let random = &mut SplitMix64::new(seed);
        // Every third scene is an element over nothing.
        let background = if seed.is_multiple_of(3) { 0.0 } else { 1.0 };
        let mut plate = Self::new([background, between(random, 0.05, 0.4)]);
        let (width, height) = (WIDTH as f32, HEIGHT as f32);
        for _ in 0..6 {
            let colour = std::array::from_fn(|_| between(random, 0.0, 1.0));
            let vergence = between(random, 0.2, 1.0);
            let (x, y) = (between(random, 0.0, width), between(random, 0.0, height));
            let size = between(random, 2.0, 14.0);
            match between(random, 0.0, 4.0) as usize {
                // A card with an anti-aliased edge, a soft matte, a wire, a leaf.
                0 => plate.add(colour, vergence, |u, v| {
                    size - (u - x).abs().max((v - y).abs()) + 0.5
                }),
                1 => plate.add(colour, vergence, |u, v| {
                    1.0 - ((u - x).hypot(v - y) / size).powi(2)
                }),
                2 => plate.add(colour, vergence, |u, v| 1.0 - (u - x + 0.3 * (v - y)).abs()),
                _ => plate.add(colour, vergence, |u, v| {
                    size / 2.0 - (u - x).hypot(v - y) + 0.5
                }),
            }
        }
        for _ in 0..8 {
            let vergence = between(random, 0.1, 1.0);
            let (x, y) = (between(random, 0.0, width), between(random, 0.0, height));
            let radius = between(random, 0.5, 1.5);
            plate.add([LAMP, 0.5 * LAMP, 0.1 * LAMP], vergence, |u, v| {
                radius - (u - x).hypot(v - y) + 0.5
            });
        }
        plate
    }

    /// Draws a few small opaque specks close together over nothing, each at its own depth.
    fn specks(seed: u64) -> Self {
        let random = &mut SplitMix64::new(seed);
        let mut plate = Self::new([0.0, 0.1]);
        let (x, y) = (between(random, 10.0, 20.0), between(random, 10.0, 20.0));
        for _ in 0..4 {
            let colour = std::array::from_fn(|_| between(random, 0.0, 1.0));
            let vergence = between(random, 0.2, 1.0);
            let at = [x, y].map(|at| at + between(random, -4.0, 4.0));
            let size = between(random, 0.5, 2.0);
            plate.add(colour, vergence, |u, v| {
                size - (u - at[0]).hypot(v - at[1]) + 0.5
            });
        }
        plate
    }
}

/// Returns the least light, the largest over the brightest of the plate, the least alpha and the largest alpha of `plate` through
/// `inner`.
fn ranges(plate: &Plate, inner: &dyn Renderer) -> [f32; 4] {
    let scene = scene(&EVEN, VergencePass::PerPixel(&plate.vergence));
    let planes = [
        plane(&plate.red, RED),
        plane(&plate.green, GREEN),
        plane(&plate.blue, BLUE),
        plane(&plate.alpha, ALPHA),
    ];
    let layered = LayeredRenderer {
        inner,
        settings: Occlusion {
            light_planes: Some(3),
            ..Occlusion::default()
        },
    };
    let done = layered.render(&scene, &planes, &|_| true);
    let done = done.expect("a valid scene").planes;
    let least = |planes: &[Vec<f32>]| planes.iter().flatten().copied().fold(f32::MAX, f32::min);
    let most = |plane: &[f32]| plane.iter().copied().fold(f32::MIN, f32::max);
    let over = |(out, plane): (&Vec<f32>, &Plane)| most(out) / most(plane.samples);
    let over = done[..3].iter().zip(&planes).map(over);
    [
        least(&done[..3]),
        over.fold(0.0, f32::max),
        least(&done[3..]),
        most(&done[3]),
    ]
}

#[test]
fn light_and_alpha_stay_within_their_range() {
    let gather = |quality| Gather {
        quality,
        kernels: None,
    };
    let renderers: [&dyn Renderer; 3] =
        [&Scatter, &gather(Quality::Final), &gather(Quality::Draft)];
    let scenes = (0..48).flat_map(|seed| {
        let plates = [Plate::random(seed), Plate::specks(seed)];
        plates.map(|plate| (seed, plate))
    });
    for (seed, plate) in scenes {
        for renderer in renderers {
            let [light, brightest, alpha, most] = ranges(&plate, renderer);
            let scene = format!("scene {seed}, {}", renderer.id());
            assert!(light >= 0.0, "{scene}: least light {light:e}");
            assert!(
                brightest <= 1.0,
                "{scene}: largest light {brightest} of the plate's"
            );
            assert!(alpha >= 0.0, "{scene}: least alpha {alpha:e}");
            assert!(
                most <= 1.0 + 1e-6,
                "{scene}: largest alpha 1 + {:e}",
                most - 1.0
            );
        }
    }
}

#[test]
fn only_the_overshoot_of_the_renderer_is_removed() {
    let samples = [0.0, 100.0];
    let mut out = [-5e-4, -0.1, 50.0, 100.0004, 101.0];
    remove_overshoot(&mut out, &samples, 3e-5);
    assert_eq!(out, [0.0, -0.1, 50.0, 100.0, 101.0]);
}
