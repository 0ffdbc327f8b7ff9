//! Text attributes of EXR plates.

use exr::meta::attribute::{AttributeValue, Text};

use super::exr_plate::{ChannelId, ExrPlate};
use super::provenance::{Texts, is_ours};

impl ExrPlate {
    /// The text attributes of the part of `id` that are provenance.
    pub(super) fn provenance(&self, id: ChannelId) -> Texts {
        let attributes = self.attributes(id).iter();
        let texts = attributes.filter_map(|(name, value)| match value {
            AttributeValue::Text(text) => {
                let name = name.to_string();
                is_ours(&name).then(|| (name, utf8(text)))
            }
            _ => None,
        });
        texts.collect()
    }

    /// Puts others in their place.
    pub(super) fn set_provenance(&mut self, id: ChannelId, texts: &Texts) {
        let attributes = self.attributes_mut(id);
        attributes.retain(|name, value| {
            !(matches!(value, AttributeValue::Text(_)) && is_ours(&name.to_string()))
        });
        for (name, text) in texts {
            let text = AttributeValue::Text(Text::from_slice_unchecked(text.as_bytes()));
            attributes.insert(Text::from(name.as_str()), text);
        }
    }
}

/// A text of an EXR file, of which UTF-8 is usual.
pub(super) fn utf8(text: &Text) -> String {
    let bytes: Vec<u8> = text.bytes().to_vec();
    String::from_utf8_lossy(&bytes).into_owned()
}
