//! The fast renderer against an overlap-add renderer and against the exact one.
//!
//! `cargo bench -p seidel-render --bench render [-- OPTIONS]`:
//!
//! - `--quick`: small plates only;
//! - `--only NAME`: cases whose name (such as `skew-normal-6-1920x1080`) contains NAME;
//! - `--rounds N`: timings of each case, by default 3;
//! - `--lights`: plates with small lights 200 times as bright as white;
//! - `--alone`: the fast renderer only.
//!
//! Two threads, three planes, plates and results in memory. Times are medians of rounds in which both renderers
//! alternate, from planes to results with kernels included. The output is Markdown: see
//! `docs/background/performance.md`.

mod accuracy;
mod cases;
mod depth;
mod lenses;
mod machine;
mod memory;
mod overlap_add;
mod plate;
mod pupil_lens;
mod report;
mod rival;
mod transform;

use accuracy::Reference;
use cases::{Case, Lens};
use report::{Measurement, RivalMeasurement};
use seidel_optics::error::Result;
use seidel_render::{Gather, Plane, Quality, Renderer, Scatter, Scene};
use std::time::Instant;

const THREADS: usize = 2;
const WEIGHTS: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const FAST: Gather = Gather {
    quality: Quality::Final,
    kernels: None,
};
/// Rows of a band of the exact renderer.
const BAND_ROWS: usize = 16;

/// Share of pixels that are small bright lights with `--lights`.
const LIGHT_SHARE: f64 = 2e-5;

/// The command-line options.
struct Options {
    quick: bool,
    /// Share of pixels that are small bright lights.
    light_share: f64,
    alone: bool,
    rounds: usize,
    only: Option<String>,
    memory: Option<String>,
}

impl Options {
    fn read() -> Self {
        let arguments: Vec<String> = std::env::args().skip(1).collect();
        let has = |name: &str| arguments.iter().any(|a| a == name);
        let after = |name: &str| {
            let place = arguments.iter().position(|a| a == name)?;
            arguments.get(place + 1).cloned()
        };
        Self {
            quick: has("--quick"),
            light_share: if has("--lights") { LIGHT_SHARE } else { 0.0 },
            alone: has("--alone"),
            rounds: after("--rounds").and_then(|n| n.parse().ok()).unwrap_or(3),
            only: after("--only"),
            memory: after("--memory"),
        }
    }
}

fn main() -> std::result::Result<(), Box<dyn std::error::Error>> {
    let options = Options::read();
    rayon::ThreadPoolBuilder::new()
        .num_threads(THREADS)
        .build_global()?;
    let mut cases = cases::quick();
    if let Some(name) = &options.memory {
        cases.extend(cases::all());
        let case = cases.iter().find(|case| case.name() == *name);
        let case = case.ok_or("no case of that name")?;
        if let Some(bytes) = memory_of(case, options.light_share)? {
            println!("{bytes}");
        }
        return Ok(());
    }
    if !options.quick {
        cases = cases::all();
    }
    let wanted = |case: &Case| {
        options
            .only
            .as_ref()
            .is_none_or(|only| case.name().contains(only))
    };
    cases.retain(wanted);
    let measurements = cases
        .iter()
        .map(|case| measure(case, &options))
        .collect::<Result<Vec<_>>>()?;
    println!(
        "{}\n\n{}\n",
        report::table(&measurements),
        report::aims(&measurements)
    );
    let asked = options.only.as_ref();
    if !options.quick && asked.is_none_or(|only| depth::NAME.contains(only)) {
        println!("{}\n", depth::report(options.rounds)?);
    }
    for line in machine::description(THREADS) {
        println!("- {line}");
    }
    println!("- Rounds: {}", options.rounds);
    Ok(())
}

fn planes_of(samples: &[Vec<f32>]) -> Vec<Plane<'_>> {
    let both = samples.iter().zip(&WEIGHTS);
    both.map(|(samples, weights)| Plane { samples, weights })
        .collect()
}

/// Returns the peak memory of a render beyond its planes and results; `None` where the system does not report it.
fn memory_of(case: &Case, light_share: f64) -> Result<Option<u64>> {
    let lens = case.lens.on(case.size, case.corner_sigma_px);
    let samples = plate::plate(case.size.0, case.size.1, light_share);
    let out = FAST
        .render(
            &case.scene(&*lens, case.lens),
            &planes_of(&samples),
            &|_| true,
        )?
        .planes;
    let images = samples.iter().chain(&out).map(Vec::len).sum::<usize>() * size_of::<f32>();
    Ok(memory::peak_bytes().map(|peak| peak.saturating_sub(images as u64)))
}

