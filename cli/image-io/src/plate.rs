//! A plate of any supported format, as the blur sees it: scene-linear colour planes and alpha.

use std::path::Path;

use crate::depth::DepthPass;
use crate::error::{FileError, Result};
use crate::exr::choice::ColourGroup;
use crate::exr::packing::Packing;
use crate::exr::plate::{ExrPlate, NonFinite, Window, non_finite};
use crate::flat_plate::{Encoding, FlatPlate};
use crate::format::{Format, detect, output_format};
use crate::other_format::write_as;
use crate::provenance::Provenance;
use crate::windows::Windows;

/// What a user may say about a plate.
#[derive(Debug, Clone, Default)]
pub struct PlateOptions {
    /// The EXR layer or part to work on; the root channels if `None`.
    pub layer: Option<String>,
    /// What integer samples mean, in the file and in one of another format that it is written to; if `None` sRGB, and in
    /// DPX what the file says, else linear. Floats are linear if `None`.
    pub encoding: Option<Encoding>,
    /// Whether colour is premultiplied by alpha; as the file says if `None`.
    pub premultiplied: Option<bool>,
    /// Whether colours are converted between colour spaces: samples are codes that are written as they are put in place,
    /// in whatever format.
    pub colour_managed: bool,
    /// Whether each colour is to have an alpha of its own beside the usual one; EXR only.
    pub alpha_per_channel: bool,
    /// How an EXR that is written is packed; as it was, but for what loses quality, if `None`.
    pub packing: Option<Packing>,
}

/// A plate in memory with everything its file holds.
#[derive(Debug, Clone)]
pub struct Plate {
    pub(crate) file: PlateFile,
    pub(crate) options: PlateOptions,
    names: Vec<String>,
    window: Window,
    display: Window,
    /// The colour space that it is put into, where that is another than it was in.
    pub(crate) space: Option<String>,
}

#[derive(Debug, Clone)]
pub(crate) enum PlateFile {
    Exr {
        plate: Box<ExrPlate>,
        group: ColourGroup,
    },
    Flat {
        plate: FlatPlate,
        encoding: Encoding,
    },
}

impl Plate {
    /// Reads a plate of any supported format.
    ///
    /// # Errors
    /// A file that cannot be read, of no supported format, or without colour channels.
    pub fn open(path: &Path, options: &PlateOptions) -> Result<Self> {
        let format = detect(path)?;
        if format == Format::Exr {
            return Self::of_exr(ExrPlate::open(path)?, options);
        }
        if let Some(layer) = &options.layer {
            return Err(FileError::new(
                path,
                "",
                format!("has no layers, but --layer {layer} was given"),
                "leave out --layer",
            ));
        }
        if options.alpha_per_channel {
            return Err(FileError::new(
                path,
                "",
                format!(
                    "is {format}, which holds one alpha only, but --alpha-per-channel was given"
                ),
                "convert the plate to EXR, or leave out --alpha-per-channel",
            ));
        }
        let plate = FlatPlate::open(path)?;
        let encoding = options.encoding.unwrap_or(plate.own_encoding());
        let window = Window {
            x: 0,
            y: 0,
            width: plate.width(),
            height: plate.height(),
        };
        let names = plate.names().iter().filter(|n| *n != "A").cloned();
        Ok(Self {
            names: names.collect(),
            file: PlateFile::Flat { plate, encoding },
            options: options.clone(),
            window,
            display: window,
            space: None,
        })
    }

    fn of_exr(mut plate: ExrPlate, options: &PlateOptions) -> Result<Self> {
        let layer = options.layer.as_deref();
        let group = match options.alpha_per_channel {
            true => plate.colour_with_own_alpha(layer)?,
            false => plate.colour(layer)?,
        };
        if let Some(packing) = options.packing {
            plate.pack(&group, packing);
        }
        Ok(Self {
            names: group.names.clone(),
            window: plate.data_window(group.colour[0]),
            display: plate.display_window(),
            options: options.clone(),
            space: None,
            file: PlateFile::Exr {
                plate: Box::new(plate),
                group,
            },
        })
    }

    /// The format that it was read in.
    pub fn format(&self) -> Format {
        match &self.file {
            PlateFile::Exr { .. } => Format::Exr,
            PlateFile::Flat { plate, .. } => plate.format(),
        }
    }

    /// What the user should know of the file as it was read, a sentence each.
    pub fn remarks(&self) -> Vec<String> {
        match &self.file {
            PlateFile::Exr { .. } => Vec::new(),
            PlateFile::Flat { plate, encoding } => {
                let taken = (!self.options.colour_managed).then_some(*encoding);
                plate.remarks(taken, self.options.encoding.is_some())
            }
        }
    }

