//! Samples that a conversion could not convert.

use std::ops::Add;

/// Numbers of samples that a conversion replaced by zero.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[must_use]
pub struct ConversionReport {
    /// Samples that were NaN or infinite before.
    pub non_finite: usize,
    /// Samples that have no finite value in the target space.
    pub unrepresentable: usize,
    /// The first of these, in the order of pixels.
    pub first_unrepresentable: Option<SamplePlace>,
}

/// The place of a sample in an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct SamplePlace {
    /// Index of the pixel, row-major.
    pub pixel: usize,
    /// Index of the channel: 0 is R or grey.
    pub channel: usize,
}

impl ConversionReport {
    /// Returns the report of pixels that begin at index `first` of an image.
    pub(crate) fn starting_at(mut self, first: usize) -> Self {
        if let Some(place) = &mut self.first_unrepresentable {
            place.pixel += first;
        }
        self
    }
}

impl Add for ConversionReport {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            non_finite: self.non_finite + other.non_finite,
            unrepresentable: self.unrepresentable + other.unrepresentable,
            first_unrepresentable: (self.first_unrepresentable.into_iter())
                .chain(other.first_unrepresentable)
                .min(),
        }
    }
}
