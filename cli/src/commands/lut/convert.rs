//! Conversion of pictures from one space to another, one or the frames of a sequence.

use std::ffi::OsString;
use std::path::Path;
use std::sync::Arc;

use seidel_colour::{Alphas, Config, Processor};

use super::LutArgs;
use crate::Console;
use crate::commands::CommandError;
use crate::commands::plates::{
    AUTO, ChangeFilter, Files, FinishedFrame, FrameFiles, Run, SideInputs, ViewWork, setting,
    space_of, unrepresentable,
};
use seidel_image_io::error::FileError;
use seidel_image_io::plate::{PlateFile, PlateOptions};
use seidel_image_io::samples::Encoding;

/// The work on the frames of a run.
struct Job<'a> {
    args: &'a LutArgs,
    config: &'a Config,
    run: &'a Run,
    reported: ChangeFilter,
}

/// A picture in memory, with its conversion.
struct LoadedPicture {
    plate: PlateFile,
    processor: Arc<Processor>,
    warnings: Vec<String>,
}

/// Converts the picture or pictures `input` to `output`.
pub(super) fn run(
    args: &LutArgs,
    config: &Config,
    input: &Path,
    output: &Path,
    command_line: &[OsString],
    console: &mut Console,
) -> Result<(), CommandError> {
    let files = Files {
        input,
        output,
        read: SideInputs::default(),
        written: Vec::new(),
        lenses: Vec::new(),
    };
    let run = (args.run).begin("converting", &files, command_line, console)?;
    let job = Job {
        args,
        config,
        run: &run,
        reported: ChangeFilter::default(),
    };
    run.process(&job, console)
}

/// Replaces samples that are not finite by zero. Returns whether there were any.
fn scrub(samples: &mut [f32]) -> bool {
    let mut any = false;
    for sample in samples.iter_mut().filter(|sample| !sample.is_finite()) {
        *sample = 0.0;
        any = true;
    }
    any
}

impl ViewWork for Job<'_> {
    type Loaded = LoadedPicture;

    fn files(&self, index: usize) -> &FrameFiles {
        &self.run.frames()[index]
    }

    fn plate<'a>(&self, picture: &'a LoadedPicture) -> &'a PlateFile {
        &picture.plate
    }

    fn read(&self, index: usize, view: usize) -> Result<LoadedPicture, CommandError> {
        let args = self.args;
        let options = PlateOptions {
            layer: args.layer.clone(),
            encoding: Some(Encoding::Linear),
            colour_managed: true,
            ..PlateOptions::default()
        };
        let plate = PlateFile::open_view(&self.files(index).input, &options, view)?;
        let (from, source) = match args.in_space.as_deref().unwrap_or(AUTO) {
            AUTO => space_of(self.config, &plate)?,
            name => (self.config.space(name)?, "--in-space".to_owned()),
        };
        let processor = args.processor(self.config, &from.name)?;
        let message = format!(
            "colour: `{}` ({source}) to `{}`, by {}",
            from.name,
            processor.to(),
            self.config.name()
        );
        let mut warnings = Vec::new();
        if self.reported.is_new(&message) {
            warnings.push(message);
        }
        Ok(LoadedPicture {
            plate,
            processor,
            warnings,
        })
    }

    fn memory_bytes(&self, picture: &LoadedPicture) -> u64 {
        let plate = &picture.plate;
        // The colours and alpha as planes, beside the content of the file.
        let planes = plate.colour_names().len() as u64 + 1;
        let pixels = plate.width() as u64 * plate.height() as u64;
        plate.memory_bytes() + planes * pixels * size_of::<f32>() as u64
    }

    fn warnings(&self, picture: &LoadedPicture) -> Vec<String> {
        picture.warnings.clone()
    }

    fn process(&self, index: usize, picture: LoadedPicture) -> Result<FinishedFrame, CommandError> {
        let LoadedPicture {
            mut plate,
            processor,
            mut warnings,
        } = picture;
        let bad = plate.non_finite();
        if let Some(first) = bad.first()
            && !self.args.scrub
        {
            let remedy = "correct the picture, or give --scrub to replace such samples by zero";
            return Err(FileError::new(plate.path(), "", first.to_string(), remedy).into());
        }
        warnings.extend(bad.iter().map(|bad| format!("{bad}; replaced by zero")));
        let mut colours = plate.colour();
        // The processor replaces them too, except where it converts nothing.
        for colour in &mut colours {
            scrub(colour);
        }
        let mut alpha = plate.alpha();
        if let Some(alpha) = &mut alpha
            && scrub(alpha)
        {
            plate.set_alpha(alpha)?;
        }
        let alphas = match &alpha {
            Some(alpha) if plate.is_premultiplied() => Alphas::Shared(alpha),
            _ => Alphas::Straight,
        };
        let report = processor.convert_planes(&mut colours, alphas)?;
        let space = format!("value in `{}`", processor.to());
        if let Some(problem) = unrepresentable(&report, &plate, &space) {
            if !self.args.scrub {
                let remedy = "check --in-space, or give --scrub to replace such samples by zero";
                return Err(FileError::new(plate.path(), "colour", problem, remedy).into());
            }
            warnings.push(format!("{problem}; replaced by zero"));
        }
        plate.set_colour(&colours)?;
        if processor.from() != processor.to() {
            plate.set_colour_space(processor.to());
        }
        let record = vec![
            setting("config", self.config.name()),
            setting("in-space", processor.from()),
            setting("out-space", processor.to()),
        ];
        self.run.show_progress(index, 1.0);
        Ok(FinishedFrame {
            plate,
            record,
            side_files: Vec::new(),
            warnings,
        })
    }
}
