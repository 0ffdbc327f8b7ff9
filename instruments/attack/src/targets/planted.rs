//! Planted faults, to test the attack: each must be found. Not part of an attack.

use std::path::Path;
use std::time::Duration;

use super::{Attack, Method, Target};
use crate::case::{Case, Inputs};
use crate::finding::Kind;
use crate::seeds::raster;

pub(crate) static TARGET: Target = Target {
    name: "planted",
    about: "planted faults",
    weight: 1.0,
    method: Method::Calls(|_: &Path| Box::new(Planted)),
};

struct Planted;

/// The undamaged input.
const SOUND: &[u8] = b"sound";

impl Attack for Planted {
    fn seeds(&self) -> usize {
        1
    }

    fn run(&mut self, case: &mut Case) {
        case.is_accepted = true;
        if case.inputs == Inputs::Sound {
            case.write("input", SOUND);
            return;
        }
        case.write("input", format!("case {}", case.number).as_bytes());
        match case.number {
            1 => panic!("a planted panic"),
            2 => std::process::abort(),
            3 => {
                let size = 2 * crate::allocator::BOUND_BYTES;
                std::hint::black_box(vec![1_u8; size]);
            }
            4 => std::thread::sleep(TARGET.max_delay() + Duration::from_millis(200)),
            5 => case.report(Kind::SilentChange, "a planted change"),
            6 => case.check_error("a message without the file; remedy", "input"),
            7 => case.check_error("input: a message without a remedy", "input"),
            8 => overflow(0),
            _ => {}
        }
    }

    fn clean_up(&mut self, folder: &Path) {
        raster::write(&folder.join("input"), SOUND);
    }
}

/// Uses all of the stack.
fn overflow(depth: usize) {
    let room = std::hint::black_box([depth as u8; 4096]);
    if room[depth % 4096] < 255 || depth > 0 {
        overflow(depth + 1);
    }
    std::hint::black_box(&room);
}
