//! Draws sealed cases with known causes, diagnoses them blind, opens their answers and scores the diagnoses.
#![forbid(unsafe_code)]

mod aims;
mod holdout;
mod json;
mod mistakes;
mod processor_time;
mod results;
mod runner;
#[cfg(test)]
mod samples;
#[cfg(test)]
mod tests;

use std::error::Error;
use std::io::{Write as _, stderr, stdout};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::error::ErrorKind;
use clap::{CommandFactory as _, Parser};
use mistakes::Depth;
use rayon::ThreadPoolBuilder;
use results::SelfTest;
use runner::{Observer, Plan};
use seidel::{Console, ProgressForm, ProgressOutput};
use seidel_image_io::atomic::{check_folder_content, write_atomically, write_folder_atomically};
use seidel_image_io::error::FileError;
use seidel_trial::{KindClass, Selection};

const REPORT: &str = "self-test.json";
/// Largest integer that JSON readers which parse numbers as doubles keep exactly.
const LARGEST_SEED: u64 = 1 << 53;
/// Largest number of threads, as in the command.
const MAX_THREADS: i64 = 1024;

/// Draws sealed cases with known causes, diagnoses them blind, and says how often the diagnosis was right
#[derive(Debug, Parser)]
#[command(name = "seidel-self-test", version, max_term_width = 100)]
struct SelfTestArgs {
    /// Number of cases to draw
    #[arg(value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    count: u32,
    /// Seed from which the cases are drawn
    #[arg(long, value_name = "S", default_value_t = 1, value_parser = clap::value_parser!(u64).range(..=LARGEST_SEED))]
    seed: u64,
    /// The only kind of the cases; all kinds if omitted
    #[arg(
        long,
        value_name = "KIND",
        value_parser = PossibleValuesParser::new(KindClass::ALL.map(KindClass::id)).map(|id| kind(&id))
    )]
    kind: Option<KindClass>,
    /// Run only the case with this index, from 0, of the N that the seed gives
    #[arg(long, value_name = "I")]
    only_case: Option<usize>,
    /// Diagnose each case with a single effect again without that effect in the library, and report how often the verdict
    /// is "unexplained"
    #[arg(long)]
    withhold: bool,
    /// Plant a mistake in keeping books in each case, and report how often it is named, and how often one is without
    #[arg(long, value_enum, value_name = "DEPTH", conflicts_with_all = ["withhold", "out", "json"])]
    mistakes: Option<Depth>,
    /// Folder for self-test.json
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print self-test.json instead of a summary
    #[arg(long)]
    json: bool,
    /// Number of threads; all cores if omitted
    #[arg(long, value_parser = clap::value_parser!(u16).range(..=MAX_THREADS))]
    threads: Option<u16>,
    /// Progress on stderr
    #[arg(long, value_enum, value_name = "FORM", default_value_t = ProgressForm::Auto)]
    progress: ProgressForm,
}

/// Returns the kind called `id`, which is one of the possible values.
fn kind(id: &str) -> KindClass {
    let mut all = KindClass::ALL.into_iter();
    all.find(|kind| kind.id() == id)
        .expect("the parser accepts the identifiers of all kinds only")
}

impl SelfTestArgs {
    /// Returns the plan that the options describe.
    ///
    /// # Errors
    /// An index beyond the number of cases.
    fn plan(&self) -> Result<Plan, clap::Error> {
        let count = self.count as usize;
        if let Some(index) = self.only_case.filter(|index| *index >= count) {
            let last = count - 1;
            let problem = format!("--only-case {index}: there are {count} cases, 0 to {last}");
            return Err(Self::command().error(ErrorKind::ValueValidation, problem));
        }
        Ok(Plan {
            selection: Selection {
                count,
                seed: self.seed,
                only: self.kind,
                size: None,
            },
            only_case: self.only_case,
            library: Vec::new(),
            withhold: self.withhold,
        })
    }
}

fn main() -> ExitCode {
    #[cfg(unix)]
    seidel::remove_partial_outputs_on_signals();
    let args = SelfTestArgs::parse();
    let plan = args.plan().unwrap_or_else(|error| error.exit());
    let (mut stdout, mut stderr) = (stdout(), stderr());
    let mut console = Console {
        stdout: &mut stdout,
        stderr: &mut stderr,
        progress: ProgressOutput::stderr().with_form(args.progress),
    };
    match run(&args, &plan, &mut console) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            console.error(&error.to_string());
            ExitCode::FAILURE
        }
    }
}

/// Runs the self-test: writes it to `--out` if given, and prints it.
fn run(args: &SelfTestArgs, plan: &Plan, console: &mut Console) -> Result<(), Box<dyn Error>> {
    let out = args.out.as_deref();
    if let Some(out) = out {
        check_folder_content(out, &[REPORT])?;
    }
    let threads = args.threads.unwrap_or(0).into();
    ThreadPoolBuilder::new()
        .num_threads(threads)
        .build_global()?;
    if let Some(depth) = args.mistakes {
        run_mistakes(plan, depth, console);
        return Ok(());
    }
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
        runner::run(plan, &mut observer)
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

/// Plants mistakes in the cases of `plan`, and prints how often they are named.
fn run_mistakes(plan: &Plan, depth: Depth, console: &mut Console) {
    let results = mistakes::run(&plan.selection, plan.only_case, depth, |result| {
        console.print(result.line());
    });
    for line in mistakes::summary(&results) {
        console.print(line);
    }
}

/// Writes `self-test.json` to `folder`, whole or not at all.
///
/// # Errors
/// A folder with other content, a file in the way, or a full disk.
fn write(folder: &Path, test: &SelfTest) -> Result<(), FileError> {
    let text = json::json(test);
    write_folder_atomically(folder, |at| {
        write_atomically(&at.join(REPORT), |out| out.write_all(text.as_bytes()))
    })
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
