//! A robust loss.

/// Cauchy (Lorentzian) loss of the misfit m of a group of residuals, its mean square: scale ln(1 + m / scale). It is linear in
/// m below the scale and logarithmic above, so outlying groups have little influence.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CauchyLoss {
    /// Misfit from which on a group loses influence.
    pub(crate) scale: f64,
}

impl CauchyLoss {
    /// Returns the loss of a group with `freedom` degrees of freedom.
    pub(crate) fn cost(&self, misfit: f64, freedom: f64) -> f64 {
        (misfit / self.scale).ln_1p() * self.scale * freedom
    }

    /// Returns the weight of a group in the normal equations.
    pub(crate) fn weight(&self, misfit: f64) -> f64 {
        1.0 / (1.0 + misfit / self.scale)
    }
}
