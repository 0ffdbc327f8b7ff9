//! Manifests of observation sets.

use std::path::Path;

use seidel_image_io::observation_set::{self, ReadOptions};

use super::reader::Reader;
use super::{Method, Target};
use crate::case::Case;
use crate::mutations::{JSON, TEXT};
use crate::seeds::{self, lenses};

pub(crate) static TARGET: Target = Target {
    name: "manifest",
    about: "manifests of observation sets",
    weight: 1.0,
    method: Method::Reader(Reader {
        file: "set/manifest.json",
        seeds: manifests,
        mutations: |rng| if rng.once_in(4) { TEXT } else { JSON },
        read,
    }),
};

fn manifests(folder: &Path) -> Vec<Vec<u8>> {
    let set = folder.join("set");
    lenses::write_set(&set, 3);
    vec![seeds::read(&set.join("manifest.json"))]
}

fn read(case: &mut Case, path: &Path) {
    let skip_bad = case.rng.once_in(2);
    let set = path.parent().unwrap_or(path);
    match observation_set::read(set, ReadOptions { skip_bad }) {
        Ok(loaded) => {
            case.is_accepted = true;
            std::hint::black_box(loaded.set.observations.len() + loaded.skipped.len());
        }
        Err(error) => case.check_file_error(&error, path),
    }
}
