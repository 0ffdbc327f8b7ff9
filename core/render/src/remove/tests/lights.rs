//! Lights as sources of their own.

use super::super::Lights;
use super::super::test_scenes::{
    GrowingBlur, HEIGHT, NormalDeviates, WEIGHTS, WIDTH, blurred, lens, psnr_db, remove, scene,
    sharpen,
};
use super::super::{Deconvolver, KeptBlurReason, Saturation, find_lights, match_blur};
use crate::{BlurField, DisplacedBlur, Displacement, Plane, Renderer, Scatter, Scene};
use seidel_optics::field::{FieldPoint, Frame};

const GROUND: f32 = 0.18;
const RADIUS: f64 = 3.0;
/// Centres of lamps, px, and their light.
const LAMPS: [(f64, f64, f32); 3] = [(40.0, 40.0, 3.0), (125.0, 45.0, 10.0), (85.0, 110.0, 1e3)];

fn far(k: usize, lamp: (f64, f64, f32)) -> f64 {
    ((k % WIDTH) as f64 - lamp.0).hypot((k / WIDTH) as f64 - lamp.1)
}

fn lamps() -> Vec<f32> {
    let light = |k: usize| LAMPS.iter().find(|lamp| far(k, **lamp) < RADIUS);
    (0..WIDTH * HEIGHT)
        .map(|k| light(k).map_or(GROUND, |lamp| lamp.2))
        .collect()
}

/// Returns the light of a lamp above the ground, within `radius` of its centre.
fn light_within(plane: &[f32], lamp: (f64, f64, f32), radius: f64) -> f64 {
    let inside = (0..plane.len()).filter(|k| far(*k, lamp) < radius);
    inside.map(|k| f64::from(plane[k] - GROUND)).sum()
}

/// Returns the largest undershoot of means over 3 x 3 px in a ring about a lamp, as a share of the ground.
fn undershoot(plane: &[f32], lamp: (f64, f64, f32)) -> f32 {
    let ring = (0..plane.len()).filter(|k| (RADIUS + 3.5..24.0).contains(&far(*k, lamp)));
    let mean = |k: usize| {
        let rows = [k - WIDTH, k, k + WIDTH];
        let around = rows.iter().flat_map(|k| &plane[k - 1..k + 2]);
        around.sum::<f32>() / 9.0
    };
    ring.fold(0.0, |most, k| most.max(1.0 - mean(k) / GROUND))
}

#[test]
fn lamps_come_back_as_discs_without_rings() {
    let lens = lens(1.0);
    let scene = scene(&lens);
    let truth = lamps();
    let plate = blurred(&scene, &Scatter, &truth, 0.001);
    let removed = remove(&scene, &plate, Deconvolver::default());
    let sharp = removed.canvas.crop(&removed.sharp);
    for lamp in LAMPS {
        let undershoot = undershoot(&sharp, lamp);
        assert!(undershoot < 0.02, "{lamp:?}: {undershoot}");
        let share = light_within(&sharp, lamp, RADIUS + 1.5) / light_within(&truth, lamp, 20.0);
        assert!((share - 1.0).abs() < 0.03, "{lamp:?}: {share}");
    }
    assert!(removed.sharp.iter().all(|v| *v >= 0.0));
    let kept = Deconvolver {
        lights: Lights::KeepBlur,
        ..Deconvolver::default()
    };
    let ringing = sharpen(&scene, &plate, kept);
    assert!(
        undershoot(&ringing, LAMPS[0]) > 0.05,
        "the test scene is too easy"
    );
}

/// The unclipped rim of a lamp's blur tells how bright it is.
#[test]
fn light_of_a_clipped_lamp_is_found_from_its_rim() {
    let lens = lens(1.0);
    let scene = scene(&lens);
    let truth = lamps();
    let plate = blurred(&scene, &Scatter, &truth, 0.001);
    let clipped: Vec<f32> = plate.iter().map(|v| v.min(1.0)).collect();
    let deconvolver = Deconvolver {
        saturation: Saturation::Level(1.0),
        ..Deconvolver::default()
    };
    let sharp = sharpen(&scene, &clipped, deconvolver);
    let lamp = LAMPS[1];
    let share = |plane: &[f32]| light_within(plane, lamp, 10.0) / light_within(&truth, lamp, 20.0);
    assert!(share(&clipped) < 0.7, "{}", share(&clipped));
    assert!((share(&sharp) - 1.0).abs() < 0.15, "{}", share(&sharp));
    assert!(undershoot(&sharp, lamp) < 0.02);
}

