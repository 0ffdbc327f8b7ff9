//! How exact the fast renderer is asked to be.

use crate::psf::PsfModel;

/// What the user asks for; the figures are what tests hold against the exact renderer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Quality {
    /// For looking: at least 45 dB.
    Draft,
    /// For delivery: at least 60 dB, 75 dB where no blur has a standard deviation above 4 px; models
    /// drawn ray by ray, 50 dB. Less where blur changes by much of itself within the narrowest tiles,
    /// 16 px of a level: docs/rendering.md has figures.
    #[default]
    Final,
}

/// The approximations that make up a quality.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tolerance {
    /// Share of each kernel's light that may be left out at its rim; the rest is scaled up.
    pub(super) left_out: f64,
    /// Least standard deviation, in pixels of a level, that is drawn at that level: for smooth PSFs and
    /// for those with edges, which a coarse level would surround with rings where lights are bright.
    pub(super) least_sigma: f64,
    pub(super) least_sigma_of_rays: f64,
    /// Largest error of a kernel half way between corners, as a share of its light.
    pub(super) between_corners: f64,
}

impl Quality {
    pub(super) fn tolerance(self) -> Tolerance {
        match self {
            Self::Draft => Tolerance {
                left_out: 2e-3,
                least_sigma: 0.9,
                least_sigma_of_rays: 4.0,
                between_corners: 0.02,
            },
            Self::Final => Tolerance {
                left_out: 1e-4,
                least_sigma: 1.3,
                least_sigma_of_rays: 12.0,
                between_corners: 1.6e-2,
            },
        }
    }
}

impl Tolerance {
    /// Least standard deviation drawn at a level, in its pixels, for PSFs of `model`.
    pub(super) fn least_sigma_for(&self, model: &dyn PsfModel) -> f64 {
        if model.needs_rays() {
            self.least_sigma_of_rays
        } else {
            self.least_sigma
        }
    }
}
