//! One frame of a run: read, blurred, written.

use std::path::Path;
use std::sync::Arc;

use rayon::ThreadPool;
use seidel_core::profile::LensProfile;
use seidel_core::render::{BlurField, NonSquare, PlateExtent, Scene, VergencePass};

use super::depth::{DepthMeaning, DepthSource};
use super::depth_check::PlateView;
use super::occlusion::{HoldoutPixels, HoldoutSource};
use super::plate::{Light, plate_map, plate_weights};
use super::queue::{Outcome, Stages};
use super::rendering::Rendering;
use super::setup::Setup;
use super::{ApplyArgs, EdgeChoice, QualityChoice, Vergences, verbose};
use crate::commands::CommandError;
use crate::commands::drawing::Drawing;
use crate::files::animation::Animation;
use crate::files::error::FileError;
use crate::files::plate::Plate;
use crate::files::sequence::Step;

/// What all frames of a run share.
pub(super) struct Job<'a> {
    pub(super) args: &'a ApplyArgs,
    /// The lens as its file has it.
    pub(super) measured: &'a LensProfile,
    /// The lens of frames that no table changes.
    pub(super) setup: Arc<Setup>,
    /// What changes by frame.
    pub(super) animation: Option<&'a Animation>,
    pub(super) depth: &'a DepthSource,
    pub(super) holdout: &'a HoldoutSource,
    /// What the numbers of depth passes are.
    pub(super) meaning: DepthMeaning,
    /// The frames to render.
    pub(super) steps: &'a [&'a Step],
    /// Where files are unpacked: not where frames are blurred, so that both go on at once.
    pub(super) reading: &'a ThreadPool,
    /// Where frames are blurred.
    pub(super) blurring: &'a ThreadPool,
    /// Told which frame is being blurred and how much of it is.
    pub(super) progress: &'a (dyn Fn(usize, f64) + Sync),
}

/// A frame in memory.
pub(super) struct ReadFrame {
    setup: Arc<Setup>,
    plate: Plate,
    light: Light,
    vergence: Vergences,
    holdout: Option<HoldoutPixels>,
    said: Vec<String>,
}

/// A frame to be written.
pub(super) struct BlurredFrame {
    plate: Plate,
    said: Vec<String>,
}

