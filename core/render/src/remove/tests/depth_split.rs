//! Tests of removal at the edge of a foreground whose background is known.

use super::super::test_scenes::{
    GrowingBlur, HEIGHT, NormalDeviates, WEIGHTS, WIDTH, blurred, discs, lens, remove, scene,
    sharpen, texture,
};
use super::super::{Deconvolver, DepthSplit};
use crate::{Plane, Scatter, Scene, VergencePass};

const NEAR: f64 = 1.5;
const NOISE: f64 = 0.002;
/// Radius of the foreground, a disc in the middle of the plate, px.
const RADIUS: f64 = 40.0;

fn distance_from_middle(k: usize) -> f64 {
    let (x, y) = ((k % WIDTH) as f64, (k / WIDTH) as f64);
    (x - WIDTH as f64 / 2.0).hypot(y - HEIGHT as f64 / 2.0)
}

fn is_foreground(k: usize) -> bool {
    distance_from_middle(k) < RADIUS
}

/// A disc of texture in front of a picture: sharp, as the lens shows it, and without the disc.
struct Shot {
    sharp: Vec<f32>,
    plate: Vec<f32>,
    clean: Vec<f32>,
}

fn at(lens: &GrowingBlur, vergence: f64) -> Scene<'_> {
    Scene {
        vergence: VergencePass::Constant(vergence),
        ..scene(lens)
    }
}

impl Shot {
    /// Renders both surfaces by themselves with the exact renderer, one over the other.
    fn new(lens: &GrowingBlur) -> Self {
        let (front, back) = (texture(WIDTH, HEIGHT), discs(WIDTH, HEIGHT));
        let masked = |value: &dyn Fn(usize) -> f32| -> Vec<f32> {
            let pixels = 0..WIDTH * HEIGHT;
            pixels
                .map(|k| if is_foreground(k) { value(k) } else { 0.0 })
                .collect()
        };
        let near = |samples: &[f32]| blurred(&at(lens, NEAR), &Scatter, samples, 0.0);
        let (light, cover) = (near(&masked(&|k| front[k])), near(&masked(&|_| 1.0)));
        let clean = blurred(&at(lens, 0.0), &Scatter, &back, 0.0);
        let mut deviates = NormalDeviates(3);
        let plate = (0..clean.len())
            .map(|k| light[k] + (1.0 - cover[k]) * clean[k] + (NOISE * deviates.next()) as f32);
        Self {
            plate: plate.collect(),
            clean: clean
                .iter()
                .map(|v| v + (NOISE * deviates.next()) as f32)
                .collect(),
            sharp: (0..back.len())
                .map(|k| if is_foreground(k) { front[k] } else { back[k] })
                .collect(),
        }
    }

    /// Returns the error of an image within 8 px of the edge.
    fn error(&self, found: &[f32]) -> f64 {
        let near = (0..found.len()).filter(|k| (distance_from_middle(*k) - RADIUS).abs() < 8.0);
        let (squares, count) = near.fold((0.0, 0.0), |(sum, count), k| {
            (
                sum + f64::from(found[k] - self.sharp[k]).powi(2),
                count + 1.0,
            )
        });
        f64::sqrt(squares / count)
    }
}

/// Returns the vergence of each pixel of the plate.
fn pass() -> Vec<f32> {
    (0..WIDTH * HEIGHT)
        .map(|k| if is_foreground(k) { NEAR as f32 } else { 0.0 })
        .collect()
}

#[test]
fn edges_of_a_foreground_become_sharp_where_the_background_is_known() {
    let lens = lens(1.0);
    let shot = Shot::new(&lens);
    let pass = pass();
    let deep = Scene {
        vergence: VergencePass::PerPixel(&pass),
        ..scene(&lens)
    };
    let plane = Plane {
        samples: &shot.plate,
        weights: &WEIGHTS,
    };
    let split = DepthSplit::new(&deep, VergencePass::Constant(0.0)).expect("a valid scene");
    let split = split.expect("a foreground");
    let parts = split.split(&Deconvolver::default(), &plane, &shot.clean);
    let parts = parts.expect("a valid plane");
    let sharp = |(deconvolver, samples): &(Deconvolver, Vec<f32>), scene| {
        remove(&scene, samples, *deconvolver)
    };
    let front = sharp(&parts.foreground, split.foreground_scene());
    let back = sharp(&parts.background, split.background_scene());
    let joined = split.join(&parts, &front, &back);
    let found = shot.error(&joined.canvas.crop(&joined.sharp));
    let without = shot.error(&sharpen(&deep, &shot.plate, Deconvolver::default()));
    let before = shot.error(&shot.plate);
    assert!(
        found < 0.3 * before && found < 0.6 * without,
        "{found} {without} {before}"
    );
    let square = |v: &f32| f64::from(*v).powi(2);
    let residual = joined.residual.iter().map(square).sum::<f64>() / joined.residual.len() as f64;
    assert!(
        residual.sqrt() < 1.3 * NOISE && joined.misfit < 1.2,
        "{}",
        residual.sqrt()
    );
}

/// Hidden surfaces are solved for together with those that the plate shows.
#[test]
fn edges_of_a_foreground_become_sharper_without_its_background() {
    let lens = lens(1.0);
    let shot = Shot::new(&lens);
    let pass = pass();
    let deep = Scene {
        vergence: VergencePass::PerPixel(&pass),
        ..scene(&lens)
    };
    let found = shot.error(&sharpen(&deep, &shot.plate, Deconvolver::default()));
    let before = shot.error(&shot.plate);
    assert!(found < 0.65 * before, "{found} {before}");
}

#[test]
fn a_plate_that_is_nowhere_nearer_than_its_background_is_not_split() {
    let lens = lens(1.0);
    let pass = vec![0.3; WIDTH * HEIGHT];
    let flat = Scene {
        vergence: VergencePass::PerPixel(&pass),
        ..scene(&lens)
    };
    let split = |scene: &Scene, vergence| {
        let split = DepthSplit::new(scene, VergencePass::Constant(vergence));
        split.expect("a valid scene").is_some()
    };
    assert!(!split(&flat, 0.3));
    assert!(!split(&at(&lens, NEAR), 0.0));
    assert!(split(&flat, -0.5));
    let short = DepthSplit::new(&flat, VergencePass::PerPixel(&pass[1..]));
    assert!(short.is_err());
}
