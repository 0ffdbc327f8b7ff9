//! Images of formats with a single picture: read in every way, written again and compared.

mod round_trip;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use seidel_image_io::description::Description;
use seidel_image_io::formats::exr::DepthOwner;
use seidel_image_io::image_channel::ImageChannel;
use seidel_image_io::plate::{PlateFile, PlateOptions};
use seidel_image_io::raster::RasterImage;
use seidel_image_io::samples::Encoding;

use super::reader::Reader;
use super::{Method, Target};
use crate::case::Case;
use crate::mutations::{BINARY, PNG as PNG_MUTATIONS, TIFF as TIFF_MUTATIONS};
use crate::seeds::raster;

pub(crate) use round_trip::check_round_trip;

pub(crate) static PNG: Target = Target {
    name: "png",
    about: "PNG images",
    weight: 1.0,
    method: Method::Reader(Reader {
        file: "in.png",
        seeds: raster::png,
        mutations: |_| PNG_MUTATIONS,
        read,
    }),
};

pub(crate) static TIFF: Target = Target {
    name: "tiff",
    about: "TIFF images",
    weight: 1.0,
    method: Method::Reader(Reader {
        file: "in.tif",
        seeds: raster::tiff,
        mutations: |_| TIFF_MUTATIONS,
        read,
    }),
};

pub(crate) static DPX: Target = Target {
    name: "dpx",
    about: "DPX images",
    weight: 1.0,
    method: Method::Reader(Reader {
        file: "in.dpx",
        seeds: raster::dpx,
        mutations: |_| BINARY,
        read,
    }),
};

pub(crate) static HDR: Target = Target {
    name: "hdr",
    about: "Radiance HDR images",
    weight: 1.0,
    method: Method::Reader(Reader {
        file: "in.hdr",
        seeds: raster::hdr,
        mutations: |_| BINARY,
        read,
    }),
};

pub(crate) static JPEG: Target = Target {
    name: "jpeg",
    about: "JPEG images",
    weight: 1.0,
    method: Method::Reader(Reader {
        file: "in.jpg",
        seeds: |_| raster::jpeg(),
        mutations: |_| BINARY,
        read,
    }),
};

fn read(case: &mut Case, path: &Path) {
    read_picture(case, path);
    if case.rng.once_in(4) {
        read_otherwise(case, path);
    }
}

/// Reads a plate, writes it again in its own format and compares.
pub(crate) fn read_picture(case: &mut Case, path: &Path) {
    let is_exr = path.extension() == Some(OsStr::new("exr"));
    let options = PlateOptions {
        encoding: (!is_exr).then_some(Encoding::Srgb),
        ..PlateOptions::default()
    };
    match PlateFile::open(path, &options) {
        Ok(plate) => {
            case.is_accepted = true;
            let extension = path.extension().unwrap_or_default();
            let out: PathBuf = case.folder.join("out").with_extension(extension);
            if plate.format().is_writable() {
                check_round_trip(case, &plate, &out, &options);
            }
        }
        Err(error) => case.check_file_error(&error, path),
    }
}

/// Reads a file by the readers of other inputs.
pub(crate) fn read_otherwise(case: &mut Case, path: &Path) {
    let errors = [
        ImageChannel::read_depth(path, None, DepthOwner::Unknown).err(),
        ImageChannel::read_matte(path, None).err(),
        Description::read(path).err(),
        RasterImage::open(path).err(),
    ];
    for error in errors.into_iter().flatten() {
        case.check_file_error(&error, path);
    }
}
