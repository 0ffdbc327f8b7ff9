//! Manifests of observation sets.

use std::fs;
use std::path::Path;

use seidel_image_io::observation_set::{ReadOptions, read};

use super::{Attack, Sort, Target};
use crate::case::Case;
use crate::mutations::{JSON, TEXT};
use crate::seeds::{self, lenses};

const NAME: &str = "manifest.json";

pub(crate) static TARGET: Target = Target {
    name: "manifest",
    about: "manifests of observation sets",
    sort: Sort::InProcess,
    weight: 1.0,
    start: |folder| Box::new(Manifests::new(folder)),
};

struct Manifests {
    seeds: Vec<Vec<u8>>,
}

impl Manifests {
    fn new(folder: &Path) -> Self {
        let set = folder.join("set");
        lenses::write_set(&set, 3);
        Self {
            seeds: vec![seeds::read(&set.join(NAME))],
        }
    }
}

impl Attack for Manifests {
    fn seeds(&self) -> usize {
        self.seeds.len()
    }

    fn run(&mut self, case: &mut Case) {
        let mutations = if case.rng.once_in(4) { TEXT } else { JSON };
        let bytes = case.damaged(&self.seeds, mutations);
        let set = case.folder.join("set");
        if fs::write(set.join(NAME), bytes).is_err() {
            panic!("the attack cannot write {}", set.display());
        }
        let skip_bad = case.rng.once_in(2);
        match read(&set, ReadOptions { skip_bad }) {
            Ok(loaded) => {
                case.is_accepted = true;
                std::hint::black_box(loaded.set.observations.len() + loaded.skipped.len());
            }
            Err(error) => case.check_error(&error.to_string(), NAME),
        }
    }
}
