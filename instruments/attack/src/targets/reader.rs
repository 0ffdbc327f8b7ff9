//! Readers of files, attacked with damaged files here and with those of a fuzzer in `fuzz`.

use std::path::Path;

use super::Attack;
use crate::case::Case;
use crate::mutations::Mutation;
use crate::rng::Rng;

/// A reader of files.
pub(crate) struct Reader {
    /// Path of the file within the folder of the cases.
    pub(crate) file: &'static str,
    /// Makes the seeds, and what the reader needs beside the file, in the folder of the cases.
    pub(crate) seeds: fn(&Path) -> Vec<Vec<u8>>,
    /// Chooses the mutations of a case.
    pub(crate) mutations: fn(&mut Rng) -> &'static [Mutation],
    /// Reads the file and reports breaches of the rules.
    pub(crate) read: fn(&mut Case, &Path),
}

/// The attack on a reader.
pub(super) struct DamagedFiles {
    reader: &'static Reader,
    seeds: Vec<Vec<u8>>,
}

impl DamagedFiles {
    pub(super) fn new(reader: &'static Reader, folder: &Path) -> Self {
        Self {
            reader,
            seeds: (reader.seeds)(folder),
        }
    }
}

impl Attack for DamagedFiles {
    fn seeds(&self) -> usize {
        self.seeds.len()
    }

    fn run(&mut self, case: &mut Case) {
        let mutations = (self.reader.mutations)(&mut case.rng);
        let bytes = case.damaged(&self.seeds, mutations);
        let path = case.write(self.reader.file, &bytes);
        (self.reader.read)(case, &path);
    }
}
