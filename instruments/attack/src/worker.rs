//! A worker: runs cases of one target one after the other and reports them on stdout.

use std::ffi::OsString;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::process::ExitCode;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use crate::allocator;
use crate::case::{Case, Inputs};
use crate::finding::{Finding, Kind};
use crate::log::copy_folder;
use crate::options::Options;
use crate::rng::Rng;
use crate::targets::{self, Attack, Target};

/// The text and place of the last panic.
static LAST_PANIC: Mutex<String> = Mutex::new(String::new());

/// Returns the text and place of the last panic.
pub(crate) fn last_panic() -> String {
    LAST_PANIC
        .lock()
        .map_or_else(|_| String::new(), |text| text.clone())
}

/// Runs cases of `target` from `--first` on, `--cases` of them or without end.
pub(crate) fn run(target: &str, options: &Options) -> ExitCode {
    let Some(target) = targets::named(target) else {
        eprintln!("error: no target {target}");
        return ExitCode::from(2);
    };
    std::panic::set_hook(Box::new(|panic| {
        if let Ok(mut last) = LAST_PANIC.lock() {
            *last = panic.to_string();
        }
    }));
    let Some(folder) = options.folder.as_deref() else {
        eprintln!("error: a worker needs --folder, a folder of its own");
        return ExitCode::from(2);
    };
    let program = program(options);
    let mut attack = target.start(folder);
    let runner = Runner {
        target,
        seed: options.seed,
        folder,
        kept: options.kept.as_deref(),
        program: &program,
    };
    let mut report = Report {
        out: std::io::stdout(),
    };
    if !options.no_twins {
        for number in 0..attack.seeds() as u64 {
            report.line(&format!("twin {number}"));
            let (mut case, _) = runner.run(&mut *attack, number, Inputs::Sound);
            if !case.is_accepted {
                case.report(Kind::Refused, "the undamaged input was refused");
            }
            if !case.findings.is_empty() {
                runner.keep_inputs(number);
            }
            for finding in &case.findings {
                report.finding(number, finding);
            }
            attack.clean_up(folder);
        }
    }
    let last = options.cases.map(|count| options.first + count);
    let max_delay = target.max_delay();
    let mut number = options.first;
    while last.is_none_or(|last| number < last) {
        report.line(&format!("begin {number}"));
        let (case, time) = runner.run(&mut *attack, number, Inputs::Damaged);
        // Before the next run in this folder, that of the undamaged twin too.
        if !case.findings.is_empty() || time.counted() > max_delay {
            runner.keep_inputs(number);
        }
        attack.clean_up(folder);
        for finding in &case.findings {
            report.finding(number, finding);
        }
        if time.counted() > max_delay {
            let (_, twin) = runner.run(&mut *attack, number, Inputs::Sound);
            attack.clean_up(folder);
            let (time, twin) = (time.counted(), twin.counted());
            if time > twin + max_delay {
                let text = format!("{time:.1?}, and {twin:.1?} undamaged");
                report.finding(number, &Finding::new(Kind::Slow, text));
            }
        }
        report.line(&format!("end {number}"));
        number += 1;
    }
    ExitCode::SUCCESS
}

/// Returns the words that start the `seidel` command.
pub(crate) fn program(options: &Options) -> Vec<OsString> {
    match &options.program {
        Some(path) => vec![path.clone().into()],
        None => {
            let own = std::env::current_exe().unwrap_or_default();
            vec![own.into(), crate::AS_PROGRAM.into()]
        }
    }
}

/// The circumstances that all cases of a worker share.
struct Runner<'a> {
    target: &'static Target,
    seed: u64,
    folder: &'a Path,
    /// Folder of kept inputs of findings, a folder a case.
    kept: Option<&'a Path>,
    program: &'a [OsString],
}

impl<'a> Runner<'a> {
    /// Copies the inputs of a case to where the supervisor finds them.
    fn keep_inputs(&self, number: u64) {
        if let Some(kept) = self.kept {
            copy_folder(self.folder, &kept.join(number.to_string()));
        }
    }

    fn run(&self, attack: &mut dyn Attack, number: u64, inputs: Inputs) -> (Case<'a>, CaseTime) {
        let mut case = Case {
            number,
            rng: Rng::of_case(self.target.name, self.seed, number),
            inputs,
            folder: self.folder,
            program: self.program,
            is_accepted: false,
            findings: Vec::new(),
        };
        allocator::begin_case();
        let (started, before) = (Instant::now(), processor_time());
        let result = catch_unwind(AssertUnwindSafe(|| attack.run(&mut case)));
        let time = CaseTime {
            elapsed: started.elapsed(),
            of_processor: processor_time().saturating_sub(before),
        };
        if result.is_err() {
            case.report(Kind::Panic, last_panic());
        }
        (case, time)
    }
}

/// The time that a case took.
struct CaseTime {
    elapsed: Duration,
    /// That of the processor, in this process and those that it started.
    of_processor: Duration,
}

impl CaseTime {
    /// Returns the time of the processor, or the elapsed time of a case that waited for something: other programs on the machine
    /// delay a case that works.
    fn counted(&self) -> Duration {
        if self.of_processor < self.elapsed / 50 {
            self.elapsed
        } else {
            self.of_processor
        }
    }
}

/// Returns the processor time of this process and of its children that have ended.
fn processor_time() -> Duration {
    [libc::RUSAGE_SELF, libc::RUSAGE_CHILDREN]
        .into_iter()
        .map(|whose| {
            // SAFETY: zero is valid for numbers.
            let mut usage: libc::rusage = unsafe { std::mem::zeroed() };
            // SAFETY: the pointer is valid.
            unsafe { libc::getrusage(whose, &mut usage) };
            let time = |t: libc::timeval| {
                Duration::from_secs(t.tv_sec as u64) + Duration::from_micros(t.tv_usec as u64)
            };
            time(usage.ru_utime) + time(usage.ru_stime)
        })
        .sum()
}

/// The pipe to the supervisor.
struct Report {
    out: std::io::Stdout,
}

impl Report {
    /// Sends a line. A supervisor that has ended ends the worker.
    fn line(&mut self, line: &str) {
        let mut out = self.out.lock();
        if writeln!(out, "{line}").and_then(|()| out.flush()).is_err() {
            std::process::exit(0);
        }
    }

    fn finding(&mut self, number: u64, finding: &Finding) {
        self.line(&format!(
            "finding {number} {} {}",
            finding.kind.name(),
            finding.text
        ));
    }
}
