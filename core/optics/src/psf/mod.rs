//! PSF models: the point-spread function of a lens at one point.
//!
//! A [`PsfModel`] turns a [`LocalBlur`] into a light density. It knows one point only; the variation over the field
//! is that of the lens model. Each model has a file; all of them are listed in [`ALL`].
//!
//! ```
//! use seidel_optics::field::Meridian;
//! use seidel_optics::moments::CentralMoments;
//! use seidel_optics::psf::{Gaussian, Kernel, LocalBlur, draw_kernel};
//!
//! let moments = CentralMoments { mu20: 4.0, mu02: 2.25, ..CentralMoments::default() }; // px²
//! let blur = LocalBlur::from_moments(moments, Meridian::X);
//! let mut kernel = Kernel::default();
//! draw_kernel(&Gaussian, &blur, (0.0, 0.0), &mut kernel);
//! assert_eq!((kernel.width, kernel.height), (21, 15)); // five standard deviations each way
//! assert!((kernel.weights.iter().sum::<f32>() - 1.0).abs() < 1e-5);
//! ```

mod gaussian;
mod kernel;
mod mirrored_pair;
mod mixture;
pub mod pupil;
mod rows;
mod skew_normal;
mod skew_normal_density;
mod skew_normal_general;
mod skew_normal_samples;

pub use crate::numeric::normal_cdf;
pub use gaussian::Gaussian;
pub use kernel::{Kernel, SampleGrid, draw_kernel};
pub use mirrored_pair::MirroredPair;
pub use mixture::Mixture;
pub use pupil::Pupil;
pub use rows::{KernelRows, KernelSpan};
pub use skew_normal::{PaperParameters, SkewNormal, meridional_density, meridional_skew};
pub use skew_normal_density::{B, PHI, SKEW_CAP, SkewNormalDensity, T_MAX};
pub use skew_normal_general::{SkewNormalEq43, SkewNormalGeneral, best_skew};

use crate::error::{Error, Result};
use crate::field::Meridian;
use crate::lens::LocalPupil;
use crate::moments::CentralMoments;

/// The blur of one point of light in one channel: the input of a PSF model.
///
/// Lengths are in pixels of the grid that the PSF is drawn on.
#[derive(Debug, Clone, PartialEq)]
pub struct LocalBlur {
    /// Second and third central moments in image axes.
    pub moments: CentralMoments,
    /// The meridional direction at this point.
    pub meridian: Meridian,
    /// Wavefront and pupil of the same blur, which [`Pupil`] draws; `None` for a lens described by moments.
    pub pupil: Option<LocalPupil>,
    /// Width over height of the grid's pixels. Lengths along x are in pixel widths, lengths along y in pixel
    /// heights; the meridian is that on square pixels.
    pub pixel_aspect: f64,
}

impl LocalBlur {
    /// Creates a blur from its moments alone.
    pub fn from_moments(moments: CentralMoments, meridian: Meridian) -> Self {
        Self {
            moments,
            meridian,
            pupil: None,
            pixel_aspect: 1.0,
        }
    }

    /// Creates a blur from wavefront and pupil; computes the moments from them.
    pub fn from_pupil(pupil: LocalPupil, meridian: Meridian) -> Self {
        Self {
            moments: pupil.moments().0,
            meridian,
            pupil: Some(pupil),
            pixel_aspect: 1.0,
        }
    }

    /// Returns the blur on a grid with `scale` times as many pixels along each axis.
    #[must_use]
    pub fn rescaled(&self, scale: f64) -> Self {
        Self {
            moments: self.moments.rescaled(scale),
            pupil: self.pupil.as_ref().map(|pupil| pupil.rescaled(scale)),
            ..*self
        }
    }

    /// Returns the blur on a grid whose pixels are `aspect` times as wide, and as high as before.
    #[must_use]
    pub fn on_wider_pixels(&self, aspect: f64) -> Self {
        Self {
            moments: self.moments.stretched_x(1.0 / aspect),
            pupil: self
                .pupil
                .as_ref()
                .map(|pupil| pupil.stretched_x(1.0 / aspect)),
            meridian: self.meridian,
            pixel_aspect: self.pixel_aspect * aspect,
        }
    }

    /// Returns the blur, widened so that its variance is at least `floor_px2` along every direction.
    #[must_use]
    pub fn with_least_variance(&self, floor_px2: f64) -> Self {
        let lacking = (floor_px2 - self.moments.least_variance()).max(0.0);
        Self {
            moments: self.moments.with_least_variance(floor_px2),
            pupil: self.pupil.as_ref().map(|pupil| pupil.blurred_by(lacking)),
            ..*self
        }
    }
}

/// Smallest variance of a drawn density, px²: a standard deviation of a thirtieth of a pixel, far below what a pixel
/// grid can show. Freely fitted moments can be smaller, even negative.
pub const LEAST_VARIANCE_PX2: f64 = 1e-3;

