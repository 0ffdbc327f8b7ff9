//! `seidel diagnose`: which effect a lens lacks, and how far the gap closes once it is added.

mod output;
mod pair;
pub mod self_test;

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use clap::Args;
use rayon::ThreadPool;
use seidel_core::diagnose::{Diagnosis, Progress, Settings, diagnose};
use seidel_core::effects;
use seidel_core::observations::ObservationSet;
use seidel_core::profile::{LensDescription, LensProfile};

use super::{CommandError, read_lens, short_name};
use crate::Console;
use crate::report::{self, Subject};
use output::Output;
use pair::PairArgs;
use seidel_image_io::error::FileError;
use seidel_image_io::observation_set::{self as manifest, ReadOptions};
use self_test::SelfTestArgs;

/// Options of `seidel diagnose`.
#[derive(Debug, Args)]
pub struct DiagnoseArgs {
    /// The lens profile: one known ray by ray, as fit --model reduced or extended makes it
    #[arg(long, required_unless_present_any = ["schema", "self_test"])]
    lens: Option<PathBuf>,
    /// The observation set to hold it against
    #[arg(value_name = "OBS", required_unless_present_any = ["schema", "reference", "self_test"], conflicts_with = "reference")]
    observations: Option<PathBuf>,
    #[command(flatten)]
    pair: PairArgs,
    #[command(flatten)]
    self_test: SelfTestArgs,
    /// Folder to write report.json, report.html and corrected.json to; estimated PSFs go to its folder
    /// psf
    #[arg(long, value_name = "DIR", required_unless_present_any = ["schema", "self_test"])]
    out: Option<PathBuf>,
    /// Try these effects only, by identifier; all that there are if left out
    #[arg(long, value_name = "EFFECTS", value_delimiter = ',')]
    only: Vec<String>,
    /// Try effects one by one, not in pairs: faster
    #[arg(long)]
    no_pairs: bool,
    /// Threads to use; all cores if left out
    #[arg(long)]
    threads: Option<usize>,
    /// Print report.json (of a self-test self-test.json) instead of a summary
    #[arg(long)]
    json: bool,
    /// Print the JSON schema of report.json, and do nothing else
    #[arg(long, exclusive = true)]
    schema: bool,
}

