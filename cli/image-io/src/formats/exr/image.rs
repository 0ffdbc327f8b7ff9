//! An OpenEXR file in memory: everything in it passes through, and only the channels that are replaced change.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use exr::image::write::layers::WritableLayers;
use exr::image::{AnyChannel, AnyImage, Blocks, FlatSamples, Levels};
use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, LineOrder, SampleType, Text};
use exr::prelude::{Compression, ImageAttributes, LayerAttributes, Vec2};

use super::codec::{Compressing, read_exr, write_exr};
use super::compression::{ExrCompression, is_lossy};
use super::library_types::window;
use super::placeholders::{replace_key_codes, replace_standard_names};
use super::samples::{as_floats, full_level, keep_full_level, overwrite, sample_type};
use super::selection::ChannelPlace;
use crate::error::{FileError, Result};
use crate::input::InputFile;
use crate::samples::SampleFormat;
use crate::windows::{ImageWindows, crop_or_extend, crop_or_pad};
use seidel_optics::Rectangle;

/// The identity of a channel: its place in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ChannelId {
    part: usize,
    channel: usize,
}

impl ChannelId {
    /// Returns the index of the part that holds the channel.
    pub fn part(self) -> usize {
        self.part
    }

    pub(super) fn place(self) -> ChannelPlace {
        ChannelPlace {
            part: self.part,
            channel: self.channel,
        }
    }
}

impl From<ChannelPlace> for ChannelId {
    fn from(place: ChannelPlace) -> Self {
        Self {
            part: place.part,
            channel: place.channel,
        }
    }
}

/// The samples of a channel beyond its data window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Beyond {
    /// Those of the nearest pixel.
    Edge,
    Zero,
}

/// The name and sample type of a channel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChannelInfo {
    /// The identity of the channel.
    pub id: ChannelId,
    /// Name of its part, if the part has one.
    pub part: Option<String>,
    /// Full name with layer, such as `R` or `diffuse.R`.
    pub name: String,
    /// Half, float or unsigned integer.
    pub sample_type: SampleType,
}

/// A flat OpenEXR file in memory, with all its parts, channels and attributes.
#[derive(Debug, Clone)]
pub struct ExrImage {
    path: PathBuf,
    image: AnyImage,
    warnings: Vec<String>,
    /// Parts whose lossy compression is replaced by ZIP, each with its warning.
    recompressed: Vec<(usize, String)>,
}

impl ExrImage {
    /// Reads an open file.
    pub(super) fn read(input: &InputFile) -> Result<Self> {
        let mut image = Self {
            path: input.path.to_path_buf(),
            image: read_exr(input)?,
            warnings: Vec::new(),
            recompressed: Vec::new(),
        };
        image.make_writable();
        Ok(image)
    }

    /// Replaces what must not or cannot be written again: lossy compressions, undefined line orders and key codes.
    fn make_writable(&mut self) {
        for (index, layer) in self.image.layer_data.iter_mut().enumerate() {
            let part = match &layer.attributes.layer_name {
                Some(name) => format!("part `{name}`"),
                None => "the plate".to_owned(),
            };
            if is_lossy(layer.encoding.compression, &layer.channel_data.list) {
                self.recompressed.push((
                    index,
                    format!(
                        "{part} was {} compressed, which loses quality each time; it is written with ZIP",
                        layer.encoding.compression
                    ),
                ));
                layer.encoding.compression = Compression::ZIP16;
            }
            // The library refuses to write scan lines without an order.
            if layer.encoding.blocks == Blocks::ScanLines
                && layer.encoding.line_order == LineOrder::Unspecified
            {
                layer.encoding.line_order = LineOrder::Increasing;
            }
            replace_key_codes(&mut layer.attributes);
            replace_standard_names(&mut layer.attributes.other);
        }
        replace_standard_names(&mut self.image.attributes.other);
    }

    /// Returns the path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns warnings about everything, apart from replaced samples, that is written otherwise than it was read.
    pub fn warnings(&self) -> Vec<String> {
        let recompressed = self.recompressed.iter().map(|(_, warning)| warning);
        recompressed.chain(&self.warnings).cloned().collect()
    }

