//! The readers under a fuzzer, `instruments/fuzz`.

use std::path::Path;

use tempfile::TempDir;

use crate::allocator;
use crate::case::{Case, Inputs};
use crate::rng::Rng;
use crate::targets::reader::Reader;
use crate::targets::{self, Method};

/// A reader with a folder for its files.
pub struct FuzzTarget {
    /// Name of the target.
    pub name: &'static str,
    /// Valid inputs.
    pub seeds: Vec<Vec<u8>>,
    reader: &'static Reader,
    folder: TempDir,
}

impl FuzzTarget {
    /// Returns every target, or the one called `chosen`.
    pub fn all(chosen: Option<&str>) -> impl Iterator<Item = Self> {
        let is_chosen = move |name| chosen.is_none_or(|chosen| chosen == name);
        let targets = targets::ALL
            .iter()
            .filter(move |target| is_chosen(target.name));
        targets.filter_map(|target| match &target.method {
            Method::Reader(reader) => Some(Self::new(target.name, reader)),
            _ => None,
        })
    }

    fn new(name: &'static str, reader: &'static Reader) -> Self {
        // In memory where the system has such a place.
        let memory = Path::new("/dev/shm");
        let folder = if memory.is_dir() {
            tempfile::tempdir_in(memory)
        } else {
            tempfile::tempdir()
        };
        let folder = folder.unwrap_or_else(|e| panic!("no temporary folder: {e}"));
        Self {
            name,
            seeds: (reader.seeds)(folder.path()),
            reader,
            folder,
        }
    }

    /// Reads `bytes`.
    ///
    /// # Panics
    /// A broken rule.
    pub fn read(&self, bytes: &[u8]) {
        // Choices of the reader follow from its input, so that a finding repeats.
        let number = crc32fast::hash(bytes).into();
        let mut case = Case {
            number,
            rng: Rng::of_case(self.name, 0, number),
            inputs: Inputs::Damaged,
            folder: self.folder.path(),
            program: &[],
            is_accepted: false,
            findings: Vec::new(),
        };
        let path = case.write(self.reader.file, bytes);
        allocator::begin_case();
        (self.reader.read)(&mut case, &path);
        assert!(
            case.findings.is_empty(),
            "{}: {:?}",
            self.name,
            case.findings
        );
    }
}
