//! Lens profiles: read, written again, and asked for blur.

use std::path::Path;

use seidel_core::{BlurField, FieldPoint, LensProfile, ObjectDistance, Predictor};
use seidel_image_io::lens_profile;

use super::reader::Reader;
use super::{Method, Target};
use crate::case::Case;
use crate::finding::Kind;
use crate::mutations::{JSON, TEXT};
use crate::seeds::lenses;

pub(crate) static TARGET: Target = Target {
    name: "profile",
    about: "lens profiles",
    weight: 1.0,
    method: Method::Reader(Reader {
        file: "lens.json",
        seeds: |_| lenses::profiles(),
        mutations: |rng| if rng.once_in(4) { TEXT } else { JSON },
        read,
    }),
};

fn read(case: &mut Case, path: &Path) {
    match lens_profile::read(path) {
        Ok(profile) => {
            case.is_accepted = true;
            use_profile(case, &profile);
        }
        Err(error) => case.check_file_error(&error, path),
    }
}

fn use_profile(case: &mut Case, profile: &LensProfile) {
    match LensProfile::from_json(&profile.to_json()) {
        Ok(back) if back.to_json() == profile.to_json() => {}
        Ok(_) => case.report(Kind::SilentChange, "the profile differs after writing"),
        Err(error) => {
            case.report(
                Kind::SilentChange,
                format!("written, not readable: {error}"),
            );
        }
    }
    let Ok(predictor) = Predictor::new(profile) else {
        return;
    };
    for metres in [0.5, 2.0, f64::INFINITY] {
        let distance = ObjectDistance::metres(metres);
        let Ok(vergence) = distance.and_then(|distance| predictor.vergence(distance)) else {
            continue;
        };
        for channel in 0..predictor.channel_count() {
            std::hint::black_box(predictor.blur_at(channel, FieldPoint::new(0.4, 0.3), vergence));
        }
    }
}