fn measure(case: &Case, options: &Options) -> Result<Measurement> {
    eprintln!("{}", case.name());
    let lens = case.lens.on(case.size, case.corner_sigma_px);
    let scene = case.scene(&*lens, case.lens);
    let samples = plate::plate(case.size.0, case.size.1, options.light_share);
    let planes = planes_of(&samples);
    let mut times = Times::default();
    let found = times.fast(&scene, &planes)?;
    let exact = if options.alone {
        None
    } else {
        Reference::new(&scene, &planes, case.truth)?
    };
    let psnr_db = exact.as_ref().map(|exact| exact.psnr_db(&found));
    drop(found);
    if let Some(db) = psnr_db {
        eprintln!("  fast: {db:.1} dB");
    }
    let tuned = match (&exact, psnr_db) {
        (Some(exact), Some(db)) if case.rival => Some(rival::tuned(&scene, &planes, exact, db)),
        _ => None,
    };
    let skew_normal = Lens::SkewNormal.on(case.size, case.corner_sigma_px);
    let beside = (case.lens == Lens::Pupil).then(|| case.scene(&*skew_normal, Lens::SkewNormal));
    // The first run was a warm-up.
    times = Times::default();
    for _ in 0..options.rounds {
        times.fast(&scene, &planes)?;
        if let Some(tuned) = &tuned {
            let (rendered, seconds) = timed(|| tuned.renderer.render(&scene, &planes));
            times.rival.push(seconds);
            times.kernels.push(rendered.kernels.as_secs_f64());
        }
        if let Some(beside) = &beside {
            let (result, seconds) = timed(|| FAST.render(beside, &planes, &|_| true));
            result?;
            times.beside.push(seconds);
        }
    }
    let exact_seconds = match case.exact_bands {
        bands if bands > 0 && !options.alone => Some(exact_seconds(&scene, &samples, bands)?),
        _ => None,
    };
    let lights = if options.light_share > 0.0 {
        "--lights"
    } else {
        ""
    };
    let peak_bytes = case
        .memory
        .then(|| memory::ask_child(&["--memory", &case.name(), lights]))
        .flatten();
    Ok(Measurement {
        case: *case,
        psnr_db,
        seconds: median(&times.fast),
        rival: tuned.map(|tuned| RivalMeasurement {
            tuned,
            seconds: median(&times.rival),
            kernel_seconds: median(&times.kernels),
        }),
        skew_normal_seconds: beside.map(|_| median(&times.beside)),
        exact_seconds,
        peak_bytes,
    })
}

/// Times of each round, s.
#[derive(Default)]
struct Times {
    fast: Vec<f64>,
    rival: Vec<f64>,
    kernels: Vec<f64>,
    beside: Vec<f64>,
}

impl Times {
    fn fast(&mut self, scene: &Scene, planes: &[Plane]) -> Result<Vec<Vec<f32>>> {
        let (found, seconds) = timed(|| FAST.render(scene, planes, &|_| true));
        self.fast.push(seconds);
        Ok(found?.planes)
    }
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}

fn median(times: &[f64]) -> f64 {
    let mut sorted = times.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    match sorted.len() {
        0 => f64::NAN,
        odd if odd % 2 == 1 => sorted[middle],
        _ => (sorted[middle - 1] + sorted[middle]) / 2.0,
    }
}

/// Estimates the time of the exact renderer from one of every `apart` bands of rows, s: it skips black pixels.
fn exact_seconds(scene: &Scene, samples: &[Vec<f32>], apart: usize) -> Result<f64> {
    let band_of = |index: usize| index / scene.width / BAND_ROWS;
    let lit = |band: usize| band % apart == apart / 2;
    let bands = scene.height.div_ceil(BAND_ROWS);
    let count = (0..bands).filter(|band| lit(*band)).count().max(1);
    let dimmed: Vec<Vec<f32>> = samples
        .iter()
        .map(|plane| {
            let sample = |(k, v): (usize, &f32)| if lit(band_of(k)) { *v } else { 0.0 };
            plane.iter().enumerate().map(sample).collect()
        })
        .collect();
    let (result, seconds) = timed(|| Scatter.render(scene, &planes_of(&dimmed), &|_| true));
    result?;
    Ok(seconds * bands as f64 / count as f64)
}
