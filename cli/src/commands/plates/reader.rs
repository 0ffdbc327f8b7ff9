//! The plates of a run: read, and prepared for the lens of their frame.

use std::path::Path;
use std::sync::Arc;

use seidel_core::profile::{Adequacy, Verdict};
use seidel_core::{
    DepthMeaning, Image, LensProfile, LensScale, LensSession, ObjectDistance, PlateGeometry,
    PreparedDepth, PreparedPlate, RelensSide, Settings,
};

use super::animated::{self, check_columns};
use super::colour::{ColourPipeline, PlateColour};
use super::depth::FrameOrder;
use super::frame_lens::FrameLens;
use super::look::{LookArgs, look_record};
use super::plate::put_image;
use super::shot_lens::{LENS_METADATA, SINGLE, ShotLens};
use super::{FrameFiles, PlateCommandArgs, Run, SettingsRecord, setting};
use crate::Console;
use crate::commands::CommandError;
use crate::commands::knobs::{ApplyKnobs, RelensKnobs};
use seidel_core::Rectangle;
use seidel_image_io::animation::Animation;
use seidel_image_io::error::FileError;
use seidel_image_io::formats::exr::ViewChoice;
use seidel_image_io::lens_profile;
use seidel_image_io::plate::PlateFile;
use seidel_image_io::sequence::number_in_name;
use seidel_image_io::windows::ImageWindows;

/// A reader of the plates of a run, which prepares them for the lens of their frame.
pub(crate) struct PlateReader<'a> {
    pub(super) args: &'a PlateCommandArgs,
    /// The lens profile before any control is set.
    measured: LensProfile,
    lens_file: &'a Path,
    /// The settings of frames that no table changes.
    base: Settings,
    lens_use: LensUse<'a>,
    /// The lens of frames that no table changes.
    lens: FrameLens,
    animation: Option<Animation>,
    /// Number in the name of a plate that is rendered by itself, for the animation.
    pub(super) single: Option<i64>,
    /// The lens that the shot states, if its use was requested.
    pub(super) shot: Option<ShotLens>,
    /// Conversion of colours, if one is requested.
    colour: Option<ColourPipeline<'a>>,
    /// The meaning of the samples of depth passes.
    pub(super) depth_meaning: DepthMeaning,
}

/// The use of a lens, with the options that a command has for it.
#[derive(Clone, Copy)]
pub(crate) enum LensUse<'a> {
    /// Plates get its blur.
    Apply(&'a LookArgs, &'a ApplyKnobs),
    /// Its blur is removed.
    Remove,
    /// It is one of the two lenses of `relens`. The look is that of the new one.
    Relens(RelensSide, &'a LookArgs, &'a RelensKnobs),
}

impl<'a> LensUse<'a> {
    /// Returns the side of the lens, if there are two.
    fn side(self) -> Option<RelensSide> {
        match self {
            Self::Relens(side, ..) => Some(side),
            Self::Apply(..) | Self::Remove => None,
        }
    }

    /// Returns the options of the look, if they change the lens.
    fn look(self) -> Option<&'a LookArgs> {
        match self {
            Self::Apply(look, _) | Self::Relens(RelensSide::To, look, _) => Some(look),
            Self::Remove | Self::Relens(RelensSide::From, ..) => None,
        }
    }

    /// Rejects a table with a column that the command does not have.
    fn check_columns(self, table: &Animation) -> Result<(), CommandError> {
        match self {
            Self::Apply(look, _) => check_columns(table, Some(look), ApplyKnobs::numbers()),
            Self::Remove => check_columns(table, None, std::iter::empty()),
            Self::Relens(_, look, _) => check_columns(table, Some(look), RelensKnobs::numbers()),
        }
    }
}

/// A plate in memory, prepared for its lens.
pub(crate) struct LoadedPlate {
    pub(crate) lens: FrameLens,
    pub(crate) plate: PlateFile,
    pub(crate) prepared: PreparedPlate,
    /// The distance picked in the plate, which the lens is focused at.
    pub(crate) focused_at: Option<ObjectDistance>,
    /// The data window of the file, if the plate was expanded.
    pub(crate) own_window: Option<Rectangle>,
    colour: Option<PlateColour>,
    pub(crate) warnings: Vec<String>,
}

