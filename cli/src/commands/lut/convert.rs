//! Pictures from one space to another, one or the frames of a sequence.

use std::ffi::OsString;
use std::sync::{Arc, Mutex, PoisonError};

use seidel_colour::{Alphas, Config, Processor};

use super::LutArgs;
use crate::Console;
use crate::commands::CommandError;
use crate::commands::plates::{Files, Outcome, Run, Stages, space_of};
use seidel_image_io::error::FileError;
use seidel_image_io::plate::{Plate, PlateOptions};
use seidel_image_io::samples::Encoding;

/// What asks for the space that a file is in to be told by the file.
const AUTO: &str = "auto";

/// What all frames of a run share.
struct Job<'a> {
    args: &'a LutArgs,
    config: &'a Config,
    run: &'a Run,
    /// What was said of the last picture's colour.
    told: Mutex<String>,
}

/// A picture with what converts it, and what the user should know of it.
struct Picture {
    plate: Plate,
    processor: Arc<Processor>,
    said: Vec<String>,
}

/// Converts the picture or pictures `input`.
pub(super) fn run(
    args: &LutArgs,
    config: &Config,
    (input, output): (&str, &str),
    words: &[OsString],
    console: &mut Console,
) -> Result<(), CommandError> {
    let files = Files {
        input,
        output,
        read: Vec::new(),
        written: Vec::new(),
    };
    let frames = args.run.frames(&files, &[], console)?;
    let run = args
        .run
        .begin("converting", frames, (words, &[]), console)?;
    let job = Job {
        args,
        config,
        run: &run,
        told: Mutex::default(),
    };
    run.through(&job, console)
}

/// Puts zero in the place of samples that are not finite; whether there were any.
fn scrub_samples(samples: &mut [f32]) -> bool {
    let mut any = false;
    for sample in samples.iter_mut().filter(|sample| !sample.is_finite()) {
        *sample = 0.0;
        any = true;
    }
    any
}

impl Stages for Job<'_> {
    type Read = Picture;
    type Done = Picture;

    fn read(&self, index: usize) -> Result<Picture, CommandError> {
        let args = self.args;
        let options = PlateOptions {
            layer: args.layer.clone(),
            encoding: Some(Encoding::Linear),
            colour_managed: true,
            ..PlateOptions::default()
        };
        let plate = Plate::open(&self.run.frame(index).input, &options)?;
        let asked = args.in_space.as_deref().unwrap_or(AUTO);
        let (from, by) = match asked {
            AUTO => space_of(self.config, &plate)?,
            name => (self.config.space(name)?, "--in-space".to_owned()),
        };
        let processor = args.processor(self.config, &from.name)?;
        let mut said = Vec::new();
        let told = format!(
            "colour: `{}` ({by}) to `{}`, by {}",
            from.name,
            processor.to(),
            self.config.name()
        );
        let mut last = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        if *last != told {
            said.push(told.clone());
            *last = told;
        }
        Ok(Picture {
            plate,
            processor,
            said,
        })
    }

    fn bytes(&self, picture: &Picture) -> u64 {
        let plate = &picture.plate;
        // The colours beside what the file holds, and alpha.
        let planes = plate.colour_names().len() as u64 + 1;
        let pixels = plate.width() as u64 * plate.height() as u64;
        plate.memory_bytes() + planes * pixels * size_of::<f32>() as u64
    }

    fn blur(&self, index: usize, picture: Picture) -> Result<Picture, CommandError> {
        let Picture {
            mut plate,
            processor,
            mut said,
        } = picture;
        let scrub = self.args.scrub;
        let bad = plate.non_finite();
        if let (Some(first), false) = (bad.first(), scrub) {
            let remedy = "mend the picture, or give --scrub to replace such samples by zero";
            return Err(FileError::new(plate.path(), "", first.to_string(), remedy).into());
        }
        said.extend(bad.iter().map(|bad| format!("{bad}; replaced by zero")));
        let mut colours = plate.colour();
        // Also where nothing is converted.
        for colour in &mut colours {
            scrub_samples(colour);
        }
        let mut alpha = plate.alpha();
        if let Some(alpha) = &mut alpha
            && scrub_samples(alpha)
        {
            plate.set_alpha(alpha)?;
        }
        let alphas = match &alpha {
            Some(alpha) if plate.is_premultiplied() => Alphas::Shared(alpha),
            _ => Alphas::Straight,
        };
        let report = processor.convert_planes(&mut colours, alphas)?;
        if report.unrepresentable > 0 {
            let problem = format!(
                "{} samples have no finite number in `{}`",
                report.unrepresentable,
                processor.to()
            );
            if !scrub {
                let remedy = "check --in-space, or give --scrub to replace such samples by zero";
                return Err(FileError::new(plate.path(), "colour", problem, remedy).into());
            }
            said.push(format!("{problem}; replaced by zero"));
        }
        plate.set_colour(&colours)?;
        if processor.from() != processor.to() {
            plate.set_colour_space(processor.to());
        }
        let told = [
            ("config", self.config.name()),
            ("in-space", processor.from()),
            ("out-space", processor.to()),
        ];
        let told = told.map(|(name, value)| (name.to_owned(), value.to_owned()));
        self.run.set_provenance(index, &mut plate, &told);
        self.run.tell(index, 1.0);
        Ok(Picture {
            plate,
            processor,
            said,
        })
    }

    fn write(&self, index: usize, picture: Picture) -> Outcome {
        self.run.write(index, picture.plate, picture.said)
    }
}
