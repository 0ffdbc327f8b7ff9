//! Text attributes of EXR plates.

use exr::meta::attribute::{AttributeValue, Text};

use crate::exr::plate::{ChannelId, ExrPlate};
use crate::provenance::{Texts, is_ours};

impl ExrPlate {
    /// The text of an attribute of a part by its name.
    pub(crate) fn text(&self, part: usize, name: &str) -> Option<String> {
        match self.attributes(part)?.get(&Text::new_or_none(name)?)? {
            AttributeValue::Text(text) => Some(utf8(text)),
            _ => None,
        }
    }

    /// Gives a text attribute of a part another text, or none, where it is there.
    pub(crate) fn replace_text(&mut self, part: usize, name: &str, text: Option<&str>) {
        let (Some(attributes), Some(name)) = (self.attributes_mut(part), Text::new_or_none(name))
        else {
            return;
        };
        if let Some(old) = attributes.remove(&name)
            && let Some(text) = text
        {
            let new = match old {
                AttributeValue::Text(_) => AttributeValue::Text(as_text(text)),
                other => other,
            };
            attributes.insert(name, new);
        }
    }

    /// The text attributes of the part of `id` that are provenance.
    pub(crate) fn provenance(&self, id: ChannelId) -> Texts {
        let attributes = self.attributes(id.part()).into_iter().flatten();
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
    pub(crate) fn set_provenance(&mut self, id: ChannelId, texts: &Texts) {
        let Some(attributes) = self.attributes_mut(id.part()) else {
            return;
        };
        attributes.retain(|name, value| {
            !(matches!(value, AttributeValue::Text(_)) && is_ours(&name.to_string()))
        });
        for (name, text) in texts {
            attributes.insert(as_text(name), AttributeValue::Text(as_text(text)));
        }
    }
}

/// A text as EXR files hold it.
pub(crate) fn as_text(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}

/// A text of an EXR file, of which UTF-8 is usual.
pub(crate) fn utf8(text: &Text) -> String {
    String::from_utf8_lossy(text.bytes()).into_owned()
}
