//! Plates of any format: scene-linear colour planes and alpha, with everything else in the file passed through.

mod colour_space;
mod convert;
mod non_finite;
mod views;

use std::path::Path;

pub use self::non_finite::NonFiniteSamples;
use self::views::parts_of;
use crate::error::{FileError, Result};
use crate::format::Format;
use crate::formats::exr::{self, ColourChannels, DepthOwner, ExrCompression, ExrImage, ViewChoice};
use crate::formats::output_row;
use crate::image_channel::ImageChannel;
use crate::image_file::ImageFile;
use crate::input::Limits;
use crate::provenance::Provenance;
use crate::raster::{AssumedEncoding, RasterImage};
use crate::samples::{Encoding, SampleFormat};
use crate::windows::ImageWindows;
use seidel_optics::Rectangle;

/// The user's choices about a plate.
#[derive(Debug, Clone, Default)]
pub struct PlateOptions {
    /// The EXR layer, part or view to read; if `None` the root channels, or those of a beauty pass.
    pub layer: Option<String>,
    /// The views of an EXR to read.
    pub view: ViewChoice,
    /// Whether all channels are extended by their edge pixels where the data window grows, and not only colour and depth.
    pub extend_channels: bool,
    /// The encoding of integer samples, in the file and in a conversion to integers. If `None` it is sRGB, and in DPX
    /// that of the header, else linear. Floats are linear if `None`.
    pub encoding: Option<Encoding>,
    /// Relation of colour and alpha: true if colour is premultiplied, `None` as the file states.
    pub premultiplied: Option<bool>,
    /// Whether colour is converted between colour spaces: code values are then written as they are set, in any format.
    pub colour_managed: bool,
    /// Whether each colour has an alpha channel of its own beside the common one; EXR only.
    pub alpha_per_channel: bool,
    /// Compression of a written EXR; if `None` that of the plate, or ZIP if that is lossy.
    pub compression: Option<ExrCompression>,
}

/// A plate in memory with everything that its file holds.
#[derive(Debug, Clone)]
pub struct PlateFile {
    source: Source,
    options: PlateOptions,
    names: Vec<String>,
    windows: ImageWindows,
    /// The colour space that colour was converted to, if it was converted.
    colour_space: Option<String>,
}

/// The file of a plate, and how its colour is read.
#[derive(Debug, Clone)]
enum Source {
    Exr {
        image: Box<ExrImage>,
        channels: ColourChannels,
        /// Those of the other views that were chosen.
        other_views: Vec<ColourChannels>,
        /// Views of the file that were not chosen.
        unchanged_views: Vec<String>,
    },
    Raster {
        image: RasterImage,
        encoding: Encoding,
    },
}

impl PlateFile {
    /// Reads a plate in any supported format.
    ///
    /// # Errors
    /// A file that cannot be read, is in no supported format, or has no colour channels.
    pub fn open(path: &Path, options: &PlateOptions) -> Result<Self> {
        Self::open_view(path, options, 0)
    }

    /// Reads the view at `index` of those that `options` choose, as [`PlateFile::open`] reads the first.
    ///
    /// # Errors
    /// Those of [`PlateFile::open`], and fewer views.
    pub fn open_view(path: &Path, options: &PlateOptions, index: usize) -> Result<Self> {
        match ImageFile::open(path, Limits::PLATE)? {
            ImageFile::Exr(image) => Self::from_exr(image, options, index),
            ImageFile::Raster(image) => Self::from_raster(*image, options),
        }
    }

    fn from_exr(mut image: Box<ExrImage>, options: &PlateOptions, index: usize) -> Result<Self> {
        let layer = options.layer.as_deref();
        let mut views = if options.alpha_per_channel {
            image.colour_with_channel_alphas(layer, &options.view)?
        } else {
            image.colour_views(layer, &options.view)?
        };
        if index >= views.len() {
            return Err(FileError::new(
                image.path(),
                "views",
                format!(
                    "has {} views of the plate, and view {} was asked for",
                    views.len(),
                    index + 1
                ),
                "render all frames with the same views",
            ));
        }
        if let Some(compression) = options.compression {
            for part in parts_of(&views) {
                image.compress(&part, compression);
            }
        }
        let mut unchanged_views = image.view_names();
        unchanged_views.retain(|name| views.iter().all(|own| own.view.as_ref() != Some(name)));
        let channels = views.remove(index);
        Ok(Self {
            names: channels.names.clone(),
            windows: image.windows(channels.colour[0]),
            options: options.clone(),
            colour_space: None,
            source: Source::Exr {
                image,
                channels,
                other_views: views,
                unchanged_views,
            },
        })
    }

