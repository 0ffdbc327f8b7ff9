//! Description of an OpenEXR file from its headers.

use std::io::BufReader;

use exr::meta::attribute::{AttributeValue, ChannelDescription, SampleType};
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};

use super::library_types::utf8;
use super::selection::{ChannelPlace, NoColour, NoDepth, PartNames, Selection, ViewChoice};

use crate::error::Result;
use crate::input::InputFile;
use crate::metadata::{TextAttributes, is_provenance, key_code_text, time_code_text};
use crate::part::Part;

/// Attributes that are described as storage.
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

/// Describes the parts of a file.
///
/// # Errors
/// A damaged header.
pub(super) fn describe(input: &InputFile) -> Result<Vec<Part>> {
    let meta = MetaData::read_from_buffered(BufReader::new(&input.file), false)
        .map_err(|error| input.damaged(&error.to_string()))?;
    let mut parts: Vec<Part> = meta.headers.iter().map(describe_part).collect();
    describe_choice(&meta.headers, &mut parts);
    Ok(parts)
}

/// Adds which channels would be taken as the plate and as its depth.
fn describe_choice(headers: &[Header], parts: &mut [Part]) {
    let names = headers.iter().map(|header| {
        let channels = header.channels.list.iter().map(|own| own.name.to_string());
        PartNames::new(&header.own_attributes, channels.collect())
    });
    let names: Vec<PartNames> = names.collect();
    let selection = Selection::new(&names);
    let name = |place: &ChannelPlace| names[place.part].channels[place.channel].clone();
    let full_names = |places: &[ChannelPlace]| {
        let full = places.iter().map(|place| match &names[place.part].name {
            Some(part) if names.len() > 1 => format!("{part}:{}", name(place)),
            _ => name(place),
        });
        full.collect::<Vec<_>>().join(", ")
    };
    let mut add = |part: usize, what: &str, text: String| {
        parts[part].storage.push((what.to_owned(), text));
    };
    let views = match selection.colour(None, &ViewChoice::All) {
        Ok(views) => views,
        Err(NoColour::Several(places)) => {
            let text = format!("one of {}: name it with --layer", full_names(&places));
            return add(0, "plate", text);
        }
        Err(_) => return,
    };
    for choice in views {
        let channels: Vec<String> = choice
            .colour
            .iter()
            .chain(&choice.alpha)
            .map(name)
            .collect();
        let view = choice.view.map(|view| format!("view {view}"));
        let why: Vec<String> = view.into_iter().chain(choice.reason).collect();
        let why = if why.is_empty() {
            String::new()
        } else {
            format!(" ({})", why.join("; "))
        };
        let first = choice.colour[0];
        add(first.part, "plate", format!("{}{why}", channels.join(", ")));
        // Samples are not read here, so that equal channels count as several.
        match selection.depth(Some(first), None, &|_, _| false) {
            Ok(depth) => add(depth.place.part, "depth of the plate", name(&depth.place)),
            Err(NoDepth::Several(places)) => {
                let places = full_names(&places);
                let text = format!("one of {places}: name it with --depth, if they differ");
                add(first.part, "depth of the plate", text);
            }
            Err(_) => {}
        }
    }
}

fn describe_part(header: &Header) -> Part {
    let window =
        |x: i32, y: i32, width: usize, height: usize| format!("{width} x {height} at ({x}, {y})");
    let named = |name: &str, value: String| (name.to_owned(), value);
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
        named("pixel aspect", shared.pixel_aspect.to_string()),
        named("compression", header.compression.to_string()),
        named("stored as", blocks),
    ];
    if header.deep {
        storage.push(named(
            "pixels",
            "deep: flatten the file before using it here".to_owned(),
        ));
    }
    let mut attributes = TextAttributes::new();
    let mut provenance = TextAttributes::new();
    for (name, value) in header.all_named_attributes() {
        let name = String::from_utf8_lossy(name).into_owned();
        if STORAGE.contains(&name.as_str()) {
            continue;
        }
        let list = if is_provenance(&name) {
            &mut provenance
        } else {
            &mut attributes
        };
        list.push((name, value_text(&value)));
    }
    attributes.sort();
    provenance.sort();
    let channel = |channel: &ChannelDescription| {
        let kind = match channel.sample_type {
            SampleType::F16 => "half",
            SampleType::F32 => "float",
            SampleType::U32 => "unsigned integer",
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

/// Length limit of a value that is no text, characters.
const MAX_VALUE: usize = 200;

fn value_text(value: &AttributeValue) -> String {
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
        AttributeValue::Rational((numerator, denominator)) => format!("{numerator}/{denominator}"),
        AttributeValue::IntegerBounds(bounds) => {
            // The corners as OpenEXR stores them, both inside. Wide, because a header may claim any.
            let (start, size) = (bounds.position, bounds.size);
            let right = i64::from(start.x()) + size.width() as i64 - 1;
            let bottom = i64::from(start.y()) + size.height() as i64 - 1;
            format!("{} {} {right} {bottom}", start.x(), start.y())
        }
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
        AttributeValue::TimeCode(code) => time_code_text(code),
        AttributeValue::KeyCode(code) => key_code_text(code),
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
                .nth(MAX_VALUE)
                .map_or(words.len(), |(at, _)| at);
            words[..end].to_owned()
        }
    }
}
