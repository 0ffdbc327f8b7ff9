//! Shots in motion: what does not move stays still, and focus moves as with exact kernels.

use super::aim::{Aim, Wanted};
use super::lens;
use super::plates::{Objects, plate, shot};
use seidel_core::{
    Controls, Lens, ObjectDistance, Plate, Quality, Result, Settings, apply, no_progress,
};

/// Frames of the moving card, and of the pull of focus.
const FRAMES: usize = 24;
const FOCUS_FRAMES: usize = 12;

/// Columns of the plates.
const WIDTH: usize = 480;
const FOCUS_WIDTH: usize = 160;

/// The radius of the card's blur, px of [`WIDTH`], and twice as much for what is seen through its edge.
const REACH_PX: usize = 30;

/// Returns the aims of motion.
pub(crate) fn aims() -> Result<Vec<Aim>> {
    let lens = lens()?;
    eprintln!("motion");
    let (mean, largest) = focus_differences(&lens)?;
    Ok(vec![
        Aim::new(
            "a moving card: largest change beyond its blur",
            Wanted::AtMost(1e-4),
            "",
            change_beyond_blur(&lens)?,
        ),
        Aim::new(
            "a pull of focus, changes against exact ones: root mean square",
            Wanted::AtMost(1e-3),
            "",
            mean,
        ),
        Aim::new(
            "a pull of focus, changes against exact ones: largest",
            Wanted::AtMost(1e-3),
            "",
            largest,
        ),
    ])
}

fn samples(lens: &Lens, plate: &Plate, settings: &Settings) -> Result<Vec<f32>> {
    Ok(apply(lens, plate, settings, &no_progress)?.to_interleaved())
}

/// The shot without lamps, whose peak is below one.
fn dark_shot(frame: usize) -> Objects {
    Objects {
        lamps: None,
        ..shot(frame)
    }
}

/// Returns the largest change from one frame to the next beyond the blur of the moving card.
fn change_beyond_blur(lens: &Lens) -> Result<f64> {
    let height = WIDTH * 9 / 16;
    let scaled = |px: usize| px * WIDTH / 1920;
    let (top, bottom) = (scaled(300), scaled(900));
    let mut largest = 0.0_f32;
    let mut before: Option<Vec<f32>> = None;
    for frame in 0..FRAMES {
        let plate = plate(&dark_shot(frame), WIDTH)?;
        let now = samples(lens, &plate, &Settings::default())?;
        let left = scaled(300 + 8 * frame);
        let near = left.saturating_sub(scaled(8) + REACH_PX)..left + scaled(320) + REACH_PX;
        let lines = top.saturating_sub(REACH_PX)..(bottom + REACH_PX).min(height);
        if let Some(before) = &before {
            for (index, (a, b)) in now.iter().zip(before).enumerate() {
                let (x, y) = (index / 3 % WIDTH, index / 3 / WIDTH);
                if !near.contains(&x) || !lines.contains(&y) {
                    largest = largest.max((a - b).abs());
                }
            }
        }
        before = Some(now);
    }
    Ok(f64::from(largest))
}

/// Returns how far changes from frame to frame are from those of the exact renderer in a pull of focus: root mean square and largest.
fn focus_differences(lens: &Lens) -> Result<(f64, f64)> {
    let plate = plate(&dark_shot(0), FOCUS_WIDTH)?;
    let (mut largest_mean, mut largest) = (0.0_f64, 0.0_f64);
    let mut before: Option<[Vec<f32>; 2]> = None;
    for frame in 0..FOCUS_FRAMES {
        let mut settings = Settings::default();
        let metres = 1.6 + 0.1 * frame as f64;
        settings.controls = Controls {
            focus_distance: Some(ObjectDistance::metres(metres)?),
            ..Controls::default()
        };
        let fast = samples(lens, &plate, &settings)?;
        settings.quality = Quality::Exact;
        let exact = samples(lens, &plate, &settings)?;
        if let Some([fast_before, exact_before]) = &before {
            let changes = fast.iter().zip(fast_before);
            let exact_changes = exact.iter().zip(exact_before);
            let apart = changes
                .zip(exact_changes)
                .map(|((b, a), (d, c))| f64::from((b - a) - (d - c)));
            let (mut squares, mut most) = (0.0, 0.0_f64);
            for apart in apart {
                squares += apart * apart;
                most = most.max(apart.abs());
            }
            largest_mean = largest_mean.max((squares / fast.len() as f64).sqrt());
            largest = largest.max(most);
        }
        before = Some([fast, exact]);
    }
    Ok((largest_mean, largest))
}
