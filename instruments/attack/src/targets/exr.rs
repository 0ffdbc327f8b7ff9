//! OpenEXR images: every compression, tiles, parts, mip maps, deep.

use std::path::Path;

use seidel_image_io::formats::exr::ExrImage;

use super::image::{read_otherwise, read_picture};
use super::reader::Reader;
use super::{Method, Target};
use crate::case::{Case, Inputs};
use crate::finding::Kind;
use crate::mutations::EXR;
use crate::seeds::{self, exr};

pub(crate) static TARGET: Target = Target {
    name: "exr",
    about: "OpenEXR images of every compression, tiled, multi-part, with mip maps, deep",
    weight: 3.0,
    method: Method::Reader(Reader {
        file: "in.exr",
        seeds: exr::files,
        mutations: |_| EXR,
        read,
    }),
};

fn read(case: &mut Case, path: &Path) {
    read_picture(case, path);
    match ExrImage::open(path) {
        Ok(image) => check_all_channels(case, &image),
        // Deep pictures are refused by name, also undamaged ones.
        Err(error) if case.inputs == Inputs::Sound => {
            let bytes = seeds::read(path);
            let is_deep = bytes.windows(exr::DEEP.len()).any(|word| word == exr::DEEP);
            case.is_accepted = is_deep && error.to_string().contains("deep");
        }
        Err(error) => case.check_file_error(&error, path),
    }
    if case.rng.once_in(4) {
        read_otherwise(case, path);
    }
}

/// Writes all channels of all parts and reads them again.
fn check_all_channels(case: &mut Case, image: &ExrImage) {
    let out = case.folder.join("all.exr");
    if image.write(&out).is_err() {
        return;
    }
    let back = match ExrImage::open(&out) {
        Ok(back) => back,
        Err(error) => {
            case.report(
                Kind::SilentChange,
                format!("written, not readable: {error}"),
            );
            return;
        }
    };
    let (before, after) = (image.channels(), back.channels());
    if before.len() != after.len() {
        case.report(
            Kind::SilentChange,
            "the number of channels differs after writing",
        );
        return;
    }
    for (a, b) in before.iter().zip(&after) {
        let samples = [image.samples(a.id), back.samples(b.id)];
        let same = |(a, b): (&f32, &f32)| a == b || (a.is_nan() && b.is_nan());
        let is_same =
            samples[0].len() == samples[1].len() && samples[0].iter().zip(&samples[1]).all(same);
        if !is_same {
            let text = format!("channel {} differs after writing", image.channel_name(a.id));
            case.report(Kind::SilentChange, text);
        }
    }
}
