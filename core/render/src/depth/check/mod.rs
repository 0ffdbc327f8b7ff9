//! A look at a depth pass before the first frame: does it hold what it is said to hold? Wrong depth
//! draws a plausible picture with the wrong blur, so nobody notices; here the pass itself is asked.

mod edges;
mod finding;
mod patches;
mod planes;
#[cfg(test)]
mod scenes;
#[cfg(test)]
mod tests;
mod values;

pub use finding::{DepthFinding, DepthProblem, Severity};

use super::DepthConvention;
use seidel_optics::error::{Error, Result};
use seidel_optics::field::ImagePoint;

/// A depth pass and what is known around it.
#[derive(Debug, Clone, Copy)]
pub struct DepthCheck<'a> {
    /// The numbers of the pass as they stand, row-major.
    pub samples: &'a [f32],
    /// The vergence they were read as, 1/m, zero at infinity: [`super::DepthReading::vergence`].
    pub vergence: &'a [f32],
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// What the numbers are said to be.
    pub convention: DepthConvention,
    /// The plate's alpha, where it has one.
    pub alpha: Option<&'a [f32]>,
    /// The camera's perspective.
    pub view: CameraPerspective,
    /// What the lens tells about distances.
    pub lens: LensDistances,
}

/// The perspective of the camera, in pixels of the pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraPerspective {
    /// Where the optical axis meets the picture.
    pub axis: ImagePoint,
    /// Distance of the image plane: half the picture's width over the tangent of half its field of
    /// view; `None` where it is not known.
    pub focal_px: Option<f64>,
    /// Width of a pixel over its height; lengths along x are in widths.
    pub pixel_aspect: f64,
}

/// What a lens tells about the distances it is used at; every part may be missing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LensDistances {
    /// Nearest and farthest distance at which it was measured, metres; the farthest may be infinite.
    pub measured_m: Option<(f64, f64)>,
    /// Focal length, metres.
    pub focal_length_m: Option<f64>,
}

impl DepthCheck<'_> {
    /// What is wrong with the pass, gravest first; nothing where no evidence is strong.
    ///
    /// # Errors
    /// Planes of another size than the pass, and a perspective that cannot be.
    pub fn findings(&self) -> Result<Vec<DepthFinding>> {
        self.check()?;
        if let Some(finding) = values::constant(self) {
            return Ok(vec![finding]);
        }
        let mut findings = Vec::new();
        // Each makes the next mean nothing: stretched numbers bend planes, and values of another
        // meaning have no unit that could be wrong.
        let meaning = values::normalised(self)
            .or_else(|| planes::meaning(self))
            .or_else(|| values::unit(self));
        findings.extend(meaning);
        findings.extend(edges::filtered(self));
        findings.extend(values::quantised(self));
        findings.sort_by_key(|f| f.severity != Severity::Warning);
        Ok(findings)
    }

    fn check(&self) -> Result<()> {
        let pixels = self.width * self.height;
        let sizes = [
            Some(self.samples.len()),
            Some(self.vergence.len()),
            self.alpha.map(<[f32]>::len),
        ];
        if pixels == 0 || sizes.into_iter().flatten().any(|size| size != pixels) {
            return Err(Error::new(
                "depth check",
                format!(
                    "has planes that do not hold {} x {} samples",
                    self.width, self.height
                ),
                "give depth, vergence and alpha of one size",
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

    /// Rows of the pass where `row` starts at `row * width`.
    fn sample(&self, column: usize, row: usize) -> f32 {
        self.samples[row * self.width + column]
    }
}
