//! Accuracy of the fast renderer.

use seidel_optics::psf::PsfModel;

/// The accuracy of the fast renderer, as PSNR against the exact one; tests check these figures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Quality {
    /// For preview: at least 45 dB.
    Draft,
    /// For delivery: at least 60 dB; 75 dB where no blur has a standard deviation above 6 px; 50 dB for ray-traced
    /// models. A plate too small for how fast its blur changes is rendered exactly.
    #[default]
    Final,
}

/// The approximations behind a [`Quality`].
///
/// The values were chosen against the exact renderer so that the PSNR of the quality holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tolerance {
    /// Share of each kernel's light truncated at its rim; the rest is scaled up to unit sum.
    pub(super) truncated_share: f64,
    /// Smallest standard deviation of smooth PSFs drawn at a level, pixels of the level.
    pub(super) min_sigma: f64,
    /// The same for ray-traced PSFs, whose hard edges ring around bright lights on coarse levels.
    pub(super) min_ray_sigma: f64,
    /// Largest interpolation error of a kernel half way between corners, as a share of its light: on levels that
    /// draw blur of less than 6 px, and on coarser ones.
    pub(super) interpolation_error: [f64; 2],
    /// Largest negative lobe of the low-pass filters of coarse levels around a bright light, as a share of the light.
    pub(super) overshoot: f32,
}

impl Quality {
    /// Returns the approximations allowed at this quality.
    pub(super) fn tolerance(self) -> Tolerance {
        match self {
            Self::Draft => Tolerance {
                truncated_share: 2e-3,
                min_sigma: 0.9,
                min_ray_sigma: 2.0,
                interpolation_error: [4e-2; 2],
                overshoot: 3e-4,
            },
            Self::Final => Tolerance {
                truncated_share: 3e-4,
                min_sigma: 1.15,
                min_ray_sigma: 4.0,
                interpolation_error: [4.5e-3, 3.5e-2],
                overshoot: 3e-5,
            },
        }
    }
}

/// The first level whose narrowest blur is above 6 px.
const FIRST_WIDE_LEVEL: u32 = 3;

/// Factor on the interpolation error of ray-traced kernels: most of it is light of their edges that moves by less
/// than a pixel.
const RAY_ERROR_FACTOR: f64 = 8.0;

impl Tolerance {
    /// Returns the largest interpolation error allowed at `level`, as a share of a kernel's light.
    pub(super) fn interpolation_error_at(&self, level: u32, model: &dyn PsfModel) -> f64 {
        let factor = if model.needs_rays() {
            RAY_ERROR_FACTOR
        } else {
            1.0
        };
        factor * self.interpolation_error[usize::from(level >= FIRST_WIDE_LEVEL)]
    }

    /// Returns the smallest side of a tile, pixels of its level. Ray-traced kernels are expensive, and smaller tiles
    /// would not interpolate their edges better.
    pub(super) fn min_tile_for(&self, model: &dyn PsfModel) -> usize {
        if model.needs_rays() { 16 } else { 4 }
    }

    /// Returns the smallest standard deviation drawn at a level, in its pixels.
    pub(super) fn min_sigma_for(&self, model: &dyn PsfModel) -> f64 {
        if model.needs_rays() {
            self.min_ray_sigma
        } else {
            self.min_sigma
        }
    }
}
