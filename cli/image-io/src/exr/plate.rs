//! OpenEXR plates: everything in the file is kept, and only the channels that are replaced change.

use std::collections::HashMap;
use std::fmt;
use std::path::{Path, PathBuf};

use exr::image::{AnyChannel, AnyImage, Blocks, FlatSamples, Levels};
use exr::meta::attribute::{AttributeValue, LineOrder, SampleType, Text};
use exr::prelude::{Compression, ImageAttributes, LayerAttributes, Vec2};
use half::f16;

use crate::error::{FileError, Result};
use crate::exr::file::{read_exr, write_exr};
use crate::exr::key_code;
use crate::exr::packing::loses;
use crate::limits::Limits;
use crate::windows::held;

/// A rectangle of pixels on the infinite plane of an EXR file: x right, y down.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    /// Column of the left-most pixel; may be negative.
    pub x: i32,
    /// Row of the top-most pixel; may be negative.
    pub y: i32,
    /// Width, pixels.
    pub width: usize,
    /// Height, pixels.
    pub height: usize,
}

impl fmt::Display for Window {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}x{} at ({}, {})",
            self.width, self.height, self.x, self.y
        )
    }
}

/// One channel of a plate, by its place in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ChannelId {
    pub(crate) part: usize,
    pub(crate) channel: usize,
}

impl ChannelId {
    /// Index of the part that holds the channel.
    pub fn part(self) -> usize {
        self.part
    }
}

/// What a channel is called and how it is stored.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChannelInfo {
    /// Its place.
    pub id: ChannelId,
    /// Name of its part, where the part has one.
    pub part: Option<String>,
    /// Full name with its layer, such as `R` or `diffuse.R`.
    pub name: String,
    /// Half, float or unsigned integer.
    pub sample_type: SampleType,
}

/// Samples of one channel that are NaN or infinite.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NonFinite {
    /// Name of the channel.
    pub channel: String,
    /// How many samples are not finite.
    pub count: usize,
    /// Column and row of the first, from the top-left pixel of the data window.
    pub first: (usize, usize),
}

impl fmt::Display for NonFinite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (column, row) = self.first;
        write!(
            f,
            "channel {} holds {} NaN or infinite samples, the first at column {column}, row {row}",
            self.channel, self.count
        )
    }
}

/// The samples of `plane`, `width` wide, that are NaN or infinite; `None` if all are finite.
pub fn non_finite(channel: &str, width: usize, plane: &[f32]) -> Option<NonFinite> {
    let first = plane.iter().position(|v| !v.is_finite())?;
    let width = width.max(1);
    Some(NonFinite {
        channel: channel.to_owned(),
        count: plane.iter().filter(|v| !v.is_finite()).count(),
        first: (first % width, first / width),
    })
}

/// A flat OpenEXR file in memory, with all its parts, channels and attributes.
#[derive(Debug, Clone)]
pub struct ExrPlate {
    path: PathBuf,
    image: AnyImage,
    notes: Vec<String>,
    /// Parts that lost quality by how they were packed, each with what is told of it.
    repacked: Vec<(usize, String)>,
}

impl ExrPlate {
    /// Reads a plate.
    ///
    /// What could not be written back is settled here and told by [`ExrPlate::notes`]: parts in a lossy
    /// compression become ZIP, so that pixels that are not replaced stay as they are.
    ///
    /// # Errors
    /// A file that cannot be read, and deep, subsampled or otherwise unsupported ones.
    pub fn open(path: &Path) -> Result<Self> {
        let mut plate = Self {
            path: path.to_path_buf(),
            image: read_exr(path, Limits::PLATE)?,
            notes: Vec::new(),
            repacked: Vec::new(),
        };
        plate.make_writable();
        Ok(plate)
    }

    fn make_writable(&mut self) {
        for (index, layer) in self.image.layer_data.iter_mut().enumerate() {
            let part = match &layer.attributes.layer_name {
                Some(name) => format!("part `{name}`"),
                None => "the plate".to_owned(),
            };
            if loses(layer.encoding.compression, &layer.channel_data.list) {
                self.repacked.push((
                    index,
                    format!(
                        "{part} was {} compressed, which loses quality each time; it is written with ZIP",
                        layer.encoding.compression
                    ),
                ));
                layer.encoding.compression = Compression::ZIP16;
            }
            // The library refuses to write scan lines in no order.
            if layer.encoding.blocks == Blocks::ScanLines
                && layer.encoding.line_order == LineOrder::Unspecified
            {
                layer.encoding.line_order = LineOrder::Increasing;
            }
            key_code::veil(&mut layer.attributes);
        }
    }

    /// The file it was read from.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What is or will be written otherwise than it was read; one sentence each.
    pub fn notes(&self) -> Vec<String> {
        let repacked = self.repacked.iter().map(|(_, note)| note);
        repacked.chain(&self.notes).cloned().collect()
    }

    /// Whether a part would lose quality by a compression.
    pub(crate) fn would_lose(&self, part: usize, compression: Compression) -> bool {
        let layer = self.image.layer_data.get(part);
        layer.is_some_and(|layer| loses(compression, &layer.channel_data.list))
    }

