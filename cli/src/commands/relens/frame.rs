//! One frame of a run: read, one lens's blur taken off and another's put on, written.

use std::path::Path;

use seidel_core::{NoiseGain, RemovedPlate};

use super::RelensArgs;
use crate::commands::CommandError;
use crate::commands::plates::{FrameId, LoadedPlate, Outcome, PlateReader, Run, Stages};
use crate::commands::removal::{LensCheck, work_bytes};
use seidel_image_io::plate::Plate;

/// Share of the work that is the removal.
const REMOVAL_SHARE: f64 = 0.9;

/// The frames of a run: options, readers and progress.
pub(super) struct Job<'a> {
    pub(super) args: &'a RelensArgs,
    /// The lens that the plate was taken with, and the other.
    pub(super) from: &'a PlateReader<'a>,
    pub(super) to: &'a PlateReader<'a>,
    /// Whether the first lens's blur is that of the plate.
    pub(super) check: LensCheck,
    pub(super) run: &'a Run,
}

/// A frame to be written.
pub(super) struct NewFrame {
    plate: Plate,
    warnings: Vec<String>,
}

impl Job<'_> {
    fn depth_file(&self, index: usize) -> Option<&Path> {
        let read = &self.run.frame(index).read;
        read.first().map(|path| path.as_path())
    }

    /// Renders what was `removed` through the other lens, with the plate's own grain.
    fn apply_other(
        &self,
        index: usize,
        loaded: &LoadedPlate,
        removed: &RemovedPlate,
    ) -> Result<Vec<Vec<f32>>, CommandError> {
        let number = self.run.frame(index).number;
        let lens = self.to.frame_lens(number, &mut Vec::new())?;
        let progress = |share: f64| {
            let done = REMOVAL_SHARE + (1.0 - REMOVAL_SHARE) * share;
            self.run.tell(index, done);
            true
        };
        let other = loaded.prepared.seen_through(&lens.session);
        let planes = other.and_then(|other| removed.apply_other(&other, &progress));
        planes.map_err(|e| loaded.in_file(e))
    }
}

impl Stages for Job<'_> {
    type Read = LoadedPlate;
    type Done = NewFrame;

    fn read(&self, index: usize) -> Result<LoadedPlate, CommandError> {
        let frame = self.run.frame(index);
        let id = FrameId::new(frame.number, index);
        let loaded = (self.from).read(&frame.input, id, self.depth_file(index))?;
        self.args.removal.check(&loaded.plate)?;
        Ok(loaded)
    }

    fn bytes(&self, loaded: &LoadedPlate) -> u64 {
        work_bytes(loaded)
    }

    fn blur(&self, index: usize, mut loaded: LoadedPlate) -> Result<NewFrame, CommandError> {
        let mut plate = loaded.plate.clone();
        if loaded.is_neutral() {
            loaded.keep(&mut plate)?;
            (loaded.warnings).push("at --amount 0 the plate stays as it is".into());
        } else {
            let progress = |share| self.run.tell(index, REMOVAL_SHARE * share);
            let number = self.run.frame(index).number;
            let removed = self.args.removal.remove(
                self.from,
                &self.check,
                number,
                &mut loaded,
                NoiseGain::Skip,
                &progress,
            )?;
            let planes = self.apply_other(index, &loaded, &removed)?;
            loaded.put_planes(&mut plate, planes)?;
        }
        let record = self.from.record(&loaded.lens, &loaded.plate)?;
        self.run.set_provenance(index, &mut plate, &record);
        Ok(NewFrame {
            plate,
            warnings: loaded.warnings,
        })
    }

    fn write(&self, index: usize, frame: NewFrame) -> Outcome {
        self.run.write(index, frame.plate, frame.warnings)
    }
}