    fn from_raster(image: RasterImage, options: &PlateOptions) -> Result<Self> {
        let refuse = |problem, remedy: &str| Err(FileError::new(image.path(), "", problem, remedy));
        if let Some(layer) = &options.layer {
            return refuse(
                format!("has no layers, but --layer {layer} was given"),
                "leave out --layer",
            );
        }
        if let ViewChoice::Named(view) = &options.view {
            return refuse(
                format!("has no views, but --view {view} was given"),
                "leave out --view",
            );
        }
        if options.alpha_per_channel {
            return refuse(
                format!(
                    "is {}, which holds one alpha only, but --alpha-per-channel was given",
                    image.format()
                ),
                "convert the plate to EXR, or leave out --alpha-per-channel",
            );
        }
        let names = image.names().iter().filter(|n| *n != "A").cloned();
        Ok(Self {
            names: names.collect(),
            windows: ImageWindows::of_size(image.width(), image.height()),
            options: options.clone(),
            colour_space: None,
            source: Source::Raster {
                encoding: options.encoding.unwrap_or(image.default_encoding()),
                image,
            },
        })
    }

    /// Returns the format of the file that was read.
    pub fn format(&self) -> Format {
        match &self.source {
            Source::Exr { .. } => exr::FORMAT,
            Source::Raster { image, .. } => image.format(),
        }
    }

    /// Returns warnings about how the file was interpreted.
    pub fn read_warnings(&self) -> Vec<String> {
        let Source::Raster { image, encoding } = &self.source else {
            return Vec::new();
        };
        let assumed = AssumedEncoding {
            encoding: (!self.options.colour_managed).then_some(*encoding),
            from_user: self.options.encoding.is_some(),
        };
        image.metadata.read_warning(assumed).into_iter().collect()
    }

    /// Returns the sample format of the colour channels; float if they differ.
    fn sample_format(&self) -> SampleFormat {
        match &self.source {
            Source::Exr {
                image, channels, ..
            } => image.sample_format(&channels.colour),
            Source::Raster { image, .. } => image.sample_format(),
        }
    }

    /// Returns whether the file stores integers, which are clipped to 0..1.
    pub fn has_integer_samples(&self) -> bool {
        self.sample_format().is_integer()
    }

    /// Returns the integer that stores 1.0; `None` for floats.
    pub fn integer_full_scale(&self) -> Option<u16> {
        self.sample_format().full_scale()
    }

    /// Returns the encoding by which samples were decoded; `None` for EXR, which is not encoded.
    pub fn encoding(&self) -> Option<Encoding> {
        match &self.source {
            Source::Exr { .. } => None,
            Source::Raster { encoding, .. } => Some(*encoding),
        }
    }

    /// Returns the sample format in which samples are stored in a file of format `target`.
    pub fn sample_format_in(&self, target: Format) -> SampleFormat {
        let channels = self.names.len() + usize::from(self.has_alpha());
        (target.sample_format)(self.sample_format(), channels)
    }

    /// Returns the width of the planes, pixels.
    pub fn width(&self) -> usize {
        self.windows.data.width
    }

    /// Returns the height of the planes, pixels.
    pub fn height(&self) -> usize {
        self.windows.data.height
    }

    /// Returns the data window, which the planes cover.
    pub fn data_window(&self) -> Rectangle {
        self.windows.data
    }

    /// Returns the display window, which the frame of the lens covers.
    pub fn display_window(&self) -> Rectangle {
        self.windows.display
    }

    /// Returns the data and display windows.
    pub fn windows(&self) -> ImageWindows {
        self.windows
    }

    /// Changes the data window of an EXR: all channels of the part are cropped. Colour, alpha and depth are extended by their
    /// edge pixels; other channels, such as identifiers, coverage and normals, are zero there unless
    /// [`PlateOptions::extend_channels`] is set. Plates of other formats stay the same.
    pub fn set_data_window(&mut self, window: Rectangle) {
        if let Source::Exr {
            image, channels, ..
        } = &mut self.source
        {
            let mut extended = channels.all();
            let depth = image.depth_channel(None, DepthOwner::Colour(channels.colour[0]));
            extended.extend(depth);
            let all = self.options.extend_channels;
            image.set_data_window(channels.colour[0], window, |id| {
                all || extended.contains(&id)
            });
            self.windows.data = window;
        }
    }

    /// Quantises the samples to the sample format of the file. EXR planes are quantised when they are set.
    pub fn quantise(&mut self) {
        if let Source::Raster { image, .. } = &mut self.source {
            image.quantise();
        }
    }

    /// Returns the width of a pixel over its height: as stated in EXR and DPX files, else one.
    pub fn pixel_aspect(&self) -> f64 {
        match &self.source {
            Source::Exr { image, .. } => image.pixel_aspect(),
            Source::Raster { image, .. } => image.metadata.pixel_aspect(),
        }
    }

