//! The lens and the observations that a report is about.

use image::RgbImage;
use seidel_core::{Diagnosis, Frame, ObservationSet};

/// Names and counts that a diagnosis does not hold.
#[derive(Debug, Clone, PartialEq)]
pub struct Subject {
    /// Name of the lens profile's file.
    pub lens: String,
    /// Name of the observation set, or of the picture it was estimated from.
    pub observations: String,
    /// Frame of the lens and of the set.
    pub frame: Frame,
    /// Channels of the set.
    pub channels: Vec<String>,
    /// Number of PSFs in the set, with all channels of a PSF counted once.
    pub count: usize,
    /// Number of object distances in the set.
    pub distances: usize,
    /// Maps of the gap in the plate, where it was rendered.
    pub plate_gap: Option<RgbImage>,
}

impl Subject {
    /// Returns the names of a lens and a set with the counts of the set.
    pub fn new(lens: String, observations: String, set: &ObservationSet) -> Self {
        Self {
            lens,
            observations,
            frame: set.frame,
            channels: set.channels.clone(),
            count: set.observations.len(),
            distances: set.distances().len(),
            plate_gap: None,
        }
    }
    /// Returns the counts in words, such as `96 PSFs at 4 distances in 3 channels: 288 tiles`. A tile is a PSF in one
    /// channel; those of `diagnosis` were compared.
    pub(super) fn counts(&self, diagnosis: &Diagnosis) -> String {
        let (compared, all) = (diagnosis.tiles.len(), self.count * self.channels.len());
        let tiles = if compared == all {
            number(all, "tile")
        } else {
            format!("{compared} of {}", number(all, "tile"))
        };
        format!(
            "{} at {} in {}: {tiles}",
            number(self.count, "PSF"),
            number(self.distances, "distance"),
            number(self.channels.len(), "channel")
        )
    }
}

/// Formats a count with its noun.
fn number(count: usize, noun: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{plural}")
}