    /// Adds a warning.
    pub(crate) fn warn(&mut self, warning: String) {
        self.warnings.push(warning);
    }

    /// Compresses the part of `channels` by another method. If that is lossy and the part has further channels, it is
    /// compressed by ZIP, with a warning.
    pub(crate) fn compress(&mut self, channels: &[ChannelId], compression: ExrCompression) {
        let part = channels[0].part;
        let others = self.channels().into_iter();
        let others = others.filter(|c| c.id.part == part && !channels.contains(&c.id));
        let others: Vec<String> = others.map(|c| c.name).collect();
        let layer = &mut self.image.layer_data[part];
        let mut method = compression.method();
        if !others.is_empty() && is_lossy(method, &layer.channel_data.list) {
            self.warnings.push(format!(
                "{method} would degrade {}, which are in the same part: it is written with ZIP",
                others.join(", ")
            ));
            method = Compression::ZIP16;
        }
        layer.encoding.compression = method;
        self.recompressed.retain(|(own, _)| *own != part);
    }

    /// Returns the attributes that all parts share.
    pub(crate) fn image_attributes(&self) -> &ImageAttributes {
        &self.image.attributes
    }

    /// Returns the attributes of each part.
    pub(crate) fn part_attributes(&self) -> impl Iterator<Item = &LayerAttributes> {
        self.image.layer_data.iter().map(|layer| &layer.attributes)
    }

    /// Returns the non-standard attributes of a part.
    pub(super) fn attributes_mut(
        &mut self,
        part: usize,
    ) -> Option<&mut HashMap<Text, AttributeValue>> {
        Some(&mut self.image.layer_data.get_mut(part)?.attributes.other)
    }

    /// Removes the chromaticities, which all parts share. Returns whether there were any.
    pub(crate) fn remove_chromaticities(&mut self) -> bool {
        self.image.attributes.chromaticities.take().is_some()
    }

    /// Returns the number of parts, at least one.
    pub fn parts(&self) -> usize {
        self.image.layer_data.len()
    }

    /// Returns the name of a part, if it has one.
    pub fn part_name(&self, part: usize) -> Option<String> {
        let attributes = &self.image.layer_data.get(part)?.attributes;
        attributes.layer_name.as_ref().map(ToString::to_string)
    }

    /// Returns the data window of the part that holds `id`.
    pub fn data_window(&self, id: ChannelId) -> Rectangle {
        window(self.image.layer_data[id.part].absolute_bounds())
    }

    /// Returns the display window.
    pub fn display_window(&self) -> Rectangle {
        window(self.image.attributes.display_window)
    }

    /// Returns the data window of the part that holds `id`, and the display window.
    pub fn windows(&self, id: ChannelId) -> ImageWindows {
        ImageWindows {
            data: self.data_window(id),
            display: self.display_window(),
        }
    }

    /// Returns the width of a pixel over its height.
    pub fn pixel_aspect(&self) -> f64 {
        f64::from(self.image.attributes.pixel_aspect)
    }

    /// Returns every channel, part by part.
    pub fn channels(&self) -> Vec<ChannelInfo> {
        let mut all = Vec::new();
        for (part, layer) in self.image.layer_data.iter().enumerate() {
            for (channel, info) in layer.channel_data.list.iter().enumerate() {
                all.push(ChannelInfo {
                    id: ChannelId { part, channel },
                    part: self.part_name(part),
                    name: info.name.to_string(),
                    sample_type: full_level(&info.sample_data).map_or(SampleType::F32, sample_type),
                });
            }
        }
        all
    }

    /// Returns the name of a channel, with its layer but without its part.
    pub fn channel_name(&self, id: ChannelId) -> String {
        self.channel(id).name.to_string()
    }

    fn channel(&self, id: ChannelId) -> &AnyChannel<Levels<FlatSamples>> {
        &self.image.layer_data[id.part].channel_data.list[id.channel]
    }

