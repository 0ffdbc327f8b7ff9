//! How exact the fast renderer is asked to be.

use seidel_optics::psf::PsfModel;

/// What the user asks for; the figures are what tests hold against the exact renderer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Quality {
    /// For looking: at least 45 dB.
    Draft,
    /// For delivery: at least 60 dB, 75 dB where no blur has a standard deviation above 6 px; models
    /// drawn ray by ray, 50 dB. A plate too small for how fast its blur changes is rendered exactly.
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
    /// Largest error of a kernel half way between corners, as a share of its light: on levels that draw
    /// blur of less than 6 px, and on coarser ones.
    pub(super) between_corners: [f64; 2],
}

impl Quality {
    pub(super) fn tolerance(self) -> Tolerance {
        match self {
            Self::Draft => Tolerance {
                left_out: 2e-3,
                least_sigma: 0.9,
                least_sigma_of_rays: 2.0,
                between_corners: [4e-2; 2],
            },
            Self::Final => Tolerance {
                left_out: 3e-4,
                least_sigma: 1.15,
                least_sigma_of_rays: 4.0,
                between_corners: [4.5e-3, 3.5e-2],
            },
        }
    }
}

/// The first level whose narrowest blur is above 6 px.
const FIRST_WIDE_LEVEL: u32 = 3;

/// How much more the kernels of rays may err: they have edges, whose light moves by less than a pixel.
const MORE_FOR_RAYS: f64 = 8.0;

impl Tolerance {
    /// Largest error of a kernel half way between corners, as a share of its light, at a level.
    pub(super) fn between_corners_at(&self, level: u32, model: &dyn PsfModel) -> f64 {
        let more = if model.needs_rays() {
            MORE_FOR_RAYS
        } else {
            1.0
        };
        more * self.between_corners[usize::from(level >= FIRST_WIDE_LEVEL)]
    }

    /// Least side of a tile, pixels of its level, for PSFs of `model`: kernels drawn ray by ray are dear, and
    /// their edges do not change more evenly for being closer together.
    pub(super) fn least_tile_for(&self, model: &dyn PsfModel) -> usize {
        if model.needs_rays() { 16 } else { 4 }
    }

    /// Least standard deviation drawn at a level, in its pixels, for PSFs of `model`.
    pub(super) fn least_sigma_for(&self, model: &dyn PsfModel) -> f64 {
        if model.needs_rays() {
            self.least_sigma_of_rays
        } else {
            self.least_sigma
        }
    }
}
