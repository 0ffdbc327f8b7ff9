//! Instantaneous PSF models: from what a lens does at one point to the light density there.
//!
//! A model knows one point, never the field. One model a file; all of them are in [`ALL`].

mod gaussian;
mod kernel;
mod mirrored_pair;
mod mixture;
mod normal;
pub mod pupil;
mod rows;
mod skew_normal;
mod skew_normal_general;

pub use gaussian::Gaussian;
pub use kernel::{Kernel, SampleGrid, draw_kernel};
pub use mirrored_pair::MirroredPair;
pub use mixture::{B, Mixture, PHI, SKEW_CAP, SkewNormalDensity, T_MAX};
pub use normal::normal_cdf;
pub use pupil::Pupil;
pub use rows::{KernelRows, KernelSpan};
pub use skew_normal::{PaperParameters, SkewNormal, meridional_density, meridional_skew};
pub use skew_normal_general::{SkewNormalEq43, SkewNormalGeneral, best_skew};

use crate::error::{Error, Result};
use crate::field::Meridian;
use crate::lens::LocalPupil;
use crate::moments::CentralMoments;

/// What a lens does to one point of light in one channel: all a PSF model may draw on.
///
/// Lengths in pixels of whatever grid the PSF is drawn on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalBlur {
    /// Second and third central moments in image axes.
    pub moments: CentralMoments,
    /// The meridional direction at this point.
    pub meridian: Meridian,
    /// The same blur ray by ray, where the lens is known so: what [`Pupil`] draws.
    pub pupil: Option<LocalPupil>,
    /// Width of the grid's pixels over their height. Lengths along x are in widths, those along y in
    /// heights; the meridian is as on square pixels.
    pub pixel_aspect: f64,
}

impl LocalBlur {
    /// A blur of which moments alone are known.
    pub fn from_moments(moments: CentralMoments, meridian: Meridian) -> Self {
        Self {
            moments,
            meridian,
            pupil: None,
            pixel_aspect: 1.0,
        }
    }

    /// A blur known ray by ray.
    pub fn from_pupil(pupil: LocalPupil, meridian: Meridian) -> Self {
        Self {
            moments: pupil.moments().0,
            meridian,
            pupil: Some(pupil),
            pixel_aspect: 1.0,
        }
    }

    /// The same blur on a grid of which `scale` pixels make up one of the present ones.
    #[must_use]
    pub fn rescaled(&self, scale: f64) -> Self {
        Self {
            moments: self.moments.rescaled(scale),
            pupil: self.pupil.map(|pupil| pupil.rescaled(scale)),
            ..*self
        }
    }

    /// The same blur on a grid whose pixels are `aspect` times as wide as the present ones, and as high.
    #[must_use]
    pub fn on_wider_pixels(&self, aspect: f64) -> Self {
        Self {
            moments: self.moments.stretched_x(1.0 / aspect),
            pupil: self.pupil.map(|pupil| pupil.stretched_x(1.0 / aspect)),
            meridian: self.meridian,
            pixel_aspect: self.pixel_aspect * aspect,
        }
    }

    /// The same blur, widened where its variance along any direction is below `floor_px2`.
    #[must_use]
    pub fn with_least_variance(&self, floor_px2: f64) -> Self {
        let lacking = (floor_px2 - self.moments.least_variance()).max(0.0);
        Self {
            moments: self.moments.with_least_variance(floor_px2),
            pupil: self.pupil.map(|pupil| pupil.blurred_by(lacking)),
            ..*self
        }
    }
}

/// Least variance a density is drawn with, px²: a thirtieth of a pixel squared, far below what a
/// pixel grid can show. Freely fitted moments can fall below it, even below zero.
pub const LEAST_VARIANCE_PX2: f64 = 1e-3;

/// A PSF model: turns a [`LocalBlur`] into a light density about its centroid.
pub trait PsfModel: Send + Sync {
    /// Stable identifier, as the command line and files name it.
    fn id(&self) -> &'static str;

    /// Whether the model draws on [`LocalBlur::pupil`], which only lenses known ray by ray have.
    fn needs_rays(&self) -> bool {
        false
    }

    /// The box about the centroid outside which the density is negligible: less than 1e-6 of the
    /// light in all; where waves or a halo carry light far, 0.005 for each.
    fn kernel_bounds(&self, blur: &LocalBlur) -> KernelBounds;

    /// Light per px² at the pixel centres of `window`, row-major; the whole plane holds one.
    ///
    /// # Panics
    /// If `out` is not as long as the window has pixels.
    fn sample(&self, blur: &LocalBlur, window: &SampleGrid, out: &mut [f64]);