pub(super) fn run(args: &DiagnoseArgs, console: &mut Console) -> Result<(), CommandError> {
    if args.schema {
        console.say(report::schema());
        return Ok(());
    }
    for id in &args.only {
        effects::by_id(id)?;
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(args.threads.unwrap_or(0))
        .build()
        .map_err(|e| CommandError::Usage(format!("--threads: {e}")))?;
    if let Some(count) = args.self_test.count() {
        let told = (args.out.as_deref(), args.json);
        return args.self_test.run(count, told, &pool, console);
    }
    let (Some(lens), Some(out)) = (&args.lens, &args.out) else {
        return Err(CommandError::Usage("give --lens and --out".to_owned()));
    };
    let output = Output::checked(out, lens, args.pair.reference.is_some())?;
    let profile = read_lens(lens)?;
    needs_rays(&profile, lens)?;
    let seen = args.read((&profile, lens), &pool, console)?;
    let mut found = args
        .diagnose(&profile, &seen.set, &pool, console)
        .map_err(|e| FileError::from_core(&seen.path, e))?;
    found.remarks.extend(seen.remarks);
    let subject = Subject::new(short_name(lens), seen.name, &seen.set);
    let json = report::json(&found, &subject)?;
    let estimated = seen.estimated.then_some(&seen.set);
    output.write(&found, &subject, &json, estimated)?;
    if args.json {
        console.say(json.trim_end());
    } else {
        summary(&found, out, console);
    }
    for remark in &found.remarks {
        console.remark(remark);
    }
    Ok(())
}

/// What a lens is held against.
struct Seen {
    set: ObservationSet,
    /// The file or folder that messages name.
    path: PathBuf,
    /// What the report calls it.
    name: String,
    /// Whether the set was estimated and stands nowhere yet.
    estimated: bool,
    remarks: Vec<String>,
}

impl DiagnoseArgs {
    /// The observations: a set, or what a pair of pictures says.
    fn read(
        &self,
        lens: (&LensProfile, &Path),
        pool: &ThreadPool,
        console: &Console,
    ) -> Result<Seen, CommandError> {
        if let (Some(sharp), Some(plate)) = (&self.pair.reference, &self.pair.observed) {
            let found = self.pair.estimate((sharp, plate), lens, pool, console)?;
            let (count, name) = (found.set.observations.len(), short_name(plate));
            let mut remarks = vec![format!(
                "{count} PSFs were estimated from {} and {name}; nobody measured them",
                short_name(sharp)
            )];
            remarks.extend(found.remarks());
            return Ok(Seen {
                set: found.set,
                path: plate.clone(),
                name,
                estimated: true,
                remarks,
            });
        }
        let Some(path) = &self.observations else {
            return Err(CommandError::Usage(
                "give OBS, or --reference and --observed".to_owned(),
            ));
        };
        let set = manifest::read(path, ReadOptions::default())?.set;
        same_channels(lens.0, &set, path)?;
        Ok(Seen {
            set,
            path: path.clone(),
            name: short_name(path),
            estimated: false,
            remarks: Vec::new(),
        })
    }

    fn diagnose(
        &self,
        lens: &LensProfile,
        set: &ObservationSet,
        pool: &ThreadPool,
        console: &Console,
    ) -> seidel_core::Result<Diagnosis> {
        let settings = Settings {
            library: self.only.clone(),
            pairs: !self.no_pairs,
        };
        let bar = console.progress("diagnosing");
        let stop = AtomicBool::new(false);
        let progress = Progress {
            report: &|share| bar.set(share),
            stop: &stop,
        };
        pool.install(|| diagnose(lens, set, &settings, &progress))
    }
}

/// Refuses a lens described by moments before anything long is begun.
fn needs_rays(lens: &LensProfile, path: &Path) -> Result<(), FileError> {
    match lens.description {
        LensDescription::Pupil(_) => Ok(()),
        LensDescription::Moments(_) => Err(FileError::new(
            path,
            "kind",
            "is `moments`, to which no effect can be added",
            "fit the lens with `seidel fit --model reduced` or `extended`",
        )),
    }
}

/// Refuses a set that has a channel the lens has not.
fn same_channels(lens: &LensProfile, set: &ObservationSet, path: &Path) -> Result<(), FileError> {
    let known = lens.channel_names();
    let strange: Vec<&str> = set
        .channels
        .iter()
        .map(String::as_str)
        .filter(|name| !known.contains(name))
        .collect();
    if strange.is_empty() {
        return Ok(());
    }
    Err(FileError::new(
        path,
        format!("channel {}", strange.join(", ")),
        format!("is not in the lens, which has {}", known.join(", ")),
        "fit the lens to sets with the same channels",
    ))
}

/// The answer in five lines.
fn summary(found: &Diagnosis, out: &Path, console: &mut Console) {
    let gap = &found.gap;
    let added = match found.added.as_slice() {
        [] => "nothing".to_owned(),
        ids => ids.join(", "),
    };
    console.say(format!("verdict: {}", found.verdict.id()));
    console.say(format!("added: {added}"));
    console.say(format!(
        "gap: {:.4} before, {:.4} after, {:.4} by noise alone; closed {:.1} % ({:.1} to {:.1} %)",
        gap.before,
        gap.after,
        gap.noise_floor,
        100.0 * gap.closed,
        100.0 * gap.closed_ci95.0,
        100.0 * gap.closed_ci95.1
    ));
    console.say(format!("next capture: {}", found.next_capture));
    console.say(format!(
        "wrote {} ({})",
        out.display(),
        output::NAMES.join(", ")
    ));
}
