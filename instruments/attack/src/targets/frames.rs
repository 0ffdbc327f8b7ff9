//! Frame lists.

use seidel_image_io::sequence::parse_frames;

use super::{Attack, Sort, Target};
use crate::case::Case;
use crate::finding::Kind;
use crate::mutations::TEXT;
use crate::seeds::texts;

pub(crate) static TARGET: Target = Target {
    name: "frames",
    about: "frame lists",
    sort: Sort::InProcess,
    weight: 0.3,
    start: |_| {
        Box::new(Lists {
            seeds: texts::frame_lists(),
        })
    },
};

struct Lists {
    seeds: Vec<Vec<u8>>,
}

impl Attack for Lists {
    fn seeds(&self) -> usize {
        self.seeds.len()
    }

    fn run(&mut self, case: &mut Case) {
        let bytes = case.damaged(&self.seeds, TEXT);
        case.write("frames.txt", &bytes);
        match parse_frames(&String::from_utf8_lossy(&bytes)) {
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
}