    /// Returns the names of all channels for messages: `R, G, B`, or `beauty:R, depth:Z` if there are several parts.
    pub fn channel_list(&self) -> String {
        let channels = self.channels().into_iter();
        let names: Vec<String> = channels.map(|channel| self.full_name(channel)).collect();
        names.join(", ")
    }

    /// Returns the name of a channel for messages, with its part if there are several.
    pub(crate) fn full_name(&self, channel: ChannelInfo) -> String {
        match channel.part {
            Some(part) if self.parts() > 1 => format!("{part}:{}", channel.name),
            _ => channel.name,
        }
    }

    /// Returns the name of a channel for messages, with its part if there are several.
    pub fn full_name_of(&self, id: ChannelId) -> String {
        match self.part_name(id.part) {
            Some(part) if self.parts() > 1 => format!("{part}:{}", self.channel_name(id)),
            _ => self.channel_name(id),
        }
    }

    /// Returns the samples of a channel as floats, row-major over its data window. Unsigned integers above 2^24 are
    /// rounded.
    pub fn samples(&self, id: ChannelId) -> Vec<f32> {
        full_level(&self.channel(id).sample_data).map_or_else(Vec::new, as_floats)
    }

    /// Returns the sample format that represents all of the given channels: half or float.
    pub(crate) fn sample_format(&self, ids: &[ChannelId]) -> SampleFormat {
        let is_half = |id: &ChannelId| {
            let samples = full_level(&self.channel(*id).sample_data);
            matches!(samples, Some(FlatSamples::F16(_)))
        };
        if ids.iter().all(is_half) {
            SampleFormat::F16
        } else {
            SampleFormat::F32
        }
    }

    /// Returns the memory that the samples of all channels take at full resolution, bytes.
    pub fn memory_bytes(&self) -> u64 {
        let channels = self.channels().into_iter().map(|channel| {
            let window = self.data_window(channel.id);
            (window.width * window.height * channel.sample_type.bytes_per_sample()) as u64
        });
        channels.sum()
    }

    /// Replaces the samples of a channel. They are converted to its sample type: half and unsigned integer samples are
    /// rounded to nearest and clipped, with a warning.
    ///
    /// Mip and rip levels of the same part are dropped, with a warning.
    ///
    /// # Errors
    /// A sample count that differs from that of the channel.
    pub fn replace(&mut self, id: ChannelId, samples: &[f32]) -> Result<()> {
        let name = self.channel_name(id);
        let window = self.data_window(id);
        if samples.len() != window.width * window.height {
            return Err(FileError::new(
                &self.path,
                format!("channel {name}"),
                format!("{} samples do not fill {window}", samples.len()),
                "give one sample per pixel of the data window",
            ));
        }
        self.drop_levels(id, &name);
        let layer = &mut self.image.layer_data[id.part];
        let clipped = match &mut layer.channel_data.list[id.channel].sample_data {
            Levels::Singular(target) => overwrite(target, samples),
            // A channel without levels has no samples.
            _ => 0,
        };
        if clipped > 0 {
            self.warnings.push(format!(
                "channel {name}: {clipped} samples were beyond its sample type and are clipped"
            ));
        }
        Ok(())
    }

    /// Drops all mip and rip levels of the part that holds `id` but the full resolution, with a warning that names the
    /// channel `name`.
    fn drop_levels(&mut self, id: ChannelId, name: &str) {
        let mut dropped = false;
        for channel in &mut self.image.layer_data[id.part].channel_data.list {
            dropped |= keep_full_level(&mut channel.sample_data);
        }
        if dropped {
            self.warnings.push(format!(
                "the mip or rip levels beside channel {name} are left out, as they no longer match"
            ));
        }
    }

