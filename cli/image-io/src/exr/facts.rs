//! What EXR plates say of a picture in attributes that other formats have places for.

use std::collections::HashMap;

use exr::meta::attribute::{AttributeValue, Text};
use exr::prelude::{ImageAttributes, LayerAttributes};

use crate::exr::key_code;
use crate::exr::plate::{ChannelId, ExrPlate};
use crate::exr::texts::{as_text, utf8};
use crate::facts::{CAMERA_MODEL, CAMERA_SERIAL, Facts, SHUTTER_ANGLE};
use crate::provenance::is_ours;

/// What OpenImageIO calls `framesPerSecond` where it writes it.
const FRAME_RATE: &str = "FramesPerSecond";

impl ExrPlate {
    /// What the part of `id` says of the picture.
    pub(crate) fn facts(&self, id: ChannelId) -> Facts {
        let Some(own) = self.part_attributes().nth(id.part()) else {
            return Facts::default();
        };
        let text = |name| self.text(id.part(), name);
        let other = |name| Text::new_or_none(name).and_then(|name| own.other.get(&name));
        let rate = || match other(FRAME_RATE) {
            Some(AttributeValue::Rational(rate)) => Some(*rate),
            _ => None,
        };
        Facts {
            time_code: self.image_attributes().time_code,
            frame_rate: own.frames_per_second.or_else(rate),
            owner: own.owner.as_ref().map(utf8),
            captured: own.capture_date.as_ref().map(utf8),
            device: text(CAMERA_MODEL),
            serial: text(CAMERA_SERIAL),
            shutter_angle: match other(SHUTTER_ANGLE) {
                Some(AttributeValue::F32(angle)) => Some(*angle),
                _ => None,
            },
            key_code: key_code::of(own),
        }
    }

    /// Whether it says anything beside windows, pixel aspect, names of parts, what made it, and attributes of the names
    /// `but`.
    pub(crate) fn has_own_attributes(&self, but: &[&str]) -> bool {
        let is = |name: &str| {
            but.contains(&name) || name == FRAME_RATE && but.contains(&"framesPerSecond")
        };
        let shared = self.image_attributes();
        let plain = ImageAttributes {
            pixel_aspect: shared.pixel_aspect,
            time_code: shared.time_code.filter(|_| is("timeCode")),
            ..ImageAttributes::new(shared.display_window)
        };
        let of_part = |part: &LayerAttributes| {
            let plain = LayerAttributes {
                layer_name: part.layer_name.clone(),
                layer_position: part.layer_position,
                owner: part.owner.clone().filter(|_| is("owner")),
                capture_date: part.capture_date.clone().filter(|_| is("capDate")),
                frames_per_second: part.frames_per_second.filter(|_| is("framesPerSecond")),
                ..LayerAttributes::default()
            };
            let bare = LayerAttributes {
                other: HashMap::new(),
                ..part.clone()
            };
            let named = |(name, value)| key_code::name_of(name, value).to_string();
            let mut names = part.other.iter().map(named);
            bare != plain || names.any(|name| !is_ours(&name) && !is(&name))
        };
        *shared != plain || self.part_attributes().any(of_part)
    }
}

/// Has the attributes of a new part say what is known of the picture, but for the time code, which is of all parts.
pub(crate) fn put_facts(attributes: &mut LayerAttributes, facts: &Facts) {
    attributes.frames_per_second = facts.frame_rate;
    attributes.owner = facts.owner.as_deref().map(as_text);
    attributes.capture_date = facts.captured.as_deref().map(as_text);
    let texts = [
        (CAMERA_MODEL, &facts.device),
        (CAMERA_SERIAL, &facts.serial),
    ];
    for (name, text) in texts {
        if let Some(text) = text {
            let text = AttributeValue::Text(as_text(text));
            attributes.other.insert(as_text(name), text);
        }
    }
    if let Some(code) = &facts.key_code {
        key_code::put(attributes, code);
    }
    if let Some(angle) = facts.shutter_angle {
        let angle = AttributeValue::F32(angle);
        attributes.other.insert(as_text(SHUTTER_ANGLE), angle);
    }
}
