//! What the frames of a run share: the lens, where depth comes from, and how plates are read and seen.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use seidel_core::plate::{LensUse, Placed};
use seidel_core::profile::LensProfile;
use seidel_core::render::{Gather, Occlusion, Scene};

use super::adjust::AdjustArgs;
use super::colour::{ColourRoom, PlateColour};
use super::depth::{DepthArgs, DepthSource};
use super::depth_check::PlateView;
use super::focus::FocusArgs;
use super::plate::{Light, PlateArgs, placed, plate_weights};
use super::setup::{Settings, Setup, check_names};
use super::{DepthMeaning, Geometry, Rendering, Vergences};
use crate::commands::drawing::DrawingArgs;
use crate::commands::{CommandError, read_lens};
use crate::files::animation::Animation;
use seidel_image_io::error::FileError;
use seidel_image_io::plate::Plate;

/// Options about how a lens is used.
#[derive(Debug, Args)]
pub(crate) struct LensArgs {
    #[command(flatten)]
    drawing: DrawingArgs,
    #[command(flatten)]
    adjust: AdjustArgs,
    #[command(flatten)]
    focus: FocusArgs,
    /// Values by frame of --amount, --focus-distance, --f-number and others: CSV with a column `frame` and one an
    /// option, or JSON; between frames that have a value it changes evenly
    #[arg(long, value_name = "FILE")]
    animate: Option<PathBuf>,
    /// Which displacement of light to render
    #[arg(long, value_enum, default_value_t = Geometry::Lateral)]
    pub(crate) geometry: Geometry,
}

impl LensArgs {
    /// How the lens is to be where no table says otherwise.
    fn settings(&self) -> Settings {
        Settings {
            drawing: self.drawing.clone(),
            adjust: self.adjust.clone(),
            focus: self.focus.clone(),
        }
    }
}

/// What the frames of a run share.
pub(crate) struct Shared<'a> {
    args: &'a LensArgs,
    plate: &'a PlateArgs,
    /// The lens as its file has it.
    measured: LensProfile,
    /// That file.
    lens: &'a Path,
    /// The lens of frames that no table changes.
    setup: Arc<Setup>,
    /// What changes by frame.
    animation: Option<Animation>,
    depth: DepthSource,
    /// What converts colours, where they are to be.
    colour: Option<ColourRoom<'a>>,
    /// What the numbers of depth passes are.
    pub(crate) meaning: DepthMeaning,
}

/// A frame in memory.
pub(crate) struct ReadPlate {
    pub(crate) setup: Arc<Setup>,
    pub(crate) plate: Plate,
    pub(crate) light: Light,
    pub(crate) vergence: Vergences,
    /// What the user should know of it.
    pub(crate) said: Vec<String>,
}

/// A plate through its lens.
pub(crate) struct Sight<'a> {
    /// With mirrored edges.
    pub(crate) scene: Scene<'a>,
    /// How much each lens channel acts on each plane of light.
    pub(crate) weights: &'a [Vec<f64>],
    /// What the options about focus make of vergences.
    pub(crate) refocused: &'a dyn Fn(Vergences) -> seidel_core::Result<Vergences>,
}

impl<'a> Shared<'a> {
    /// Reads the `lens`, and settles what the options leave open for an OUT of the name `output`; remarks go to `said`.
    pub(crate) fn open(
        lens: &'a Path,
        (args, depth, plate): (&'a LensArgs, &DepthArgs, &'a PlateArgs),
        output: &'a str,
        said: &mut Vec<String>,
    ) -> Result<Self, CommandError> {
        let measured = read_lens(lens)?;
        let setup = args.settings().open(&measured, lens, said)?;
        let animation = args.animate.as_deref().map(Animation::open).transpose()?;
        if let Some(table) = &animation {
            check_names(table)?;
        }
        let meaning = depth.meaning()?;
        let depth = depth.source()?;
        depth.check_lens(&setup.drawing.predictor, lens)?;
        let colour = plate.colour.room(output, said)?;
        Ok(Self {
            args,
            plate,
            measured,
            lens,
            setup: Arc::new(setup),
            animation,
            depth,
            colour,
            meaning,
        })
    }

