//! The estimate of the kernel of a block.

/// The estimate of a block.
#[derive(Debug, Clone)]
pub(crate) struct BlockEstimate {
    /// Light of unit sum on the offsets of a tile, row by row; the pixel's own area not included.
    pub(crate) kernel: Vec<f64>,
    /// Mean squared residual over the noise variance.
    pub(crate) chi_square: f64,
    /// Residuals beyond the noise over the step from dark to bright.
    pub(crate) misfit: f64,
    /// Height of the parabola of the predicted light in the residuals, over the range of the light.
    pub(crate) curvature: f64,
    /// Tile of unit sum, estimated without its bound at zero.
    pub(crate) unbounded: Vec<f64>,
    /// Standard deviation of a sample of the tile.
    pub(crate) sigma: f64,
    /// Light where the chart is 1, counts.
    pub(crate) white: f64,
    /// Root mean square difference of the chart between neighbouring pixels.
    pub(crate) detail: f64,
}