    /// Returns the names of the colour planes: R, G, B, or Y.
    pub fn colour_names(&self) -> &[String] {
        &self.names
    }

    /// Returns whether there is an alpha channel.
    pub fn has_alpha(&self) -> bool {
        match &self.source {
            Source::Exr { channels, .. } => channels.alpha.is_some(),
            Source::Raster { image, .. } => image.plane("A").is_some(),
        }
    }

    /// Returns whether colour is premultiplied by alpha: by the user's choice, else always in EXR and DPX, never in PNG, and
    /// as stated in TIFF. True without alpha.
    pub fn is_premultiplied(&self) -> bool {
        if !self.has_alpha() {
            return true;
        }
        let by_file = match &self.source {
            Source::Exr { .. } => true,
            Source::Raster { image, .. } => image.metadata.is_premultiplied(),
        };
        self.options.premultiplied.unwrap_or(by_file)
    }

    /// Returns the colour planes, scene-linear, row-major, in the order of [`PlateFile::colour_names`].
    pub fn colour(&self) -> Vec<Vec<f32>> {
        match &self.source {
            Source::Exr {
                image, channels, ..
            } => {
                let ids = channels.colour.iter();
                ids.map(|&id| image.samples(id)).collect()
            }
            Source::Raster { image, encoding } => self
                .names
                .iter()
                .filter_map(|name| image.plane(name))
                .map(|plane| plane.iter().map(|&code| encoding.decode(code)).collect())
                .collect(),
        }
    }

    /// Returns the alpha plane, if there is one.
    pub fn alpha(&self) -> Option<Vec<f32>> {
        match &self.source {
            Source::Exr {
                image, channels, ..
            } => channels.alpha.map(|id| image.samples(id)),
            Source::Raster { image, .. } => image.plane("A").map(<[f32]>::to_vec),
        }
    }

    /// Returns whether each colour has an alpha channel of its own.
    pub fn has_channel_alphas(&self) -> bool {
        match &self.source {
            Source::Exr { channels, .. } => !channels.channel_alphas.is_empty(),
            Source::Raster { .. } => false,
        }
    }

    /// Returns the alpha plane of each colour, in the order of [`PlateFile::colour_names`]; empty unless requested by
    /// [`PlateOptions::alpha_per_channel`].
    pub fn channel_alphas(&self) -> Vec<Vec<f32>> {
        match &self.source {
            Source::Exr {
                image, channels, ..
            } => {
                let ids = channels.channel_alphas.iter();
                ids.map(|&id| image.samples(id)).collect()
            }
            Source::Raster { .. } => Vec::new(),
        }
    }

    /// Returns the NaN and infinite samples of colour and alpha.
    pub fn non_finite(&self) -> Vec<NonFiniteSamples> {
        let find = |name: &str, plane: &[f32]| NonFiniteSamples::find(name, self.width(), plane);
        match &self.source {
            Source::Exr {
                image, channels, ..
            } => {
                let ids = channels.all().into_iter();
                ids.filter_map(|id| find(&image.channel_name(id), &image.samples(id)))
                    .collect()
            }
            Source::Raster { image, .. } => image
                .names()
                .iter()
                .filter_map(|name| find(name, image.plane(name)?))
                .collect(),
        }
    }

    /// Returns the memory that the samples of the file take, bytes.
    pub fn memory_bytes(&self) -> u64 {
        match &self.source {
            Source::Exr { image, .. } => image.memory_bytes(),
            Source::Raster { image, .. } => image.memory_bytes(),
        }
    }

    /// Replaces the colour planes by scene-linear ones, in the order of [`PlateFile::colour_names`].
    ///
    /// # Errors
    /// Planes that differ in number or size.
    pub fn set_colour(&mut self, planes: &[Vec<f32>]) -> Result<()> {
        if planes.len() != self.names.len() {
            return Err(FileError::new(
                self.path(),
                "channels",
                format!("{} planes for {}", planes.len(), self.names.join(", ")),
                "give one plane per colour channel",
            ));
        }
        match &mut self.source {
            Source::Exr {
                image, channels, ..
            } => {
                for (&id, plane) in channels.colour.iter().zip(planes) {
                    image.replace(id, plane)?;
                }
            }
            Source::Raster { image, encoding } => {
                for (name, plane) in self.names.iter().zip(planes) {
                    let codes = plane.iter().map(|&sample| encoding.encode(sample));
                    image.replace(name, codes.collect())?;
                }
            }
        }
        Ok(())
    }

