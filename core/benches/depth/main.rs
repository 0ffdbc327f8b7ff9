//! All aims of rendering with depth, each with what is found, as one table.
//!
//!     cargo bench -p seidel-core --bench depth [-- --own] [--rounds N]
//!
//! - `--own`: without the rows of other benches, those of flat plates and of the node, which are run otherwise;
//! - `--rounds N`: timings of each case, by default 3, in which all cases take turns; medians count.
//!
//! Plates are drawn: a floor with a card, leaves and lamps at many depths (`plates`). The lens is that of the tests: 50 mm, f/0.95, focused
//! at 2 m, drawn ray by ray; the lens of moments is fitted to its PSFs. Two threads. Seconds are wall time. Figures about time are ratios
//! within one run.

mod accuracy;
mod aim;
mod memory;
mod motion;
mod other_benches;
mod plates;
mod times;

#[path = "../../examples/support/mod.rs"]
mod support;

use seidel_core::{FitSettings, Lens, Model, Result, fit, no_progress};

const THREADS: usize = 2;

fn main() -> std::result::Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let after = |name: &str| {
        let place = arguments.iter().position(|argument| argument == name)?;
        arguments.get(place + 1)
    };
    rayon::ThreadPoolBuilder::new()
        .num_threads(THREADS)
        .build_global()?;
    if let Some(width) = after(memory::OPTION) {
        println!("{}", memory::bytes_of_render(width.parse()?)?);
        return Ok(());
    }
    let rounds = after("--rounds").map_or(Ok(3), |rounds| rounds.parse())?;
    let moments = lens_of_moments()?;
    let mut aims = times::aims(&moments, rounds)?;
    aims.extend(accuracy::aims(&moments)?);
    aims.extend(motion::aims()?);
    aims.extend(memory::aims());
    if !arguments.iter().any(|argument| argument == "--own") {
        aims.extend(other_benches::aims());
    }
    println!("{}", aim::table(&aims));
    Ok(())
}

/// Returns the lens of the tests, newly read: without kernels of earlier renders.
fn lens() -> Result<Lens> {
    Lens::from_json(include_str!("../../tests/data/lens.json"))
}

/// Returns a lens of moments, fitted to PSFs of [`lens`].
fn lens_of_moments() -> Result<Lens> {
    let measured = support::measure(&lens()?, 8, 6)?;
    let settings = FitSettings {
        model: Model::Moments,
        ..FitSettings::default()
    };
    let fitted = fit(&[measured], &settings, &no_progress)?;
    Lens::new(fitted.into_lens())
}