impl Job<'_> {
    fn depth_file<'s>(&self, step: &'s Step) -> Option<&'s Path> {
        let given = self.depth.file_pattern().is_some();
        given.then(|| step.paths[2].as_path())
    }

    /// Matte and depth of the holdout.
    fn holdout_files<'s>(&self, step: &'s Step) -> (Option<&'s Path>, Option<&'s Path>) {
        let first = 2 + usize::from(self.depth.file_pattern().is_some());
        let matte = self.holdout.matte.as_ref();
        let depth = self.holdout.depth.as_ref();
        (
            matte.map(|_| step.paths[first].as_path()),
            depth.map(|_| step.paths[first + 1].as_path()),
        )
    }

    /// The lens of a frame; remarks go to `said`.
    fn setup(&self, step: &Step, said: &mut Vec<String>) -> Result<Arc<Setup>, CommandError> {
        let (Some(table), Some(frame)) = (self.animation, step.frame) else {
            return Ok(Arc::clone(&self.setup));
        };
        let settings = self.args.settings().at(table, frame)?;
        let setup = settings.open(self.measured, &self.args.lens, said)?;
        Ok(Arc::new(setup))
    }

    fn read_frame(&self, index: usize) -> Result<ReadFrame, CommandError> {
        let step = self.steps[index];
        let mut said = Vec::new();
        let plate = Plate::open(&step.paths[0], &self.args.plate.options())?;
        let light = self.args.plate.light(&plate, &mut said)?;
        let depth_file = self.depth_file(step);
        let setup = self.setup(step, &mut said)?;
        let Drawing {
            lens, predictor, ..
        } = &setup.drawing;
        let aspect = self.args.plate.pixel_aspect(&plate)?;
        let map = plate_map(&plate, predictor, self.args.plate.lens_scale, aspect);
        let view = PlateView::new(lens, (map, aspect), setup.adjust.axis_offset_px());
        let first = index == 0;
        let vergence = self
            .depth
            .read(&plate, depth_file, predictor, &view, first, &mut said)?;
        let files = self.holdout_files(step);
        let holdout = self.holdout.read(&plate, files, self.meaning, &view)?;
        Ok(ReadFrame {
            setup,
            plate,
            light,
            vergence,
            holdout,
            said,
        })
    }

    fn blur_frame(&self, index: usize, frame: ReadFrame) -> Result<BlurredFrame, CommandError> {
        let ReadFrame {
            setup,
            mut plate,
            light,
            vergence,
            holdout,
            mut said,
        } = frame;
        let args = self.args;
        let Drawing {
            predictor: lens,
            model,
            ..
        } = &setup.drawing;
        let in_plate = |e| FileError::from_core(&self.steps[index].paths[0], e);
        let weights = plate_weights(&plate, lens).map_err(in_plate)?;
        if setup.adjust.is_nothing() {
            // As it is to the bit, and not only to the rounding of a render; but for what was scrubbed.
            if !plate.non_finite().is_empty() {
                light.put_back(&mut plate, light.copied())?;
            }
            if args.verbose {
                said.push("not rendered: at --amount 0 the plate stays as it is".into());
            }
            return Ok(BlurredFrame { plate, said });
        }
        let aspect = args.plate.pixel_aspect(&plate)?;
        let map = plate_map(&plate, lens, args.plate.lens_scale, aspect);
        let adjusted = (setup.adjust).adjusted(lens, [map.scale / aspect, map.scale])?;
        let non_square = match aspect == 1.0 {
            true => None,
            false => Some(NonSquare::new(&adjusted, aspect)?),
        };
        let seen: &dyn BlurField = match &non_square {
            Some(lens) => lens,
            None => &adjusted,
        };
        let extent = PlateExtent {
            map,
            width: plate.width(),
            height: plate.height(),
        };
        let refocused = |v| setup.focus.applied(v, seen, extent, setup.focused_at);
        let vergence = refocused(vergence)?;
        let holdout = holdout.map(|h| h.changed(refocused)).transpose()?;
        let scene = Scene {
            lens: seen,
            model: *model,
            width: plate.width(),
            height: plate.height(),
            map,
            vergence: vergence.pass(),
            edges: args.edges.into(),
            displacement: args.geometry.into(),
        };
        let varies = matches!(scene.vergence, VergencePass::PerPixel(_));
        if varies && !args.occlusion.is_on() && args.quality != QualityChoice::Exact {
            said.push(
                "depth varies over the plate: without occlusion it is rendered exactly, whatever --quality says"
                    .into(),
            );
        }
        let progress = |share| {
            (self.progress)(index, share);
            true
        };
        let planes = light.with_weights(&weights);
        let settings = args.occlusion.settings(holdout.as_ref());
        let rendering = Rendering {
            scene: &scene,
            planes: &planes,
            occlusion: args.occlusion.is_on().then_some(settings),
            extended: args.edges == EdgeChoice::Extend,
        };
        let inner = args.quality.renderer();
        let mut blurred = if args.verbose {
            let about = (args, light.colour_count(), light.peak());
            let (blurred, told) =
                verbose::rendered(&rendering, &*inner, about, &progress).map_err(in_plate)?;
            said.push(told);
            blurred
        } else {
            rendering.by(&*inner, &progress).map_err(in_plate)?
        };
        light.develop(lens, &weights, &mut blurred);
        light.put_back(&mut plate, blurred)?;
        Ok(BlurredFrame { plate, said })
    }
}

impl Stages for Job<'_> {
    type Read = ReadFrame;
    type Done = BlurredFrame;

    fn read(&self, index: usize) -> Result<ReadFrame, CommandError> {
        self.reading.install(|| self.read_frame(index))
    }

    fn bytes(&self, frame: &ReadFrame) -> u64 {
        let pixels = frame.plate.width() as u64 * frame.plate.height() as u64;
        // Of each plane: the light before, what a renderer gathers in double precision, and the light
        // after. Of each pixel: its depth as read and as vergence.
        let planes = frame.light.plane_count() as u64;
        frame.plate.held_bytes() + pixels * (planes * (4 + 8 + 4) + (4 + 4))
    }

    fn blur(&self, index: usize, frame: ReadFrame) -> Result<BlurredFrame, CommandError> {
        self.blurring.install(|| self.blur_frame(index, frame))
    }

    fn write(&self, index: usize, frame: BlurredFrame) -> Outcome {
        let BlurredFrame { plate, mut said } = frame;
        said.extend(plate.write(&self.steps[index].paths[1])?);
        Ok(said)
    }
}