    /// Adds copies of channel `id` to its part under `names`, except for names that exist. Invalidates the ids of all
    /// channels of the part.
    pub(super) fn duplicate_channel(&mut self, id: ChannelId, names: &[String]) {
        let list = &mut self.image.layer_data[id.part].channel_data.list;
        let original = list[id.channel].clone();
        for name in names {
            let name = Text::from(name.as_str());
            if list.iter().all(|channel| channel.name != name) {
                list.push(AnyChannel {
                    name,
                    ..original.clone()
                });
            }
        }
        list.sort_by(|a, b| a.name.cmp(&b.name));
    }

    /// Changes the data window of the part that holds `id`: all of its channels are cropped; beyond their edges, `extended`
    /// channels are extended by their edge pixels, and others are zero. Mip and rip levels are dropped.
    pub fn set_data_window(
        &mut self,
        id: ChannelId,
        to: Rectangle,
        extended: impl Fn(ChannelId) -> bool,
    ) {
        let from = self.data_window(id);
        let name = self.channel_name(id);
        self.drop_levels(id, &name);
        let layer = &mut self.image.layer_data[id.part];
        for (channel, own) in layer.channel_data.list.iter_mut().enumerate() {
            let beyond = if extended(ChannelId { channel, ..id }) {
                Beyond::Edge
            } else {
                Beyond::Zero
            };
            if let Levels::Singular(samples) = &mut own.sample_data {
                *samples = resized(samples, from, to, beyond);
            }
        }
        layer.size = Vec2(to.width, to.height);
        layer.attributes.layer_position = Vec2(to.x, to.y);
    }

    /// Replaces the channels `ids` by those of `other`, the same file with other changes. The data window becomes that of both
    /// together; beyond their own, these channels are zero.
    pub(crate) fn take_channels(&mut self, other: &Self, ids: &[ChannelId]) {
        for &id in ids {
            let (own, theirs) = (self.data_window(id), other.data_window(id));
            let both = own.union(theirs);
            if own != both {
                self.set_data_window(id, both, |_| false);
            }
            let taken = &other.channel(id).sample_data;
            let target = &mut self.image.layer_data[id.part].channel_data.list[id.channel];
            target.sample_data = match taken {
                Levels::Singular(samples) if theirs != both => {
                    Levels::Singular(resized(samples, theirs, both, Beyond::Zero))
                }
                levels => levels.clone(),
            };
            if matches!(taken, Levels::Singular(_)) {
                let name = self.channel_name(id);
                self.drop_levels(id, &name);
            }
        }
        let new = other
            .warnings
            .iter()
            .filter(|own| !self.warnings.contains(own));
        let new: Vec<String> = new.cloned().collect();
        self.warnings.extend(new);
    }

    /// Checks that the file can be written again, apart from its target.
    ///
    /// # Errors
    /// Names, windows or attributes that the format does not allow.
    pub fn check_writable(&self) -> Result<()> {
        let headers = self.image.layer_data.infer_headers(&self.image.attributes);
        match MetaData::validate(&headers, true) {
            Ok(_) => Ok(()),
            Err(error) => Err(FileError::new(
                &self.path,
                "header",
                format!("cannot be written again ({error})"),
                "correct the file, or give OUT the extension of another format",
            )),
        }
    }

    /// Writes the file, whole or not at all.
    ///
    /// # Errors
    /// A target that cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        write_exr(path, &self.image, Compressing::Parallel)
    }
}

/// Returns samples of the window `from` over the window `to`.
fn resized(samples: &FlatSamples, from: Rectangle, to: Rectangle, beyond: Beyond) -> FlatSamples {
    match samples {
        FlatSamples::F16(s) => FlatSamples::F16(resize(s, from, to, beyond)),
        FlatSamples::F32(s) => FlatSamples::F32(resize(s, from, to, beyond)),
        FlatSamples::U32(s) => FlatSamples::U32(resize(s, from, to, beyond)),
    }
}

fn resize<T: Copy + Default>(
    samples: &[T],
    from: Rectangle,
    to: Rectangle,
    beyond: Beyond,
) -> Vec<T> {
    match beyond {
        Beyond::Edge => crop_or_extend(samples, from, to),
        Beyond::Zero => crop_or_pad(samples, from, to),
    }
}
