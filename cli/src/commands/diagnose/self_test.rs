//! `--self-test`: sealed cases drawn, diagnosed blind, opened, and scored.

mod cases;

pub use cases::{Plan, run};

use std::path::Path;

use super::super::CommandError;
use crate::Console;
use crate::report::self_test::{SelfTest, html, json};
use clap::Args;
use rayon::ThreadPool;
use seidel_core::trial::Size;
use seidel_image_io::atomic::{refuse_foreign, write_folder_whole, write_whole};

const REPORT: &str = "self-test.json";
const PAGE: &str = "self-test.html";
/// How large the command's cases are.
const SIZE: Size = Size {
    design: 25,
    real: 24,
    holdout: 8,
    tile: 33,
};
const DEFAULT_SEED: u64 = 1;
/// Larger whole numbers lose digits in JSON readers that hold them as floats.
const LARGEST_SEED: u64 = 1 << 53;

/// Options about the self-test.
#[derive(Debug, Args)]
pub(super) struct SelfTestArgs {
    /// Instead of a lens and OBS: draw N sealed cases with known causes, diagnose each blind, and tell how
    /// often the answer was right; --out gets self-test.json and self-test.html
    #[arg(
        long = "self-test",
        value_name = "N",
        value_parser = clap::value_parser!(u32).range(1..=100_000),
        conflicts_with_all = ["lens", "observations", "reference", "observed", "only", "no_pairs"]
    )]
    self_test: Option<u32>,
    /// What the cases follow from; 1 if left out
    #[arg(
        long,
        value_name = "S",
        value_parser = clap::value_parser!(u64).range(..=LARGEST_SEED),
        requires = "self_test",
        conflicts_with_all = ["lens", "observations", "reference"]
    )]
    seed: Option<u64>,
    /// Diagnose each case with one effect once more with that effect left out of the library, and tell how
    /// often it is called unexplained
    #[arg(
        long,
        requires = "self_test",
        conflicts_with_all = ["lens", "observations", "reference"]
    )]
    withhold: bool,
}

impl SelfTestArgs {
    /// How many cases are asked for, if any.
    pub(super) fn count(&self) -> Option<usize> {
        self.self_test.map(|count| count as usize)
    }

    /// Runs the whole test; `out` gets its folder, and stdout JSON or a summary.
    pub(super) fn run(
        &self,
        count: usize,
        (out, as_json): (Option<&Path>, bool),
        pool: &ThreadPool,
        console: &mut Console,
    ) -> Result<(), CommandError> {
        if let Some(out) = out {
            refuse_foreign(out, &[REPORT, PAGE])?;
        }
        let plan = Plan {
            count,
            seed: self.seed.unwrap_or(DEFAULT_SEED),
            size: SIZE,
            library: Vec::new(),
            withhold: self.withhold,
        };
        let test = {
            let bar = console.progress("diagnosing sealed cases");
            pool.install(|| cases::run(&plan, &|share| bar.set(share)))
        };
        if let Some(out) = out {
            write(out, &test)?;
        }
        if as_json {
            console.say(json(&test).trim_end());
        } else {
            summary(&test, out, console);
        }
        Ok(())
    }
}

/// Writes both files to `folder`, whole or not at all.
///
/// # Errors
/// A folder with other content, a file in the way, and a full disk.
pub fn write(folder: &Path, test: &SelfTest) -> Result<(), CommandError> {
    let files = [(REPORT, json(test)), (PAGE, html(test))];
    write_folder_whole(folder, |at: &Path| {
        files.iter().try_for_each(|(name, text)| {
            write_whole(&at.join(name), |out| {
                std::io::Write::write_all(out, text.as_bytes())
            })
        })
    })?;
    Ok(())
}

/// The headline figures, one a line.
fn summary(test: &SelfTest, out: Option<&Path>, console: &mut Console) {
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
    for (index, tested) in test.cases.iter().enumerate() {
        if let Some(problem) = &tested.failure {
            console.remark(format!("case {index} ({}): {problem}", tested.truth()));
        }
    }
    if let Some(out) = out {
        console.say(format!("wrote {} ({REPORT}, {PAGE})", out.display()));
    }
}
