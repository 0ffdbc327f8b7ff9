//! Frame patterns, also those that are not Unicode.

use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;

use seidel_image_io::sequence::{FramePattern, expand_frames};

use super::reader::Reader;
use super::{Method, Target};
use crate::case::Case;
use crate::mutations::TEXT;
use crate::seeds::{self, texts};

pub(crate) static TARGET: Target = Target {
    name: "patterns",
    about: "frame patterns",
    weight: 0.3,
    method: Method::Reader(Reader {
        file: "pattern.txt",
        seeds: |_| texts::patterns(),
        mutations: |_| TEXT,
        read,
    }),
};

/// Parses the text of the file, which is the word of a command line.
fn read(case: &mut Case, path: &Path) {
    let bytes = seeds::read(path);
    let word = Path::new(OsStr::from_bytes(&bytes));
    let pattern = FramePattern::parse(word);
    for frame in [i64::MIN, -1, 0, 1001, i64::MAX] {
        std::hint::black_box(pattern.path(frame));
    }
    case.is_accepted = true;
    if let Err(error) = expand_frames(&[word, word], Some("1-3")) {
        // The path itself is in the message, as far as it can be displayed.
        case.check_error(&error.to_string(), "");
    }
}
