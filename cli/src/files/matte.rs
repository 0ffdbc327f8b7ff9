//! Mattes: one number a pixel, 0 to 1, such as an alpha channel.

use std::path::{Path, PathBuf};

use super::error::{FileError, Result};
use super::exr_choice::fitted;
use super::exr_plate::{ExrPlate, Window};
use super::flat_plate::FlatPlate;
use super::format::{Format, detect};

/// A matte as it stands in its file.
#[derive(Debug, Clone, PartialEq)]
pub struct Matte {
    /// The file it is from.
    pub file: PathBuf,
    /// Name of the channel it is from.
    pub channel: String,
    /// Where the pixels lie; at (0, 0) for PNG and TIFF.
    window: Window,
    samples: Vec<f32>,
}

impl Matte {
    /// Reads a matte: the channel named, or else `A`, or else the only channel there is.
    ///
    /// # Errors
    /// A file that cannot be read, and no such channel.
    pub fn open(file: &Path, channel: Option<&str>) -> Result<Self> {
        let refused = |names: &[String]| none_such(file, names, channel);
        let (name, window, samples) = match detect(file)? {
            Format::Exr => {
                let plate = ExrPlate::open(file)?;
                let names: Vec<String> = plate.channels().into_iter().map(|c| c.name).collect();
                let at = chosen(&names, channel).ok_or_else(|| refused(&names))?;
                let id = plate.channels()[at].id;
                (names[at].clone(), plate.data_window(id), plate.samples(id))
            }
            Format::Png | Format::Tiff => {
                let plate = FlatPlate::open(file)?;
                let at = chosen(plate.names(), channel).ok_or_else(|| refused(plate.names()))?;
                let window = Window {
                    x: 0,
                    y: 0,
                    width: plate.width(),
                    height: plate.height(),
                };
                let name = plate.names()[at].clone();
                let samples = plate.plane(&name).unwrap_or_default().to_vec();
                (name, window, samples)
            }
        };
        Ok(Self {
            file: file.to_owned(),
            channel: name,
            window,
            samples,
        })
    }

    /// The samples over another window, that of the plate.
    ///
    /// # Errors
    /// A matte that does not cover the window.
    pub fn over(&self, window: Window) -> Result<Vec<f32>> {
        fitted(&self.samples, self.window, window).ok_or_else(|| {
            FileError::new(
                &self.file,
                format!("channel {}", self.channel),
                format!("covers {}, the plate {window}", self.window),
                "render matte and plate at one size and data window",
            )
        })
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
