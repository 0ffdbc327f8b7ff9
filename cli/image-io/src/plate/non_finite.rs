//! Samples of a plate that are not finite.

use std::fmt;

/// NaN and infinite samples of a channel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NonFiniteSamples {
    /// The name of the channel.
    pub channel: String,
    /// The number of samples that are not finite.
    pub count: usize,
    /// Column and row of the first, from the top-left pixel of the data window.
    pub first: (usize, usize),
}

impl fmt::Display for NonFiniteSamples {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (column, row) = self.first;
        let (channel, count) = (&self.channel, self.count);
        if count == 1 {
            return write!(
                f,
                "channel {channel}: the sample at column {column}, row {row} is NaN or infinite"
            );
        }
        write!(
            f,
            "channel {channel}: {count} samples are NaN or infinite, the first at column {column}, row {row}"
        )
    }
}

impl NonFiniteSamples {
    /// Finds the NaN and infinite samples of a plane of `width` pixels per row; `None` if all are finite.
    pub(super) fn find(channel: &str, width: usize, plane: &[f32]) -> Option<Self> {
        let first = plane.iter().position(|v| !v.is_finite())?;
        let width = width.max(1);
        Some(Self {
            channel: channel.to_owned(),
            count: plane.iter().filter(|v| !v.is_finite()).count(),
            first: (first % width, first / width),
        })
    }
}
