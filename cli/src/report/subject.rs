//! What was diagnosed: names and counts that a diagnosis does not hold.

use seidel_core::field::Frame;
use seidel_core::observations::ObservationSet;

/// What a report is about.
#[derive(Debug, Clone, PartialEq)]
pub struct Subject {
    /// Name of the lens profile's file.
    pub lens: String,
    /// Name of the observation set, or of the pictures it was estimated from.
    pub observations: String,
    /// The frame that both share.
    pub frame: Frame,
    /// Channels of the set.
    pub channels: Vec<String>,
    /// PSFs in the set, all channels of one counted once.
    pub count: usize,
    /// Object distances in the set.
    pub distances: usize,
}

impl Subject {
    /// A lens and a set by their names.
    pub fn new(lens: String, observations: String, set: &ObservationSet) -> Self {
        Self {
            lens,
            observations,
            frame: set.frame,
            channels: set.channels.clone(),
            count: set.observations.len(),
            distances: set.distances().len(),
        }
    }
}
