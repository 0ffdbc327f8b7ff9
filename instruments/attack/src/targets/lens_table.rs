//! Tables of lens settings beside a shot.

use std::path::Path;

use seidel_image_io::lens_metadata::{Quantity, ShotFrame, Sidecar, match_frames};

use super::reader::Reader;
use super::{Method, Target};
use crate::case::Case;
use crate::finding::Kind;
use crate::mutations::{JSON, TEXT};
use crate::seeds::texts;

pub(crate) static TARGET: Target = Target {
    name: "lens-table",
    about: "tables of lens settings: OpenTrackIO, ARRI, RED, Sony, Canon, Blackmagic",
    weight: 0.5,
    method: Method::Reader(Reader {
        file: "table.csv",
        seeds: |_| texts::lens_tables(),
        mutations: |rng| if rng.once_in(3) { JSON } else { TEXT },
        read,
    }),
};

fn read(case: &mut Case, path: &Path) {
    let table = match Sidecar::open(path) {
        Ok(table) => table,
        Err(error) => return case.check_file_error(&error, path),
    };
    case.is_accepted = true;
    for record in table.records() {
        for quantity in Quantity::ALL {
            let value = record
                .preferred(quantity, None)
                .map(|r| record.usable_value(r, None));
            if value.is_some_and(f64::is_nan) {
                let text = format!("{} of {} is NaN", quantity.name(), table.dialect());
                case.report(Kind::SilentChange, text);
            }
        }
    }
    for number in [None, Some(i64::MIN), Some(0), Some(1001), Some(i64::MAX)] {
        let frame = ShotFrame {
            number,
            time_code: None,
        };
        for start in [None, Some(i64::MIN), Some(1001)] {
            if let Err(error) = match_frames(&table, &[frame], start) {
                case.check_file_error(&error, path);
            }
        }
    }
}
