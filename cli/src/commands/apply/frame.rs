//! One frame of a run: read, blurred, written.

use std::path::Path;

use seidel_core::plate::apply_bytes;
use seidel_core::render::{Plane, Scene, VergencePass};

use super::occlusion::{HoldoutPixels, HoldoutSource};
use super::{ApplyArgs, EdgeChoice, QualityChoice, residual, verbose};
use crate::commands::CommandError;
use crate::commands::plates::{
    FrameFiles, Light, Outcome, ReadPlate, Rendering, Run, Shared, Sight, Stages,
};
use seidel_image_io::error::FileError;
use seidel_image_io::plate::Plate;
use seidel_image_io::residual::Residual;

/// What all frames of a run share.
pub(super) struct Job<'a> {
    pub(super) args: &'a ApplyArgs,
    pub(super) shared: &'a Shared<'a>,
    pub(super) holdout: &'a HoldoutSource,
    pub(super) run: &'a Run,
}

/// A frame in memory.
pub(super) struct ReadFrame {
    read: ReadPlate,
    holdout: Option<HoldoutPixels>,
    residual: Option<Residual>,
}

/// A frame to be written.
pub(super) struct BlurredFrame {
    plate: Plate,
    said: Vec<String>,
}

impl Job<'_> {
    /// Depth of the plate, then matte and depth of the holdout, then the residual.
    fn files<'s>(&self, frame: &'s FrameFiles) -> [Option<&'s Path>; 4] {
        let mut files = frame.read.iter();
        let given = [
            self.shared.depth_pattern().is_some(),
            self.holdout.matte.is_some(),
            self.holdout.depth.is_some(),
            self.args.residual.is_some(),
        ];
        given.map(|given| {
            let file = given.then(|| files.next());
            file.flatten().map(|path| path.as_path())
        })
    }

    fn scene<'s>(&self, sight: &Sight<'s>) -> Scene<'s> {
        Scene {
            edges: self.args.edges.into(),
            ..sight.scene
        }
    }

    fn rendering<'s>(
        &self,
        scene: &'s Scene<'s>,
        planes: &'s [Plane<'s>],
        holdout: Option<&'s HoldoutPixels>,
    ) -> Rendering<'s> {
        let args = self.args;
        Rendering {
            scene,
            planes,
            occlusion: (args.occlusion.is_on()).then(|| args.occlusion.settings(holdout)),
            extended: args.edges == EdgeChoice::Extend,
        }
    }

    fn rendered(
        &self,
        index: usize,
        sight: &Sight,
        (light, holdout): (&Light, Option<&HoldoutPixels>),
        said: &mut Vec<String>,
    ) -> seidel_core::Result<Vec<Vec<f32>>> {
        let args = self.args;
        let scene = self.scene(sight);
        let varies = matches!(scene.vergence, VergencePass::PerPixel(_));
        if varies && !args.occlusion.is_on() && args.quality != QualityChoice::Exact {
            said.push(
                "depth varies over the plate: without occlusion it is rendered exactly, whatever --quality says"
                    .into(),
            );
        }
        let progress = |share| {
            self.run.tell(index, share);
            true
        };
        let planes = light.with_weights(sight.weights);
        let rendering = self.rendering(&scene, &planes, holdout);
        let inner = args.quality.renderer();
        if !args.verbose {
            return Ok(rendering.by(&*inner, &progress)?.planes);
        }
        let about = (args, light.colour_count(), light.peak());
        let (blurred, told) = verbose::rendered(&rendering, &*inner, about, &progress)?;
        said.push(told);
        Ok(blurred)
    }
}

impl Stages for Job<'_> {
    type Read = ReadFrame;
    type Done = BlurredFrame;

    fn read(&self, index: usize) -> Result<ReadFrame, CommandError> {
        let frame = self.run.frame(index);
        let [depth, matte, matte_depth, residual] = self.files(frame);
        let mut read = self
            .shared
            .open_plate(&frame.input, frame.number, depth, index == 0)?;
        let view = self.shared.view(&read.setup, &read.plate)?;
        let files = (matte, matte_depth);
        let holdout = self.holdout.read(
            &read.plate,
            files,
            self.shared.meaning,
            &view,
            &mut read.said,
        )?;
        let residual = residual
            .map(|file| {
                let mut told = self.shared.told(&read.setup, &read.plate)?;
                told.extend(self.args.told());
                residual::open(file, (&read.plate, &read.light), &told, &mut read.said)
            })
            .transpose()?;
        Ok(ReadFrame {
            read,
            holdout,
            residual,
        })
    }

    fn bytes(&self, frame: &ReadFrame) -> u64 {
        let read = &frame.read;
        let pixels = read.plate.width() as u64 * read.plate.height() as u64;
        read.plate.held_bytes() + apply_bytes(pixels, read.light.plane_count() as u64)
    }

    fn blur(&self, index: usize, frame: ReadFrame) -> Result<BlurredFrame, CommandError> {
        let ReadPlate {
            setup,
            mut plate,
            light,
            vergence,
            mut said,
        } = frame.read;
        let mut told = self.shared.told(&setup, &plate)?;
        told.extend(self.args.told());
        self.run.sign(index, &mut plate, &told);
        if setup.adjust.is_nothing() {
            light.keep(&mut plate)?;
            if self.args.verbose {
                said.push("not rendered: at --amount 0 the plate stays as it is".into());
            }
            if let Some(residual) = &frame.residual {
                plate.reframe(residual.plate);
            }
            return Ok(BlurredFrame { plate, said });
        }
        let blurred = self.shared.seen(&setup, &plate, vergence, |sight| {
            let holdout = frame.holdout.map(|h| h.changed(sight.refocused));
            let holdout = holdout.transpose()?;
            let in_plate = |e| FileError::from_core(plate.path(), e);
            let mut blurred = self
                .rendered(index, sight, (&light, holdout.as_ref()), &mut said)
                .map_err(in_plate)?;
            light.develop(&setup.drawing.predictor, sight.weights, &mut blurred);
            if let Some(kept) = &frame.residual {
                let blur = |planes: &[Plane]| {
                    let scene = self.scene(sight);
                    let inner = self.args.quality.renderer();
                    let rendering = self.rendering(&scene, planes, holdout.as_ref());
                    Ok(rendering.by(&*inner, &|_| true)?.planes)
                };
                residual::add(kept, (&light, sight.weights), &mut blurred, blur)
                    .map_err(in_plate)?;
            }
            Ok(blurred)
        })?;
        light.put_back(&mut plate, blurred)?;
        if let Some(residual) = &frame.residual {
            plate.reframe(residual.plate);
        }
        Ok(BlurredFrame { plate, said })
    }

    fn write(&self, index: usize, frame: BlurredFrame) -> Outcome {
        self.run.write(index, frame.plate, frame.said)
    }
}
