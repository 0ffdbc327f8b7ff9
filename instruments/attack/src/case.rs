//! One case: its random numbers, its folder, and the findings about it.

use std::fmt::Display;
use std::fs;
use std::path::{Path, PathBuf};

use crate::finding::{Finding, Kind};
use crate::mutations::Mutation;
use crate::rng::Rng;

/// Longest damaged input, bytes: memory beyond the bound is then the reader's.
const LONGEST_INPUT: usize = 4 << 20;

/// Longest input that is damaged further, bytes: mutations repeat parts of it hundreds of times.
const LONGEST_CHANGED: usize = 64 << 10;

/// The state of the inputs of a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Inputs {
    /// As the writers made them: the undamaged twin of a case.
    Sound,
    /// Damaged by mutations.
    Damaged,
}

/// One case of a target.
pub(crate) struct Case<'a> {
    pub(crate) number: u64,
    pub(crate) rng: Rng,
    pub(crate) inputs: Inputs,
    /// A folder of the worker, in which the case writes its inputs.
    pub(crate) folder: &'a Path,
    /// The words that start the `seidel` command.
    pub(crate) program: &'a [std::ffi::OsString],
    /// Whether the input was accepted.
    pub(crate) is_accepted: bool,
    pub(crate) findings: Vec<Finding>,
}

impl Case<'_> {
    /// Adds a finding.
    pub(crate) fn report(&mut self, kind: Kind, text: impl AsRef<str>) {
        self.findings.push(Finding::new(kind, text));
    }

    /// Returns the index of the seed of this case among `count`.
    pub(crate) fn seed_index(&self, count: usize) -> usize {
        (self.number % count.max(1) as u64) as usize
    }

    /// Returns the seed of this case, damaged by one to four mutations unless the case is an undamaged twin.
    pub(crate) fn damaged(&mut self, seeds: &[Vec<u8>], mutations: &[Mutation]) -> Vec<u8> {
        let bytes = seeds[self.seed_index(seeds.len())].clone();
        self.damage(bytes, seeds, mutations)
    }

    /// Damages `bytes` by one to four mutations, unless the case is an undamaged twin.
    pub(crate) fn damage(
        &mut self,
        mut bytes: Vec<u8>,
        others: &[Vec<u8>],
        mutations: &[Mutation],
    ) -> Vec<u8> {
        if self.inputs == Inputs::Damaged {
            let rounds = 1 + self.rng.below(4).min(self.rng.below(4));
            for _ in 0..rounds {
                let other = self.rng.pick(others).clone();
                let mutate = self.rng.pick(mutations);
                mutate(&mut bytes, &mut self.rng, &other);
                bytes.truncate(LONGEST_INPUT);
                if bytes.len() > LONGEST_CHANGED {
                    break;
                }
            }
        }
        bytes
    }

    /// Writes an input of the case and returns its path.
    pub(crate) fn write(&mut self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.folder.join(name);
        if let Err(error) = fs::write(&path, bytes) {
            panic!("the attack cannot write {}: {error}", path.display());
        }
        path
    }

    /// Notes the error of a reader, which must name the file at `path`.
    pub(crate) fn check_file_error(&mut self, error: &impl Display, path: &Path) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        self.check_error(&error.to_string(), &name);
    }

    /// Notes an error, which must contain `name` and a remedy.
    pub(crate) fn check_error(&mut self, error: &str, name: &str) {
        if !error.contains(name) {
            self.report(
                Kind::Message,
                format!("the error does not name {name}: {error}"),
            );
        }
        if !error.contains("; ") {
            self.report(Kind::Message, format!("the error has no remedy: {error}"));
        }
    }
}
