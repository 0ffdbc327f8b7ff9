//! Lens profiles: read, written again, and asked for blur.

use seidel_core::distance::ObjectDistance;
use seidel_core::field::FieldPoint;
use seidel_core::predict::Predictor;
use seidel_core::profile::LensProfile;
use seidel_core::render::BlurField;
use seidel_image_io::lens_profile;

use super::{Attack, Sort, Target};
use crate::case::Case;
use crate::finding::Kind;
use crate::mutations::{JSON, TEXT};
use crate::seeds::lenses;

const NAME: &str = "lens.json";

pub(crate) static TARGET: Target = Target {
    name: "profile",
    about: "lens profiles",
    sort: Sort::InProcess,
    weight: 1.0,
    start: |_| {
        Box::new(Profiles {
            seeds: vec![lenses::lens().into_bytes()],
        })
    },
};

struct Profiles {
    seeds: Vec<Vec<u8>>,
}

impl Attack for Profiles {
    fn seeds(&self) -> usize {
        self.seeds.len()
    }

    fn run(&mut self, case: &mut Case) {
        let mutations = if case.rng.once_in(4) { TEXT } else { JSON };
        let bytes = case.damaged(&self.seeds, mutations);
        let path = case.write(NAME, &bytes);
        match lens_profile::read(&path) {
            Ok(profile) => {
                case.is_accepted = true;
                use_profile(case, &profile);
            }
            Err(error) => case.check_error(&error.to_string(), NAME),
        }
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
