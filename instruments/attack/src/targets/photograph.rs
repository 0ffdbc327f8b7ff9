//! Raw photographs: DNG, FITS and PGM.

use std::ffi::OsStr;
use std::path::Path;

use seidel_image_io::photograph::{self, ColourFilter, PhotographOptions};

use super::reader::Reader;
use super::{Method, Target};
use crate::case::Case;
use crate::mutations::{BINARY, TEXT, TIFF};
use crate::seeds::photographs;

pub(crate) static DNG: Target = Target {
    name: "dng",
    about: "DNG photographs, plain and lossless JPEG",
    weight: 1.0,
    method: Method::Reader(Reader {
        file: "in.dng",
        seeds: |_| photographs::dng(),
        mutations: |rng| if rng.once_in(3) { BINARY } else { TIFF },
        read,
    }),
};

pub(crate) static FITS: Target = Target {
    name: "fits",
    about: "FITS photographs",
    weight: 0.5,
    method: Method::Reader(Reader {
        file: "in.fits",
        seeds: |_| photographs::fits(),
        mutations: |rng| if rng.once_in(3) { BINARY } else { TEXT },
        read,
    }),
};

pub(crate) static PGM: Target = Target {
    name: "pgm",
    about: "PGM photographs",
    weight: 0.5,
    method: Method::Reader(Reader {
        file: "in.pgm",
        seeds: |_| photographs::pgm(),
        mutations: |rng| if rng.once_in(3) { BINARY } else { TEXT },
        read,
    }),
};

fn read(case: &mut Case, path: &Path) {
    let is_raw = path.extension() == Some(OsStr::new("dng"));
    let options = PhotographOptions {
        cfa: (!is_raw).then_some(ColourFilter::None),
        ..PhotographOptions::default()
    };
    match photograph::read(path, &options) {
        Ok(photograph) => {
            case.is_accepted = true;
            let pixels = photograph.width * photograph.height;
            assert!(
                photograph.planes.iter().all(|p| p.len() == pixels),
                "a plane of another size"
            );
        }
        Err(error) => case.check_file_error(&error, path),
    }
}