/// The blur of a lamp is far from that of a lens twice as wide.
#[test]
fn lights_that_the_lens_does_not_explain_keep_their_blur() {
    let (narrow, wide) = (lens(0.8), lens(1.6));
    let plate = blurred(&scene(&narrow), &Scatter, &lamps(), 0.001);
    let removed = remove(&scene(&wide), &plate, Deconvolver::default());
    let lamp = LAMPS[2];
    let share = |reason| removed.kept.share_of(reason);
    assert!(share(KeptBlurReason::UnexplainedLight) > 0.0005);
    assert!(share(KeptBlurReason::NearLight) > 0.01);
    assert_eq!(share(KeptBlurReason::Clipped), 0.0);
    let total: f64 = KeptBlurReason::ALL.map(share).iter().sum();
    let shares: Vec<f32> = removed.kept.shares().collect();
    let mean = shares.iter().map(|v| f64::from(*v)).sum::<f64>() / shares.len() as f64;
    assert!((total - mean).abs() < 1e-9, "{total} {mean}");
    let sharp = removed.canvas.crop(&removed.sharp);
    let same = |k: &usize| (sharp[*k] - plate[*k]).abs() < 1e-6;
    assert!(
        (0..plate.len())
            .filter(|k| far(*k, lamp) < RADIUS)
            .all(|k| same(&k))
    );
}

/// The sources of a large light before a textured ground would take a part of its texture.
#[test]
fn a_large_light_before_texture_keeps_its_blur() {
    let lens = lens(1.0);
    let scene = scene(&lens);
    let inside = |k: usize| (55..95).contains(&(k % WIDTH)) && (50..90).contains(&(k / WIDTH));
    let mut deviates = NormalDeviates(3);
    let cells: Vec<f32> = (0..WIDTH * HEIGHT)
        .map(|_| deviates.next() as f32)
        .collect();
    let truth = |texture: f32| -> Vec<f32> {
        let sample = |k: usize| {
            let cell = k / WIDTH / 6 * WIDTH + k % WIDTH / 6;
            let ripple = if k / WIDTH % 8 < 3 { 2.0 } else { 0.0 };
            let light = if inside(k) { 0.4 + ripple } else { 0.0 };
            (GROUND + texture * cells[cell]).max(0.0) + light
        };
        (0..WIDTH * HEIGHT).map(sample).collect()
    };
    let middle = 70 * WIDTH + 75;
    let change = |texture: f32| {
        let plate = blurred(&scene, &Scatter, &truth(texture), 0.001);
        let sharp = sharpen(&scene, &plate, Deconvolver::default());
        let near = (-4..=4).map(|row: isize| middle.saturating_add_signed(row * WIDTH as isize));
        near.fold(0.0_f32, |most, k| most.max((sharp[k] - plate[k]).abs()))
    };
    assert!(change(0.05) < 1e-6, "{}", change(0.05));
    assert!(change(0.015) > 0.05, "{}", change(0.015));
}

/// A window of some 2000 sources is solved by its residual, and a thin line as well as small lamps are.
#[test]
fn windows_and_lines_come_back_without_rings() {
    let lens = lens(1.0);
    let scene = scene(&lens);
    let outside = |k: usize| -> (usize, usize) {
        let (x, y) = (k % WIDTH, k / WIDTH);
        let beyond = |at: usize, first: usize, last: usize| {
            first.saturating_sub(at).max(at.saturating_sub(last))
        };
        let window = beyond(x, 55, 94).max(beyond(y, 50, 89));
        (window, beyond(x, 40, 110).max(beyond(y, 120, 120)))
    };
    let truth: Vec<f32> = (0..WIDTH * HEIGHT)
        .map(|k| match outside(k) {
            (0, _) => 6.0,
            (_, 0) => 20.0,
            _ => GROUND,
        })
        .collect();
    let plate = blurred(&scene, &Scatter, &truth, 0.001);
    let sharp = sharpen(&scene, &plate, Deconvolver::default());
    let dark = (0..plate.len()).filter(|k| {
        let (window, line) = outside(*k);
        (4..24).contains(&window.min(line))
    });
    let mean = |k: usize| {
        let rows = [k - WIDTH, k, k + WIDTH];
        rows.iter().flat_map(|k| &sharp[k - 1..k + 2]).sum::<f32>() / 9.0
    };
    let undershoot = dark.fold(0.0_f32, |most, k| most.max(1.0 - mean(k) / GROUND));
    assert!(undershoot < 0.02, "{undershoot}");
    assert!(psnr_db(&sharp, &truth) > psnr_db(&plate, &truth) + 12.0);
}

/// Two colours: the second is displaced, and blurred more.
struct TwoColours(GrowingBlur, GrowingBlur);

impl BlurField for TwoColours {
    fn frame(&self) -> Frame {
        self.0.frame
    }

    fn channel_count(&self) -> usize {
        2
    }

    fn blur_at(&self, channel: usize, at: FieldPoint, vergence_per_m: f64) -> DisplacedBlur {
        if channel == 0 {
            return self.0.blur_at(0, at, vergence_per_m);
        }
        DisplacedBlur {
            displacement_px: (1.3, -0.6),
            ..self.1.blur_at(0, at, vergence_per_m)
        }
    }
}

