//! Removal of blur from pictures with known truth: gain in PSNR, re-blur error, and time relative to one blur by the fast
//! renderer.
//!
//! `cargo bench -p seidel-render --bench remove [-- OPTIONS]`:
//!
//! - `--images DIR`: pictures, NAME.f32 files of 512 x 512 samples (0 to 1, linear, little-endian, row-major), by default
//!   a synthetic one;
//! - `--noise S,S,..`: standard deviations of the noise, by default 0, 0.001 and 0.01;
//! - `--grain`: the noise is film grain instead, coarser than a pixel and stronger in the light;
//! - `--pan`: measures the flicker over a pan of 24 frames instead;
//! - `--edges`: measures errors at depth edges instead, without a clean plate and with one;
//! - `--doubts`: measures the lens check instead, with the right lens and wrong ones;
//! - `--scenes`: measures ringing in drawn scenes instead, for each treatment of lights;
//! - `--only TEXT`: of those scenes, those with TEXT in their names;
//! - `--fringes`: measures colour fringes instead, before and after they are taken off alone;
//! - `--rounds N`: timings of each case, by default 3;
//! - `--out DIR`: writes plates, results (those of scenes too) and the lens's kernels for competitors (`peers.py` runs all of this on
//!   photographs).
//!
//! Two threads, one plane. Times are medians of rounds in which blurring and removal alternate, from plane to plane. The
//! output is Markdown: see `docs/background/figures.md`.

mod case;
mod depth_edges;
mod doubts;
mod fringes;
mod kernels;
#[path = "../render/lenses.rs"]
mod lenses;
#[path = "../render/machine.rs"]
mod machine;
mod noise;
mod pan;
mod pictures;
#[path = "../render/plate.rs"]
mod plate;
mod ringing;
mod scenes;

use case::{Measurement, measure};
use noise::Noise;
use std::path::PathBuf;

/// Columns and rows of pictures.
const SIDE: usize = 512;
const THREADS: usize = 2;

/// The command-line options.
struct Options {
    images: Option<PathBuf>,
    out: Option<PathBuf>,
    rounds: usize,
    noises: Vec<f64>,
    kind: Noise,
    pan: bool,
    doubts: bool,
    edges: bool,
    scenes: bool,
    only: String,
    fringes: bool,
}

impl Options {
    fn read() -> Result<Self, Box<dyn std::error::Error>> {
        let arguments: Vec<String> = std::env::args().skip(1).collect();
        let after = |name: &str| {
            let place = arguments.iter().position(|a| a == name)?;
            arguments.get(place + 1).cloned()
        };
        let noises = after("--noise").unwrap_or_else(|| "0,0.001,0.01".to_owned());
        let has = |name: &str| arguments.iter().any(|a| a == name);
        Ok(Self {
            images: after("--images").map(PathBuf::from),
            out: after("--out").map(PathBuf::from),
            rounds: after("--rounds").map_or(Ok(3), |n| n.parse())?,
            scenes: has("--scenes"),
            only: after("--only").unwrap_or_default(),
            fringes: has("--fringes"),
            pan: has("--pan"),
            doubts: has("--doubts"),
            edges: has("--edges"),
            kind: if has("--grain") {
                Noise::FilmGrain
            } else {
                Noise::White
            },
            noises: noises
                .split(',')
                .map(str::parse)
                .collect::<Result<_, _>>()?,
        })
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let options = Options::read()?;
    rayon::ThreadPoolBuilder::new()
        .num_threads(THREADS)
        .build_global()?;
    let lens = case::lens()?;
    let scene = case::scene(&lens);
    if let Some(folder) = &options.out {
        kernels::write(&scene, &folder.join("kernels.f32"))?;
    }
    if options.scenes {
        ringing::print(&scene, &options)?;
        return Ok(());
    }
    if options.fringes {
        let pictures = pictures::all(options.images.as_deref())?;
        fringes::print(&pictures, &options.noises, options.rounds)?;
        return Ok(());
    }
    if options.pan {
        let pictures = pictures::all(options.images.as_deref())?;
        pan::print(&scene, &pictures, &options)?;
        return Ok(());
    }
    if options.edges {
        let pictures = pictures::all(options.images.as_deref())?;
        depth_edges::print(&pictures, &options)?;
        return Ok(());
    }
    if options.doubts {
        let pictures = pictures::all(options.images.as_deref())?;
        doubts::print(&scene, &pictures, &options)?;
        return Ok(());
    }
    println!("{}", Measurement::head());
    for (name, truth) in pictures::all(options.images.as_deref())? {
        let blurred = case::blurred(&scene, &truth)?;
        for noise in &options.noises {
            let found = measure(&scene, &name, &truth, &blurred, *noise, &options)?;
            println!("{}", found.line());
            if let Some(folder) = &options.out {
                for (kind, samples) in [("plate", &found.plate), ("seidel", &found.sharp)] {
                    let file = folder.join(format!("{name}-{noise}-{kind}.f32"));
                    pictures::write(&file, samples)?;
                }
            }
        }
    }
    println!();
    for line in machine::description(THREADS) {
        println!("- {line}");
    }
    println!("- Rounds: {}", options.rounds);
    Ok(())
}
