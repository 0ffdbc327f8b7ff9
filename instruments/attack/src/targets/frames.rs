//! Frame lists.

use std::path::Path;

use seidel_image_io::sequence::parse_frames;

use super::reader::Reader;
use super::{Method, Target};
use crate::case::Case;
use crate::finding::Kind;
use crate::mutations::TEXT;
use crate::seeds::{self, texts};

pub(crate) static TARGET: Target = Target {
    name: "frames",
    about: "frame lists",
    weight: 0.3,
    method: Method::Reader(Reader {
        file: "frames.txt",
        seeds: |_| texts::frame_lists(),
        mutations: |_| TEXT,
        read,
    }),
};

/// Parses the text of the file, which is the word of a command line.
fn read(case: &mut Case, path: &Path) {
    match parse_frames(&String::from_utf8_lossy(&seeds::read(path))) {
        Ok(frames) => {
            case.is_accepted = true;
            if frames.is_empty() || frames.len() > 1_000_000 {
                let text = format!("a list of {} frames was accepted", frames.len());
                case.report(Kind::SilentChange, text);
            }
        }
        Err(error) => case.check_error(&error.to_string(), "--frames"),
    }
}