#[test]
fn colours_get_the_blur_and_the_place_of_the_reference() {
    let narrow = lens(0.8);
    let both = TwoColours(lens(0.8), lens(1.0));
    let scene = Scene {
        lens: &both,
        displacement: Displacement::Full,
        ..scene(&narrow)
    };
    let mut truth = super::discs(WIDTH, HEIGHT);
    truth[75 * WIDTH + 85] = 50.0;
    let weights = [vec![1.0, 0.0], vec![0.0, 1.0]];
    let planes = weights.each_ref().map(|weights| Plane {
        samples: &truth,
        weights,
    });
    let blurred = Scatter.render(&scene, &planes, &|_| true);
    let blurred = blurred.expect("a valid scene").planes;
    let plane = |colour: usize| Plane {
        samples: &blurred[colour],
        weights: &weights[colour],
    };
    let deconvolver = Deconvolver {
        noise: Some(0.0005),
        ..Deconvolver::default()
    };
    let planes = [0, 1].map(|colour| (deconvolver, plane(colour)));
    let lights = find_lights(&scene, &planes, &|_| true).expect("a valid scene");
    let matched = |colour: usize| {
        let lights = &lights[colour];
        let matched = match_blur(lights, &scene, &plane(colour), &weights[0], &|_| true);
        matched.expect("a valid scene")
    };
    assert!(matched(0) == blurred[0]);
    let error = |plane: &[f32]| {
        let squares = plane.iter().zip(&blurred[0]).enumerate();
        let inside = squares.filter(|(k, _)| {
            (12..WIDTH - 12).contains(&(k % WIDTH)) && (12..HEIGHT - 12).contains(&(k / WIDTH))
        });
        inside
            .map(|(_, (a, b))| f64::from(a - b).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    let (before, after) = (error(&blurred[1]), error(&matched(1)));
    assert!(after < 0.2 * before, "{before} {after}");
}

/// A lamp that one colour cannot explain keeps its blur in the other too: no rim of one colour is left about it.
#[test]
fn a_lamp_is_separated_in_all_colours_or_none() {
    let lens = lens(1.0);
    let scene = scene(&lens);
    let truth = lamps();
    let plate = blurred(&scene, &Scatter, &truth, 0.001);
    // The lamp of 10 has twice its size in the second colour, with a hole that no blur of this lens has.
    let (lamp, mut other) = (LAMPS[1], plate.clone());
    for (k, sample) in other.iter_mut().enumerate() {
        let far = far(k, lamp);
        if far < 2.0 * RADIUS {
            *sample = if far < RADIUS { 0.2 } else { 10.0 };
        }
    }
    let planes = [&plate, &other].map(|samples| Plane {
        samples,
        weights: &WEIGHTS,
    });
    let remove = |planes: &[Plane]| {
        let removed = Deconvolver::default().remove(&scene, planes, &|_| true);
        let removed = removed.expect("a valid scene").swap_remove(0);
        removed.canvas.crop(&removed.sharp)
    };
    let changed = |sharp: &[f32], lamp: (f64, f64, f32)| {
        let near = (0..sharp.len()).filter(|k| far(*k, lamp) < RADIUS + 2.0);
        near.fold(0.0_f32, |most, k| most.max((sharp[k] - plate[k]).abs()))
    };
    let (alone, together) = (remove(&planes[..1]), remove(&planes));
    for lamp in LAMPS[..2].iter().copied() {
        assert!(changed(&alone, lamp) > 0.1 * lamp.2, "{lamp:?}");
        let is_kept = changed(&together, lamp) < 0.01 * lamp.2;
        assert_eq!(is_kept, lamp.2 == 10.0, "{lamp:?}");
    }
}

/// A lamp that is clipped in one colour, and keeps its blur there, keeps it in the other too.
#[test]
fn a_lamp_that_is_clipped_in_one_colour_is_separated_in_none() {
    let lens = lens(1.0);
    let scene = scene(&lens);
    let plate = blurred(&scene, &Scatter, &lamps(), 0.001);
    // No sample of the rim of the second lamp tells how bright it is.
    let clipped: Vec<f32> = (plate.iter().enumerate())
        .map(|(k, v)| {
            if far(k, LAMPS[1]) < 14.0 {
                1.0
            } else {
                v.min(1.0)
            }
        })
        .collect();
    let colour = |samples, saturation| {
        let deconvolver = Deconvolver {
            saturation,
            ..Deconvolver::default()
        };
        let weights = &WEIGHTS;
        (deconvolver, Plane { samples, weights })
    };
    let colours = [
        colour(&plate, Saturation::Never),
        colour(&clipped, Saturation::Level(1.0)),
    ];
    let separated = |colours| {
        let lights = find_lights(&scene, colours, &|_| true).expect("a valid scene");
        [LAMPS[0], LAMPS[1]]
            .map(|(x, y, _)| lights[0].sources.explained[y as usize * WIDTH + x as usize])
    };
    assert_eq!(separated(&colours[..1]), [true, true]);
    assert_eq!(separated(&colours), [true, false]);
}
