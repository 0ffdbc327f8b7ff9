//! Seeds and checks of the fuzz targets, which are `tests/readers.rs`. The seeds are those of the attack, `instruments/attack`.
#![forbid(unsafe_code)]

mod profiles;
mod readers;
mod shared;

use std::fs;
use std::path::{Path, PathBuf};

use shared::{exr, photographs, raster, texts};

/// A reader under attack: the file that it reads, its seeds and what is checked.
pub struct Target {
    /// Name of the target: that of its test, and of the folder of its corpus.
    pub name: &'static str,
    /// Name of the file that holds the input, within a folder.
    pub file: &'static str,
    /// Makes the seeds; the folder is for temporary files.
    pub seeds: fn(&Path) -> Vec<Vec<u8>>,
    /// Reads the file and panics where a rule is broken.
    pub read: fn(&Path),
}

/// Every target.
pub const ALL: &[Target] = &[
    target("exr", "in.exr", exr::files, readers::picture),
    target("png", "in.png", raster::png, readers::picture),
    target("tiff", "in.tif", raster::tiff, readers::picture),
    target("dpx", "in.dpx", raster::dpx, readers::picture),
    target("hdr", "in.hdr", raster::hdr, readers::picture),
    target("jpeg", "in.jpg", |_| raster::jpeg(), readers::picture),
    target("dng", "in.dng", |_| photographs::dng(), readers::photograph),
    target(
        "fits",
        "in.fits",
        |_| photographs::fits(),
        readers::photograph,
    ),
    target("pgm", "in.pgm", |_| photographs::pgm(), readers::photograph),
    target(
        "profile",
        "lens.json",
        |_| profiles::seeds(),
        readers::profile,
    ),
    target(
        "manifest",
        "set/manifest.json",
        profiles::manifests,
        readers::manifest,
    ),
    target(
        "animation",
        "table.csv",
        |_| texts::animations(),
        readers::animation,
    ),
    target(
        "frames",
        "frames.txt",
        |_| texts::frame_lists(),
        readers::frames,
    ),
    target(
        "patterns",
        "pattern.txt",
        |_| texts::patterns(),
        readers::pattern,
    ),
    target(
        "config",
        "config.ocio",
        |_| texts::configs(),
        readers::config,
    ),
    target("cube", "table.cube", |_| texts::cubes(), readers::table),
    target("spi1d", "table.spi1d", |_| texts::spi1d(), readers::table),
];

const fn target(
    name: &'static str,
    file: &'static str,
    seeds: fn(&Path) -> Vec<Vec<u8>>,
    read: fn(&Path),
) -> Target {
    Target {
        name,
        file,
        seeds,
        read,
    }
}

impl Target {
    /// Returns the target of this name.
    pub fn named(name: &str) -> &'static Self {
        let found = ALL.iter().find(|target| target.name == name);
        found.unwrap_or_else(|| panic!("no target {name}"))
    }

    /// Prepares a folder for the inputs of the target, and writes the seeds to its corpus, where the fuzzer looks for them.
    pub fn prepare(&self, folder: &Path) {
        let corpus = corpus(self.name);
        let made = fs::create_dir_all(&corpus);
        made.unwrap_or_else(|e| panic!("{}: {e}", corpus.display()));
        for (k, bytes) in (self.seeds)(folder).iter().enumerate() {
            raster::write(&corpus.join(format!("seed-{k}")), bytes);
        }
    }
}

/// The folder of the inputs of a target.
fn corpus(name: &str) -> PathBuf {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/__fuzz__");
    tests.join(name).join("corpus")
}

/// A folder for the files of a target, in memory where the system has such a place.
pub fn temporary_folder() -> tempfile::TempDir {
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() {
        tempfile::tempdir_in(memory)
    } else {
        tempfile::tempdir()
    };
    folder.unwrap_or_else(|e| panic!("no temporary folder: {e}"))
}
