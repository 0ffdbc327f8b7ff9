//! Frame patterns, also those that are not Unicode.

use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;

use seidel_image_io::sequence::{FramePattern, expand_frames};

use super::{Attack, Sort, Target};
use crate::case::Case;
use crate::mutations::TEXT;
use crate::seeds::texts;

pub(crate) static TARGET: Target = Target {
    name: "patterns",
    about: "frame patterns",
    sort: Sort::InProcess,
    weight: 0.3,
    start: |_| {
        Box::new(Patterns {
            seeds: texts::patterns(),
        })
    },
};

struct Patterns {
    seeds: Vec<Vec<u8>>,
}

impl Attack for Patterns {
    fn seeds(&self) -> usize {
        self.seeds.len()
    }

    fn run(&mut self, case: &mut Case) {
        let bytes = case.damaged(&self.seeds, TEXT);
        case.write("pattern.txt", &bytes);
        let path = Path::new(OsStr::from_bytes(&bytes));
        let pattern = FramePattern::parse(path);
        for frame in [i64::MIN, -1, 0, 1001, i64::MAX] {
            std::hint::black_box(pattern.path(frame));
        }
        case.is_accepted = true;
        if let Err(error) = expand_frames(&[path, path], Some("1-3")) {
            // The path itself is in the message, as far as it can be displayed.
            case.check_error(&error.to_string(), "");
        }
    }
}
