//! Lens profiles and observation sets.

use std::path::Path;

use seidel_core::ObservationSet;
use seidel_image_io::observation_set;

use super::{HEIGHT, WIDTH};

/// Returns the profile of a lens drawn ray by ray, for the size of the pictures.
pub(crate) fn lens() -> String {
    let lens = seidel::demo::lens::lens(WIDTH as u32, HEIGHT as u32);
    lens.unwrap_or_else(|e| panic!("{e}")).to_json()
}

/// Returns that profile, and those of every kind as the first version of the format was written.
pub(crate) fn profiles() -> Vec<Vec<u8>> {
    let stored = [
        include_str!("../../../../tests/profiles/version-1-moments.json"),
        include_str!("../../../../tests/profiles/version-1-reduced.json"),
        include_str!("../../../../tests/profiles/version-1-designed.json"),
    ];
    let all = std::iter::once(lens()).chain(stored.map(str::to_owned));
    all.map(String::into_bytes).collect()
}

/// Writes an observation set of the lens with `count` PSFs into a folder.
pub(crate) fn write_set(folder: &Path, count: usize) -> ObservationSet {
    let lens = seidel::demo::lens::lens(WIDTH as u32, HEIGHT as u32);
    let set = lens.and_then(|lens| seidel::demo::observations::measured(&lens));
    let mut set = set.unwrap_or_else(|e| panic!("{e}"));
    set.observations.truncate(count);
    let written = observation_set::write(&set, folder);
    written.unwrap_or_else(|e| panic!("{e}"));
    set
}