impl<'a> PlateReader<'a> {
    /// Reads the profile `lens_file` and sets the lens by `args` and `lens_use`; prints warnings. `base` has the settings that are
    /// not about the lens.
    ///
    /// # Errors
    /// An invalid profile, animation table, colour space or picture of an aperture, and options that the lens or the output
    /// cannot follow.
    pub(crate) fn open(
        lens_file: &'a Path,
        args: &'a PlateCommandArgs,
        lens_use: LensUse<'a>,
        mut base: Settings,
        console: &mut Console,
    ) -> Result<Self, CommandError> {
        if let Some(look) = lens_use.look() {
            look.put(&mut base)?;
        }
        args.plate.check_output(&args.output)?;
        let mut warnings = Vec::new();
        let measured = lens_profile::read(lens_file)?;
        let poor = |adequacy: &&Adequacy| adequacy.verdict() != Verdict::Describes;
        if let Some(adequacy) = measured.adequacy().filter(poor) {
            warnings.push(format!("{}: {adequacy}", lens_file.display()));
        }
        let options = &args.lens.options;
        options.put(&mut base)?;
        check_film_back(&base, &measured, lens_file)?;
        let lens = options.set(&measured, lens_file, &base, lens_use.side(), &mut warnings)?;
        let animation = args.lens.animate.as_deref();
        let animation = animation.map(Animation::open).transpose()?;
        if let Some(table) = &animation {
            lens_use.check_columns(table)?;
        }
        let depth_meaning = args.depth.meaning()?;
        (args.depth).check_lens(lens.session.lens(), lens_file)?;
        let colour = args.plate.colour.pipeline(&args.output, &mut warnings)?;
        // With settings from metadata they follow when these are known.
        if args.lens.metadata.source.is_none() {
            warnings.drain(..).for_each(|warning| console.note(warning));
        }
        Ok(Self {
            args,
            measured,
            lens_file,
            base,
            lens_use,
            lens,
            animation,
            single: None,
            shot: None,
            colour,
            depth_meaning,
        })
    }

    /// Returns whether the option called `name` has values by frame.
    pub(crate) fn is_animated(&self, name: &str) -> bool {
        let table = self.animation.iter();
        table.flat_map(Animation::names).any(|own| own == name)
    }

    /// Finds the frame of an animation table for a single plate, and reads the lens that its plates or a table beside them state, if
    /// that was requested. Prints notes on the values, or on those that the plates state and nobody requested.
    ///
    /// # Errors
    /// Values that cannot be true, and plates and tables that state none.
    pub(crate) fn begin(&mut self, run: &Run, console: &mut Console) -> Result<(), CommandError> {
        if self.animation.is_some() && !run.is_sequence() {
            self.single = number_in_name(&self.args.input);
            if self.single.is_none() {
                let problem = "has no frame number in its name, which --animate needs";
                let remedy = "give IN and OUT a frame pattern, or name the plate as plate.1001.exr";
                return Err(FileError::new(&self.args.input, "", problem, remedy).into());
            }
        }
        if self.args.lens.metadata.source.is_none() {
            self.unused_knowledge(run)
                .into_iter()
                .for_each(|note| console.note(note));
            return Ok(());
        }
        let mut notes = Vec::new();
        let shot = self.read_shot(run, &mut notes)?;
        self.set_shot(shot, &mut notes)?;
        notes.into_iter().for_each(|note| console.note(note));
        Ok(())
    }

    /// Sets the lens by what a shot states. Adds to `notes`.
    pub(super) fn set_shot(
        &mut self,
        shot: Option<ShotLens>,
        notes: &mut Vec<String>,
    ) -> Result<(), CommandError> {
        let options = &self.args.lens.options;
        if let Some(shot) = shot.as_ref().filter(|shot| shot.table.is_constant()) {
            options.put_at_frame(&shot.table, SINGLE, &mut self.base)?;
        }
        self.lens = self.set(&self.base, notes)?;
        self.shot = shot;
        Ok(())
    }

