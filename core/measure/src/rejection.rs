//! Lights, edges and blocks of charts that were left out, with the reason.

use std::fmt;

/// The reason for leaving out a light, an edge or a block of a chart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reason {
    /// Pixels reach the clipping level.
    Clipped,
    /// Another light or edge overlaps it.
    Double,
    /// A defective pixel, or light that falls into a single one.
    HotPixel,
    /// It is cut off by the border of the frame.
    Border,
    /// Too little light for its noise.
    Faint,
    /// The shape departs from a smooth field through its neighbours.
    UnlikeNeighbours,
    /// Dust on the sensor shades the light, or the background beside it.
    Dust,
    /// The background beside the light is no plane.
    Slope,
    /// Pixels that no check explains are darker than the background, or hold no light.
    DarkPixels,
    /// The user asked for it.
    Asked,
    /// The light moved between photographs.
    Moved,
    /// The pixels are not those of a step along a straight line.
    NotAnEdge,
    /// Too little of the edge is left between its corners.
    ShortEdge,
    /// The edge is not straight.
    CurvedEdge,
    /// The step of an edge is too small for the noise, or a block of a chart has too little contrast.
    LowContrast,
    /// The levels overshoot beside the edge: the photograph was sharpened.
    Sharpened,
    /// The pixels are too large for the blur, or too few distances from the edge were sampled.
    Undersampled,
    /// A block of a chart lies elsewhere than its neighbours say.
    Registration,
}

impl Reason {
    /// Every reason.
    pub const ALL: [Self; 18] = [
        Self::Clipped,
        Self::Double,
        Self::HotPixel,
        Self::Border,
        Self::Faint,
        Self::UnlikeNeighbours,
        Self::Dust,
        Self::Slope,
        Self::DarkPixels,
        Self::Asked,
        Self::Moved,
        Self::NotAnEdge,
        Self::ShortEdge,
        Self::CurvedEdge,
        Self::LowContrast,
        Self::Sharpened,
        Self::Undersampled,
        Self::Registration,
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
            Self::Slope => "slope",
            Self::DarkPixels => "dark_pixels",
            Self::Asked => "asked",
            Self::Moved => "moved",
            Self::NotAnEdge => "not_an_edge",
            Self::ShortEdge => "short_edge",
            Self::CurvedEdge => "curved_edge",
            Self::LowContrast => "low_contrast",
            Self::Sharpened => "sharpened",
            Self::Undersampled => "undersampled",
            Self::Registration => "registration",
        }
    }

    /// Returns the quantity that was compared with the limit, and its unit.
    pub fn quantity(self) -> &'static str {
        match self {
            Self::Clipped => "largest sample, counts",
            Self::Double => "distance to the other light or edge, px",
            Self::HotPixel => "share of the light in one pixel",
            Self::Border => "distance to the border, px",
            Self::Faint => "flux over its noise",
            Self::UnlikeNeighbours => "departure in standard deviations",
            Self::Dust => "transmission of the darkest pixel",
            Self::Slope => "departure of the background from a plane, over the peak",
            Self::DarkPixels => "darkest pixel over its noise",
            Self::Asked => "number of the light",
            Self::Moved => "motion, px",
            Self::NotAnEdge => "misfit of a step, over the step",
            Self::ShortEdge => "length between the corners, px",
            Self::CurvedEdge => "turn of the normal, rad",
            Self::LowContrast => {
                "step of an edge over the noise of a pixel, or detail of a block over the largest"
            }
            Self::Sharpened => "overshoot over the step",
            Self::Undersampled => "standard deviation of the blur, px",
            Self::Registration => "departure of the centroid from the smooth map, px",
        }
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A light, an edge or a block of a chart that was left out.
#[derive(Debug, Clone, PartialEq)]
pub struct LeftOut {
    /// Index of the photograph.
    pub photograph: usize,
    /// Number of a light among all that were found; `None` for edges and blocks.
    pub number: Option<usize>,
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