    /// The file of the depth pass as given, which may hold a frame pattern.
    pub(crate) fn depth_pattern(&self) -> Option<&str> {
        self.depth.file_pattern()
    }

    /// Whether the option called `name` has values by frame.
    pub(crate) fn is_animated(&self, name: &str) -> bool {
        let table = self.animation.iter();
        table.flat_map(Animation::names).any(|own| own == name)
    }

    /// Refuses values by frame where there are no frames.
    pub(crate) fn check_animation(&self, has_frames: bool) -> Result<(), CommandError> {
        if self.animation.is_none() || has_frames {
            return Ok(());
        }
        Err(CommandError::Usage(
            "--animate needs frames: give IN and OUT a frame pattern, and --frames".to_owned(),
        ))
    }

    /// The lens of the frame `number`; remarks go to `said`.
    fn setup(
        &self,
        number: Option<i64>,
        said: &mut Vec<String>,
    ) -> Result<Arc<Setup>, CommandError> {
        let (Some(table), Some(number)) = (&self.animation, number) else {
            return Ok(Arc::clone(&self.setup));
        };
        let settings = self.args.settings().at(table, number)?;
        Ok(Arc::new(settings.open(&self.measured, self.lens, said)?))
    }

    /// Opens the plate at `path`, frame `number` of a run, with its lens and depth, which is in `depth_file` where
    /// [`Shared::depth_pattern`] says so. Depth of the `first` frame is looked at for doubts.
    pub(crate) fn open_plate(
        &self,
        path: &Path,
        number: Option<i64>,
        depth_file: Option<&Path>,
        first: bool,
    ) -> Result<ReadPlate, CommandError> {
        let plate = Plate::open(path, &self.plate.options())?;
        self.read(plate, number, depth_file, first)
    }

    /// As [`Shared::open_plate`], of a plate in memory.
    pub(crate) fn read(
        &self,
        plate: Plate,
        number: Option<i64>,
        depth_file: Option<&Path>,
        first: bool,
    ) -> Result<ReadPlate, CommandError> {
        let mut said = Vec::new();
        let colour = self.colour.as_ref();
        let colour = colour.map(|colour| colour.of(&plate, &mut said));
        let colour = colour.transpose()?;
        self.read_in(plate, colour, (number, depth_file, first), said)
    }

    /// As [`Shared::read`], of a plate that was made of `light` and is written in its colour space.
    pub(crate) fn read_written(
        &self,
        plate: Plate,
        light: &Light,
        number: Option<i64>,
        depth_file: Option<&Path>,
    ) -> Result<ReadPlate, CommandError> {
        let colour = light.written_colour();
        self.read_in(plate, colour, (number, depth_file, false), Vec::new())
    }

    fn read_in(
        &self,
        plate: Plate,
        colour: Option<PlateColour>,
        (number, depth_file, first): (Option<i64>, Option<&Path>, bool),
        mut said: Vec<String>,
    ) -> Result<ReadPlate, CommandError> {
        if self.colour.is_none() && first {
            said.extend(plate.unheeded_colour_space());
        }
        let light = self.plate.light(&plate, colour, &mut said)?;
        let setup = self.setup(number, &mut said)?;
        let view = self.view(&setup, &plate)?;
        let lens = &setup.drawing.predictor;
        let vergence = self
            .depth
            .read(&plate, depth_file, lens, &view, first, &mut said)?;
        Ok(ReadPlate {
            setup,
            plate,
            light,
            vergence,
            said,
        })
    }