    /// As [`PsfModel::sample`] in single precision, for the renderer: within 1e-6 of the peak.
    ///
    /// # Panics
    /// If `out` is not as long as the window has pixels.
    fn sample_f32(&self, blur: &LocalBlur, window: &SampleGrid, out: &mut [f32]);

    /// Whether a renderer may draw two blurs, each with its shift (x, y) in px, with one kernel.
    ///
    /// By default only equal ones may share. A model that is costly to draw can allow small differences.
    fn can_share_kernel(
        &self,
        blur: &LocalBlur,
        shift_px: (f64, f64),
        other: &LocalBlur,
        other_shift_px: (f64, f64),
    ) -> bool {
        blur == other && shift_px == other_shift_px
    }

    /// Whether samples of the density on any grid of unit spacing are known to sum to one within 1e-6,
    /// so that a kernel need not be drawn whole to scale one of its weights.
    fn sums_to_one(&self, _blur: &LocalBlur) -> bool {
        false
    }

    /// Draws the PSF into `rows`, its centroid `shift_px` (x, y) from the source pixel's centre: the
    /// same kernel as [`draw_kernel`], in the form the exact renderer scatters fastest. A model costly
    /// to draw may draw it coarser and says by how much.
    fn draw_rows(&self, blur: &LocalBlur, shift_px: (f64, f64), rows: &mut KernelRows) {
        let mut kernel = Kernel::default();
        draw_kernel(self, blur, shift_px, &mut kernel);
        rows.copy_from(&kernel);
    }
}

/// A PSF model that draws on moments alone and is a mean of skew-normal densities.
pub trait MomentPsf: Send + Sync {
    /// See [`PsfModel::id`].
    const ID: &'static str;

    /// The density for `blur`, whose covariance has no eigenvalue below [`LEAST_VARIANCE_PX2`]; its pixels are
    /// square.
    fn mixture(&self, blur: &LocalBlur) -> Mixture;
}

impl<M: MomentPsf> PsfModel for M {
    fn id(&self) -> &'static str {
        M::ID
    }

    fn kernel_bounds(&self, blur: &LocalBlur) -> KernelBounds {
        on_grid(self, blur).reach()
    }

    fn sample(&self, blur: &LocalBlur, window: &SampleGrid, out: &mut [f64]) {
        on_grid(self, blur).sample(window, out);
    }

    fn sample_f32(&self, blur: &LocalBlur, window: &SampleGrid, out: &mut [f32]) {
        on_grid(self, blur).sample_f32(window, out);
    }

    fn sums_to_one(&self, blur: &LocalBlur) -> bool {
        on_grid(self, blur).sums_to_one()
    }

    fn draw_rows(&self, blur: &LocalBlur, shift_px: (f64, f64), rows: &mut KernelRows) {
        rows.draw(&on_grid(self, blur), shift_px);
    }
}

/// The density of `model` on the grid of `blur`. Models look along the meridian, which pixels that are not
/// square turn: there the density is that on square pixels, stretched.
fn on_grid<M: MomentPsf>(model: &M, blur: &LocalBlur) -> Mixture {
    let blur = drawable(blur);
    if blur.pixel_aspect == 1.0 {
        return model.mixture(&blur);
    }
    let square = drawable(&blur.on_wider_pixels(1.0 / blur.pixel_aspect));
    let stretch = 1.0 / blur.pixel_aspect;
    model.mixture(&square).stretched_x(stretch)
}

fn drawable(blur: &LocalBlur) -> LocalBlur {
    blur.with_least_variance(LEAST_VARIANCE_PX2)
}

/// The box about a centroid that holds a PSF, in px from the centroid; all four are positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KernelBounds {
    /// Towards smaller x.
    pub left_px: f64,
    /// Towards larger x.
    pub right_px: f64,
    /// Towards smaller y.
    pub up_px: f64,
    /// Towards larger y.
    pub down_px: f64,
}

/// Every PSF model, by the order in which they are listed to users.
pub static ALL: &[&dyn PsfModel] = &[
    &Gaussian,
    &SkewNormal,
    &SkewNormalGeneral,
    &SkewNormalEq43,
    &MirroredPair,
    &Pupil,
];

/// The model called `id`.
///
/// # Errors
/// A name that no model has; the message lists those that exist.
pub fn by_id(id: &str) -> Result<&'static dyn PsfModel> {
    ALL.iter()
        .copied()
        .find(|model| model.id() == id)
        .ok_or_else(|| {
            let names: Vec<_> = ALL.iter().map(|model| model.id()).collect();
            Error::new(
                format!("PSF model `{id}`"),
                "is not known",
                format!("use one of: {}", names.join(", ")),
            )
        })
}
