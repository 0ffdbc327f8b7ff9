//! `--self-test`: draws sealed cases, diagnoses them blind, opens their answers and scores the diagnoses.

mod aims;
mod holdout;
mod json;
mod results;
mod runner;
#[cfg(test)]
mod samples;

pub use results::{AdvisedResult, CaseResult, SelfTest, WithheldResult};
pub use runner::{Observer, Plan, run};

use std::path::Path;

use super::super::{CommandError, write_text};
use super::DiagnoseArgs;
use crate::Console;
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use rayon::ThreadPool;
use seidel_image_io::atomic::{check_folder_content, write_folder_atomically};
use seidel_trial::{KindClass, Selection};

const REPORT: &str = "self-test.json";
const DEFAULT_SEED: u64 = 1;
/// Largest integer that JSON readers which parse numbers as doubles keep exactly.
const LARGEST_SEED: u64 = 1 << 53;

/// Options of the self-test.
#[derive(Debug, Args)]
#[command(next_help_heading = "Self-test")]
pub(super) struct SelfTestArgs {
    /// Number of sealed cases with known causes to draw and diagnose blind, instead of a lens and OBS
    ///
    /// The report says how often the diagnosis was right. --out gets self-test.json.
    #[arg(
        long = "self-test",
        value_name = "N",
        value_parser = clap::value_parser!(u32).range(1..=100_000),
        conflicts_with_all = ["lens", "observations", "reference", "observed", "only", "no_pairs"]
    )]
    self_test: Option<u32>,
    /// Seed from which the cases are drawn; 1 if omitted
    #[arg(
        long,
        value_name = "S",
        value_parser = clap::value_parser!(u64).range(..=LARGEST_SEED),
        requires = "self_test",
        conflicts_with_all = ["lens", "observations", "reference"]
    )]
    seed: Option<u64>,
    /// The only kind of the cases; all kinds if omitted
    #[arg(
        long,
        value_name = "KIND",
        value_parser = PossibleValuesParser::new(KindClass::ALL.map(KindClass::id)).map(|id| kind(&id)),
        requires = "self_test",
        conflicts_with_all = ["lens", "observations", "reference"]
    )]
    kind: Option<KindClass>,
    /// Run only the case with this index, from 0, of the N that the seed gives
    #[arg(
        long,
        value_name = "I",
        requires = "self_test",
        conflicts_with_all = ["lens", "observations", "reference"]
    )]
    only_case: Option<usize>,
    /// Diagnose each case with a single effect again without that effect in the library, and report how often the verdict
    /// is "unexplained"
    #[arg(
        long,
        requires = "self_test",
        conflicts_with_all = ["lens", "observations", "reference"]
    )]
    withhold: bool,
}

/// Returns the kind called `id`, which is one of the possible values.
fn kind(id: &str) -> KindClass {
    let mut all = KindClass::ALL.into_iter();
    all.find(|kind| kind.id() == id)
        .expect("the parser accepts the identifiers of all kinds only")
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
    let only_case = args.self_test.only_case;
    if let Some(index) = only_case.filter(|index| *index >= count) {
        return Err(CommandError::Usage(format!(
            "--only-case {index}: there are {count} cases, 0 to {}",
            count - 1
        )));
    }
    let plan = Plan {
        selection: Selection {
            count,
            seed: args.self_test.seed.unwrap_or(DEFAULT_SEED),
            only: args.self_test.kind,
            size: None,
        },
        only_case,
        library: Vec::new(),
        withhold: args.self_test.withhold,
    };
    let test = {
        let bar = console.progress_bar("diagnosing sealed cases");
        let mut observer = Observer {
            progress: &|share| bar.show(share),
            finished: &mut |result| {
                // The standard output holds JSON alone with --json.
                bar.suspend(|| {
                    if args.json {
                        console.note(result.line());
                    } else {
                        console.print(result.line());
                    }
                });
            },
        };
        run(&plan, Some(pool), &mut observer)
    };
    if let Some(out) = out {
        write(out, &test)?;
    }
    if args.json {
        console.print(json::json(&test).trim_end());
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
    write_folder_atomically(folder, |at| write_text(&at.join(REPORT), &text))?;
    Ok(())
}

/// Prints the headline figures, one per line.
fn print_summary(test: &SelfTest, out: Option<&Path>, console: &mut Console) {
    console.print(format!(
        "self-test: {} cases, seed {}: {} right, {} wrong, {} of these failed",
        test.cases.len(),
        test.selection.seed,
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
        console.print(format!("{}: {}{state}", aim.name, aim.found()));
    }
    for result in &test.cases {
        if let Some(error) = &result.error {
            console.note(format!(
                "case {} ({}): {error}",
                result.index,
                result.truth()
            ));
        }
    }
    if let Some(out) = out {
        console.print(format!("wrote {} ({REPORT})", out.display()));
    }
}
