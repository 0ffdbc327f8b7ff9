//! Shots in motion: what does not move stays still, and focus moves as smoothly as with exact kernels.

use seidel_core::{
    Controls, Depth, DepthPass, Image, Lens, LensSession, ObjectDistance, Plate, Quality,
    RenderWindow, Settings, apply, no_progress,
};
use std::sync::Arc;

fn lens() -> Lens {
    Lens::from_json(include_str!("data/lens.json")).expect("a lens profile")
}

/// A card that faces the camera.
struct Card {
    /// Left, top, right and bottom, px.
    sides: [f32; 4],
    metres: f32,
}

/// Returns a plate without lights, see [`plate_with_lights`].
fn plate(size: [usize; 2], leaves: usize, card: &Card) -> Plate {
    plate_with_lights(size, leaves, card, &[])
}

/// Returns a plate of `width` x `height` px: `lights` of 200 at columns and rows, a patterned floor from 9 m at the top to 1.6 m, some leaves at many depths, and a card.
fn plate_with_lights(
    [width, height]: [usize; 2],
    leaves: usize,
    card: &Card,
    lights: &[[usize; 2]],
) -> Plate {
    let mut state = 5_u32;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    // Column, row, radius and metres.
    let leaves: Vec<[f32; 4]> = (0..leaves)
        .map(|_| {
            let (x, y) = (noise() * width as f32, noise() * 0.5 * height as f32);
            [x, y, 1.0 + 3.0 * noise(), 1.4 + 6.0 * noise()]
        })
        .collect();
    let mut depth = vec![0.0; width * height];
    let mut samples = vec![0.0; 3 * width * height];
    for (index, metres) in depth.iter_mut().enumerate() {
        let (x, y) = ((index % width) as f32, (index / width) as f32);
        *metres = 9.0 - 7.4 * y / height as f32;
        let mut tone = 0.3 + 0.2 * (0.9 * x).sin() * (0.31 * y).cos();
        for [column, row, radius, at] in &leaves {
            let is_on = (x - column).abs() < *radius && (y - row).abs() < *radius;
            if is_on && *at < *metres {
                (*metres, tone) = (*at, 0.1 + 0.1 * at);
            }
        }
        let [left, top, right, bottom] = card.sides;
        if x >= left && x < right && y >= top && y < bottom && card.metres < *metres {
            (*metres, tone) = (card.metres, 0.8 - 0.2 * (0.7 * (x - left)).sin());
        }
        for (channel, sample) in samples[3 * index..][..3].iter_mut().enumerate() {
            *sample = tone * (1.0 - 0.2 * channel as f32);
        }
    }
    for [column, row] in lights {
        samples[3 * (row * width + column)..][..3].fill(200.0);
    }
    let image = Image::from_interleaved(width, height, 3, &samples).expect("an image");
    Plate::new(image).with_depth(Depth::Pass(DepthPass::metres(depth)))
}

const LEAVES: usize = 60;

fn focused_at(metres: f64, quality: Quality) -> Settings {
    let mut settings = Settings::default();
    settings.quality = quality;
    settings.controls = Controls {
        focus_distance: Some(ObjectDistance::metres(metres).expect("a distance")),
        ..Controls::default()
    };
    settings
}

fn rendered(lens: &Lens, plate: &Plate, settings: &Settings) -> Vec<f32> {
    let image = apply(lens, plate, settings, &no_progress).expect("a render");
    image.to_interleaved()
}

/// Only what the window needs is drawn, with the same kernels at the same places.
#[test]
fn a_window_of_a_plate_in_depth_is_a_part_of_the_whole() {
    const SIZE: [usize; 2] = [480, 270];
    let card = Card {
        sides: [150.0, 80.0, 230.0, 200.0],
        metres: 1.2,
    };
    let settings = focused_at(2.0, Quality::Final);
    let session = LensSession::new(&lens(), &settings).expect("a session");
    // Neighbours share kernels, and some windows cut through them.
    let lights: Vec<[usize; 2]> = (0..1000)
        .map(|k| [5 + 9 * (k % 50), 6 + 13 * (k / 50)])
        .collect();
    let plate = plate_with_lights(SIZE, LEAVES, &card, &lights);
    let plate = Arc::new(session).prepare(plate);
    let plate = plate.expect("a sound plate");
    let whole = plate.apply(&no_progress).expect("a render");
    for [column, row, width, height] in [[0, 0, 120, 68], [200, 150, 90, 60], [470, 0, 10, 270]] {
        let window = RenderWindow {
            column,
            row,
            width,
            height,
        };
        let part = plate.apply_window(window, &no_progress).expect("a render");
        for (part, whole) in part.iter().zip(&whole) {
            let lines = part.chunks_exact(width).zip(row..);
            let apart = lines.flat_map(|(line, y)| {
                let expected = &whole[y * SIZE[0] + column..][..width];
                line.iter().zip(expected).map(|(a, b)| a - b)
            });
            let apart = farthest(apart);
            assert!(apart == 0.0, "{window:?}: {apart:e}");
        }
    }
}

