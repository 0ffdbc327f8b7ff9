//! Samples in addition to the plate's: hidden ones, and corrections of mixed pixels.

/// Margin added to the reach of the blur within which they are needed, px.
pub(super) const SPARE_PX: f32 = 2.0;

/// Samples of one row in addition to the plate's: hidden ones, or corrections of mixed pixels.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct ExtraSamples {
    /// Plate columns, ascending.
    pub(super) columns: Vec<u32>,
    /// Presence of each sample; negative where it is taken away.
    pub(super) weights: Vec<f32>,
    pub(super) coordinates: Vec<f32>,
    /// Samples of each, one per plane, multiplied by presence.
    pub(super) samples: Vec<f32>,
}