/// A PSF model: the light density of a [`LocalBlur`] about its centroid.
pub trait PsfModel: Send + Sync {
    /// The stable identifier used on the command line and in files.
    fn id(&self) -> &'static str;

    /// Returns whether the model needs [`LocalBlur::pupil`], which only profiles of the kind `pupil` have.
    fn needs_rays(&self) -> bool {
        false
    }

    /// Returns the box about the centroid outside which the density is negligible.
    ///
    /// It leaves out less than 1e-6 of the light; diffraction and a halo may each leave out 0.005.
    fn kernel_bounds(&self, blur: &LocalBlur) -> KernelBounds;

    /// Samples the density at the pixel centres of `grid` into `out`, row-major, in light per px².
    ///
    /// The density integrates to one over the plane.
    ///
    /// # Panics
    /// If the length of `out` is not the number of pixels of `grid`.
    fn sample(&self, blur: &LocalBlur, grid: &SampleGrid, out: &mut [f64]);

    /// Samples like [`PsfModel::sample`], in single precision, within 1e-6 of the peak.
    ///
    /// # Panics
    /// If the length of `out` is not the number of pixels of `grid`.
    fn sample_f32(&self, blur: &LocalBlur, grid: &SampleGrid, out: &mut [f32]);

    /// Returns whether a renderer may draw two blurs, each with its shift (x, y) in px, with one kernel.
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

    /// Returns whether the samples on any grid of unit spacing sum to one within 1e-6.
    ///
    /// If so, single weights of a kernel can be computed without drawing all of it to normalise them.
    fn sums_to_one(&self, _blur: &LocalBlur) -> bool {
        false
    }

    /// Draws the kernel of [`draw_kernel`] into `rows`, the form that the exact renderer scatters fastest.
    ///
    /// The centroid lies `shift_px` (x, y) from the centre of the source pixel. A model that is costly to draw may
    /// use a coarser approximation and documents its error.
    fn draw_rows(&self, blur: &LocalBlur, shift_px: (f64, f64), rows: &mut KernelRows) {
        let mut kernel = Kernel::default();
        draw_kernel(self, blur, shift_px, &mut kernel);
        rows.copy_from(&kernel);
    }

    /// [`PsfModel::draw_rows`] for kernels that are interpolated between places: the error may be that of interpolation.
    ///
    /// Weights farther than `reach` columns and rows from the source pixel are not needed. They may be left out of the
    /// rows, and count in their sum all the same.
    fn draw_interpolated_rows(
        &self,
        blur: &LocalBlur,
        shift_px: (f64, f64),
        _reach: Option<[i32; 2]>,
        rows: &mut KernelRows,
    ) {
        self.draw_rows(blur, shift_px, rows);
    }
}

/// A PSF model that needs moments only: one skew-normal density or the mean of two.
pub trait MomentPsf: Send + Sync {
    /// See [`PsfModel::id`].
    const ID: &'static str;

    /// Returns the density of `blur`, which has square pixels and no covariance eigenvalue below
    /// [`LEAST_VARIANCE_PX2`].
    fn mixture(&self, blur: &LocalBlur) -> Mixture;
}

impl<M: MomentPsf> PsfModel for M {
    fn id(&self) -> &'static str {
        M::ID
    }

    fn kernel_bounds(&self, blur: &LocalBlur) -> KernelBounds {
        on_grid(self, blur).bounds()
    }

    fn sample(&self, blur: &LocalBlur, grid: &SampleGrid, out: &mut [f64]) {
        on_grid(self, blur).sample(grid, out);
    }

    fn sample_f32(&self, blur: &LocalBlur, grid: &SampleGrid, out: &mut [f32]) {
        on_grid(self, blur).sample_f32(grid, out);
    }

    fn sums_to_one(&self, blur: &LocalBlur) -> bool {
        on_grid(self, blur).sums_to_one()
    }

    fn draw_rows(&self, blur: &LocalBlur, shift_px: (f64, f64), rows: &mut KernelRows) {
        rows.draw(&on_grid(self, blur), shift_px);
    }
}

/// Returns the density of `model` on the grid of `blur`.
///
/// Pixels that are not square would change the direction of the meridian, so the density is built on square pixels
/// and then stretched.
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

/// The box about the centroid that bounds a PSF, in px from the centroid; all four are positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KernelBounds {
    /// Extent towards smaller x.
    pub left_px: f64,
    /// Extent towards larger x.
    pub right_px: f64,
    /// Extent towards smaller y.
    pub up_px: f64,
    /// Extent towards larger y.
    pub down_px: f64,
}

/// All PSF models, in the order in which they are listed to users.
pub static ALL: &[&dyn PsfModel] = &[
    &Gaussian,
    &SkewNormal,
    &SkewNormalGeneral,
    &SkewNormalEq43,
    &MirroredPair,
    &Pupil,
];

/// Returns the model called `id`.
///
/// # Errors
/// Rejects an unknown name; the message lists the known ones.
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
