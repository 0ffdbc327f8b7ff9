//! What an image file is, for people: size, channels, storage, attributes, and what made it.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use exr::meta::BlockDescription;
use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, SampleType, TimeCode};
use exr::meta::header::Header;
use serde::Serialize;

use crate::error::{FileError, Result};
use crate::exr::key_code;
use crate::exr::texts::utf8;
use crate::flat_plate::FlatPlate;
use crate::format::{Format, detect};
use crate::guard::caught;
use crate::provenance::is_ours;

/// Names and values, in an order.
type Named = Vec<(String, String)>;

/// A file described.
#[derive(Debug, Clone, Serialize)]
pub struct Description {
    /// The file.
    pub file: String,
    /// Its format.
    pub format: String,
    /// Its parts, at least one.
    pub parts: Vec<Part>,
}

/// A part of a file; most have one.
#[derive(Debug, Clone, Serialize)]
pub struct Part {
    /// Its name, where it has one.
    pub name: Option<String>,
    /// Width and height of what it has pixels of.
    pub size: (usize, usize),
    /// Channels, each with its sample type.
    pub channels: Named,
    /// How it is stored.
    pub storage: Named,
    /// What else the file says.
    pub attributes: Named,
    /// What Seidel wrote of what made it.
    pub provenance: Named,
}

impl Description {
    /// That of an image file. Pixels of OpenEXR files are not read.
    ///
    /// # Errors
    /// A file that cannot be read, or of no supported format.
    pub fn of(path: &Path) -> Result<Self> {
        let format = detect(path)?;
        let parts = match format {
            Format::Exr => exr_parts(path)?,
            _ => vec![flat_part(&FlatPlate::open(path)?)],
        };
        Ok(Self {
            file: path.display().to_string(),
            format: format.to_string(),
            parts,
        })
    }

    /// The same as lines of text.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![format!("{}: {}", self.file, self.format)];
        for (index, part) in self.parts.iter().enumerate() {
            if self.parts.len() > 1 || part.name.is_some() {
                let name = part.name.as_deref().unwrap_or("without a name");
                lines.push(format!("part {}: {name}", index + 1));
            }
            let (width, height) = part.size;
            lines.push(format!("  size: {width} x {height}"));
            let channels = part
                .channels
                .iter()
                .map(|(name, kind)| format!("{name} ({kind})"));
            lines.push(format!(
                "  channels: {}",
                channels.collect::<Vec<_>>().join(", ")
            ));
            for (name, value) in part.storage.iter().chain(&part.attributes) {
                lines.extend(indented(name, value));
            }
            if !part.provenance.is_empty() {
                lines.push("  made by Seidel:".to_owned());
                let own = part.provenance.iter();
                lines.extend(own.flat_map(|(name, value)| indented(&format!("  {name}"), value)));
            }
        }
        lines
    }
}

/// A name with its value, further lines of which stand under it.
fn indented(name: &str, value: &str) -> Vec<String> {
    if value.contains('\n') {
        let below = value.lines().map(|line| format!("      {line}"));
        return std::iter::once(format!("  {name}:")).chain(below).collect();
    }
    vec![format!("  {name}: {value}")]
}

fn named(name: &str, value: impl ToString) -> (String, String) {
    (name.to_owned(), value.to_string())
}

fn flat_part(plate: &FlatPlate) -> Part {
    let depth = plate.depth().to_string();
    let (provenance, attributes) =
        (plate.texts().iter().cloned()).partition(|(name, _)| is_ours(name));
    Part {
        name: None,
        size: (plate.width(), plate.height()),
        channels: plate
            .names()
            .iter()
            .map(|name| named(name, &depth))
            .collect(),
        storage: plate.storage(),
        attributes,
        provenance,
    }
}

fn exr_parts(path: &Path) -> Result<Vec<Part>> {
    let unreadable = |what: String| {
        FileError::new(
            path,
            "header",
            format!("cannot be read ({what})"),
            "copy or render the file again",
        )
    };
    let file = File::open(path).map_err(|e| FileError::io(path, "be opened", &e))?;
    let read = caught(|| MetaData::read_from_buffered(BufReader::new(file), false));
    let meta = read
        .map_err(unreadable)?
        .map_err(|error| unreadable(error.to_string()))?;
    Ok(meta.headers.iter().map(exr_part).collect())
}

/// What is told apart from other attributes.
const STORAGE: [&str; 11] = [
    "channels",
    "compression",
    "dataWindow",
    "displayWindow",
    "lineOrder",
    "tiles",
    "type",
    "chunkCount",
    "name",
    "pixelAspectRatio",
    "version",
];