    /// Whether its samples are whole numbers in the file, which clip at full scale.
    pub fn holds_integers(&self) -> bool {
        match &self.file {
            PlateFile::Exr { .. } => false,
            PlateFile::Flat { plate, .. } => plate.depth().is_integer(),
        }
    }

    /// Whether its samples become whole numbers in a file of the format `target`.
    pub fn becomes_integers(&self, target: Format) -> bool {
        match (target, &self.file) {
            (Format::Exr | Format::Hdr, _) => false,
            (Format::Tiff, PlateFile::Exr { .. }) => false,
            (Format::Tiff, PlateFile::Flat { plate, .. }) => plate.depth().is_integer(),
            _ => true,
        }
    }

    /// Width of the planes, pixels.
    pub fn width(&self) -> usize {
        self.window.width
    }

    /// Height of the planes, pixels.
    pub fn height(&self) -> usize {
        self.window.height
    }

    /// Where the planes lie on the plane of the display window.
    pub fn data_window(&self) -> Window {
        self.window
    }

    /// The picture proper: the frame that a lens covers.
    pub fn display_window(&self) -> Window {
        self.display
    }

    /// Both.
    pub fn windows(&self) -> Windows {
        Windows {
            data: self.window,
            display: self.display,
        }
    }

    /// Gives the planes, and all else in the same part of the file, another data window; beyond what there was
    /// everything is as its nearest pixel. EXR only: others stay as they are.
    pub fn reframe(&mut self, window: Window) {
        if let PlateFile::Exr { plate, group } = &mut self.file {
            plate.reframe(group.colour[0], window);
            self.window = window;
        }
    }

    /// Rounds the samples to what the file will hold. EXR planes are rounded when they are put in place.
    pub fn round(&mut self) {
        if let PlateFile::Flat { plate, .. } = &mut self.file {
            plate.round();
        }
    }

    /// Width of a pixel over its height: as the file says in EXR and DPX, else one.
    pub fn pixel_aspect(&self) -> f64 {
        match &self.file {
            PlateFile::Exr { plate, .. } => plate.pixel_aspect(),
            PlateFile::Flat { plate, .. } => plate.pixel_aspect(),
        }
    }

    /// Names of the colour planes: R, G, B, or Y.
    pub fn colour_names(&self) -> &[String] {
        &self.names
    }

    /// Whether there is an alpha channel beside the colour.
    pub fn has_alpha(&self) -> bool {
        match &self.file {
            PlateFile::Exr { group, .. } => group.alpha.is_some(),
            PlateFile::Flat { plate, .. } => plate.plane("A").is_some(),
        }
    }

    /// Whether colour comes premultiplied by alpha: as the user says, else always in EXR and DPX, never in PNG, as the
    /// file says in TIFF. True where there is no alpha.
    pub fn is_premultiplied(&self) -> bool {
        match &self.file {
            _ if !self.has_alpha() => true,
            PlateFile::Exr { .. } => self.options.premultiplied.unwrap_or(true),
            PlateFile::Flat { plate, .. } => {
                let told = self.options.premultiplied;
                told.unwrap_or_else(|| plate.is_premultiplied())
            }
        }
    }

    /// The colour planes, scene-linear, row-major, in the order of [`Plate::colour_names`].
    pub fn colour(&self) -> Vec<Vec<f32>> {
        match &self.file {
            PlateFile::Exr { plate, group } => {
                group.colour.iter().map(|&id| plate.samples(id)).collect()
            }
            PlateFile::Flat { plate, encoding } => self
                .names
                .iter()
                .filter_map(|name| plate.plane(name))
                .map(|plane| plane.iter().map(|&code| encoding.decode(code)).collect())
                .collect(),
        }
    }

    /// The alpha plane, where there is one.
    pub fn alpha(&self) -> Option<Vec<f32>> {
        match &self.file {
            PlateFile::Exr { plate, group } => group.alpha.map(|id| plate.samples(id)),
            PlateFile::Flat { plate, .. } => plate.plane("A").map(<[f32]>::to_vec),
        }
    }

    /// Whether each colour has an alpha of its own.
    pub fn has_own_alphas(&self) -> bool {
        match &self.file {
            PlateFile::Exr { group, .. } => !group.own_alpha.is_empty(),
            PlateFile::Flat { .. } => false,
        }
    }

    /// The alpha of each colour alone, in the order of [`Plate::colour_names`]; empty unless asked for by
    /// [`PlateOptions::alpha_per_channel`].
    pub fn own_alphas(&self) -> Vec<Vec<f32>> {
        match &self.file {
            PlateFile::Exr { plate, group } => {
                let ids = group.own_alpha.iter();
                ids.map(|&id| plate.samples(id)).collect()
            }
            PlateFile::Flat { .. } => Vec::new(),
        }
    }

