//! One frame of a run: read, its blur taken off, written.

use std::path::Path;
use std::sync::Arc;

use seidel_core::plate::Unblurred;

use super::extras::{Extra, Map};
use super::{Grain, RemoveArgs};
use crate::commands::CommandError;
use crate::commands::plates::{Outcome, ReadPlate, Run, Shared, Stages};
use crate::commands::removal::{LensCheck, work_bytes};
use seidel_image_io::error::FileError;
use seidel_image_io::format::{Format, output_format};
use seidel_image_io::plate::Plate;
use seidel_image_io::residual::Residual;
use seidel_image_io::windows::{held, surrounded};

/// Share of the work that is taking blur off.
const REMOVAL_SHARE: f64 = 0.9;

/// What all frames of a run share.
pub(super) struct Job<'a> {
    pub(super) args: &'a RemoveArgs,
    pub(super) shared: &'a Shared<'a>,
    /// Whether its blur is that of the plate.
    pub(super) check: LensCheck,
    pub(super) run: &'a Run,
}

/// A frame to be written.
pub(super) struct SharpFrame {
    plate: Plate,
    extras: Vec<Extra>,
    said: Vec<String>,
}

impl Job<'_> {
    fn depth_file(&self, index: usize) -> Option<&Path> {
        let read = &self.run.frame(index).read;
        read.first().map(|path| path.as_path())
    }

    /// What the plate that was `read` has beside what its lens makes of the sharp one as its file will hold it.
    fn residual(
        &self,
        index: usize,
        read: &ReadPlate,
        (sharp, found): (&Plate, Option<&Unblurred>),
        path: &Path,
    ) -> Result<Residual, CommandError> {
        let number = self.run.frame(index).number;
        let stored = ReadPlate {
            // As far as the lens was taken off.
            setup: Arc::clone(&read.setup),
            ..self.shared.read_written(
                sharp.clone(),
                &read.light,
                number,
                self.depth_file(index),
            )?
        };
        let progress = |share: f64| {
            let done = REMOVAL_SHARE + (1.0 - REMOVAL_SHARE) * share;
            self.run.tell(index, done);
        };
        let applied = self.shared.applied(&stored, &progress)?;
        let noise = match found {
            Some(found) => found.noise(),
            None => vec![0.0; read.light.plane_count()],
        };
        let (whole, own) = (sharp.data_window(), read.plate.data_window());
        let rest = |(seen, plane): (&Vec<f32>, &Vec<f32>)| {
            let seen = held(seen, whole, own);
            let rest: Vec<f32> = plane.iter().zip(seen).map(|(p, seen)| p - seen).collect();
            surrounded(&rest, own, whole)
        };
        let mut settings = self.shared.told(&read.setup, &read.plate)?;
        settings.extend(Shared::defaults_told());
        Ok(Residual {
            path: path.to_owned(),
            windows: sharp.windows(),
            plate: own,
            names: read.light.names().to_vec(),
            residual: applied.iter().zip(read.light.planes()).map(rest).collect(),
            sharp: stored.light.copied(),
            noise,
            settings,
        })
    }

    /// Whether the frame at `index` is written in the format of its `plate`.
    fn keeps_format(&self, index: usize, plate: &Plate) -> Result<bool, CommandError> {
        Ok(output_format(&self.run.frame(index).output)? == plate.format())
    }

    /// Puts the sharp planes into `plate`, with overscan where it is an EXR and is written `to_exr`.
    fn put_sharp(
        &self,
        read: &ReadPlate,
        found: &Unblurred,
        plate: &mut Plate,
        to_exr: bool,
    ) -> Result<(), CommandError> {
        let Some(canvas) = found.canvas() else {
            return Ok(());
        };
        let mut planes = found.sharp();
        if self.args.grain == Grain::Keep {
            found.add_grain(&mut planes, false);
        }
        let own = plate.data_window();
        let grows = to_exr && plate.format() == Format::Exr && !self.args.no_overscan;
        if grows {
            plate.reframe(own.grown(canvas.margin_x, canvas.margin_y));
        } else {
            planes = planes.iter().map(|plane| canvas.cropped(plane)).collect();
        }
        let strength = self.args.strength as f32;
        if strength < 1.0 {
            for (plane, before) in planes.iter_mut().zip(read.light.planes()) {
                let before = held(before, own, plate.data_window());
                for (sample, before) in plane.iter_mut().zip(before) {
                    *sample = before + strength * (*sample - before);
                }
            }
        }
        read.light.put_back(plate, planes)
    }
}

