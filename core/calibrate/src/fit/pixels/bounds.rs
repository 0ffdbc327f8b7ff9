//! Parameters at their bounds.

use super::parameters::ParameterLayout;

/// Distance to a bound from which on a parameter counts as at the bound.
const BOUND_MARGIN: f64 = 1e-6;

impl ParameterLayout {
    /// Returns whether parameter `k` of `theta` may move in the direction of `slope`: it is not fixed, and not at the bound that
    /// lies there.
    pub(in crate::fit) fn is_free(
        &self,
        theta: &[f64],
        k: usize,
        slope: f64,
        least_blur: f64,
    ) -> bool {
        if self.is_fixed(k) {
            return false;
        }
        let mut pushed = theta.to_vec();
        pushed[k] += BOUND_MARGIN * slope.signum();
        let wanted = pushed[k];
        self.clamp_to_bounds(&mut pushed, least_blur);
        pushed[k] == wanted
    }
}