    /// Packs a part by a compression that was asked for.
    pub(crate) fn set_compression(&mut self, part: usize, compression: Compression) {
        if let Some(layer) = self.image.layer_data.get_mut(part) {
            layer.encoding.compression = compression;
        }
        self.repacked.retain(|(own, _)| *own != part);
    }

    /// An attribute of the first part by its name.
    pub(crate) fn attribute(&self, name: &str) -> Option<&AttributeValue> {
        let attributes = &self.image.layer_data.first()?.attributes.other;
        attributes.get(&Text::new_or_none(name)?)
    }

    /// The attributes of all parts.
    pub(crate) fn image_attributes(&self) -> &ImageAttributes {
        &self.image.attributes
    }

    /// The attributes of each part.
    pub(crate) fn part_attributes(&self) -> impl Iterator<Item = &LayerAttributes> {
        self.image.layer_data.iter().map(|layer| &layer.attributes)
    }

    /// The attributes of a part that the format does not define.
    pub(crate) fn attributes(&self, part: usize) -> Option<&HashMap<Text, AttributeValue>> {
        Some(&self.image.layer_data.get(part)?.attributes.other)
    }

    /// The same, to be changed.
    pub(crate) fn attributes_mut(
        &mut self,
        part: usize,
    ) -> Option<&mut HashMap<Text, AttributeValue>> {
        Some(&mut self.image.layer_data.get_mut(part)?.attributes.other)
    }

    /// Takes the chromaticities away, which are one for all parts; whether there were any.
    pub(crate) fn drop_chromaticities(&mut self) -> bool {
        self.image.attributes.chromaticities.take().is_some()
    }

    /// Adds a sentence to what is told of the file.
    pub(crate) fn note(&mut self, note: String) {
        self.notes.push(note);
    }

    /// Number of parts in the file, at least one.
    pub fn parts(&self) -> usize {
        self.image.layer_data.len()
    }

    /// Name of a part, where it has one.
    pub fn part_name(&self, part: usize) -> Option<String> {
        let attributes = &self.image.layer_data.get(part)?.attributes;
        attributes.layer_name.as_ref().map(ToString::to_string)
    }

    /// The pixels that the file has of the part of `id`.
    pub fn data_window(&self, id: ChannelId) -> Window {
        let layer = &self.image.layer_data[id.part];
        Window {
            x: layer.attributes.layer_position.x(),
            y: layer.attributes.layer_position.y(),
            width: layer.size.width(),
            height: layer.size.height(),
        }
    }

    /// The picture proper, which data windows may exceed or not fill.
    pub fn display_window(&self) -> Window {
        let window = self.image.attributes.display_window;
        Window {
            x: window.position.x(),
            y: window.position.y(),
            width: window.size.width(),
            height: window.size.height(),
        }
    }

    /// Width of a pixel over its height, as the file says.
    pub fn pixel_aspect(&self) -> f64 {
        f64::from(self.image.attributes.pixel_aspect)
    }

    /// Every channel, part by part.
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

    /// Name of one channel, with its layer but without its part.
    pub fn channel_name(&self, id: ChannelId) -> String {
        self.image.layer_data[id.part].channel_data.list[id.channel]
            .name
            .to_string()
    }

    /// The channels in words, for messages: `R, G, B` or `beauty:R, depth:Z` where there are parts.
    pub fn channel_list(&self) -> String {
        let several = self.parts() > 1;
        let names: Vec<String> = self
            .channels()
            .into_iter()
            .map(|c| match c.part {
                Some(part) if several => format!("{part}:{}", c.name),
                _ => c.name,
            })
            .collect();
        names.join(", ")
    }

    /// The samples of one channel as floats, row-major over its data window. Unsigned integers above
    /// 2^24 lose their low bits here, and only here.
    pub fn samples(&self, id: ChannelId) -> Vec<f32> {
        let channel = &self.image.layer_data[id.part].channel_data.list[id.channel];
        match full_level(&channel.sample_data) {
            Some(FlatSamples::F16(samples)) => samples.iter().map(|s| s.to_f32()).collect(),
            Some(FlatSamples::F32(samples)) => samples.clone(),
            #[allow(clippy::cast_precision_loss)]
            Some(FlatSamples::U32(samples)) => samples.iter().map(|&s| s as f32).collect(),
            None => Vec::new(),
        }
    }

    /// Memory that the samples of all channels take at full resolution, bytes.
    pub fn held_bytes(&self) -> u64 {
        let channels = self.channels().into_iter().map(|channel| {
            let window = self.data_window(channel.id);
            (window.width * window.height * channel.sample_type.bytes_per_sample()) as u64
        });
        channels.sum()
    }

    /// The NaN and infinite samples of the given channels, for those that have any.
    pub fn non_finite(&self, ids: &[ChannelId]) -> Vec<NonFinite> {
        ids.iter()
            .filter_map(|&id| {
                let width = self.data_window(id).width;
                non_finite(&self.channel_name(id), width, &self.samples(id))
            })
            .collect()
    }