    /// The NaN and infinite samples of colour and alpha.
    pub fn non_finite(&self) -> Vec<NonFinite> {
        match &self.file {
            PlateFile::Exr { plate, group } => {
                let alphas = group.alpha.iter().chain(&group.own_alpha);
                let ids: Vec<_> = group.colour.iter().chain(alphas).copied().collect();
                plate.non_finite(&ids)
            }
            PlateFile::Flat { plate, .. } => plate
                .names()
                .iter()
                .filter_map(|name| non_finite(name, self.window.width, plate.plane(name)?))
                .collect(),
        }
    }

    /// Memory that the file's samples take, bytes.
    pub fn held_bytes(&self) -> u64 {
        match &self.file {
            PlateFile::Exr { plate, .. } => plate.held_bytes(),
            PlateFile::Flat { plate, .. } => {
                (plate.names().len() * plate.width() * plate.height() * size_of::<f32>()) as u64
            }
        }
    }

    /// Puts other scene-linear colour planes in place, in the order of [`Plate::colour_names`].
    ///
    /// # Errors
    /// Planes that differ in number or size.
    pub fn set_colour(&mut self, planes: &[Vec<f32>]) -> Result<()> {
        if planes.len() != self.names.len() {
            return Err(FileError::new(
                self.path(),
                "channels",
                format!("{} planes for {}", planes.len(), self.names.join(", ")),
                "give one plane a colour channel",
            ));
        }
        match &mut self.file {
            PlateFile::Exr { plate, group } => {
                for (&id, plane) in group.colour.iter().zip(planes) {
                    plate.replace(id, plane)?;
                }
            }
            PlateFile::Flat { plate, encoding } => {
                for (name, plane) in self.names.iter().zip(planes) {
                    let codes = plane.iter().map(|&light| encoding.encode(light));
                    plate.replace(name, codes.collect())?;
                }
            }
        }
        Ok(())
    }

    /// Puts another alpha plane in place.
    ///
    /// # Errors
    /// A plate without alpha, and a plane of another size.
    pub fn set_alpha(&mut self, samples: &[f32]) -> Result<()> {
        match &mut self.file {
            PlateFile::Exr { plate, group } => match group.alpha {
                Some(id) => plate.replace(id, samples),
                None => Err(FileError::new(
                    plate.path(),
                    "channel A",
                    "is not in the plate",
                    "leave alpha as it is",
                )),
            },
            PlateFile::Flat { plate, .. } => plate.replace("A", samples.to_vec()),
        }
    }

    /// Puts other alphas of single colours in place, in the order of [`Plate::own_alphas`].
    ///
    /// # Errors
    /// A plane of another size.
    pub fn set_own_alphas(&mut self, planes: &[Vec<f32>]) -> Result<()> {
        if let PlateFile::Exr { plate, group } = &mut self.file {
            for (&id, plane) in group.own_alpha.iter().zip(planes) {
                plate.replace(id, plane)?;
            }
        }
        Ok(())
    }

    /// The depth pass inside the plate's own file.
    ///
    /// # Errors
    /// A format without depth channels, or no such channel.
    pub fn depth(&self, channel: Option<&str>) -> Result<DepthPass> {
        match &self.file {
            PlateFile::Exr { plate, .. } => DepthPass::of_plate(plate, channel),
            PlateFile::Flat { plate, .. } => Err(FileError::new(
                plate.path(),
                "depth",
                format!("cannot be in a {} plate", plate.format()),
                "give the depth pass as a file of its own",
            )),
        }
    }

    /// The file it was read from.
    pub fn path(&self) -> &Path {
        match &self.file {
            PlateFile::Exr { plate, .. } => plate.path(),
            PlateFile::Flat { plate, .. } => plate.path(),
        }
    }

    /// Says in the file, the frame `frame` of a run, what made it: `by` what, with which settings. What made it before is
    /// kept.
    pub fn sign(&mut self, by: &Provenance, frame: Option<i64>, settings: &[(String, String)]) {
        match &mut self.file {
            PlateFile::Exr { plate, group } => {
                let part = group.colour[0];
                let texts = by.texts(frame, settings, &plate.provenance(part));
                plate.set_provenance(part, &texts);
            }
            PlateFile::Flat { plate, .. } => plate.texts = by.texts(frame, settings, &plate.texts),
        }
    }

    /// Writes the plate whole or not at all, in the format that the name of `path` stands for. Returns a sentence for each
    /// thing that changed beside the blurred pixels or that the format could not hold.
    ///
    /// # Errors
    /// A name that stands for no format that is written, and a target that cannot be written.
    pub fn write(&self, path: &Path) -> Result<Vec<String>> {
        let target = output_format(path)?;
        if target != self.format() {
            return write_as(self, path, target);
        }
        match &self.file {
            PlateFile::Exr { plate, .. } => {
                plate.write(path)?;
                Ok(plate.notes())
            }
            PlateFile::Flat { plate, .. } => plate.write(path),
        }
    }
}
