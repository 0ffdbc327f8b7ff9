//! Renders of a shot with depth, one after the other with one lens, against renders each with a lens read anew.
//!
//!     cargo bench -p seidel-core --bench shot
//!
//! HD plates with a floor, cards and leaves at many depths, through the lens of the tests: 50 mm, f/0.95, focused at 2 m, drawn
//! ray by ray. Two threads; seconds are medians of three rounds in which all cases take turns.

use seidel_core::{
    Controls, Depth, DepthPass, Image, Lens, ObjectDistance, Plate, Quality, Result, Settings,
    apply, no_progress,
};
use std::time::Instant;

const WIDTH: usize = 1920;
const HEIGHT: usize = 1080;
const ROUNDS: usize = 3;
const THREADS: usize = 2;

/// Returns frame `frame` of the shot: a card moves to the right by 8 px a frame.
fn plate(frame: usize) -> Result<Plate> {
    let mut state = 7_u32;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    // Column, row, radius and metres of each leaf.
    let leaves: Vec<[f32; 4]> = (0..300)
        .map(|_| {
            let (x, y) = (noise() * WIDTH as f32, noise() * 0.5 * HEIGHT as f32);
            [x, y, 4.0 + 12.0 * noise(), 1.0 + 7.0 * noise()]
        })
        .collect();
    let card = 300 + 8 * frame;
    let mut depth = vec![0.0; WIDTH * HEIGHT];
    let mut samples = vec![0.0; 3 * WIDTH * HEIGHT];
    for (index, metres) in depth.iter_mut().enumerate() {
        let (x, y) = (index % WIDTH, index / WIDTH);
        let share = y as f32 / HEIGHT as f32;
        *metres = 12.0 - 10.5 * share;
        let mut tone = 0.2 + 0.1 * (0.05 * x as f32).sin();
        if (card..card + 320).contains(&x) && (300..900).contains(&y) {
            (*metres, tone) = (1.2, 0.6);
        }
        for [column, row, radius, at] in &leaves {
            let is_on = (x as f32 - column).abs() < *radius && (y as f32 - row).abs() < *radius;
            if is_on && *at < *metres {
                (*metres, tone) = (*at, 0.1 + 0.05 * at);
            }
        }
        for (channel, sample) in samples[3 * index..][..3].iter_mut().enumerate() {
            *sample = tone * (1.0 - 0.2 * channel as f32) + 0.02 * noise();
        }
    }
    for k in 0..40 {
        let index = (100 + 20 * (k / 8)) * WIDTH + 150 + 210 * (k % 8);
        samples[3 * index..][..3].fill(400.0);
    }
    let image = Image::from_interleaved(WIDTH, HEIGHT, 3, &samples)?;
    Ok(Plate::new(image).with_depth(Depth::Pass(DepthPass::metres(depth))))
}

fn lens() -> Result<Lens> {
    Lens::from_json(include_str!("../tests/data/lens.json"))
}

fn seconds(lens: &Lens, plate: &Plate, settings: &Settings) -> Result<f64> {
    let start = Instant::now();
    apply(lens, plate, settings, &no_progress)?;
    Ok(start.elapsed().as_secs_f64())
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn main() -> std::result::Result<(), Box<dyn std::error::Error>> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(THREADS)
        .build_global()?;
    let (first, next) = (plate(0)?, plate(1)?);
    let settings = Settings::default();
    let mut refocused = Settings::default();
    refocused.controls = Controls {
        focus_distance: Some(ObjectDistance::metres(2.2)?),
        ..Controls::default()
    };
    let mut draft = Settings::default();
    draft.quality = Quality::Draft;
    let names = [
        "first frame",
        "next frame",
        "the same frame again",
        "the same frame, another focus",
        "draft, first frame",
    ];
    let mut times: [Vec<f64>; 5] = Default::default();
    for round in 1..=ROUNDS {
        eprintln!("round {round} of {ROUNDS}");
        let kept = lens()?;
        times[0].push(seconds(&kept, &first, &settings)?);
        times[1].push(seconds(&kept, &next, &settings)?);
        times[2].push(seconds(&kept, &next, &settings)?);
        times[3].push(seconds(&kept, &next, &refocused)?);
        times[4].push(seconds(&lens()?, &first, &draft)?);
    }
    let medians: Vec<f64> = times.iter_mut().map(|times| median(times)).collect();
    println!(
        "| render, {WIDTH} x {HEIGHT}, {THREADS} threads | s | share of the first |\n| --- | --- | --- |"
    );
    for (name, seconds) in names.iter().zip(&medians) {
        println!(
            "| {name} | {seconds:.2} | {:.0} % |",
            100.0 * seconds / medians[0]
        );
    }
    Ok(())
}
