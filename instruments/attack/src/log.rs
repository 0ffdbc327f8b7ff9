//! The log: runs and findings of all attacks so far.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::finding::{Finding, Kind};
use crate::targets::{self, Target};

/// Findings of one kind and target that are stored with their inputs. More are counted only.
const MAX_STORED: usize = 20;

/// The runs of a target.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Totals {
    /// Cases that ended, and those that ended their worker.
    pub(crate) runs: u64,
    /// The number of the first case that no attack had, by seed.
    pub(crate) next: BTreeMap<u64, u64>,
    /// The number of findings by kind.
    pub(crate) findings: BTreeMap<Kind, u64>,
}

/// A finding with what runs it again.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct StoredFinding {
    pub(crate) target: String,
    pub(crate) seed: u64,
    pub(crate) number: u64,
    #[serde(flatten)]
    pub(crate) finding: Finding,
}

/// The log file.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Log {
    pub(crate) targets: BTreeMap<String, Totals>,
    pub(crate) findings: Vec<StoredFinding>,
    #[serde(skip)]
    path: PathBuf,
}

impl Log {
    /// Reads the log at `path`, or begins one.
    pub(crate) fn open(path: &Path) -> Result<Self, String> {
        let mut log = match fs::read(path) {
            Ok(bytes) => serde_json::from_slice(&bytes)
                .map_err(|e| format!("{}: is no log ({e}); give another file", path.display()))?,
            Err(_) => Self::default(),
        };
        log.path = path.to_path_buf();
        Ok(log)
    }

    /// Writes the log, whole or not at all.
    pub(crate) fn save(&self) -> Result<(), String> {
        let failed = |e: &dyn std::fmt::Display| format!("{}: {e}", self.path.display());
        if let Some(folder) = self.path.parent() {
            fs::create_dir_all(folder).map_err(|e| failed(&e))?;
        }
        seidel_image_io::json::write_json(&self.path, self).map_err(|e| failed(&e))
    }

    /// Returns the runs of a target.
    pub(crate) fn totals(&mut self, target: &str) -> &mut Totals {
        self.targets.entry(target.to_owned()).or_default()
    }

    /// Adds a finding, and copies the folder of its case beside the log.
    pub(crate) fn add(&mut self, found: StoredFinding, folder: &Path) {
        let kind = found.finding.kind;
        *self.totals(&found.target).findings.entry(kind).or_default() += 1;
        let same = |f: &&StoredFinding| f.target == found.target && f.finding.kind == kind;
        if self.findings.iter().filter(same).count() < MAX_STORED {
            let to = self.folder_of(&found.target, found.number);
            copy_folder(folder, &to);
            let words = format!(
                "cargo xtask attack --seed {} --case {}:{}\n{}: {}\n",
                found.seed,
                found.target,
                found.number,
                kind.name(),
                found.finding.text
            );
            // Best effort: the log has the same.
            let _ = fs::write(to.join("FINDING"), words);
            self.findings.push(found);
        }
    }

    /// Returns the folder of the inputs of a case.
    pub(crate) fn folder_of(&self, target: &str, number: u64) -> PathBuf {
        let beside = self.path.parent().unwrap_or(Path::new(""));
        beside.join("findings").join(format!("{target}-{number}"))
    }

    /// Keeps the inputs of a case without a finding.
    pub(crate) fn keep(&self, folder: &Path, to: &Path) {
        copy_folder(folder, to);
    }

    /// Returns the table of all runs in Markdown.
    pub(crate) fn summary(&self) -> String {
        let mut text = "| target | runs | of these whole program |".to_owned();
        for kind in Kind::ALL {
            let _ = write!(text, " {} |", kind.name());
        }
        let _ = write!(
            text,
            "\n| --- | --- | --- |{}\n",
            " --- |".repeat(Kind::ALL.len())
        );
        let mut sum = vec![0; 2 + Kind::ALL.len()];
        for (name, totals) in &self.targets {
            let is_whole = targets::named(name).is_some_and(Target::is_program);
            let mut row = vec![totals.runs, if is_whole { totals.runs } else { 0 }];
            row.extend(
                Kind::ALL.map(|kind| totals.findings.get(&kind).copied().unwrap_or_default()),
            );
            for (sum, value) in sum.iter_mut().zip(&row) {
                *sum += value;
            }
            text += &line(name, &row);
        }
        text + &line("all", &sum)
    }
}

fn line(name: &str, row: &[u64]) -> String {
    let cells: Vec<String> = row.iter().map(u64::to_string).collect();
    format!("| {name} | {} |\n", cells.join(" | "))
}

/// Copies regular files of a folder and of its folders. Best effort: pipes, devices and links are left out.
pub(crate) fn copy_folder(from: &Path, to: &Path) {
    let _ = fs::create_dir_all(to);
    let Ok(entries) = fs::read_dir(from) else {
        return;
    };
    for entry in entries.flatten() {
        let target = to.join(entry.file_name());
        match entry.file_type() {
            Ok(kind) if kind.is_dir() => copy_folder(&entry.path(), &target),
            Ok(kind) if kind.is_file() => {
                let _ = fs::copy(entry.path(), target);
            }
            _ => {}
        }
    }
}
