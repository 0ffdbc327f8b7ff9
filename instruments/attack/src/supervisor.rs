//! The supervisor: starts workers, notes what they report, and starts them again behind cases that end them.

mod watch;

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant};

use crate::finding::Finding;
use crate::log::{Log, StoredFinding};
use crate::options::Options;
use crate::targets::{self, Target};

use watch::{Slice, WorkerFolder, run_worker};

/// Numbers of cases that a slice reserves.
const BLOCK: u64 = 1 << 20;

/// Longest time that a worker runs cases of one target.
const LONGEST_SLICE: Duration = Duration::from_secs(30);

/// Runs what the options ask for and returns the number of findings.
pub(crate) fn run(options: &Options) -> Result<u64, String> {
    if options.targets {
        for target in targets::ALL {
            println!("{:15} {}", target.name, target.about);
        }
        return Ok(0);
    }
    let log = Log::open(&options.log)?;
    if options.summary {
        print!("{}", log.summary());
        return Ok(0);
    }
    if let Some(case) = &options.case {
        return run_case(case, options, log);
    }
    if options.recheck {
        return recheck(options, log);
    }
    attack(options, log)
}

/// The state that the threads of the supervisor share.
struct Shared<'a> {
    options: &'a Options,
    log: Mutex<Log>,
    /// Time spent on each of the chosen targets, in units of its weight.
    spent: Mutex<Vec<f64>>,
    chosen: Vec<&'static Target>,
    findings: AtomicU64,
}

fn attack(options: &Options, log: Log) -> Result<u64, String> {
    let chosen = targets::chosen(&options.only)?;
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let jobs = options.jobs.unwrap_or(cores).max(1);
    let time = Duration::try_from_secs_f64(options.minutes * 60.0)
        .map_err(|_| "--minutes: is no duration; give a number of minutes".to_owned())?;
    let deadline = Instant::now() + time;
    // One slice of each target fits in the time.
    let weights: f64 = chosen.iter().map(|target| target.weight).sum();
    let slice = time.mul_f64(jobs as f64 / weights).min(LONGEST_SLICE);
    let shared = Shared {
        options,
        log: Mutex::new(log),
        spent: Mutex::new(vec![0.0; chosen.len()]),
        chosen,
        findings: AtomicU64::new(0),
    };
    let problems: Vec<String> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..jobs)
            .map(|_| scope.spawn(|| shared.work(deadline, slice)))
            .collect();
        let ended = threads.into_iter().map(|t| t.join());
        ended
            .filter_map(|r| {
                r.unwrap_or_else(|_| Err("a thread panicked".to_owned()))
                    .err()
            })
            .collect()
    });
    if let Some(problem) = problems.first() {
        return Err(problem.clone());
    }
    let log = shared.log.into_inner().map_err(|e| e.to_string())?;
    log.save()?;
    print!("{}", log.summary());
    Ok(shared.findings.into_inner())
}

impl Shared<'_> {
    /// Runs slices until the deadline, or one slice of each target if the number of cases is fixed.
    fn work(&self, deadline: Instant, slice: Duration) -> Result<(), String> {
        let folder = WorkerFolder::new()?;
        while self.options.cases.is_some() || Instant::now() < deadline {
            let Some(index) = self.next_target(slice) else {
                return Ok(());
            };
            let target = self.chosen[index];
            let first = {
                let mut log = self.log.lock().map_err(|e| e.to_string())?;
                let next = log.totals(target.name).next.entry(self.options.seed);
                let next = next.or_default();
                *next += BLOCK;
                *next - BLOCK
            };
            let slice = Slice {
                target,
                first,
                cases: self.options.cases,
                seed: self.options.seed,
                until: match self.options.cases {
                    Some(_) => None,
                    None => Some(deadline.min(Instant::now() + slice.mul_f64(target.weight))),
                },
            };
            let runs = run_worker(&slice, self.options, &folder, &mut |number, finding| {
                self.note(target, number, finding, &folder);
            })?;
            let mut log = self.log.lock().map_err(|e| e.to_string())?;
            log.totals(target.name).runs += runs;
            log.save()?;
        }
        Ok(())
    }

    /// Chooses the target with the least time spent. With a number of cases, each target is chosen once.
    fn next_target(&self, slice: Duration) -> Option<usize> {
        let mut spent = self.spent.lock().ok()?;
        let least = (0..spent.len()).min_by(|&a, &b| spent[a].total_cmp(&spent[b]))?;
        if self.options.cases.is_some() && spent[least] > 0.0 {
            return None;
        }
        spent[least] += slice.as_secs_f64().max(1.0);
        Some(least)
    }

    fn note(&self, target: &Target, number: u64, finding: Finding, folder: &WorkerFolder) {
        self.findings.fetch_add(1, Relaxed);
        eprintln!(
            "{}:{number}: {}: {}",
            target.name,
            finding.kind.name(),
            finding.text
        );
        if let Ok(mut log) = self.log.lock() {
            let seed = self.options.seed;
            let found = StoredFinding {
                target: target.name.to_owned(),
                seed,
                number,
                finding,
            };
            log.add(found, &folder.inputs_of(number));
        }
    }
}

/// Runs one case and keeps its inputs.
fn run_case(case: &str, options: &Options, mut log: Log) -> Result<u64, String> {
    let parsed = case.split_once(':').and_then(|(name, number)| {
        let number = number.parse::<u64>().ok()?;
        Some((targets::named(name)?, number))
    });
    let (target, number) =
        parsed.ok_or_else(|| format!("--case {case}: no such case; write it like exr:17"))?;
    let folder = WorkerFolder::new()?;
    let found = run_again(target, options.seed, number, options, &folder)?;
    let to = log.folder_of(target.name, number);
    let count = found.len() as u64;
    for finding in found {
        println!("{}: {}", finding.kind.name(), finding.text);
        let found = StoredFinding {
            target: target.name.to_owned(),
            seed: options.seed,
            number,
            finding,
        };
        log.add(found, &folder.inputs_of(number));
    }
    if count == 0 {
        log.keep(&folder.inputs_of(number), &to);
        println!("no finding");
    }
    println!("inputs: {}", to.display());
    Ok(count)
}

/// Runs the findings of the log again, and keeps those that are still findings.
fn recheck(options: &Options, mut log: Log) -> Result<u64, String> {
    let stored = std::mem::take(&mut log.findings);
    let mut remaining = 0;
    for found in stored {
        let Some(target) = targets::named(&found.target) else {
            continue;
        };
        let folder = WorkerFolder::new()?;
        let again = run_again(target, found.seed, found.number, options, &folder)?;
        let is_still = again.iter().any(|f| f.kind == found.finding.kind);
        let state = if is_still { "still" } else { "repaired" };
        println!(
            "{}:{} {}: {state}",
            found.target,
            found.number,
            found.finding.kind.name()
        );
        if is_still {
            remaining += 1;
            log.findings.push(found);
        }
    }
    log.save()?;
    Ok(remaining)
}

fn run_again(
    target: &'static Target,
    seed: u64,
    number: u64,
    options: &Options,
    folder: &WorkerFolder,
) -> Result<Vec<Finding>, String> {
    let slice = Slice {
        target,
        first: number,
        cases: Some(1),
        seed,
        until: None,
    };
    let mut found = Vec::new();
    run_worker(&slice, options, folder, &mut |_, finding| {
        found.push(finding);
    })?;
    Ok(found)
}
