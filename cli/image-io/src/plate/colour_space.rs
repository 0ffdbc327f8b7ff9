//! The colour space that the file of a plate states.

use super::{PlateFile, Source};
use crate::formats::exr::COLOUR_SPACE;

/// The attribute of the Color Interop Forum that identifies the colour space.
const INTEROP_ID: &str = "colorInteropID";

impl PlateFile {
    /// Returns the attributes that name the colour space, each with its value; none in formats other than EXR.
    ///
    /// Chromaticities are not considered: many programs write those of their working space into every file.
    pub fn colour_space_attributes(&self) -> Vec<(&'static str, String)> {
        let Source::Exr {
            image, channels, ..
        } = &self.source
        else {
            return Vec::new();
        };
        let part = channels.colour[0].part();
        let names = [COLOUR_SPACE, INTEROP_ID].into_iter();
        names
            .filter_map(|name| Some((name, image.text(part, name)?)))
            .filter(|(_, value)| !value.trim().is_empty() && value != "unknown")
            .collect()
    }

    /// Returns a warning if the plate is read as scene-linear although its file states another colour space.
    pub fn ignored_colour_space_warning(&self) -> Option<String> {
        let attributes = self.colour_space_attributes();
        let is_linear = |value: &str| {
            let name = value.to_ascii_lowercase();
            let linear = ["lin", "acescg", "aces2065", "raw", "data"];
            linear.iter().any(|word| name.contains(word))
        };
        let (name, value) = attributes.iter().find(|(_, value)| !is_linear(value))?;
        Some(format!(
            "{name} of the plate is `{value}`, but it is read as scene-linear; give --in-space auto to use the stated space"
        ))
    }

    /// Makes the file state that its colour is in another space. Statements that cannot be corrected are removed, with
    /// a warning.
    pub fn set_colour_space(&mut self, space: &str) {
        self.colour_space = Some(space.to_owned());
        match &mut self.source {
            Source::Raster { image, .. } => {
                let removed = image.metadata.remove_colour_space();
                if !removed.is_empty() {
                    let removed = removed.join(", ");
                    let warning = format!("left out as colour is now in `{space}`: {removed}");
                    image.warnings.push(warning);
                }
            }
            Source::Exr {
                image, channels, ..
            } => {
                let part = channels.colour[0].part();
                image.replace_text(part, COLOUR_SPACE, space);
                if image.text(part, INTEROP_ID).is_some() {
                    image.remove_attribute(part, INTEROP_ID);
                    image.warn(format!(
                        "{INTEROP_ID} is left out, as colour is now in `{space}`"
                    ));
                }
                if image.remove_chromaticities() {
                    image.warn(format!(
                        "chromaticities are left out, as colour is now in `{space}`"
                    ));
                }
            }
        }
    }
}
