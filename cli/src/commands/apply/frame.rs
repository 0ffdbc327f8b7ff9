//! One frame of a run: read, blurred, written.

use std::path::Path;

use seidel_core::render::VergencePass;
use seidel_core::{Rendering, apply_bytes};

use super::occlusion::HoldoutSource;
use super::{ApplyArgs, QualityChoice, residual, verbose};
use crate::commands::CommandError;
use crate::commands::plates::{
    FrameFiles, FrameId, LoadedPlate, Outcome, PlateReader, Run, Stages,
};
use seidel_image_io::plate::Plate;
use seidel_image_io::residual::Residual;

/// The frames of a run: options, reader and progress.
pub(super) struct Job<'a> {
    pub(super) args: &'a ApplyArgs,
    pub(super) reader: &'a PlateReader<'a>,
    pub(super) holdout: &'a HoldoutSource,
    pub(super) run: &'a Run,
}

/// A frame in memory.
pub(super) struct LoadedFrame {
    plate: LoadedPlate,
    residual: Option<Residual>,
}

/// A frame to be written.
pub(super) struct BlurredFrame {
    plate: Plate,
    warnings: Vec<String>,
}

/// The files that are read beside a plate.
struct FrameInputs<'s> {
    depth: Option<&'s Path>,
    matte: Option<&'s Path>,
    matte_depth: Option<&'s Path>,
    residual: Option<&'s Path>,
}

impl Job<'_> {
    fn inputs<'s>(&self, frame: &'s FrameFiles) -> FrameInputs<'s> {
        let mut files = frame.read.iter().map(|path| path.as_path());
        let mut next = |given: bool| if given { files.next() } else { None };
        FrameInputs {
            depth: next(self.reader.depth_pattern().is_some()),
            matte: next(self.holdout.matte.is_some()),
            matte_depth: next(self.holdout.depth.is_some()),
            residual: next(self.args.residual.is_some()),
        }
    }

    /// The settings of the frame by name.
    fn record(&self, plate: &LoadedPlate) -> Result<Vec<(String, String)>, CommandError> {
        let mut record = self.reader.record(&plate.lens, &plate.plate)?;
        record.extend(self.args.record());
        Ok(record)
    }

    fn render(
        &self,
        index: usize,
        plate: &LoadedPlate,
        rendering: &Rendering,
        warnings: &mut Vec<String>,
    ) -> seidel_core::Result<Vec<Vec<f32>>> {
        let varies = matches!(rendering.scene.vergence, VergencePass::PerPixel(_));
        let occlusion = rendering.occlusion.is_some();
        if varies && !occlusion && self.args.quality != QualityChoice::Exact {
            warnings.push(
                "depth varies over the plate: without occlusion it is rendered exactly, whatever --quality says"
                    .into(),
            );
        }
        let progress = |share| {
            self.run.tell(index, share);
            true
        };
        let rendered = rendering.render(None, &progress)?;
        if self.args.verbose {
            let report = verbose::report(rendering, &rendered, &plate.prepared, self.args)?;
            warnings.push(report);
        }
        Ok(rendered.planes)
    }
}

impl Stages for Job<'_> {
    type Read = LoadedFrame;
    type Done = BlurredFrame;

    fn read(&self, index: usize) -> Result<LoadedFrame, CommandError> {
        let frame = self.run.frame(index);
        let inputs = self.inputs(frame);
        let id = FrameId::new(frame.number, index);
        let mut plate = self.reader.read(&frame.input, id, inputs.depth)?;
        let holdout = self.holdout.read(
            &plate.plate,
            (self.reader.geometry(&plate.plate)?, self.reader.meaning),
            &plate.lens.session,
            inputs.matte,
            inputs.matte_depth,
            &mut plate.warnings,
        )?;
        plate.prepared = plate.prepared.with_holdout(holdout);
        let residual = match inputs.residual {
            Some(file) => Some(residual::open(file, &mut plate, |p| self.record(p))?),
            None => None,
        };
        Ok(LoadedFrame { plate, residual })
    }

    fn bytes(&self, frame: &LoadedFrame) -> u64 {
        let plate = &frame.plate.plate;
        let pixels = plate.width() as u64 * plate.height() as u64;
        let planes = frame.plate.prepared.planes().len() as u64;
        plate.memory_bytes() + apply_bytes(pixels, planes)
    }

    fn blur(&self, index: usize, frame: LoadedFrame) -> Result<BlurredFrame, CommandError> {
        let LoadedFrame {
            plate: mut loaded,
            residual,
        } = frame;
        let mut plate = loaded.plate.clone();
        let mut warnings = std::mem::take(&mut loaded.warnings);
        self.run
            .set_provenance(index, &mut plate, &self.record(&loaded)?);
        if loaded.is_neutral() {
            loaded.keep(&mut plate)?;
            if self.args.verbose {
                warnings.push("not rendered: at --amount 0 the plate stays as it is".into());
            }
        } else {
            let render =
                |rendering: &Rendering| self.render(index, &loaded, rendering, &mut warnings);
            let blurred = loaded.prepared.apply_with(render);
            let mut blurred = blurred.map_err(|e| loaded.in_file(e))?;
            if let Some(residual) = &residual {
                residual::add(residual, &loaded.prepared, &mut blurred)
                    .map_err(|e| loaded.in_file(e))?;
            }
            loaded.put_planes(&mut plate, blurred)?;
        }
        if let Some(residual) = &residual {
            plate.set_data_window(residual.plate);
        }
        Ok(BlurredFrame { plate, warnings })
    }

    fn write(&self, index: usize, frame: BlurredFrame) -> Outcome {
        self.run.write(index, frame.plate, frame.warnings)
    }
}
