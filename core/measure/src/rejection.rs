//! Lights and blocks that were left out, with the reason.

use std::fmt;

/// The reason for leaving out a light or a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reason {
    /// Pixels of the light reach the clipping level.
    Clipped,
    /// Another light overlaps it.
    Double,
    /// A defective pixel, or light that falls into a single one.
    HotPixel,
    /// The light is cut off by the border of the frame.
    Border,
    /// Too little light for its noise.
    Faint,
    /// The shape departs from a smooth field through its neighbours.
    UnlikeNeighbours,
    /// Dust on the sensor shades the light.
    Dust,
    /// The light moved between photographs.
    Moved,
    /// A block of a chart lies elsewhere than its neighbours say.
    Registration,
    /// A block of a chart has too little contrast.
    LowContrast,
}

impl Reason {
    /// Every reason.
    pub const ALL: [Self; 10] = [
        Self::Clipped,
        Self::Double,
        Self::HotPixel,
        Self::Border,
        Self::Faint,
        Self::UnlikeNeighbours,
        Self::Dust,
        Self::Moved,
        Self::Registration,
        Self::LowContrast,
    ];

    /// Returns the name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clipped => "clipped",
            Self::Double => "double",
            Self::HotPixel => "hot_pixel",
            Self::Border => "border",
            Self::Faint => "faint",
            Self::UnlikeNeighbours => "unlike_neighbours",
            Self::Dust => "dust",
            Self::Moved => "moved",
            Self::Registration => "registration",
            Self::LowContrast => "low_contrast",
        }
    }

    /// Returns the quantity that was compared with the limit, and its unit.
    pub fn quantity(self) -> &'static str {
        match self {
            Self::Clipped => "largest sample, counts",
            Self::Double => "distance to the other light, px",
            Self::HotPixel => "share of the light in one pixel",
            Self::Border => "distance to the border, px",
            Self::Faint => "flux over its noise",
            Self::UnlikeNeighbours => "departure in standard deviations",
            Self::Dust => "transmission of the darkest pixel",
            Self::Moved => "motion, px",
            Self::Registration => "departure of the centroid from the smooth map, px",
            Self::LowContrast => "contrast, or fine detail of the chart over the largest",
        }
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A light or a block that was left out.
#[derive(Debug, Clone, PartialEq)]
pub struct LeftOut {
    /// Index of the photograph.
    pub photograph: usize,
    /// Frame position, px.
    pub x: f64,
    /// Frame position, px.
    pub y: f64,
    /// The reason.
    pub why: Reason,
    /// The value that led to it, as [`Reason::quantity`] says.
    pub value: f64,
    /// The limit that it crossed.
    pub limit: f64,
}