    /// Puts `samples` in place of a channel's, in the channel's own sample type: half and unsigned
    /// integer are rounded to nearest and saturate at their largest value. Saturation is noted.
    ///
    /// Smaller copies of the picture (mip maps) in the same part are dropped, which is noted too.
    ///
    /// # Errors
    /// A sample count that is not that of the channel.
    pub fn replace(&mut self, id: ChannelId, samples: &[f32]) -> Result<()> {
        let name = self.channel_name(id);
        let window = self.data_window(id);
        if samples.len() != window.width * window.height {
            return Err(FileError::new(
                &self.path,
                format!("channel {name}"),
                format!("{} samples do not fill {window}", samples.len()),
                "give one sample a pixel of the data window",
            ));
        }
        let layer = &mut self.image.layer_data[id.part];
        let mut dropped_levels = false;
        for channel in &mut layer.channel_data.list {
            dropped_levels |= keep_full_level(&mut channel.sample_data);
        }
        let target = &mut layer.channel_data.list[id.channel].sample_data;
        let saturated = match target {
            Levels::Singular(target) => overwrite(target, samples),
            // No levels at all: nothing was read, so the sample count is zero and checked above.
            _ => 0,
        };
        if dropped_levels {
            self.notes.push(dropped_levels_of(&name));
        }
        if saturated > 0 {
            self.notes.push(format!(
                "channel {name}: {saturated} samples were beyond its sample type and are clipped"
            ));
        }
        Ok(())
    }

    /// Adds copies of channel `id` to its part, called as `names` say; those that are there already stay.
    /// Channels may lie elsewhere afterwards.
    pub(crate) fn copy_channel(&mut self, id: ChannelId, names: &[String]) {
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

    /// Gives the part of `id` another data window: all of its channels are cut to it, and beyond what they were they
    /// are as their nearest pixel. Smaller copies of the picture are dropped.
    pub fn reframe(&mut self, id: ChannelId, to: Window) {
        let from = self.data_window(id);
        let layer = &mut self.image.layer_data[id.part];
        let mut dropped_levels = false;
        for channel in &mut layer.channel_data.list {
            dropped_levels |= keep_full_level(&mut channel.sample_data);
            if let Levels::Singular(samples) = &mut channel.sample_data {
                *samples = match samples {
                    FlatSamples::F16(samples) => FlatSamples::F16(held(samples, from, to)),
                    FlatSamples::F32(samples) => FlatSamples::F32(held(samples, from, to)),
                    FlatSamples::U32(samples) => FlatSamples::U32(held(samples, from, to)),
                };
            }
        }
        layer.size = Vec2(to.width, to.height);
        layer.attributes.layer_position = Vec2(to.x, to.y);
        if dropped_levels {
            let name = self.channel_name(id);
            self.notes.push(dropped_levels_of(&name));
        }
    }

    /// Writes the plate whole or not at all.
    ///
    /// # Errors
    /// A target that cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        write_exr(path, &self.image, true)
    }
}

fn dropped_levels_of(name: &str) -> String {
    format!("the mip or rip levels beside channel {name} are left out, as they no longer fit")
}

pub(crate) fn full_level(levels: &Levels<FlatSamples>) -> Option<&FlatSamples> {
    match levels {
        Levels::Singular(samples) => Some(samples),
        Levels::Mip { level_data, .. } => level_data.first(),
        Levels::Rip { level_data, .. } => level_data.map_data.first(),
    }
}

/// Drops all but the full resolution; whether there was anything to drop.
fn keep_full_level(levels: &mut Levels<FlatSamples>) -> bool {
    let data = match levels {
        Levels::Singular(_) => return false,
        Levels::Mip { level_data, .. } => level_data,
        Levels::Rip { level_data, .. } => &mut level_data.map_data,
    };
    if data.is_empty() {
        return false;
    }
    *levels = Levels::Singular(data.swap_remove(0));
    true
}

fn sample_type(samples: &FlatSamples) -> SampleType {
    match samples {
        FlatSamples::F16(_) => SampleType::F16,
        FlatSamples::F32(_) => SampleType::F32,
        FlatSamples::U32(_) => SampleType::U32,
    }
}

/// Writes `from` over `to` in the type of `to`; how many finite samples had to be clipped.
fn overwrite(to: &mut FlatSamples, from: &[f32]) -> usize {
    match to {
        FlatSamples::F32(to) => {
            to.copy_from_slice(from);
            0
        }
        FlatSamples::F16(to) => {
            let mut clipped = 0;
            for (to, &from) in to.iter_mut().zip(from) {
                let half = f16::from_f32(from);
                *to = if half.is_infinite() {
                    clipped += usize::from(from.is_finite());
                    if from > 0.0 { f16::MAX } else { f16::MIN }
                } else {
                    half
                };
            }
            clipped
        }
        FlatSamples::U32(to) => {
            let mut clipped = 0;
            for (to, &from) in to.iter_mut().zip(from) {
                let rounded = from.round();
                clipped += usize::from(rounded < 0.0 || rounded >= u32::MAX as f32);
                // A float cast saturates, and turns NaN into 0.
                *to = rounded as u32;
            }
            clipped
        }
    }
}
