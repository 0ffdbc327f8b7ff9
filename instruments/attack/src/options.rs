//! The command line of the attack.

use std::path::PathBuf;

use clap::Parser;

/// Hostile runs of every reader, of the C ABI and of the command.
#[derive(Debug, Parser)]
pub(crate) struct Options {
    /// Duration of the attack
    #[arg(long, value_name = "N", default_value_t = 1.0)]
    pub(crate) minutes: f64,
    /// Worker processes at a time; one for each core if omitted
    #[arg(long, value_name = "N")]
    pub(crate) jobs: Option<usize>,
    /// Seed of all cases
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Targets to attack, separated by commas; all if omitted
    #[arg(long, value_name = "TARGET,..", value_delimiter = ',')]
    pub(crate) only: Vec<String>,
    /// Cases of each target, instead of a duration
    #[arg(long, value_name = "N", conflicts_with = "minutes")]
    pub(crate) cases: Option<u64>,
    /// Log of all runs so far, to which this one is added; findings are stored beside it
    #[arg(long, value_name = "FILE", default_value = "target/attack/log.json")]
    pub(crate) log: PathBuf,
    /// Run one case and keep its inputs beside the log
    #[arg(long, value_name = "TARGET:NUMBER")]
    pub(crate) case: Option<String>,
    /// Run the findings of the log again, and drop those that are no findings any more
    #[arg(long)]
    pub(crate) recheck: bool,
    /// Print the table of the log
    #[arg(long)]
    pub(crate) summary: bool,
    /// List the targets
    #[arg(long)]
    pub(crate) targets: bool,
    /// Long runs instead of an attack: sequence, c-abi, node, separated by commas; all without a name
    #[arg(long, value_name = "RUN,..", value_delimiter = ',', num_args = 0..)]
    pub(crate) endurance: Option<Vec<String>>,
    /// Repetitions of each long run
    #[arg(long, value_name = "N", requires = "endurance")]
    pub(crate) repeats: Option<usize>,
    /// The `seidel` command to attack; that of this binary if omitted
    #[arg(long, value_name = "PATH")]
    pub(crate) program: Option<PathBuf>,
    /// Run cases of this target and report them on stdout
    #[arg(long, hide = true, value_name = "TARGET")]
    pub(crate) worker: Option<String>,
    /// First case of a worker
    #[arg(long, hide = true, value_name = "N", default_value_t = 0)]
    pub(crate) first: u64,
    /// Folder of a worker
    #[arg(long, hide = true, value_name = "DIR")]
    pub(crate) folder: Option<PathBuf>,
    /// Folder to which a worker copies the inputs of findings
    #[arg(long, hide = true, value_name = "DIR")]
    pub(crate) kept: Option<PathBuf>,
    /// Leave out the undamaged cases that a worker begins with
    #[arg(long, hide = true)]
    pub(crate) no_twins: bool,
}
