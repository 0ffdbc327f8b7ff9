//! Animation tables.

use std::path::Path;

use seidel_image_io::animation::{Animation, Interpolation};

use super::reader::Reader;
use super::{Method, Target};
use crate::case::Case;
use crate::finding::Kind;
use crate::mutations::{JSON, TEXT};
use crate::seeds::texts;

pub(crate) static TARGET: Target = Target {
    name: "animation",
    about: "animation tables, CSV and JSON",
    weight: 0.5,
    method: Method::Reader(Reader {
        file: "table.csv",
        seeds: |_| texts::animations(),
        mutations: |rng| if rng.once_in(3) { JSON } else { TEXT },
        read,
    }),
};

fn read(case: &mut Case, path: &Path) {
    match Animation::open(path) {
        Ok(table) => {
            case.is_accepted = true;
            let names: Vec<String> = table.names().map(str::to_owned).collect();
            for name in &names {
                // Negative values, which no option allows, have no reciprocal mean.
                let ends = [i64::MIN, 0, 1003, i64::MAX];
                let value = |frame| table.value(name, frame, Interpolation::Linear);
                if ends.into_iter().filter_map(value).any(|v| v < 0.0) {
                    continue;
                }
                for frame in [i64::MIN, -1, 0, 1003, 1_000_000, i64::MAX] {
                    let value = table.value(name, frame, Interpolation::Reciprocal);
                    if value.is_some_and(f64::is_nan) {
                        let text = format!("{name} at {frame} is NaN");
                        case.report(Kind::SilentChange, text);
                    }
                    std::hint::black_box(table.value(name, frame, Interpolation::Linear));
                }
            }
        }
        Err(error) => case.check_file_error(&error, path),
    }
}