    /// Returns the lens of frame `number`, focused at the distance that was picked in its plate, if any. Adds to `warnings`.
    pub(crate) fn frame_lens(
        &self,
        number: Option<i64>,
        focused_at: Option<ObjectDistance>,
        warnings: &mut Vec<String>,
    ) -> Result<FrameLens, CommandError> {
        let shot = self.shot.as_ref().map(|shot| &shot.table);
        // A constant one is among the settings of all frames.
        let shot = shot.filter(|table| !table.is_constant());
        let animation = self.animation.as_ref().zip(number.or(self.single));
        if shot.is_none() && animation.is_none() && focused_at.is_none() {
            return Ok(self.lens.clone());
        }
        let options = &self.args.lens.options;
        let mut settings = self.base.clone();
        if let Some(table) = shot {
            options.put_at_frame(table, number.unwrap_or(SINGLE), &mut settings)?;
        }
        if let Some((table, number)) = animation {
            options.put_at_frame(table, number, &mut settings)?;
            if let Some(look) = self.lens_use.look() {
                look.put_at_frame(table, number, &mut settings)?;
            }
            match self.lens_use {
                LensUse::Apply(_, knobs) => {
                    animated::at_frame(knobs, table, number)?.put(&mut settings)?;
                }
                LensUse::Relens(_, _, sides) => {
                    animated::at_frame(sides, table, number)?.put(&mut settings)?;
                }
                LensUse::Remove => {}
            }
        }
        if let Some(focus) = focused_at {
            settings.controls.focus_distance = Some(focus);
        }
        self.set(&settings, warnings)
    }

    /// Sets the lens to `settings`. Adds to `warnings`.
    fn set(
        &self,
        settings: &Settings,
        warnings: &mut Vec<String>,
    ) -> Result<FrameLens, CommandError> {
        let (options, side) = (&self.args.lens.options, self.lens_use.side());
        options.set(&self.measured, self.lens_file, settings, side, warnings)
    }

    /// Returns the lens profile, and the settings of frames that no table changes.
    pub(super) fn base_session(&self) -> &LensSession {
        &self.lens.session
    }

    /// Returns look and bloom of frame `number` by name, as far as they change the lens or the plate.
    pub(crate) fn look_record(&self, number: Option<i64>) -> Result<SettingsRecord, CommandError> {
        let lens = self.frame_lens(number, None, &mut Vec::new())?;
        Ok(look_record(lens.session.settings()))
    }

    /// Reads a view of the plate of the frame at `index` of the run, and its depth.
    pub(crate) fn read(
        &self,
        frame: &FrameFiles,
        index: usize,
        view: usize,
    ) -> Result<LoadedPlate, CommandError> {
        let plate = PlateFile::open_view(&frame.input, &self.args.plate.options(), view)?;
        let mut warnings = Vec::new();
        if index == 0 {
            warnings.extend(plate.channels_notes());
        }
        let colour = self.colour.as_ref();
        let colour = colour.map(|colour| colour.of_plate(&plate, &mut warnings));
        let colour = colour.transpose()?;
        let order = if index == 0 {
            FrameOrder::First
        } else {
            FrameOrder::Later
        };
        self.load(plate, colour, frame, order, warnings)
    }

    /// Loads `plate`, a result made from `source` in the colour space of the output.
    pub(crate) fn load_result(
        &self,
        plate: PlateFile,
        source: &LoadedPlate,
        frame: &FrameFiles,
    ) -> Result<LoadedPlate, CommandError> {
        let colour = source.colour.as_ref().map(PlateColour::of_result);
        self.load(plate, colour, frame, FrameOrder::Later, Vec::new())
    }

    fn load(
        &self,
        plate: PlateFile,
        colour: Option<PlateColour>,
        frame: &FrameFiles,
        order: FrameOrder,
        mut warnings: Vec<String>,
    ) -> Result<LoadedPlate, CommandError> {
        if self.colour.is_none() && order == FrameOrder::First {
            warnings.extend(plate.ignored_colour_space_warning());
        }
        let image = (self.args.plate).image(&plate, colour.as_ref(), &mut warnings)?;
        let mut lens = self.frame_lens(frame.number, None, &mut warnings)?;
        let geometry = self.geometry(&plate, &lens)?;
        let (depth, source) = self.read_depth(
            &plate,
            &geometry,
            frame.read.depth.as_ref(),
            &lens.session,
            order,
            &mut warnings,
        )?;
        let focused_at = self.picked_distance(&plate, &depth, frame.number)?;
        if let Some(distance) = focused_at {
            lens = self.frame_lens(frame.number, focused_at, &mut warnings)?;
            if order == FrameOrder::First {
                let place = match distance {
                    ObjectDistance::Metres(metres) => format!("{metres:.3} m"),
                    other => other.to_string(),
                };
                warnings.push(format!("focused at {place}, which --focus-at picks"));
            }
        }
        let prepared = lens.session.prepare_parts(image, geometry, depth, None);
        let prepared = prepared.map_err(|e| FileError::from_core(plate.path(), e))?;
        if order == FrameOrder::First {
            if let Some(source) = source.filter(|_| !self.args.depth.no_depth_check) {
                warnings.extend(self.depth_doubts(&source, &prepared)?);
            }
            warnings.extend(prepared.frame_warning());
            let focus = self.shot.as_ref().and_then(|shot| {
                shot.focus_outside(prepared.depth().reading()?.range_m?, frame.number)
            });
            warnings.extend(focus);
        }
        Ok(LoadedPlate {
            lens,
            plate,
            prepared,
            own_window: None,
            focused_at,
            colour,
            warnings,
        })
    }

