//! The exact renderer against the same scatter in plain C (`scatter_baseline.c`).
//!
//! `cargo bench -p seidel-render --bench scatter [-- WIDTH HEIGHT CORNER_SIGMA]`, by default 512 x 512 at 6 px. Both run
//! alternately three times, with one thread and with all; the best time of each counts. The lens is that of
//! `render/lenses.rs`; edges are black.

#[path = "render/lenses.rs"]
mod lenses;

use lenses::SkewNormalLens;
use seidel_optics::field::{Frame, ImagePoint};
use seidel_optics::psf::SkewNormal;
use seidel_render::{Displacement, Edges, Plane, PlateMap, Renderer, Scatter, Scene, VergencePass};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

const RUNS: usize = 3;

/// Compiles the C program into `folder`; `None` if there is no C compiler with OpenMP.
fn compile_baseline(folder: &Path) -> Option<PathBuf> {
    let program = folder.join("scatter_baseline");
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/scatter_baseline.c");
    let status = Command::new(std::env::var("CC").unwrap_or_else(|_| "cc".into()))
        .args(["-O3", "-march=native", "-fopenmp", "-o"])
        .args([&program, &source])
        .arg("-lm")
        .status();
    status
        .is_ok_and(|status| status.success())
        .then_some(program)
}

/// Returns three planes of checks and noise from 0 to 1, the same on every machine.
fn plate(width: usize, height: usize) -> Vec<Vec<f32>> {
    let mut state = 1_u32;
    let mut plane = |channel: usize| {
        let sample = |index: usize| {
            let (x, y) = (index % width, index / width);
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = f64::from(state >> 8) / f64::from(1 << 24);
            let checks = f64::from(u8::from((x / 24 + y / 24 + channel).is_multiple_of(2)));
            (0.05 + 0.45 * checks + 0.5 * noise) as f32
        };
        (0..width * height).map(sample).collect()
    };
    vec![plane(0), plane(1), plane(2)]
}

fn bytes_of(planes: &[Vec<f32>]) -> Vec<u8> {
    let samples = planes.iter().flatten();
    samples.flat_map(|sample| sample.to_ne_bytes()).collect()
}

/// Returns the peak signal-to-noise ratio for a peak of one, dB.
fn psnr_db(ours: &[Vec<f32>], theirs: &[u8]) -> f64 {
    let (mut squares, mut count) = (0.0, 0.0);
    for (ours, theirs) in ours.iter().flatten().zip(theirs.as_chunks::<4>().0) {
        let difference = f64::from(*ours) - f64::from(f32::from_ne_bytes(*theirs));
        squares += difference * difference;
        count += 1.0;
    }
    -10.0 * (squares / count).log10()
}

fn main() -> Result<(), Box<dyn Error>> {
    let numbers: Vec<f64> = std::env::args()
        .filter_map(|arg| arg.parse().ok())
        .collect();
    let number = |index: usize, otherwise: f64| numbers.get(index).copied().unwrap_or(otherwise);
    let (width, height) = (number(0, 512.0) as usize, number(1, 512.0) as usize);
    let corner_sigma_px = number(2, 6.0);
    let frame = Frame::new(width as u32, height as u32, None)?;
    let lens = SkewNormalLens::new(frame, corner_sigma_px);
    let scene = Scene {
        lens: &lens,
        model: &SkewNormal,
        width,
        height,
        map: PlateMap {
            origin: ImagePoint::new(0.0, 0.0),
            scale: 1.0,
        },
        vergence: VergencePass::Constant(0.0),
        edges: Edges::Black,
        displacement: Displacement::None,
    };
    let source = plate(width, height);
    let weights = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let planes: Vec<_> = source
        .iter()
        .zip(&weights)
        .map(|(samples, weights)| Plane { samples, weights })
        .collect();

    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let baseline = compile_baseline(folder);
    if baseline.is_none() {
        println!("no C compiler with OpenMP: the comparison with C is skipped");
    }
    let (plate_file, out_file) = (folder.join("plate.raw"), folder.join("blurred.raw"));
    std::fs::write(&plate_file, bytes_of(&source))?;

    println!("{width} x {height}, 3 channels, corner sigma {corner_sigma_px} px; best of {RUNS}");
    let all = std::thread::available_parallelism()?.get();
    let mut counts = vec![1, all];
    counts.dedup();
    for threads in counts {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()?;
        let (mut ours, mut theirs) = (f64::INFINITY, f64::INFINITY);
        let mut blurred = Vec::new();
        for _ in 0..RUNS {
            let start = Instant::now();
            blurred = pool
                .install(|| Scatter.render(&scene, &planes, &|_| true))?
                .planes;
            ours = ours.min(start.elapsed().as_secs_f64());
            let Some(program) = &baseline else {
                continue;
            };
            let output = Command::new(program)
                .args([width.to_string(), height.to_string()])
                .arg(corner_sigma_px.to_string())
                .args([&plate_file, &out_file])
                .env("OMP_NUM_THREADS", threads.to_string())
                .output()?;
            let printed = String::from_utf8_lossy(&output.stdout);
            let seconds = printed.split_whitespace().next().ok_or("no time from C")?;
            theirs = theirs.min(seconds.parse()?);
        }
        let sum: f64 = blurred
            .iter()
            .flatten()
            .map(|&light| f64::from(light))
            .sum();
        print!("{threads} thread(s): ours {ours:.3} s (sum {sum:.3})");
        if baseline.is_some() {
            let psnr = psnr_db(&blurred, &std::fs::read(&out_file)?);
            print!(", C {theirs:.3} s, ours / C {:.3}, ", ours / theirs);
            print!("{psnr:.1} dB between them");
        }
        println!();
    }
    Ok(())
}
