//! Descriptions of image files for users: size, channels, storage, attributes and provenance.

use std::path::Path;

use serde::Serialize;

use crate::error::Result;
use crate::formats::row_of_file;
use crate::input::{InputFile, Limits};
use crate::lens_metadata::{self, FrameRecord};
use crate::part::Part;

/// The description of an image file.
#[derive(Debug, Clone, Serialize)]
pub struct Description {
    /// The path of the file.
    pub file: String,
    /// The name of its format.
    pub format: String,
    /// Its parts, at least one.
    pub parts: Vec<Part>,
    /// The statements of its attributes about lens and camera.
    #[serde(skip_serializing_if = "FrameRecord::is_empty")]
    pub lens: FrameRecord,
}

impl Description {
    /// Describes an image file. The pixels of OpenEXR files are not read.
    ///
    /// # Errors
    /// A file that cannot be read, or is in no supported format.
    pub fn read(path: &Path) -> Result<Self> {
        let (format, implementation) = row_of_file(path)?;
        let input = InputFile::open(path, format, Limits::PLATE)?;
        let parts = input.guarded(|input| implementation.describe(input))?;
        Ok(Self {
            file: path.display().to_string(),
            format: format.to_string(),
            lens: lens_metadata::of_parts(&parts),
            parts,
        })
    }

    /// Formats the description as lines of text.
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
                let provenance = part.provenance.iter();
                lines.extend(
                    provenance.flat_map(|(name, value)| indented(&format!("  {name}"), value)),
                );
            }
        }
        if !self.lens.is_empty() {
            lines.push("lens and camera:".to_owned());
            let stated = lens_metadata::lines(&self.lens).into_iter();
            lines.extend(stated.flat_map(|(name, value)| indented(&name, &value)));
        }
        lines
    }
}

/// Formats a name and value; a value of several lines stands below its name.
fn indented(name: &str, value: &str) -> Vec<String> {
    if value.contains('\n') {
        let below = value.lines().map(|line| format!("      {line}"));
        return std::iter::once(format!("  {name}:")).chain(below).collect();
    }
    vec![format!("  {name}: {value}")]
}
