//! Mattes: one number a pixel, 0 to 1, such as an alpha channel.

use std::path::{Path, PathBuf};

use crate::error::{FileError, Result};
use crate::exr::plate::ExrPlate;
use crate::flat_plate::FlatPlate;
use crate::format::{Format, detect};
use crate::windows::{Windows, fitted};

/// A matte as it stands in its file.
#[derive(Debug, Clone, PartialEq)]
pub struct Matte {
    /// The file it is from.
    pub file: PathBuf,
    /// Name of the channel it is from.
    pub channel: String,
    /// Where the pixels lie; at (0, 0) in all but EXR.
    windows: Windows,
    samples: Vec<f32>,
}

impl Matte {
    /// Reads a matte: the channel named, or else `A`, or else the only channel there is.
    ///
    /// # Errors
    /// A file that cannot be read, and no such channel.
    pub fn open(file: &Path, channel: Option<&str>) -> Result<Self> {
        let refused = |names: &[String]| none_such(file, names, channel);
        let (name, windows, samples) = match detect(file)? {
            Format::Exr => {
                let plate = ExrPlate::open(file)?;
                let names: Vec<String> = plate.channels().into_iter().map(|c| c.name).collect();
                let at = chosen(&names, channel).ok_or_else(|| refused(&names))?;
                let id = plate.channels()[at].id;
                let windows = Windows {
                    data: plate.data_window(id),
                    display: plate.display_window(),
                };
                (names[at].clone(), windows, plate.samples(id))
            }
            _ => {
                let plate = FlatPlate::open(file)?;
                let at = chosen(plate.names(), channel).ok_or_else(|| refused(plate.names()))?;
                let windows = Windows::of_size(plate.width(), plate.height());
                let name = plate.names()[at].clone();
                let samples = plate.plane(&name).unwrap_or_default().to_vec();
                (name, windows, samples)
            }
        };
        Ok(Self {
            file: file.to_owned(),
            channel: name,
            windows,
            samples,
        })
    }

    /// The samples over those of a plate, as [`fitted`] has them; with a remark where there is something to say.
    ///
    /// # Errors
    /// A matte that neither covers the plate nor is of the same picture.
    pub fn over(&self, plate: Windows) -> Result<(Vec<f32>, Option<String>)> {
        let what = format!("channel {}", self.channel);
        fitted(&self.samples, self.windows, plate, (&self.file, &what))
    }
}

fn chosen(names: &[String], channel: Option<&str>) -> Option<usize> {
    let named = names.iter().position(|name| name == channel.unwrap_or("A"));
    named.or_else(|| (channel.is_none() && names.len() == 1).then_some(0))
}

fn none_such(file: &Path, names: &[String], channel: Option<&str>) -> FileError {
    FileError::new(
        file,
        "matte",
        match channel {
            Some(name) => format!("has no channel `{name}`"),
            None => "has no alpha channel".to_owned(),
        },
        format!(
            "name one of its channels after a colon: {}",
            names.join(", ")
        ),
    )
}
