//! A plausibility check of a depth pass before the first frame.
//!
//! A wrong convention gives a plausible picture with the wrong blur, which is easy to miss. The pass itself holds
//! evidence of its convention.

mod edges;
mod finding;
mod patches;
mod picture;
mod planes;
mod ramps;
#[cfg(test)]
mod scenes;
#[cfg(test)]
mod tests;
mod values;

pub(crate) use finding::distance_span;
pub use finding::{DepthFinding, DepthProblem, Severity};
pub use picture::DepthPlace;

use super::DepthConvention;
use seidel_optics::error::{Error, Result};
use seidel_optics::field::ImagePoint;

/// The inputs of a depth check: a depth pass with its convention, camera and lens.
#[derive(Debug, Clone, Copy)]
pub struct DepthCheck<'a> {
    /// The numbers of the pass, row-major.
    pub samples: &'a [f32],
    /// The vergence that they were read as, 1/m, zero at infinity: [`super::DepthReading::vergence`].
    pub vergence: &'a [f32],
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The convention that the user states.
    pub convention: DepthConvention,
    /// The colours of the plate, premultiplied and linear in light; none if they are not known.
    pub colours: &'a [Vec<f32>],
    /// The plate's alpha, if any.
    pub alpha: Option<&'a [f32]>,
    /// The camera's perspective.
    pub view: CameraPerspective,
    /// The distances that the lens profile states.
    pub lens: LensDistances,
}

/// The perspective of the camera, in pixels of the pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraPerspective {
    /// Image point of the optical axis.
    pub axis: ImagePoint,
    /// Focal length: half the picture's width over the tangent of half its field of view; `None` if unknown.
    pub focal_px: Option<f64>,
    /// Width of a pixel over its height; `axis` and `focal_px` are in pixel widths along x.
    pub pixel_aspect: f64,
}

/// The distances that a lens profile states; each may be missing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LensDistances {
    /// Nearest and farthest measured distance, metres; the farthest may be infinite.
    pub measured_m: Option<(f64, f64)>,
    /// Focal length, metres.
    pub focal_length_m: Option<f64>,
}

impl DepthCheck<'_> {
    /// Returns the findings, warnings first; empty unless the evidence is strong.
    ///
    /// # Errors
    /// Planes of another size than the pass, and an invalid perspective.
    pub fn findings(&self) -> Result<Vec<DepthFinding>> {
        self.check()?;
        if let Some(finding) = values::constant(self) {
            return Ok(vec![finding]);
        }
        if let Some(finding) = picture::colour(self) {
            return Ok(vec![finding]);
        }
        // Each of these makes the next meaningless: normalised numbers bend planes, and values of another
        // convention have no unit.
        let meaning = || {
            values::normalised(self)
                .or_else(|| planes::wrong_reading(self))
                .or_else(|| values::unit(self))
        };
        let filtered = || rayon::join(|| edges::filtered(self), || ramps::averaged(self));
        let ((meaning, (filtered, averaged)), (misplaced, quantised)) = rayon::join(
            || rayon::join(meaning, filtered),
            || rayon::join(|| picture::misplaced(self), || values::quantised(self)),
        );
        // Slanted surfaces in the reciprocal of distance look like averages.
        let averaged = averaged.filter(|_| meaning.is_none() && filtered.is_none());
        let found = [meaning, filtered, averaged, misplaced, quantised];
        let mut findings: Vec<DepthFinding> = found.into_iter().flatten().collect();
        findings.sort_by_key(|f| f.severity != Severity::Warning);
        Ok(findings)
    }

    fn check(&self) -> Result<()> {
        let pixels = self.width * self.height;
        let sizes = [self.samples.len(), self.vergence.len()].into_iter();
        let sizes = sizes.chain(self.alpha.map(<[f32]>::len));
        let mut sizes = sizes.chain(self.colours.iter().map(Vec::len));
        if pixels == 0 || sizes.any(|size| size != pixels) {
            return Err(Error::new(
                "depth check",
                format!(
                    "has planes that do not hold {} x {} samples",
                    self.width, self.height
                ),
                "give depth, vergence, colours and alpha of one size",
            ));
        }
        let CameraPerspective { axis, focal_px, .. } = self.view;
        let finite = axis.x_px.is_finite() && axis.y_px.is_finite();
        if !finite || focal_px.is_some_and(|f| !(f.is_finite() && f > 0.0)) {
            return Err(Error::new(
                "depth check",
                format!("has the axis at {axis:?} and the image plane at {focal_px:?} px"),
                "give finite numbers of pixels, the distance above zero",
            ));
        }
        Ok(())
    }

    /// Returns the number at a pixel.
    fn sample(&self, column: usize, row: usize) -> f32 {
        self.samples[row * self.width + column]
    }
}