/// The map that `option` asks for; of a plate that stays as it is nothing is guessed, and its noise is its own.
fn map(option: &str, read: &ReadPlate, found: Option<&Unblurred>, path: &Path) -> Map {
    let planes = match (found, option) {
        (Some(found), "--confidence") => found.confidence(),
        (Some(found), _) => found.noise_gain.clone(),
        (None, _) => {
            let pixels = read.plate.width() * read.plate.height();
            vec![vec![1.0; pixels]; read.light.colour_count()]
        }
    };
    Map {
        path: path.to_owned(),
        windows: read.plate.windows(),
        names: read.plate.colour_names().to_vec(),
        planes,
    }
}

impl Stages for Job<'_> {
    type Read = ReadPlate;
    type Done = SharpFrame;

    fn read(&self, index: usize) -> Result<ReadPlate, CommandError> {
        let frame = self.run.frame(index);
        let depth = self.depth_file(index);
        let read = self
            .shared
            .open_plate(&frame.input, frame.number, depth, index == 0)?;
        if self.args.residual.is_some() && !self.keeps_format(index, &read.plate)? {
            let problem = format!(
                "is written as another format than the plate, which is {}: --residual would not fit it",
                read.plate.format()
            );
            let remedy = "give OUT the extension of IN, or leave out --residual";
            return Err(FileError::new(&frame.output, "", problem, remedy).into());
        }
        self.args.removal.check(&read.plate)?;
        Ok(read)
    }

    fn bytes(&self, read: &ReadPlate) -> u64 {
        work_bytes(read)
    }

    fn blur(&self, index: usize, mut read: ReadPlate) -> Result<SharpFrame, CommandError> {
        let mut plate = read.plate.clone();
        let mut found = None;
        if read.setup.adjust.is_nothing() || self.args.strength == 0.0 {
            read.light.keep(&mut plate)?;
            (read.said).push("at --amount 0 or --strength 0 the plate stays as it is".into());
        } else {
            let progress = |share| self.run.tell(index, REMOVAL_SHARE * share);
            let gain = self.args.noise_gain.is_some();
            let removal = &self.args.removal;
            let lens = (self.shared, &self.check);
            let frame = (self.run.frame(index).number, &mut read);
            let unblurred = removal.found(lens, frame, gain, &progress)?;
            let to_exr = output_format(&self.run.frame(index).output)? == Format::Exr;
            self.put_sharp(&read, &unblurred, &mut plate, to_exr)?;
            found = Some(unblurred);
        }
        if self.keeps_format(index, &plate)? {
            plate.round();
        }
        let mut extras = Vec::new();
        for ((option, _), path) in self.args.written().zip(&self.run.frame(index).written) {
            extras.push(match option {
                "--residual" => Extra::Residual(Box::new(self.residual(
                    index,
                    &read,
                    (&plate, found.as_ref()),
                    path,
                )?)),
                _ => Extra::Map(map(option, &read, found.as_ref(), path)),
            });
        }
        let mut told = self.shared.told(&read.setup, &read.plate)?;
        told.push(("strength".to_owned(), self.args.strength.to_string()));
        self.run.sign(index, &mut plate, &told);
        Ok(SharpFrame {
            plate,
            extras,
            said: read.said,
        })
    }

    fn write(&self, index: usize, frame: SharpFrame) -> Outcome {
        let SharpFrame {
            plate,
            extras,
            mut said,
        } = frame;
        for extra in extras {
            extra.write()?;
        }
        said.extend(plate.write(&self.run.frame(index).output)?);
        Ok(said)
    }
}
