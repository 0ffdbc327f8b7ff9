//! A plate whose pixels lie in depth layers.

use crate::Plane;

/// A plate with the layer coordinates of its pixels.
pub(super) struct LayeredPlate<'a> {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Position of the plate's first pixel on the frame's grid of cells.
    pub(super) origin: [usize; 2],
    /// Place of every pixel on the layers.
    pub(super) coordinates: &'a [f32],
    pub(super) planes: &'a [Plane<'a>],
}
