//! A plate whose pixels lie in depth layers.

use crate::{Plane, RenderWindow};

/// A plate with the layer coordinates of its pixels.
pub(super) struct LayeredPlate<'a> {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Position of the plate's first pixel on the frame's grid of cells.
    pub(super) origin: [usize; 2],
    /// The pixels whose light is known; the others are a black margin.
    pub(super) known: RenderWindow,
    /// Place of every pixel on the layers.
    pub(super) coordinates: &'a [f32],
    pub(super) planes: &'a [Plane<'a>],
    /// Number of planes that hold light; those after them hold coverage.
    pub(super) light_count: usize,
}

impl LayeredPlate<'_> {
    /// Returns the pixels of the plate within `reach` of pixel `index` along both axes, itself included.
    pub(super) fn neighbourhood(
        &self,
        index: usize,
        reach: usize,
    ) -> impl Iterator<Item = usize> + Clone + use<> {
        let (width, height) = (self.width, self.height);
        let (column, row) = (index % width, index / width);
        let span = |at: usize, size: usize| at.saturating_sub(reach)..(at + reach + 1).min(size);
        let columns = span(column, width);
        span(row, height).flat_map(move |y| columns.clone().map(move |x| y * width + x))
    }

    /// Returns the squared distance of two pixels, px².
    pub(super) fn distance_squared(&self, one: usize, other: usize) -> f64 {
        let across = (one % self.width).abs_diff(other % self.width);
        let down = (one / self.width).abs_diff(other / self.width);
        (across.pow(2) + down.pow(2)) as f64
    }
}
