//! What a plate's file says of its colour space, and what it is told to say.

use crate::plate::{Plate, PlateFile};

/// Attributes that name a colour space: OpenImageIO's, and that of the Color Interop Forum.
pub(crate) const BY_NAME: &str = "oiio:ColorSpace";
const BY_IDENTIFIER: &str = "colorInteropID";

impl Plate {
    /// The attributes that name its colour space, each with the name it gives; none in PNG and TIFF. Chromaticities are
    /// not heeded: many programs write those of their working space whatever the picture is in.
    pub fn colour_space_attributes(&self) -> Vec<(&'static str, String)> {
        let PlateFile::Exr { plate, group } = &self.file else {
            return Vec::new();
        };
        let part = group.colour.first().map_or(0, |id| id.part());
        let names = [BY_NAME, BY_IDENTIFIER].into_iter();
        names
            .filter_map(|name| Some((name, plate.text(part, name)?)))
            .filter(|(_, value)| !value.trim().is_empty() && value != "unknown")
            .collect()
    }

    /// A sentence for a plate that is taken to be scene-linear though its file says otherwise.
    pub fn unheeded_colour_space(&self) -> Option<String> {
        let attributes = self.colour_space_attributes();
        let is_linear = |value: &str| {
            let plain = value.to_ascii_lowercase();
            let linear = ["lin", "acescg", "aces2065", "raw", "data"];
            linear.iter().any(|word| plain.contains(word))
        };
        let (name, value) = attributes.iter().find(|(_, value)| !is_linear(value))?;
        Some(format!(
            "{name} of the plate is `{value}`, but it is taken to be scene-linear; give --in-space auto to go by it"
        ))
    }

    /// Has the file say that its colour is in another `space` than it was. What cannot be said right is left out.
    pub fn set_colour_space(&mut self, space: &str) {
        self.space = Some(space.to_owned());
        let (plate, group) = match &mut self.file {
            PlateFile::Exr { plate, group } => (plate, group),
            PlateFile::Flat { plate, .. } => {
                let left_out = plate.drop_colour();
                if !left_out.is_empty() {
                    let left_out = left_out.join(", ");
                    let note = format!("left out as colour is now in `{space}`: {left_out}");
                    plate.notes.push(note);
                }
                return;
            }
        };
        let part = group.colour.first().map_or(0, |id| id.part());
        plate.replace_text(part, BY_NAME, Some(space));
        if plate.text(part, BY_IDENTIFIER).is_some() {
            plate.replace_text(part, BY_IDENTIFIER, None);
            plate.note(format!(
                "{BY_IDENTIFIER} is left out, as colour is now in `{space}`"
            ));
        }
        if plate.drop_chromaticities() {
            plate.note(format!(
                "chromaticities are left out, as colour is now in `{space}`"
            ));
        }
    }
}
