//! Attributes of OpenEXR files: texts, provenance and the metadata that other formats store too.

use std::collections::HashMap;

use exr::meta::attribute::{AttributeValue, Text};
use exr::prelude::{ImageAttributes, LayerAttributes};

use super::image::{ChannelId, ExrImage};
use super::library_types::{new_text, utf8};
use super::placeholders::{find_key_code, insert_key_code, stored_name};
use crate::metadata::{
    CAMERA_MODEL, CAMERA_SERIAL, CommonMetadata, SHUTTER_ANGLE, TextAttributes, is_provenance,
};

/// The attribute of OpenImageIO that names the colour space.
pub(crate) const COLOUR_SPACE: &str = "oiio:ColorSpace";
/// OpenImageIO's name of `framesPerSecond`.
const OIIO_FRAME_RATE: &str = "FramesPerSecond";

impl ExrImage {
    /// Returns a non-standard attribute of a part.
    pub(crate) fn attribute(&self, part: usize, name: &str) -> Option<&AttributeValue> {
        let attributes = &self.part_attributes().nth(part)?.other;
        attributes.get(&Text::new_or_none(name)?)
    }

    /// Returns a text attribute of a part.
    pub(crate) fn text(&self, part: usize, name: &str) -> Option<String> {
        match self.attribute(part, name)? {
            AttributeValue::Text(text) => Some(utf8(text)),
            _ => None,
        }
    }

    /// Replaces the text of an attribute of a part, if the part has it.
    pub(crate) fn replace_text(&mut self, part: usize, name: &str, text: &str) {
        let attributes = self.attributes_mut(part);
        if let (Some(attributes), Some(name)) = (attributes, Text::new_or_none(name))
            && let Some(AttributeValue::Text(old)) = attributes.get_mut(&name)
        {
            *old = new_text(text);
        }
    }

    /// Removes an attribute of a part.
    pub(crate) fn remove_attribute(&mut self, part: usize, name: &str) {
        let attributes = self.attributes_mut(part);
        if let (Some(attributes), Some(name)) = (attributes, Text::new_or_none(name)) {
            attributes.remove(&name);
        }
    }

    /// Returns the provenance of the part that holds `id`, sorted by name.
    pub(crate) fn provenance(&self, id: ChannelId) -> TextAttributes {
        let attributes = self.part_attributes().nth(id.part());
        let attributes = attributes.into_iter().flat_map(|own| &own.other);
        let texts = attributes.filter_map(|(name, value)| match value {
            AttributeValue::Text(text) => {
                let name = name.to_string();
                is_provenance(&name).then(|| (name, utf8(text)))
            }
            _ => None,
        });
        let mut texts: TextAttributes = texts.collect();
        texts.sort();
        texts
    }

    /// Replaces the provenance of the part that holds `id`.
    pub(crate) fn set_provenance(&mut self, id: ChannelId, texts: &TextAttributes) {
        let Some(attributes) = self.attributes_mut(id.part()) else {
            return;
        };
        attributes.retain(|name, value| {
            !(matches!(value, AttributeValue::Text(_)) && is_provenance(&name.to_string()))
        });
        for (name, text) in texts {
            attributes.insert(new_text(name), AttributeValue::Text(new_text(text)));
        }
    }

    /// Returns the common metadata of the part that holds `id`.
    pub(crate) fn common(&self, id: ChannelId) -> CommonMetadata {
        let Some(own) = self.part_attributes().nth(id.part()) else {
            return CommonMetadata::default();
        };
        let text = |name| self.text(id.part(), name);
        let oiio_rate = || match self.attribute(id.part(), OIIO_FRAME_RATE) {
            Some(AttributeValue::Rational(rate)) => Some(*rate),
            _ => None,
        };
        CommonMetadata {
            time_code: self.image_attributes().time_code,
            frame_rate: own.frames_per_second.or_else(oiio_rate),
            owner: own.owner.as_ref().map(utf8),
            capture_date: own.capture_date.as_ref().map(utf8),
            camera_model: text(CAMERA_MODEL),
            camera_serial: text(CAMERA_SERIAL),
            shutter_angle: match self.attribute(id.part(), SHUTTER_ANGLE) {
                Some(AttributeValue::F32(angle)) => Some(*angle),
                _ => None,
            },
            key_code: find_key_code(own),
        }
    }

    /// Returns whether the file has attributes beside windows, pixel aspect, part names, provenance, and those called `kept`.
    pub(crate) fn has_attributes_beside(&self, kept: &[&str]) -> bool {
        let is_kept = |name: &str| {
            kept.contains(&name) || name == OIIO_FRAME_RATE && kept.contains(&"framesPerSecond")
        };
        let shared = self.image_attributes();
        let plain = ImageAttributes {
            pixel_aspect: shared.pixel_aspect,
            time_code: shared.time_code.filter(|_| is_kept("timeCode")),
            ..ImageAttributes::new(shared.display_window)
        };
        let has_others = |part: &LayerAttributes| {
            let plain = LayerAttributes {
                layer_name: part.layer_name.clone(),
                layer_position: part.layer_position,
                owner: part.owner.clone().filter(|_| is_kept("owner")),
                capture_date: part.capture_date.clone().filter(|_| is_kept("capDate")),
                frames_per_second: part
                    .frames_per_second
                    .filter(|_| is_kept("framesPerSecond")),
                ..LayerAttributes::default()
            };
            let standard = LayerAttributes {
                other: HashMap::new(),
                ..part.clone()
            };
            let name = |(name, value)| stored_name(name, value).to_string();
            let mut names = part.other.iter().map(name);
            standard != plain || names.any(|name| !is_provenance(&name) && !is_kept(&name))
        };
        *shared != plain || self.part_attributes().any(has_others)
    }
}

/// Stores common metadata in the attributes of a new part, except for the time code, which all parts share.
pub(super) fn set_common(attributes: &mut LayerAttributes, common: &CommonMetadata) {
    attributes.frames_per_second = common.frame_rate;
    attributes.owner = common.owner.as_deref().map(new_text);
    attributes.capture_date = common.capture_date.as_deref().map(new_text);
    let texts = [
        (CAMERA_MODEL, &common.camera_model),
        (CAMERA_SERIAL, &common.camera_serial),
    ];
    for (name, text) in texts {
        if let Some(text) = text {
            let text = AttributeValue::Text(new_text(text));
            attributes.other.insert(new_text(name), text);
        }
    }
    if let Some(code) = &common.key_code {
        insert_key_code(attributes, code);
    }
    if let Some(angle) = common.shutter_angle {
        let angle = AttributeValue::F32(angle);
        attributes.other.insert(new_text(SHUTTER_ANGLE), angle);
    }
}
