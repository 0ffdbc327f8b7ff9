//! The views of a plate, such as the eyes of a stereo pair.

use super::{PlateFile, Source};
use crate::formats::exr::{ChannelId, ColourChannels};

impl PlateFile {
    /// Returns the number of views of the plate, this one included.
    pub fn view_count(&self) -> usize {
        match &self.source {
            Source::Exr { other_views, .. } => 1 + other_views.len(),
            Source::Raster { .. } => 1,
        }
    }

    /// Returns the name of the view, such as an eye, if the file states it.
    pub fn view(&self) -> Option<&str> {
        match &self.source {
            Source::Exr { channels, .. } => channels.view.as_deref(),
            Source::Raster { .. } => None,
        }
    }

    /// Takes the colour and alpha of `other`, another view of the same file.
    pub fn take_view(&mut self, other: &Self) {
        let theirs = &other.source;
        if let (
            Source::Exr {
                image, channels, ..
            },
            Source::Exr {
                image: from,
                channels: taken,
                ..
            },
        ) = (&mut self.source, theirs)
        {
            image.take_channels(from, &taken.all());
            self.windows.data = image.data_window(channels.colour[0]);
        }
    }

    /// Returns notes on which part, layer and view are the plate, where the file has others.
    pub fn channels_notes(&self) -> Vec<String> {
        let Source::Exr {
            image,
            channels,
            unchanged_views,
            ..
        } = &self.source
        else {
            return Vec::new();
        };
        let ids = channels.colour.iter().chain(&channels.alpha);
        let names: Vec<String> = ids.map(|&id| image.full_name_of(id)).collect();
        let chosen = channels.reason.as_ref();
        let chosen = chosen.map(|reason| format!("the plate is {}: {reason}", names.join(", ")));
        let unchanged = (!unchanged_views.is_empty()).then(|| {
            format!(
                "views that stay as they are: {}",
                unchanged_views.join(", ")
            )
        });
        chosen.into_iter().chain(unchanged).collect()
    }
}

/// Returns the colour and alpha channels of `views`, one list for each part.
pub(super) fn parts_of(views: &[ColourChannels]) -> Vec<Vec<ChannelId>> {
    let mut parts: Vec<Vec<ChannelId>> = Vec::new();
    for id in views.iter().flat_map(ColourChannels::all) {
        match parts.iter_mut().find(|part| part[0].part() == id.part()) {
            Some(part) => part.push(id),
            None => parts.push(vec![id]),
        }
    }
    parts
}