fn exr_part(header: &Header) -> Part {
    let window =
        |x: i32, y: i32, width: usize, height: usize| format!("{width} x {height} at ({x}, {y})");
    let own = &header.own_attributes;
    let shared = &header.shared_attributes;
    let display = shared.display_window;
    let blocks = match header.blocks {
        BlockDescription::ScanLines => "scan lines".to_owned(),
        BlockDescription::Tiles(tiles) => format!(
            "tiles of {} x {}, {:?} levels",
            tiles.tile_size.width(),
            tiles.tile_size.height(),
            tiles.level_mode
        ),
    };
    let mut storage = vec![
        named(
            "data window",
            window(
                own.layer_position.x(),
                own.layer_position.y(),
                header.layer_size.width(),
                header.layer_size.height(),
            ),
        ),
        named(
            "display window",
            window(
                display.position.x(),
                display.position.y(),
                display.size.width(),
                display.size.height(),
            ),
        ),
        named("pixel aspect", shared.pixel_aspect),
        named("compression", header.compression),
        named("stored as", blocks),
    ];
    if header.deep {
        storage.push(named(
            "pixels",
            "deep: flatten the file before it is used here",
        ));
    }
    let mut attributes = Named::new();
    let mut provenance = Named::new();
    for (name, value) in header.all_named_attributes() {
        let name = String::from_utf8_lossy(name).into_owned();
        if STORAGE.contains(&name.as_str()) {
            continue;
        }
        let list = if is_ours(&name) {
            &mut provenance
        } else {
            &mut attributes
        };
        list.push((name, in_words(&value)));
    }
    attributes.sort();
    let channel = |channel: &exr::meta::attribute::ChannelDescription| {
        let kind = match channel.sample_type {
            SampleType::F16 => "half",
            SampleType::F32 => "float",
            SampleType::U32 => "whole number",
        };
        let (x, y) = (channel.sampling.x(), channel.sampling.y());
        let sampled = if (x, y) == (1, 1) {
            String::new()
        } else {
            format!(", every {x} x {y} pixels")
        };
        (channel.name.to_string(), format!("{kind}{sampled}"))
    };
    Part {
        name: own.layer_name.as_ref().map(utf8),
        size: (header.layer_size.width(), header.layer_size.height()),
        channels: header.channels.list.iter().map(channel).collect(),
        storage,
        attributes,
        provenance,
    }
}

/// Most letters of a value that is no text.
const MOST: usize = 200;

fn in_words(value: &AttributeValue) -> String {
    let list = |numbers: &[f32]| {
        let words: Vec<String> = numbers.iter().map(f32::to_string).collect();
        words.join(" ")
    };
    match value {
        AttributeValue::Text(text) => utf8(text),
        AttributeValue::TextVector(texts) => texts.iter().map(utf8).collect::<Vec<_>>().join(", "),
        AttributeValue::I32(v) => v.to_string(),
        AttributeValue::F32(v) => v.to_string(),
        AttributeValue::F64(v) => v.to_string(),
        AttributeValue::Rational((over, under)) => format!("{over}/{under}"),
        AttributeValue::IntVec2(v) => format!("{} {}", v.x(), v.y()),
        AttributeValue::FloatVec2(v) => list(&[v.x(), v.y()]),
        AttributeValue::FloatVec3((x, y, z)) => list(&[*x, *y, *z]),
        AttributeValue::Matrix3x3(m) => list(m),
        AttributeValue::Matrix4x4(m) => list(m),
        AttributeValue::Chromaticities(c) => {
            let pairs = [
                ("red", c.red),
                ("green", c.green),
                ("blue", c.blue),
                ("white", c.white),
            ];
            let words = pairs.map(|(name, at)| format!("{name} {} {}", at.x(), at.y()));
            words.join(", ")
        }
        AttributeValue::TimeCode(code) => time(code),
        AttributeValue::KeyCode(code) => key_code::in_words(code),
        AttributeValue::Preview(preview) => {
            format!(
                "{} x {} pixels",
                preview.size.width(),
                preview.size.height()
            )
        }
        AttributeValue::Bytes { bytes, .. } => format!("{} bytes", bytes.len()),
        AttributeValue::Custom { kind, bytes } => format!("{} bytes of type {kind}", bytes.len()),
        other => {
            let words = format!("{other:?}");
            let end = words
                .char_indices()
                .nth(MOST)
                .map_or(words.len(), |(at, _)| at);
            words[..end].to_owned()
        }
    }
}

/// A time code, hours first.
pub(crate) fn time(code: &TimeCode) -> String {
    let parts = [code.hours, code.minutes, code.seconds, code.frame];
    let [hours, minutes, seconds, frame] = parts;
    let dropped = if code.drop_frame { " drop frame" } else { "" };
    format!("{hours:02}:{minutes:02}:{seconds:02}:{frame:02}{dropped}")
}
