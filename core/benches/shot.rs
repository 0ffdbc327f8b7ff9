//! Renders of a shot with depth, one after the other with one lens, against renders each with a lens read anew.
//!
//!     cargo bench -p seidel-core --bench shot
//!
//! HD plates with a floor, cards, leaves and lamps at many depths, through the lens of the tests: 50 mm, f/0.95, focused at 2 m, drawn
//! ray by ray. Two threads; seconds are medians of three rounds in which all cases take turns, but for the frame of 3840 x 2160, which is
//! rendered once. Every row has its aim, a share of the first frame.

use seidel_core::{
    Controls, Depth, DepthPass, Image, Lens, LensSession, ObjectDistance, Plate, Quality, Result,
    Settings, apply, no_progress, render::RenderWindow,
};
use std::sync::Arc;
use std::time::Instant;

const HD: [usize; 2] = [1920, 1080];
const UHD: [usize; 2] = [3840, 2160];
const ROUNDS: usize = 3;
const THREADS: usize = 2;

/// Returns frame `frame` of the shot, enlarged to `size`: a card moves to the right by 8 px of HD a frame.
fn plate(frame: usize, [width, height]: [usize; 2]) -> Result<Plate> {
    let scale = width / HD[0];
    let mut state = 7_u32;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    // Column, row, radius and metres of each leaf.
    let leaves: Vec<[f32; 4]> = (0..300)
        .map(|_| {
            let (x, y) = (noise() * HD[0] as f32, noise() * 0.5 * HD[1] as f32);
            [x, y, 4.0 + 12.0 * noise(), 1.0 + 7.0 * noise()]
        })
        .collect();
    let card = 300 + 8 * frame;
    let mut depth = vec![0.0; width * height];
    let mut samples = vec![0.0; 3 * width * height];
    for (index, metres) in depth.iter_mut().enumerate() {
        let (x, y) = (index % width / scale, index / width / scale);
        let share = y as f32 / HD[1] as f32;
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
        let (x, y) = (150 + 210 * (k % 8), 100 + 20 * (k / 8));
        for pixel in 0..scale * scale {
            let index = (scale * y + pixel / scale) * width + scale * x + pixel % scale;
            samples[3 * index..][..3].fill(400.0);
        }
    }
    let image = Image::from_interleaved(width, height, 3, &samples)?;
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

/// Returns the seconds of the middle quarter of `plate`.
fn seconds_of_quarter(lens: &Lens, plate: &Plate, settings: &Settings) -> Result<f64> {
    let [width, height] = HD;
    let start = Instant::now();
    let session = Arc::new(LensSession::new(lens, settings)?);
    let window = RenderWindow {
        column: width / 4,
        row: height / 4,
        width: width / 2,
        height: height / 2,
    };
    session
        .prepare(plate.clone())?
        .apply_window(window, &no_progress)?;
    Ok(start.elapsed().as_secs_f64())
}

/// Returns the PSNR of `a` against `b`, dB, with a peak of one; samples are limited to white.
fn psnr(a: &Image, b: &Image) -> f64 {
    let (a, b) = (a.to_interleaved(), b.to_interleaved());
    let pairs = a.iter().zip(&b);
    let squares = pairs.map(|(a, b)| f64::from(a.min(1.0) - b.min(1.0)).powi(2));
    -10.0 * (squares.sum::<f64>() / a.len() as f64).log10()
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// The rows of the table, each with its aim: a share of the first frame.
const ROWS: [(&str, f64); 7] = [
    ("first frame", 1.0),
    ("next frame", 0.6),
    ("the same frame again", 0.6),
    ("the same frame, another focus", 0.6),
    ("a quarter of the first frame", 0.4),
    ("draft, first frame", 1.0 / 3.0),
    ("first frame of 3840 x 2160", 5.0),
];

fn main() -> std::result::Result<(), Box<dyn std::error::Error>> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(THREADS)
        .build_global()?;
    let (first, next) = (plate(0, HD)?, plate(1, HD)?);
    let settings = Settings::default();
    let mut refocused = Settings::default();
    refocused.controls = Controls {
        focus_distance: Some(ObjectDistance::metres(2.2)?),
        ..Controls::default()
    };
    let mut draft = Settings::default();
    draft.quality = Quality::Draft;
    let mut times: [Vec<f64>; ROWS.len()] = Default::default();
    for round in 1..=ROUNDS {
        eprintln!("round {round} of {ROUNDS}");
        let kept = lens()?;
        times[0].push(seconds(&kept, &first, &settings)?);
        times[1].push(seconds(&kept, &next, &settings)?);
        times[2].push(seconds(&kept, &next, &settings)?);
        times[3].push(seconds(&kept, &next, &refocused)?);
        times[4].push(seconds_of_quarter(&lens()?, &first, &settings)?);
        times[5].push(seconds(&lens()?, &first, &draft)?);
    }
    times[6].push(seconds(&lens()?, &plate(0, UHD)?, &settings)?);
    let medians: Vec<f64> = times.iter_mut().map(|times| median(times)).collect();
    println!(
        "| render, {} x {}, {THREADS} threads | s | share of the first | aim |\n| --- | --- | --- | --- |",
        HD[0], HD[1]
    );
    for ((name, aim), seconds) in ROWS.iter().zip(&medians) {
        let share = 100.0 * seconds / medians[0];
        println!(
            "| {name} | {seconds:.2} | {share:.0} % | {:.0} % |",
            100.0 * aim
        );
    }
    let lens = lens()?;
    let [draft, fine] = [&draft, &settings].map(|s| apply(&lens, &first, s, &no_progress));
    println!(
        "draft against final: {:.1} dB, aim 45 dB",
        psnr(&draft?, &fine?)
    );
    Ok(())
}
