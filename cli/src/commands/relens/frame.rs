//! One frame of a run: read, one lens's blur taken off and another's put on, written.

use std::path::Path;

use seidel_core::plate::Unblurred;

use super::RelensArgs;
use crate::commands::CommandError;
use crate::commands::plates::{Outcome, ReadPlate, Run, Shared, Stages};
use crate::commands::removal::{LensCheck, work_bytes};
use seidel_image_io::error::FileError;
use seidel_image_io::plate::Plate;

/// Share of the work that is taking blur off.
const REMOVAL_SHARE: f64 = 0.9;

/// What all frames of a run share.
pub(super) struct Job<'a> {
    pub(super) args: &'a RelensArgs,
    /// The lens that the plate was taken with, and the other.
    pub(super) from: &'a Shared<'a>,
    pub(super) to: &'a Shared<'a>,
    /// Whether the first lens's blur is that of the plate.
    pub(super) check: LensCheck,
    pub(super) run: &'a Run,
}

/// A frame to be written.
pub(super) struct NewFrame {
    plate: Plate,
    said: Vec<String>,
}

impl Job<'_> {
    fn depth_file(&self, index: usize) -> Option<&Path> {
        let read = &self.run.frame(index).read;
        read.first().map(|path| path.as_path())
    }

    /// The plate's light as the other lens draws what was found, with the plate's own grain.
    fn seen_anew(
        &self,
        index: usize,
        read: &ReadPlate,
        found: &Unblurred,
    ) -> Result<Vec<Vec<f32>>, CommandError> {
        let number = self.run.frame(index).number;
        let other = self
            .to
            .read(read.plate.clone(), number, self.depth_file(index), false)?;
        let (setup, plate) = (&other.setup, &other.plate);
        self.to.seen(setup, plate, other.vergence.clone(), |sight| {
            let progress = |share: f64| {
                let done = REMOVAL_SHARE + (1.0 - REMOVAL_SHARE) * share;
                self.run.tell(index, done);
                true
            };
            let lens = &setup.drawing.predictor;
            let planes = found.seen_by(
                (&sight.scene, lens),
                (&read.light, sight.weights),
                &progress,
            );
            Ok(planes.map_err(|e| FileError::from_core(plate.path(), e))?)
        })
    }
}

impl Stages for Job<'_> {
    type Read = ReadPlate;
    type Done = NewFrame;

    fn read(&self, index: usize) -> Result<ReadPlate, CommandError> {
        let frame = self.run.frame(index);
        let depth = self.depth_file(index);
        let read = self
            .from
            .open_plate(&frame.input, frame.number, depth, index == 0)?;
        self.args.removal.check(&read.plate)?;
        Ok(read)
    }

    fn bytes(&self, read: &ReadPlate) -> u64 {
        work_bytes(read)
    }

    fn blur(&self, index: usize, mut read: ReadPlate) -> Result<NewFrame, CommandError> {
        let mut plate = read.plate.clone();
        if read.setup.adjust.is_nothing() {
            read.light.keep(&mut plate)?;
            (read.said).push("at --amount 0 the plate stays as it is".into());
        } else {
            let progress = |share| self.run.tell(index, REMOVAL_SHARE * share);
            let removal = &self.args.removal;
            let lens = (self.from, &self.check);
            let frame = (self.run.frame(index).number, &mut read);
            let found = removal.found(lens, frame, false, &progress)?;
            let planes = self.seen_anew(index, &read, &found)?;
            read.light.put_back(&mut plate, planes)?;
        }
        let told = self.from.told(&read.setup, &read.plate)?;
        self.run.sign(index, &mut plate, &told);
        Ok(NewFrame {
            plate,
            said: read.said,
        })
    }

    fn write(&self, index: usize, frame: NewFrame) -> Outcome {
        self.run.write(index, frame.plate, frame.said)
    }
}
