//! Measures every job of the product beside the simplest program that could do it, and writes the figures as one page:
//! `cargo xtask yardsticks`.

#![forbid(unsafe_code)]

mod depth;
mod lens;
mod page;
mod picture;
mod removal;
mod wiener;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use seidel_core::Result;

use page::Job;

/// Measures every job of Seidel beside the simplest program that could do it.
#[derive(Parser)]
struct Options {
    /// Few and small cases, for seconds instead of minutes.
    #[arg(long)]
    quick: bool,
    /// The Markdown page to write; it is printed without this option.
    #[arg(long, value_name = "FILE")]
    to: Option<PathBuf>,
}

/// The number of cases that are measured.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Extent {
    /// The whole range that users have: minutes.
    Full,
    /// Few and small cases: seconds.
    Quick,
}

fn main() -> ExitCode {
    let options = Options::parse();
    let extent = if options.quick {
        Extent::Quick
    } else {
        Extent::Full
    };
    let jobs = match jobs(extent) {
        Ok(jobs) => jobs,
        Err(error) => {
            eprintln!("error: {error}");
            return ExitCode::from(2);
        }
    };
    let text = page::page(&jobs, extent);
    let written = match &options.to {
        Some(path) => std::fs::write(path, text).map_err(|e| format!("{}: {e}", path.display())),
        None => {
            print!("{text}");
            Ok(())
        }
    };
    if let Err(error) = written {
        eprintln!("error: {error}");
        return ExitCode::from(2);
    }
    // A fault of the product, not of this program.
    let behind: Vec<&str> = (jobs.iter().filter(|job| job.worst_lead() < 0.0))
        .map(|job| job.title)
        .collect();
    if !behind.is_empty() {
        eprintln!(
            "behind the simplest program in a case of: {}",
            behind.join(", ")
        );
        return ExitCode::from(1);
    }
    ExitCode::SUCCESS
}

/// Measures all jobs.
fn jobs(extent: Extent) -> Result<Vec<Job>> {
    Ok(vec![
        removal::job(extent)?,
        depth::job(extent)?,
        lens::job(extent)?,
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_job_is_behind_the_simplest_program() {
        let jobs = jobs(Extent::Quick).expect("sound cases");
        let text = page::page(&jobs, Extent::Quick);
        assert!(
            jobs.iter()
                .all(|job| !job.cases.is_empty() && job.worst_lead() >= 0.0),
            "{text}"
        );
    }
}
