//! The fuzz targets. `cargo test` runs the corpus and some random inputs of each on stable Rust; coverage-guided runs are described
//! in CONTRIBUTING.md.

use std::fs;

use bolero::check;
use seidel_fuzz::{Target, temporary_folder};

/// Random inputs that `cargo test` adds to the corpus.
const ITERATIONS: usize = 200;

/// Longest input, bytes.
const LONGEST: usize = 64 << 10;

macro_rules! targets {
    ($($name:ident)*) => {
        $(#[test]
        fn $name() {
            let target = Target::named(stringify!($name));
            let folder = temporary_folder();
            target.prepare(folder.path());
            let path = folder.path().join(target.file);
            check!()
                .with_iterations(ITERATIONS)
                .with_max_len(LONGEST)
                .for_each(|bytes: &[u8]| {
                    let written = fs::write(&path, bytes);
                    written.unwrap_or_else(|e| panic!("{}: {e}", path.display()));
                    (target.read)(&path);
                });
        })*

        #[test]
        fn every_target_is_tested() {
            let tested = [$(stringify!($name)),*];
            let names = seidel_fuzz::ALL.iter().map(|target| target.name);
            assert!(names.eq(tested));
        }
    };
}

targets! {
    exr png tiff dpx hdr jpeg dng fits pgm profile manifest animation frames patterns config cube spi1d
}
