//! The C ABI: random sequences of calls with hostile structs, on images between guard pages.

mod images;
mod structs;

use std::ffi::c_char;
use std::path::Path;
use std::ptr::{null, null_mut};

use seidel_c::*;

use super::{Attack, Method, Target};
use crate::case::{Case, Inputs};
use crate::finding::Kind;
use crate::mutations::JSON;
use crate::seeds::lenses;

use images::GuardedImage;
use structs::{Scene, hostile_float};

pub(crate) static TARGET: Target = Target {
    name: "c-abi",
    about: "random calls of the C ABI with hostile structs, on images between guard pages",
    weight: 3.0,
    method: Method::Calls(|_: &Path| {
        Box::new(CAbi {
            lens: vec![lenses::lens().into_bytes()],
        })
    }),
};

struct CAbi {
    lens: Vec<Vec<u8>>,
}

impl Attack for CAbi {
    fn seeds(&self) -> usize {
        3
    }

    fn run(&mut self, case: &mut Case) {
        let json = if case.rng.once_in(8) {
            let bytes = self.lens[0].clone();
            case.damage(bytes, &self.lens, JSON)
        } else {
            self.lens[0].clone()
        };
        case.write("lens.json", &json);
        let mut lens = null_mut();
        // SAFETY: the text has the stated length, and the pointer to the handle is valid.
        let status =
            unsafe { seidel_lens_read(json.as_ptr().cast::<c_char>(), json.len(), &mut lens) };
        check(case, status);
        if status == SeidelStatus::Ok {
            let calls = if case.inputs == Inputs::Sound {
                1
            } else {
                1 + case.rng.below(3)
            };
            for _ in 0..calls {
                call(case, lens);
            }
            check(case, seidel_lens_release(lens));
        }
    }
}

/// Makes one random call.
fn call(case: &mut Case, lens: *const SeidelLens) {
    let scene = Scene::new(case);
    let kind = if case.inputs == Inputs::Sound {
        case.number as usize % 3
    } else {
        case.rng.below(9)
    };
    let settings: *const SeidelSettings = if case.inputs == Inputs::Damaged && case.rng.once_in(9) {
        null()
    } else {
        &scene.settings
    };
    let plate = scene.plate();
    let output = scene.output.describe();
    let structs = format!(
        "call {kind}\n{plate:#?}\n{output:#?}\n{:#?}\n",
        scene.settings
    );
    case.write("structs.txt", structs.as_bytes());
    let before_finite = scene.is_finite();
    // SAFETY: every pointer is null or valid for the call; images lie in their own mappings as they state.
    let status = unsafe {
        match kind {
            0 => seidel_apply(lens, settings, &plate, &output, null(), null()),
            1 => seidel_remove(lens, settings, &plate, &output, null(), null_mut(), null()),
            2 => seidel_relens(lens, lens, settings, &plate, &output, null(), null()),
            3 => {
                let mut share = 0.0;
                seidel_check_lens(lens, settings, &plate, &mut share, null())
            }
            4 => draw_kernel(case, lens, settings, &plate),
            5 => {
                let mut region = scene.window;
                seidel_region_of_interest(lens, settings, &plate, &scene.window, &mut region)
            }
            6 => {
                let mut bytes = 0;
                seidel_memory_needed(settings, &plate, case.rng.below(3) as u32, &mut bytes)
            }
            7 => seidel_match_colours(lens, settings, &plate, &output, null(), null()),
            _ => read_names(case, lens),
        }
    };
    check(case, status);
    if status == SeidelStatus::Ok
        && matches!(kind, 0..3 | 7)
        && before_finite
        && !scene.output.is_finite()
    {
        case.report(
            Kind::SilentChange,
            format!("call {kind} wrote samples that are not finite"),
        );
    }
    if case.inputs == Inputs::Sound {
        case.is_accepted = status == SeidelStatus::Ok;
        if !case.is_accepted {
            case.report(Kind::Refused, last_error());
        }
    }
    if let Some(image) = scene.changed_padding() {
        case.report(
            Kind::SilentChange,
            format!("call {kind} wrote between the samples of the {image}"),
        );
    }
}

/// Draws a kernel into too little, enough or no room.
///
/// # Safety
/// The pointers are null or valid.
unsafe fn draw_kernel(
    case: &mut Case,
    lens: *const SeidelLens,
    settings: *const SeidelSettings,
    plate: &SeidelPlate,
) -> SeidelStatus {
    let mut weights = vec![f32::NAN; case.rng.below(4000)];
    let mut kernel = SeidelKernel {
        size: size_of::<SeidelKernel>() as u64,
        weights: if weights.is_empty() {
            null_mut()
        } else {
            weights.as_mut_ptr()
        },
        capacity: weights.len() as u64,
        left: 0,
        top: 0,
        width: 0,
        height: 0,
    };
    let at = [
        hostile_float(&mut case.rng, 5.0),
        hostile_float(&mut case.rng, 7.0),
    ];
    let distance = hostile_float(&mut case.rng, 2.0);
    let channel = case.rng.below(5) as u32;
    // SAFETY: the weights have the stated capacity, and the caller guarantees the rest.
    let status = unsafe {
        seidel_kernel(
            lens,
            settings,
            plate,
            channel,
            at[0],
            at[1],
            distance,
            &mut kernel,
        )
    };
    if status == SeidelStatus::Ok {
        let count = (kernel.width as usize * kernel.height as usize).min(weights.len());
        if weights[..count].iter().any(|w| !w.is_finite()) {
            case.report(
                Kind::SilentChange,
                "a kernel has weights that are not finite",
            );
        }
    }
    status
}

fn read_names(case: &mut Case, lens: *const SeidelLens) -> SeidelStatus {
    let mut buffer = vec![0_u8; case.rng.below(20)];
    let mut needed = 0;
    let index = case.rng.below(12) as u32;
    let room = buffer.as_mut_ptr().cast();
    // SAFETY: the buffer has the stated length.
    let status = unsafe { seidel_lens_channel(lens, index, room, buffer.len(), &mut needed) };
    check(case, status);
    // SAFETY: as above.
    unsafe { seidel_lens_model(lens, index, room, buffer.len(), &mut needed) }
}

fn last_error() -> String {
    let mut words = [0_u8; 600];
    // SAFETY: the buffer has the stated length.
    unsafe { seidel_last_error(words.as_mut_ptr().cast(), words.len()) };
    let end = words.iter().position(|&b| b == 0).unwrap_or(words.len());
    String::from_utf8_lossy(&words[..end]).into_owned()
}

/// Reports panics, and failures without a message.
fn check(case: &mut Case, status: SeidelStatus) {
    if status == SeidelStatus::Panicked {
        case.report(Kind::Panic, crate::worker::last_panic());
    } else if status != SeidelStatus::Ok {
        let error = last_error();
        if error.is_empty() || error.chars().any(|c| c.is_control() && c != '\n') {
            case.report(Kind::Message, format!("{status:?}: {error:?}"));
        }
    }
}
