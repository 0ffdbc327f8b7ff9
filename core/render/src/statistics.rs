//! Finished renders and how they were computed.

/// A finished render.
#[derive(Debug, Clone, PartialEq)]
pub struct Rendered {
    /// The blurred planes, in the order given, row-major.
    pub planes: Vec<Vec<f32>>,
    /// Counts of the work done.
    pub statistics: RenderStatistics,
}

/// Counts of the work in a render, summed over its depth layers.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RenderStatistics {
    /// Distinct vergences rendered; 0 where every pixel was drawn at a vergence of its own.
    pub layers: usize,
    /// Calls of the innermost renderer: one for each crop of each depth layer.
    pub renders: usize,
    /// Those of `renders` that scattered an exact kernel from every source pixel.
    pub exact: usize,
    /// Pyramid levels of the fast renderer, finest first.
    pub levels: Vec<LevelStatistics>,
    /// Highlight pixels that the fast renderer rendered apart from the rest.
    pub highlights: usize,
}

/// The tiles of one pyramid level, counted once for all planes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LevelStatistics {
    /// Tiles gathered at this level.
    pub gathered: usize,
    /// Tiles whose light was scattered at this level.
    pub scattered: usize,
    /// Tiles interpolated from the next coarser level.
    pub upsampled: usize,
    /// Side of the smallest tile in any render, pixels of the level.
    pub min_tile_px: usize,
    /// Side of the largest tile in any render, pixels of the level.
    pub max_tile_px: usize,
}

impl Rendered {
    /// Planes scattered exactly in one render over `layers` distinct vergences.
    pub(crate) fn exact(planes: Vec<Vec<f32>>, layers: usize) -> Self {
        let statistics = RenderStatistics {
            layers,
            renders: 1,
            exact: 1,
            ..RenderStatistics::default()
        };
        Self { planes, statistics }
    }
}

impl RenderStatistics {
    /// Adds the work of a render of part of the same plate. The number of layers is the caller's to set: parts can
    /// share a layer.
    pub(crate) fn add_part(&mut self, part: &Self) {
        self.renders += part.renders;
        self.exact += part.exact;
        self.highlights += part.highlights;
        let known = self.levels.len().min(part.levels.len());
        for (sum, level) in self.levels.iter_mut().zip(&part.levels) {
            sum.gathered += level.gathered;
            sum.scattered += level.scattered;
            sum.upsampled += level.upsampled;
            sum.min_tile_px = sum.min_tile_px.min(level.min_tile_px);
            sum.max_tile_px = sum.max_tile_px.max(level.max_tile_px);
        }
        self.levels.extend_from_slice(&part.levels[known..]);
    }
}
