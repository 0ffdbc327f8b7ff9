//! One frame of a run: read, its blur taken off, written.

use std::path::Path;

use rayon::ThreadPool;

use super::{Grain, RemoveArgs};
use crate::commands::CommandError;
use crate::commands::plates::{FrameFiles, Outcome, ReadPlate, Shared, Shares, Stages};
use crate::commands::removal::{Unblurred, work_bytes};
use crate::files::format::Format;
use crate::files::plate::Plate;
use crate::files::windows::held;

/// What all frames of a run share.
pub(super) struct Job<'a> {
    pub(super) args: &'a RemoveArgs,
    pub(super) shared: &'a Shared<'a>,
    /// The frames to render.
    pub(super) frames: &'a [FrameFiles],
    /// Where files are unpacked: not where frames are worked on, so that both go on at once.
    pub(super) reading: &'a ThreadPool,
    /// Where frames are worked on.
    pub(super) working: &'a ThreadPool,
    /// Told which frame is being worked on and how much of it is done.
    pub(super) shares: &'a Shares,
}

/// A frame to be written.
pub(super) struct SharpFrame {
    plate: Plate,
    said: Vec<String>,
}

impl Job<'_> {
    fn depth_file(&self, index: usize) -> Option<&Path> {
        self.frames[index].read.first().map(|path| path.as_path())
    }

    fn read_plate(&self, index: usize) -> Result<ReadPlate, CommandError> {
        let frame = &self.frames[index];
        let depth = self.depth_file(index);
        let read = self
            .shared
            .open_plate(&frame.input, frame.number, depth, index == 0)?;
        self.args.removal.check(&read.plate)?;
        Ok(read)
    }

    fn sharpen(&self, index: usize, mut read: ReadPlate) -> Result<SharpFrame, CommandError> {
        let mut plate = read.plate.clone();
        if read.setup.adjust.is_nothing() || self.args.strength == 0.0 {
            read.light.keep(&mut plate)?;
            (read.said).push("at --amount 0 or --strength 0 the plate stays as it is".into());
        } else {
            let progress = |share| self.shares.tell(index, share);
            let found = (self.args.removal).found(self.shared, &mut read, &progress)?;
            self.put_sharp(&read, &found, &mut plate)?;
        }
        Ok(SharpFrame {
            plate,
            said: read.said,
        })
    }

    /// Puts the sharp planes into `plate`, with overscan where the file has room for it.
    fn put_sharp(
        &self,
        read: &ReadPlate,
        found: &Unblurred,
        plate: &mut Plate,
    ) -> Result<(), CommandError> {
        let Some(canvas) = found.canvas() else {
            return Ok(());
        };
        let mut planes = found.sharp();
        if self.args.grain == Grain::Keep {
            found.add_grain(&mut planes, false);
        }
        let own = plate.data_window();
        let grows = plate.format() == Format::Exr && !self.args.no_overscan;
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

impl Stages for Job<'_> {
    type Read = ReadPlate;
    type Done = SharpFrame;

    fn read(&self, index: usize) -> Result<ReadPlate, CommandError> {
        self.reading.install(|| self.read_plate(index))
    }

    fn bytes(&self, read: &ReadPlate) -> u64 {
        work_bytes(read)
    }

    fn blur(&self, index: usize, read: ReadPlate) -> Result<SharpFrame, CommandError> {
        self.working.install(|| self.sharpen(index, read))
    }

    fn write(&self, index: usize, frame: SharpFrame) -> Outcome {
        let SharpFrame { plate, mut said } = frame;
        said.extend(plate.write(&self.frames[index].output)?);
        Ok(said)
    }
}
