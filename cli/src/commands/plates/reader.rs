//! The plates of a run: read, and prepared for the lens of their frame.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use seidel_core::profile::LensProfile;
use seidel_core::{DepthMeaning, PlateGeometry, PreparedPlate, Settings};

use super::Geometry;
use super::adjust::AdjustArgs;
use super::colour::{ColourRoom, PlateColour};
use super::depth::{DepthArgs, DepthSource, FrameOrder};
use super::focus::FocusArgs;
use super::frame_lens::{FrameLens, LensOptions, check_names};
use super::plate::{PlateArgs, plate_geometry, put_image};
use crate::Console;
use crate::commands::CommandError;
use crate::commands::drawing::DrawingArgs;
use seidel_image_io::animation::Animation;
use seidel_image_io::error::FileError;
use seidel_image_io::lens_profile;
use seidel_image_io::plate::Plate;

/// Options about the lens of a plate.
#[derive(Debug, Args)]
pub(crate) struct LensArgs {
    #[command(flatten)]
    drawing: DrawingArgs,
    #[command(flatten)]
    adjust: AdjustArgs,
    #[command(flatten)]
    focus: FocusArgs,
    /// Values by frame of --amount, --focus-distance, --f-number and others: CSV with a column `frame` and one an
    /// option, or JSON; between frames that have a value it is interpolated
    #[arg(long, value_name = "FILE")]
    animate: Option<PathBuf>,
    /// Displacement of light to render
    #[arg(long, value_enum, default_value_t = Geometry::Lateral)]
    pub(crate) geometry: Geometry,
}

impl LensArgs {
    /// The options of a frame that no table changes.
    fn options(&self) -> LensOptions {
        LensOptions {
            drawing: self.drawing.clone(),
            adjust: self.adjust.clone(),
            focus: self.focus.clone(),
        }
    }
}

/// The options of a command on plates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ReaderOptions<'a> {
    pub(crate) lens: &'a LensArgs,
    pub(crate) depth: &'a DepthArgs,
    pub(crate) plate: &'a PlateArgs,
    /// OUT, whose name decides the colour space that is written.
    pub(crate) output: &'a str,
}

/// Reads the plates of a run and prepares them for the lens of their frame.
pub(crate) struct PlateReader<'a> {
    lens_args: &'a LensArgs,
    plate_args: &'a PlateArgs,
    /// The lens as its file has it.
    measured: LensProfile,
    lens_file: &'a Path,
    /// Settings that are not about the lens.
    base: Settings,
    /// The lens of frames that no table changes.
    lens: FrameLens,
    animation: Option<Animation>,
    depth: DepthSource,
    /// Conversion of colours, where one is asked for.
    colour: Option<ColourRoom<'a>>,
    /// The meaning of the samples of depth passes.
    pub(crate) meaning: DepthMeaning,
}

/// A plate in memory.
pub(crate) struct LoadedPlate {
    pub(crate) lens: FrameLens,
    pub(crate) plate: Plate,
    pub(crate) prepared: PreparedPlate,
    colour: Option<PlateColour>,
    pub(crate) warnings: Vec<String>,
}

/// The number of a frame in its sequence, and its place in the run.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FrameId {
    pub(crate) number: Option<i64>,
    pub(crate) order: FrameOrder,
}

impl FrameId {
    /// The frame `number` at `index` of the run.
    pub(crate) fn new(number: Option<i64>, index: usize) -> Self {
        let order = if index == 0 {
            FrameOrder::First
        } else {
            FrameOrder::Later
        };
        Self { number, order }
    }
}

