//! Long runs: a sequence of thousands of frames, calls of the C ABI from many threads, renders of the OpenFX plugin.
//!
//! Every result is compared with the first one for the same input, and the resident memory must stay flat.

mod c_abi;
mod memory;
mod node;
mod sequence;

use std::time::Instant;

use crate::options::Options;
use memory::Watch;

/// A long run.
struct LongRun {
    name: &'static str,
    about: &'static str,
    /// Repetitions of the whole run.
    repeats: usize,
    /// Runs that many repetitions. The watch samples the memory meanwhile.
    run: fn(usize, &Options, &mut Watch) -> Result<(), String>,
}

const ALL: [LongRun; 3] = [
    LongRun {
        name: "sequence",
        about: "frames of 256 x 256 in a display window of 4096 x 2160, one run of `seidel apply`",
        repeats: 2000,
        run: sequence::run,
    },
    LongRun {
        name: "c-abi",
        about: "calls of the C ABI from 8 threads",
        repeats: 100_000,
        run: c_abi::run,
    },
    LongRun {
        name: "node",
        about: "renders of the OpenFX plugin in the test host, with knobs that move",
        repeats: 10_000,
        run: node::run,
    },
];

/// Runs the long runs that the options name, or all, and prints a line for each. Returns the number of failures.
pub(crate) fn run(options: &Options) -> Result<u64, String> {
    let names = options.endurance.as_deref().unwrap_or_default();
    let known = ALL
        .iter()
        .map(|run| run.name)
        .collect::<Vec<_>>()
        .join(", ");
    if let Some(unknown) = names.iter().find(|n| ALL.iter().all(|run| run.name != **n)) {
        return Err(format!("--endurance {unknown}: give some of {known}"));
    }
    let mut failures = 0;
    for run in &ALL {
        if !names.is_empty() && names.iter().all(|name| name != run.name) {
            continue;
        }
        let repeats = options.repeats.unwrap_or(run.repeats);
        let started = Instant::now();
        let mut watch = Watch::default();
        let result = (run.run)(repeats, options, &mut watch);
        let memory = watch.end();
        let time = started.elapsed().as_secs();
        println!("{}: {repeats} {}; {time} s; {memory}", run.name, run.about);
        let problem = result.err().or_else(|| memory.problem());
        if let Some(problem) = problem {
            println!("{}: FAILED: {problem}", run.name);
            failures += 1;
        }
    }
    Ok(failures)
}
