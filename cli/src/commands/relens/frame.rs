//! One frame of a run: read, the blur of one lens replaced by that of another, written.

use std::sync::Arc;

use seidel_core::{LensSession, NoiseGain, RemovedPlate};

use crate::commands::CommandError;
use crate::commands::plates::{FinishedFrame, FrameFiles, LoadedPlate, PlateReader, ViewWork};
use crate::commands::removal::Removal;
use seidel_image_io::plate::PlateFile;

/// The work on the frames of a run.
pub(super) struct Job<'a> {
    pub(super) removal: Removal<'a>,
    /// Reader with the lens whose blur the plate gets.
    pub(super) to: &'a PlateReader<'a>,
}

impl Job<'_> {
    /// Renders the sharp image through the lens `to`, with the plate's own grain.
    fn apply_other(
        &self,
        index: usize,
        loaded: &LoadedPlate,
        removed: &RemovedPlate,
        to: &Arc<LensSession>,
    ) -> Result<Vec<Vec<f32>>, CommandError> {
        let other = loaded.prepared.for_session(to);
        let progress = |share| self.removal.show_render_progress(index, share);
        let planes =
            other.and_then(|other| removed.apply_other(&loaded.prepared, &other, &progress));
        planes.map_err(|e| loaded.in_file(e))
    }
}

impl ViewWork for Job<'_> {
    type Loaded = LoadedPlate;

    fn files(&self, index: usize) -> &FrameFiles {
        self.removal.frame(index)
    }

    fn plate<'a>(&self, loaded: &'a LoadedPlate) -> &'a PlateFile {
        &loaded.plate
    }

    fn read(&self, index: usize, view: usize) -> Result<LoadedPlate, CommandError> {
        self.removal.read(index, view)
    }

    fn memory_bytes(&self, loaded: &LoadedPlate) -> u64 {
        self.removal.memory_bytes(loaded)
    }

    fn warnings(&self, loaded: &LoadedPlate) -> Vec<String> {
        loaded.warnings.clone()
    }

    fn process(
        &self,
        index: usize,
        mut loaded: LoadedPlate,
    ) -> Result<FinishedFrame, CommandError> {
        let mut plate = loaded.plate.clone();
        let number = self.removal.frame(index).number;
        let to = (self.to).frame_lens(number, loaded.focused_at, &mut Vec::new())?;
        let to = to.session;
        if loaded.is_neutral() {
            loaded.put_unchanged(&mut plate)?;
            (loaded.warnings).push("at --amount 0 the plate stays as it is".into());
        } else if loaded.lens.session.is_same_as(&to) {
            // Whatever the check of the lens would find.
            loaded.put_unchanged(&mut plate)?;
            (loaded.warnings).push("both lenses are the same: the plate stays as it is".into());
        } else {
            let removed = self.removal.remove(index, &mut loaded, NoiseGain::Skip)?;
            let planes = self.apply_other(index, &loaded, &removed, &to)?;
            loaded.put_planes(&mut plate, planes)?;
        }
        let mut record = self.removal.reader.record(&loaded.lens, &loaded.plate)?;
        record.extend(self.to.look_record(number)?);
        Ok(FinishedFrame {
            record,
            side_files: Vec::new(),
            plate,
            warnings: loaded.warnings,
        })
    }
}
