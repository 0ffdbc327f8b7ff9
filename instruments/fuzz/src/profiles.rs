//! Lens profiles and manifests of observation sets.

use std::path::Path;

use seidel_image_io::observation_set;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::field::{Frame, ImagePoint};
use seidel_optics::observations::{Observation, ObservationSet};
use seidel_optics::tile::Tile;

use crate::shared::read;

/// The stored profiles: by moments, by rays, with effects.
pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/profiles");
    ["moments", "reduced", "designed"]
        .map(|kind| read(&folder.join(format!("version-1-{kind}.json"))))
        .into()
}

/// Writes an observation set to `set` in the folder and returns its manifest.
pub(crate) fn manifests(folder: &Path) -> Vec<Vec<u8>> {
    let set = folder.join("set");
    let frame = Frame::new(64, 48, None).unwrap_or_else(|e| panic!("{e}"));
    let observations = [(10.0, 12.0), (40.0, 30.0)].map(|(x, y)| {
        let samples = (0..49).map(|k| if k == 24 { 1.0 } else { 0.01 }).collect();
        let tile = Tile::new(7, 7, samples).unwrap_or_else(|e| panic!("{e}"));
        let distance = ObjectDistance::metres(2.0).unwrap_or_else(|e| panic!("{e}"));
        Observation::new("", ImagePoint::new(x, y), distance, vec![tile])
    });
    let set_of = ObservationSet::new(frame, vec!["Y".to_owned()], observations.into());
    let written = observation_set::write(&set_of, &set);
    written.unwrap_or_else(|e| panic!("{e}"));
    vec![read(&set.join("manifest.json"))]
}