    /// Returns the object distance at the pixel to focus on; `None` if no pixel is given.
    ///
    /// # Errors
    /// A pixel beside the plate, and a plate without distance there.
    fn picked_distance(
        &self,
        plate: &PlateFile,
        depth: &PreparedDepth,
        number: Option<i64>,
    ) -> Result<Option<ObjectDistance>, CommandError> {
        let table = self.animation.as_ref().zip(number.or(self.single));
        let Some(at) = self.args.lens.options.focus_point(table) else {
            return Ok(None);
        };
        let place = format!("--focus-at {},{}", at.x_px, at.y_px);
        let (display, data) = (plate.display_window(), plate.data_window());
        let cell = |at: f64, display: i32, data: i32, size: usize| {
            let cell = at.floor() + f64::from(display) - f64::from(data);
            (0.0..size as f64).contains(&cell).then_some(cell as usize)
        };
        let column = cell(at.x_px, display.x, data.x, data.width);
        let row = cell(at.y_px, display.y, data.y, data.height);
        let (Some(column), Some(row)) = (column, row) else {
            let problem = format!("lies beside the plate, which has the pixels {data}");
            let remedy =
                "give pixels right and down from the top-left corner of the display window";
            return Err(FileError::new(plate.path(), place, problem, remedy).into());
        };
        match depth.distance_at(column, row, data.width) {
            ObjectDistance::Unknown => {
                let remedy = "give --depth FILE, or --focus-distance METRES instead";
                let problem = "has no distance there to focus on";
                Err(FileError::new(plate.path(), place, problem, remedy).into())
            }
            distance => Ok(Some(distance)),
        }
    }

    /// Reads the `file` of another image of the frame of `loaded`, over the data window of its plate. Adds warnings to the
    /// plate.
    ///
    /// # Errors
    /// An image of another display window, or that does not cover the plate.
    pub(super) fn read_beside(
        &self,
        loaded: &mut LoadedPlate,
        file: &Path,
    ) -> Result<(PlateFile, Image), CommandError> {
        let mut options = self.args.plate.options();
        if let Some(view) = loaded.plate.view() {
            options.view = ViewChoice::Named(view.to_owned());
        }
        // A background without views is that of every view.
        let mut image = PlateFile::open(file, &options).or_else(|error| {
            options.view = ViewChoice::All;
            let other = PlateFile::open(file, &options);
            other
                .ok()
                .filter(|plate| plate.view().is_none())
                .ok_or(error)
        })?;
        let (own, plate) = (image.windows(), loaded.plate.windows());
        if own.display != plate.display || !own.data.encloses(plate.data) {
            let describe = |windows: ImageWindows| {
                format!("{} in a frame of {}", windows.data, windows.display)
            };
            return Err(FileError::new(
                file,
                "dataWindow",
                format!(
                    "is {}, that of the plate {}",
                    describe(own),
                    describe(plate)
                ),
                "render both at one size and data window",
            )
            .into());
        }
        if own.data != plate.data {
            image.set_data_window(plate.data);
        }
        let warnings = &mut loaded.warnings;
        let colour = self.colour.as_ref();
        let colour = colour.map(|colour| colour.of_plate(&image, warnings));
        let samples = (self.args.plate).image(&image, colour.transpose()?.as_ref(), warnings)?;
        Ok((image, samples))
    }

    /// Returns the place of `plate` in the frame of the lens.
    fn geometry(&self, plate: &PlateFile, lens: &FrameLens) -> Result<PlateGeometry, CommandError> {
        let lens_scale = lens.session.settings().lens_scale;
        self.args.plate.geometry(plate, lens_scale)
    }