fn farthest(differences: impl Iterator<Item = f32>) -> f32 {
    differences.map(f32::abs).fold(0.0, f32::max)
}

#[test]
fn a_moving_card_leaves_what_is_beyond_its_blur_as_it_is() {
    const SIZE: [usize; 2] = [480, 270];
    const STEP: usize = 6;
    /// The radius of the card's blur, and twice as much for what is seen through its edge.
    const REACH: usize = 30;
    let lens = lens();
    let mut before: Option<(usize, Vec<f32>)> = None;
    for frame in 0..24 {
        let left = 20 + STEP * frame;
        let card = Card {
            sides: [left as f32, 80.0, left as f32 + 60.0, 200.0],
            metres: 1.2,
        };
        let now = rendered(&lens, &plate(SIZE, LEAVES, &card), &Settings::default());
        if let Some((last, before)) = &before {
            let near = last - REACH.min(*last)..left + 60 + REACH;
            let still = now.chunks(3).zip(before.chunks(3)).enumerate();
            let still = still.filter(|(index, _)| {
                let (x, y) = (index % SIZE[0], index / SIZE[0]);
                !near.contains(&x) || !(80 - REACH..200 + REACH).contains(&y)
            });
            let changes = still.flat_map(|(_, (a, b))| a.iter().zip(b).map(|(a, b)| a - b));
            let changed = farthest(changes);
            println!("frame {frame}: {changed:.1e}");
            assert!(changed < 1e-3, "frame {frame}: {changed}");
        }
        before = Some((left, now));
    }
}

#[test]
fn focus_moves_as_with_exact_kernels() {
    const SIZE: [usize; 2] = [160, 90];
    let lens = lens();
    let card = Card {
        sides: [50.0, 30.0, 80.0, 70.0],
        metres: 1.3,
    };
    let plate = plate(SIZE, LEAVES, &card);
    let mut before: Option<[Vec<f32>; 2]> = None;
    for frame in 0..7 {
        let metres = 1.6 + 0.1 * f64::from(frame);
        let now = [Quality::Final, Quality::Exact]
            .map(|quality| rendered(&lens, &plate, &focused_at(metres, quality)));
        if let Some([fast, exact]) = &before {
            let changes = now[0].iter().zip(fast).zip(now[1].iter().zip(exact));
            let apart: Vec<f32> = changes.map(|((b, a), (d, c))| (b - a) - (d - c)).collect();
            let most = farthest(apart.iter().copied());
            let squares = apart.iter().map(|a| a * a).sum::<f32>();
            let mean = (squares / apart.len() as f32).sqrt();
            println!("frame {frame}: {mean:.1e}, at most {most:.1e}");
            assert!(mean < 1e-3, "frame {frame}: {mean}");
        }
        before = Some(now);
    }
}

#[test]
fn slices_do_not_pop_as_a_card_moves_through_them() {
    const SIZE: [usize; 2] = [240, 135];
    let lens = lens();
    let mut frames = Vec::new();
    for frame in 0..40 {
        // Even steps of vergence, through about six slices.
        let vergence = 0.55 + 0.012 * frame as f32;
        let card = Card {
            sides: [70.0, 30.0, 170.0, 110.0],
            metres: 1.0 / vergence,
        };
        // No leaves, which the card would pass.
        frames.push(rendered(
            &lens,
            &plate(SIZE, 0, &card),
            &Settings::default(),
        ));
    }
    let changes: Vec<f32> = frames
        .windows(2)
        .map(|pair| {
            let squares = pair[1].iter().zip(&pair[0]).map(|(b, a)| (b - a).powi(2));
            (squares.sum::<f32>() / pair[0].len() as f32).sqrt()
        })
        .collect();
    println!("{changes:?}");
    for around in changes.windows(3) {
        let beside = around[0].max(around[2]);
        assert!(around[1] < 1.5 * beside + 1e-5, "{around:?} of {changes:?}");
    }
}
