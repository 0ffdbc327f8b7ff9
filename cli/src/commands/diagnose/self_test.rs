//! `--self-test`: sealed cases are drawn, diagnosed blind, opened and scored.

mod aims;
mod json;
mod results;
mod runner;
#[cfg(test)]
mod samples;

pub use results::{CaseResult, SelfTest, WithheldResult};
pub use runner::{Plan, run};

use std::path::Path;

use super::super::CommandError;
use super::DiagnoseArgs;
use crate::Console;
use clap::Args;
use rayon::ThreadPool;
use seidel_image_io::atomic::{check_folder_content, write_atomically, write_folder_atomically};
use seidel_trial::Size;

const REPORT: &str = "self-test.json";
/// Number of places and tile size of the command's cases.
const SIZE: Size = Size {
    design: 25,
    real: 24,
    holdout: 8,
    tile: 33,
};
const DEFAULT_SEED: u64 = 1;
/// Largest integer that JSON readers which parse numbers as doubles keep exactly.
const LARGEST_SEED: u64 = 1 << 53;

/// Options of the self-test.
#[derive(Debug, Args)]
pub(super) struct SelfTestArgs {
    /// Instead of a lens and OBS: draw N sealed cases with known causes, diagnose each blind, and report
    /// how often the diagnosis was right; --out gets self-test.json
    #[arg(
        long = "self-test",
        value_name = "N",
        value_parser = clap::value_parser!(u32).range(1..=100_000),
        conflicts_with_all = ["lens", "observations", "reference", "observed", "only", "no_pairs"]
    )]
    self_test: Option<u32>,
    /// Seed from which the cases are drawn; 1 if left out
    #[arg(
        long,
        value_name = "S",
        value_parser = clap::value_parser!(u64).range(..=LARGEST_SEED),
        requires = "self_test",
        conflicts_with_all = ["lens", "observations", "reference"]
    )]
    seed: Option<u64>,
    /// Diagnose each case with a single effect again with that effect removed from the library, and report
    /// how often the verdict is "unexplained"
    #[arg(
        long,
        requires = "self_test",
        conflicts_with_all = ["lens", "observations", "reference"]
    )]
    withhold: bool,
}

impl SelfTestArgs {
    /// Returns the number of cases, if a self-test was requested.
    pub(super) fn count(&self) -> Option<usize> {
        self.self_test.map(|count| count as usize)
    }
}

/// Runs the self-test of `count` cases: writes it to `--out` if given, and prints it.
pub(super) fn run_command(
    args: &DiagnoseArgs,
    count: usize,
    pool: &ThreadPool,
    console: &mut Console,
) -> Result<(), CommandError> {
    let out = args.out.as_deref();
    if let Some(out) = out {
        check_folder_content(out, &[REPORT])?;
    }
    let plan = Plan {
        count,
        seed: args.self_test.seed.unwrap_or(DEFAULT_SEED),
        size: SIZE,
        library: Vec::new(),
        withhold: args.self_test.withhold,
    };
    let test = {
        let bar = console.progress("diagnosing sealed cases");
        pool.install(|| run(&plan, &|share| bar.set(share)))
    };
    if let Some(out) = out {
        write(out, &test)?;
    }
    if args.json {
        console.say(json::json(&test).trim_end());
    } else {
        print_summary(&test, out, console);
    }
    Ok(())
}

/// Writes `self-test.json` to `folder`, whole or not at all.
///
/// # Errors
/// A folder with other content, a file in the way, or a full disk.
pub fn write(folder: &Path, test: &SelfTest) -> Result<(), CommandError> {
    let text = json::json(test);
    write_folder_atomically(folder, |at: &Path| {
        write_atomically(&at.join(REPORT), |out| {
            std::io::Write::write_all(out, text.as_bytes())
        })
    })?;
    Ok(())
}

/// Prints the headline figures, one per line.
fn print_summary(test: &SelfTest, out: Option<&Path>, console: &mut Console) {
    console.say(format!(
        "self-test: {} cases, seed {}: {} right, {} wrong, {} of these failed",
        test.cases.len(),
        test.seed,
        test.right(),
        test.cases.len() - test.right(),
        test.failed()
    ));
    for aim in test.aims() {
        let state = match (aim.met(), aim.bound) {
            (Some(true), _) => format!("; aim {}: met", aim.wanted()),
            (Some(false), _) => format!("; aim {}: missed", aim.wanted()),
            (None, Some(_)) => format!("; aim {}", aim.wanted()),
            (None, None) => String::new(),
        };
        console.say(format!("{}: {}{state}", aim.name, aim.found()));
    }
    for (index, result) in test.cases.iter().enumerate() {
        if let Some(error) = &result.error {
            console.remark(format!("case {index} ({}): {error}", result.truth()));
        }
    }
    if let Some(out) = out {
        console.say(format!("wrote {} ({REPORT})", out.display()));
    }
}