    /// Replaces the alpha plane.
    ///
    /// # Errors
    /// A plate without alpha, and a plane of another size.
    pub fn set_alpha(&mut self, samples: &[f32]) -> Result<()> {
        match &mut self.source {
            Source::Exr {
                image, channels, ..
            } => match channels.alpha {
                Some(id) => image.replace(id, samples),
                None => Err(FileError::new(
                    image.path(),
                    "channel A",
                    "is not in the plate",
                    "leave alpha unchanged",
                )),
            },
            Source::Raster { image, .. } => image.replace("A", samples.to_vec()),
        }
    }

    /// Replaces the alpha planes of the colours, in the order of [`PlateFile::channel_alphas`].
    ///
    /// # Errors
    /// A plane of another size.
    pub fn set_channel_alphas(&mut self, planes: &[Vec<f32>]) -> Result<()> {
        if let Source::Exr {
            image, channels, ..
        } = &mut self.source
        {
            for (&id, plane) in channels.channel_alphas.iter().zip(planes) {
                image.replace(id, plane)?;
            }
        }
        Ok(())
    }

    /// Returns the depth channel in the plate's own file.
    ///
    /// # Errors
    /// A format without depth channels, or no such channel.
    pub fn depth(&self, channel: Option<&str>) -> Result<ImageChannel> {
        match &self.source {
            Source::Exr { image, .. } => {
                ImageChannel::depth_of_exr(image, channel, self.as_depth_owner())
            }
            Source::Raster { image, .. } => Err(FileError::new(
                image.path(),
                "depth",
                format!("cannot be in a {} plate", image.format()),
                "give the depth pass as a file of its own",
            )),
        }
    }

    /// Returns a note on further channels that may be the depth of the plate, where they differ from it.
    pub fn other_depths_note(&self) -> Option<String> {
        let Source::Exr {
            image, channels, ..
        } = &self.source
        else {
            return None;
        };
        let others = image.other_depths(channels.colour[0]);
        (!others.is_empty()).then(|| {
            format!(
                "other channels that may be depth, and differ: {others}; --depth takes one of them"
            )
        })
    }

    /// Reads a depth pass of this plate from `file`, as [`ImageChannel::read_depth`] does. If `file` is that of the plate, the
    /// pass is of the same part or view.
    ///
    /// # Errors
    /// Those of [`ImageChannel::read_depth`].
    pub fn read_depth(&self, file: &Path, channel: Option<&str>) -> Result<ImageChannel> {
        if file == self.path()
            && let Source::Exr { image, .. } = &self.source
        {
            return ImageChannel::depth_of_exr(image, channel, self.as_depth_owner());
        }
        let owner = self.view().map_or(DepthOwner::Unknown, DepthOwner::View);
        ImageChannel::read_depth(file, channel, owner)
    }

    fn as_depth_owner(&self) -> DepthOwner<'_> {
        match &self.source {
            Source::Exr { channels, .. } => DepthOwner::Colour(channels.colour[0]),
            Source::Raster { .. } => DepthOwner::Unknown,
        }
    }

    /// Returns the path of the file that was read.
    pub fn path(&self) -> &Path {
        match &self.source {
            Source::Exr { image, .. } => image.path(),
            Source::Raster { image, .. } => image.path(),
        }
    }

    /// Stores the provenance of `frame` (if the run has frames), made with `settings`, in the plate. Earlier provenance
    /// becomes its history.
    pub fn set_provenance(
        &mut self,
        provenance: &Provenance,
        frame: Option<i64>,
        settings: &[(String, String)],
    ) {
        match &mut self.source {
            Source::Exr {
                image, channels, ..
            } => {
                let id = channels.colour[0];
                let texts = provenance.texts(frame, settings, &image.provenance(id));
                image.set_provenance(id, &texts);
            }
            Source::Raster { image, .. } => {
                image.texts = provenance.texts(frame, settings, &image.texts);
            }
        }
    }

    /// Checks, before the work begins, that the plate can be written to `path`.
    ///
    /// # Errors
    /// An extension of no writable format, and content that the format does not allow.
    pub fn check_output(&self, path: &Path) -> Result<()> {
        let target = output_row(path)?.0;
        match &self.source {
            Source::Exr { image, .. } if target == self.format() => image.check_writable(),
            _ => Ok(()),
        }
    }

    /// Writes the plate in the format of the extension of `path`, whole or not at all. Returns warnings about every
    /// change beside the replaced samples, and about everything that the format cannot store.
    ///
    /// # Errors
    /// An extension of no writable format, and a target that cannot be written.
    pub fn write(&self, path: &Path) -> Result<Vec<String>> {
        let target = output_row(path)?;
        if target.0 != self.format() {
            return self.convert(path, target);
        }
        match &self.source {
            Source::Exr { image, .. } => {
                image.write(path)?;
                Ok(image.warnings())
            }
            Source::Raster { image, .. } => image.write(path),
        }
    }
}
