//! Images of formats with a single picture: read in every way, written again and compared.

mod round_trip;

use std::path::{Path, PathBuf};

use seidel_image_io::description::Description;
use seidel_image_io::image_channel::ImageChannel;
use seidel_image_io::plate::{Plate, PlateOptions};
use seidel_image_io::raster::RasterImage;
use seidel_image_io::samples::Encoding;

use super::{Attack, Sort, Target};
use crate::case::Case;
use crate::mutations::{BINARY, Mutation, PNG as PNG_MUTATIONS, TIFF as TIFF_MUTATIONS};
use crate::seeds::raster;

pub(crate) use round_trip::check_round_trip;

pub(crate) static PNG: Target = Target {
    name: "png",
    about: "PNG images",
    sort: Sort::InProcess,
    weight: 1.0,
    start: |folder| start(raster::png(folder), "in.png", PNG_MUTATIONS),
};

pub(crate) static TIFF: Target = Target {
    name: "tiff",
    about: "TIFF images",
    sort: Sort::InProcess,
    weight: 1.0,
    start: |folder| start(raster::tiff(folder), "in.tif", TIFF_MUTATIONS),
};

pub(crate) static DPX: Target = Target {
    name: "dpx",
    about: "DPX images",
    sort: Sort::InProcess,
    weight: 1.0,
    start: |folder| start(raster::dpx(folder), "in.dpx", BINARY),
};

pub(crate) static HDR: Target = Target {
    name: "hdr",
    about: "Radiance HDR images",
    sort: Sort::InProcess,
    weight: 1.0,
    start: |folder| start(raster::hdr(folder), "in.hdr", BINARY),
};

pub(crate) static JPEG: Target = Target {
    name: "jpeg",
    about: "JPEG images",
    sort: Sort::InProcess,
    weight: 1.0,
    start: |_| start(raster::jpeg(), "in.jpg", BINARY),
};

struct Images {
    seeds: Vec<Vec<u8>>,
    name: &'static str,
    mutations: &'static [Mutation],
}

fn start(
    seeds: Vec<Vec<u8>>,
    name: &'static str,
    mutations: &'static [Mutation],
) -> Box<dyn Attack> {
    Box::new(Images {
        seeds,
        name,
        mutations,
    })
}

impl Attack for Images {
    fn seeds(&self) -> usize {
        self.seeds.len()
    }

    fn run(&mut self, case: &mut Case) {
        let bytes = case.damaged(&self.seeds, self.mutations);
        let path = case.write(self.name, &bytes);
        read_picture(case, &path, self.name);
        if case.rng.once_in(4) {
            read_otherwise(case, &path, self.name);
        }
    }
}

/// Reads a plate, writes it again in its own format and compares.
pub(crate) fn read_picture(case: &mut Case, path: &Path, name: &str) {
    let options = PlateOptions {
        encoding: Some(Encoding::Srgb).filter(|_| !name.ends_with(".exr")),
        ..PlateOptions::default()
    };
    match Plate::open(path, &options) {
        Ok(plate) => {
            case.is_accepted = true;
            let extension = path.extension().unwrap_or_default();
            let out: PathBuf = case.folder.join("out").with_extension(extension);
            if plate.format().is_writable() {
                check_round_trip(case, &plate, &out, &options);
            }
        }
        Err(error) => case.check_error(&error.to_string(), name),
    }
}

/// Reads a file by the readers of other inputs.
pub(crate) fn read_otherwise(case: &mut Case, path: &Path, name: &str) {
    let errors = [
        ImageChannel::read_depth(path, None).err(),
        ImageChannel::read_matte(path, None).err(),
        Description::read(path).err(),
        RasterImage::open(path).err(),
    ];
    for error in errors.into_iter().flatten() {
        case.check_error(&error.to_string(), name);
    }
}