    /// How `plate` lies in the lens's frame.
    pub(crate) fn view<'s>(
        &self,
        setup: &'s Setup,
        plate: &Plate,
    ) -> Result<PlateView<'s>, CommandError> {
        let placed = self.placed(setup, plate)?;
        let offset = setup.adjust.axis_offset_px();
        Ok(PlateView::new(&setup.drawing.lens, &placed, offset))
    }

    fn placed(&self, setup: &Setup, plate: &Plate) -> Result<Placed, CommandError> {
        let aspect = self.plate.pixel_aspect(plate)?;
        let lens = &setup.drawing.predictor;
        Ok(placed(plate, lens, self.plate.lens_scale, aspect))
    }

    /// How `plate` is seen, each setting by its name.
    pub(crate) fn told(
        &self,
        setup: &Setup,
        plate: &Plate,
    ) -> Result<Vec<(String, String)>, CommandError> {
        let mut told = setup.told.clone();
        told.extend(self.depth.told());
        let scale = self.plate.lens_scale;
        let aspect = self.plate.pixel_aspect(plate)?;
        for (name, value) in [
            (
                "geometry",
                format!("{:?}", self.args.geometry).to_lowercase(),
            ),
            (
                "lens-scale",
                scale.map_or_else(|| "from the display window".to_owned(), |s| s.to_string()),
            ),
            ("pixel-aspect", aspect.to_string()),
            (
                "working-space",
                self.colour
                    .as_ref()
                    .map_or_else(|| "the plate's".to_owned(), |c| c.working().to_owned()),
            ),
        ] {
            told.push((name.to_owned(), value));
        }
        Ok(told)
    }

    /// How [`Shared::applied`] draws, each setting by its name.
    pub(crate) fn defaults_told() -> [(String, String); 3] {
        [
            ("quality", "final"),
            ("edges", "mirror"),
            ("occlusion", "on"),
        ]
        .map(|(name, value)| (name.to_owned(), value.to_owned()))
    }

    /// The planes of light that `seidel apply`, its options about quality, edges and occlusion left out, makes of a
    /// plate; `progress` is told the share done.
    pub(crate) fn applied(
        &self,
        read: &ReadPlate,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Vec<Vec<f32>>, CommandError> {
        let ReadPlate {
            setup,
            plate,
            light,
            vergence,
            ..
        } = read;
        if setup.adjust.is_nothing() {
            return Ok(light.copied());
        }
        self.seen(setup, plate, vergence.clone(), |sight| {
            let rendering = Rendering {
                scene: &sight.scene,
                planes: &light.with_weights(sight.weights),
                occlusion: Some(Occlusion::default()),
                extended: false,
            };
            let tell = |share| {
                progress(share);
                true
            };
            let blurred = rendering.by(&Gather::default(), &tell);
            let mut blurred = blurred
                .map_err(|e| FileError::from_core(plate.path(), e))?
                .planes;
            light.develop(&setup.drawing.predictor, sight.weights, &mut blurred);
            Ok(blurred)
        })
    }

    /// Does `then` with what there is to draw of `plate` at some vergences.
    pub(crate) fn seen<T>(
        &self,
        setup: &Setup,
        plate: &Plate,
        vergence: Vergences,
        then: impl FnOnce(&Sight) -> Result<T, CommandError>,
    ) -> Result<T, CommandError> {
        let lens = &setup.drawing.predictor;
        let weights =
            plate_weights(plate, lens).map_err(|e| FileError::from_core(plate.path(), e))?;
        let placed = self.placed(setup, plate)?;
        let used = LensUse {
            lens,
            model: setup.drawing.model,
            amount: setup.adjust.amount,
            channel_scales: setup.adjust.channel_scales(lens)?,
            axis_offset_px: setup.adjust.axis_offset_px(),
            focus: setup.focus.controls(setup.focused_at),
            displacement: self.args.geometry.into(),
        };
        used.seen(&placed, vergence, |seen| {
            then(&Sight {
                scene: Scene { ..seen.scene },
                weights: &weights,
                refocused: seen.refocused,
            })
        })
    }
}
