//! Raw photographs: DNG, FITS and PGM.

use seidel_image_io::photograph::{ColourFilter, PhotographOptions, read};

use super::{Attack, Sort, Target};
use crate::case::Case;
use crate::mutations::{BINARY, Mutation, TEXT, TIFF};
use crate::seeds::photographs;

pub(crate) static DNG: Target = Target {
    name: "dng",
    about: "DNG photographs, plain and lossless JPEG",
    sort: Sort::InProcess,
    weight: 1.0,
    start: |_| start(photographs::dng(), "in.dng", TIFF),
};

pub(crate) static FITS: Target = Target {
    name: "fits",
    about: "FITS photographs",
    sort: Sort::InProcess,
    weight: 0.5,
    start: |_| start(photographs::fits(), "in.fits", TEXT),
};

pub(crate) static PGM: Target = Target {
    name: "pgm",
    about: "PGM photographs",
    sort: Sort::InProcess,
    weight: 0.5,
    start: |_| start(photographs::pgm(), "in.pgm", TEXT),
};

struct Photographs {
    seeds: Vec<Vec<u8>>,
    name: &'static str,
    mutations: &'static [Mutation],
}

fn start(
    seeds: Vec<Vec<u8>>,
    name: &'static str,
    mutations: &'static [Mutation],
) -> Box<dyn Attack> {
    Box::new(Photographs {
        seeds,
        name,
        mutations,
    })
}

impl Attack for Photographs {
    fn seeds(&self) -> usize {
        self.seeds.len()
    }

    fn run(&mut self, case: &mut Case) {
        let mutations = if case.rng.once_in(3) {
            BINARY
        } else {
            self.mutations
        };
        let bytes = case.damaged(&self.seeds, mutations);
        let path = case.write(self.name, &bytes);
        let options = PhotographOptions {
            cfa: Some(ColourFilter::None).filter(|_| self.name != "in.dng"),
            ..PhotographOptions::default()
        };
        match read(&path, &options) {
            Ok(photograph) => {
                case.is_accepted = true;
                let pixels = photograph.width * photograph.height;
                assert!(
                    photograph.planes.iter().all(|p| p.len() == pixels),
                    "a plane of another size"
                );
            }
            Err(error) => case.check_error(&error.to_string(), self.name),
        }
    }
}