impl<'a> PlateReader<'a> {
    /// Reads the profile `lens_file` and sets the lens by `options`; prints warnings. `base` holds the settings that are not
    /// about the lens.
    pub(crate) fn open(
        lens_file: &'a Path,
        options: &ReaderOptions<'a>,
        mut base: Settings,
        console: &mut Console,
    ) -> Result<Self, CommandError> {
        let ReaderOptions {
            lens: lens_args,
            depth: depth_args,
            plate: plate_args,
            output,
        } = *options;
        let warnings = &mut Vec::new();
        base.displacement = lens_args.geometry.into();
        let measured = lens_profile::read(lens_file)?;
        let options = lens_args.options();
        let lens = options.set(&measured, lens_file, &base, warnings)?;
        let animation = lens_args
            .animate
            .as_deref()
            .map(Animation::open)
            .transpose()?;
        if let Some(table) = &animation {
            check_names(table)?;
        }
        let meaning = depth_args.meaning()?;
        let depth = depth_args.source()?;
        depth.check_lens(lens.session.lens(), lens_file)?;
        let colour = plate_args.colour.room(output, warnings)?;
        for warning in warnings {
            console.remark(warning);
        }
        Ok(Self {
            lens_args,
            plate_args,
            measured,
            lens_file,
            base,
            lens,
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

    /// Rejects an animation table where the run is not a sequence.
    pub(crate) fn check_animation(&self, has_frames: bool) -> Result<(), CommandError> {
        if self.animation.is_none() || has_frames {
            return Ok(());
        }
        Err(CommandError::Usage(
            "--animate needs frames: give IN and OUT a frame pattern, and --frames".to_owned(),
        ))
    }

    /// Returns the lens of frame `number`. Adds to `warnings`.
    pub(crate) fn frame_lens(
        &self,
        number: Option<i64>,
        warnings: &mut Vec<String>,
    ) -> Result<FrameLens, CommandError> {
        let (Some(table), Some(number)) = (&self.animation, number) else {
            return Ok(self.lens.clone());
        };
        let options = self.lens_args.options().at(table, number)?;
        options.set(&self.measured, self.lens_file, &self.base, warnings)
    }

    /// Reads the plate file `path` and its depth, from `depth_file` where [`Self::depth_pattern`] names one.
    pub(crate) fn read(
        &self,
        path: &Path,
        frame: FrameId,
        depth_file: Option<&Path>,
    ) -> Result<LoadedPlate, CommandError> {
        let plate = Plate::open(path, &self.plate_args.options())?;
        let mut warnings = Vec::new();
        let colour = self.colour.as_ref();
        let colour = colour.map(|colour| colour.of(&plate, &mut warnings));
        let colour = colour.transpose()?;
        self.load(plate, colour, frame, depth_file, warnings)
    }

    /// Loads `plate`, made from `source` and in the colour space that it is written in.
    pub(crate) fn load_written(
        &self,
        plate: Plate,
        source: &LoadedPlate,
        number: Option<i64>,
        depth_file: Option<&Path>,
    ) -> Result<LoadedPlate, CommandError> {
        let colour = source.colour.as_ref().map(PlateColour::written);
        let order = FrameOrder::Later;
        let frame = FrameId { number, order };
        self.load(plate, colour, frame, depth_file, Vec::new())
    }

    fn load(
        &self,
        plate: Plate,
        colour: Option<PlateColour>,
        frame: FrameId,
        depth_file: Option<&Path>,
        mut warnings: Vec<String>,
    ) -> Result<LoadedPlate, CommandError> {
        if self.colour.is_none() && frame.order == FrameOrder::First {
            warnings.extend(plate.ignored_colour_space_warning());
        }
        let image = (self.plate_args).image(&plate, colour.as_ref(), &mut warnings)?;
        let lens = self.frame_lens(frame.number, &mut warnings)?;
        let geometry = self.geometry(&plate)?;
        let depth = self.depth.read(
            &plate,
            &geometry,
            depth_file,
            &lens.session,
            frame.order,
            &mut warnings,
        )?;
        let prepared = lens.session.prepare_parts(image, geometry, depth, None);
        let prepared = prepared.map_err(|e| FileError::from_core(plate.path(), e))?;
        Ok(LoadedPlate {
            lens,
            plate,
            prepared,
            colour,
            warnings,
        })
    }

    /// The place of `plate` in the frame of the lens.
    pub(crate) fn geometry(&self, plate: &Plate) -> Result<PlateGeometry, CommandError> {
        let aspect = self.plate_args.pixel_aspect(plate)?;
        Ok(plate_geometry(plate, self.plate_args.lens_scale, aspect))
    }

    /// The settings by name that `plate` is rendered with through `lens`, for provenance and residuals.
    pub(crate) fn record(
        &self,
        lens: &FrameLens,
        plate: &Plate,
    ) -> Result<Vec<(String, String)>, CommandError> {
        let mut record = lens.record.clone();
        record.extend(self.depth.record());
        let scale = self.plate_args.lens_scale;
        let aspect = self.plate_args.pixel_aspect(plate)?;
        for (name, value) in [
            (
                "geometry",
                format!("{:?}", self.lens_args.geometry).to_lowercase(),
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
            record.push((name.to_owned(), value));
        }
        Ok(record)
    }
}

/// The settings by name of `apply` without options about quality, edges and occlusion.
pub(crate) fn default_rendering_record() -> [(String, String); 3] {
    [
        ("quality", "final"),
        ("edges", "mirror"),
        ("occlusion", "on"),
    ]
    .map(|(name, value)| (name.to_owned(), value.to_owned()))
}

impl LoadedPlate {
    /// Names the plate file in an error of the core.
    pub(crate) fn in_file(&self, error: seidel_core::Error) -> CommandError {
        FileError::from_core(self.plate.path(), error).into()
    }

    /// Whether the lens leaves the plate as it is.
    pub(crate) fn is_neutral(&self) -> bool {
        self.lens.session.is_neutral()
    }

    /// Uses `lens` in place of the frame's own, such as one of a smaller amount.
    pub(crate) fn set_lens(&mut self, lens: FrameLens) {
        self.prepared.set_session(Arc::clone(&lens.session));
        self.lens = lens;
    }

    /// Leaves `target`, a copy of the plate, as it is to the bit; but for replaced samples and another colour space.
    pub(crate) fn keep(&self, target: &mut Plate) -> Result<(), CommandError> {
        let colour = self.colour.as_ref();
        let stays = colour.is_none_or(|colour| colour.other_space().is_none());
        if stays && target.non_finite().is_empty() {
            return Ok(());
        }
        self.put_planes(target, self.prepared.planes().to_vec())
    }

    /// Puts premultiplied `planes` of the data window of `target` into it, in the alpha relation and colour space that it is
    /// written in.
    pub(crate) fn put_planes(
        &self,
        target: &mut Plate,
        planes: Vec<Vec<f32>>,
    ) -> Result<(), CommandError> {
        let (width, height) = (target.width(), target.height());
        let image = self.prepared.to_image_of_size(width, height, planes);
        put_image(target, image, self.colour.as_ref())
    }
}
