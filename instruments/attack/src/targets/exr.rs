//! OpenEXR images: every compression, tiles, parts, mip maps, deep.

use seidel_image_io::formats::exr::ExrImage;

use super::image::{read_otherwise, read_picture};
use super::{Attack, Sort, Target};
use crate::case::{Case, Inputs};
use crate::finding::Kind;
use crate::mutations::EXR;
use crate::seeds::exr;

const NAME: &str = "in.exr";

pub(crate) static TARGET: Target = Target {
    name: "exr",
    about: "OpenEXR images of every compression, tiled, multi-part, with mip maps, deep",
    sort: Sort::InProcess,
    weight: 3.0,
    start: |folder| {
        Box::new(ExrFiles {
            seeds: exr::files(folder),
        })
    },
};

struct ExrFiles {
    seeds: Vec<Vec<u8>>,
}

impl Attack for ExrFiles {
    fn seeds(&self) -> usize {
        self.seeds.len()
    }

    fn run(&mut self, case: &mut Case) {
        let bytes = case.damaged(&self.seeds, EXR);
        let path = case.write(NAME, &bytes);
        read_picture(case, &path, NAME);
        match ExrImage::open(&path) {
            Ok(image) => check_all_channels(case, &image),
            // Deep pictures are refused by name, also undamaged ones; the last seed is one.
            Err(error) if case.inputs == Inputs::Sound => {
                let is_last = case.seed_index(self.seeds.len()) + 1 == self.seeds.len();
                case.is_accepted = is_last && error.to_string().contains("deep");
            }
            Err(error) => case.check_error(&error.to_string(), NAME),
        }
        if case.rng.once_in(4) {
            read_otherwise(case, &path, NAME);
        }
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
