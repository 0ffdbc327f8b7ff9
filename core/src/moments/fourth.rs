//! Fourth central moments in image axes.

/// Fourth central moments, px⁴.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FourthMoments {
    /// Mean of x⁴.
    pub mu40: f64,
    /// Mean of x³ y.
    pub mu31: f64,
    /// Mean of x² y².
    pub mu22: f64,
    /// Mean of x y³.
    pub mu13: f64,
    /// Mean of y⁴.
    pub mu04: f64,
}

impl FourthMoments {
    /// The five in order mu40, mu31, mu22, mu13, mu04.
    pub fn to_array(self) -> [f64; 5] {
        [self.mu40, self.mu31, self.mu22, self.mu13, self.mu04]
    }

    /// From the order of [`FourthMoments::to_array`].
    pub fn from_array([mu40, mu31, mu22, mu13, mu04]: [f64; 5]) -> Self {
        Self {
            mu40,
            mu31,
            mu22,
            mu13,
            mu04,
        }
    }
}