    /// Returns the settings by name that `plate` is rendered with through `lens`.
    pub(crate) fn record(
        &self,
        lens: &FrameLens,
        plate: &PlateFile,
    ) -> Result<SettingsRecord, CommandError> {
        let mut record = lens.record.clone();
        record.extend(self.args.depth.record(self.depth_meaning));
        let metadata = self.shot.as_ref().map(|shot| shot.sources.as_str());
        record.extend(metadata.map(|sources| setting(LENS_METADATA, sources)));
        let working_space = self.colour.as_ref().map(ColourPipeline::working_space);
        record.extend([
            setting("pixel-aspect", self.args.plate.pixel_aspect(plate)?),
            setting("working-space", working_space.unwrap_or("the plate's")),
        ]);
        if let Some(squeeze) = self.measured.camera.squeeze {
            let placement = lens.session.place(&self.geometry(plate, lens)?)?;
            record.extend([
                setting("squeeze", squeeze),
                setting("pixel-aspect-on-sensor", placement.sensor_aspect),
            ]);
        }
        Ok(record)
    }
}

/// Checks that the lens `measured`, read from the file `path`, can follow the film back of `settings`.
///
/// # Errors
/// A lens of unknown pixel pitch.
fn check_film_back(
    settings: &Settings,
    measured: &LensProfile,
    path: &Path,
) -> Result<(), CommandError> {
    if !matches!(settings.lens_scale, LensScale::FilmBack(_)) || measured.pixel_pitch_um.is_some() {
        return Ok(());
    }
    Err(FileError::new(
        path,
        "pixel_pitch_um",
        "is not known, so --film-back-mm has no size in the frame of the lens",
        "put the pixel pitch into the lens profile, or give --lens-scale",
    )
    .into())
}

impl LoadedPlate {
    /// Names the plate file in an error of the core.
    pub(crate) fn in_file(&self, error: seidel_core::Error) -> CommandError {
        FileError::from_core(self.plate.path(), error).into()
    }

    /// Returns whether the amount is zero, so that the plate is unchanged.
    pub(crate) fn is_neutral(&self) -> bool {
        self.lens.session.is_neutral()
    }

    /// Expands the plate by the reach of its blur, as the settings say. A plate of a format without data windows stays as it is,
    /// with a note.
    pub(crate) fn expand(&mut self) -> Result<(), CommandError> {
        let margins = self.prepared.expansion().map_err(|e| self.in_file(e))?;
        if margins.is_none() {
            return Ok(());
        }
        let format = self.plate.format();
        if !format.has_data_window() {
            self.warnings.push(format!(
                "{format} has no data window: blur that leaves the plate is cropped; give an EXR, or pad the plate"
            ));
            return Ok(());
        }
        let expanded = self.prepared.expanded(margins);
        self.prepared = expanded.map_err(|e| self.in_file(e))?;
        self.own_window = Some(self.plate.data_window());
        let window = self.prepared.geometry().data;
        self.plate.set_data_window(window);
        Ok(())
    }

    /// Returns the data window of the result of an expanded plate, whose blurred planes are `planes`: its own pixels and
    /// all light about them.
    pub(crate) fn trimmed_window(&self, planes: &[Vec<f32>]) -> Option<Rectangle> {
        let own = self.own_window?;
        let trimmed = self.prepared.trimmed(planes, own);
        Some(trimmed)
    }

    /// Replaces the lens by another setting of it, such as one of a smaller amount.
    pub(crate) fn set_lens(&mut self, lens: FrameLens) {
        self.prepared.set_session(Arc::clone(&lens.session));
        self.lens = lens;
    }

    /// Puts the plate's own samples into `target`, a copy of it, where samples were replaced or the colour space
    /// changes. Otherwise `target` keeps its bits.
    pub(crate) fn put_unchanged(&self, target: &mut PlateFile) -> Result<(), CommandError> {
        let colour = self.colour.as_ref();
        let keeps_space = colour.is_none_or(|colour| colour.new_space().is_none());
        if keeps_space && target.non_finite().is_empty() {
            return Ok(());
        }
        self.put_planes(target, self.prepared.planes().to_vec())
    }

    /// Puts `planes` that are numbers, not light, into `target`: no colour space applies to them.
    pub(crate) fn put_numbers(
        &self,
        target: &mut PlateFile,
        planes: Vec<Vec<f32>>,
    ) -> Result<(), CommandError> {
        let image = self.prepared.to_image(planes);
        put_image(target, image.map_err(|e| self.in_file(e))?, None)
    }

    /// Puts premultiplied `planes` over the data window of `target` into it, with the alpha relation and colour space of
    /// the output.
    pub(crate) fn put_planes(
        &self,
        target: &mut PlateFile,
        planes: Vec<Vec<f32>>,
    ) -> Result<(), CommandError> {
        let (width, height) = (target.width(), target.height());
        let image = self.prepared.to_image_of_size(width, height, planes);
        let image = image.map_err(|e| self.in_file(e))?;
        put_image(target, image, self.colour.as_ref())
    }
}
