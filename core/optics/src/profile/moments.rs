//! Channels of lens profiles of the kind `moments`: S1..S10 at the measured object distances.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::distance::ObjectDistance;
use crate::error::Result;
use crate::lens::{DepthLaw, DepthPlane, MomentCoefficients, VergencePoint, VergenceSeries};

/// A colour channel of the kind `moments`.
#[derive(Debug, Clone, PartialEq)]
pub struct MomentsChannel {
    /// Channel name, such as `R` or `Y`.
    pub name: String,
    /// The measured object distances, from infinity inwards.
    pub planes: Vec<MomentsPlane>,
}

/// A channel at one object distance.
#[derive(Debug, Clone, PartialEq)]
pub struct MomentsPlane {
    /// Object distance.
    pub distance: ObjectDistance,
    /// S1..S10 of the optical PSF, before integration over pixels: PSF in frame pixels, field in half frame widths.
    pub s: MomentCoefficients,
    /// Standard errors of S1..S10.
    pub s_sigma: [f64; 10],
    /// Radial displacement of the centroids, if the observations have ideal positions.
    pub displacement: Option<RadialDisplacement>,
    /// Number of tiles that the fit used.
    pub tiles_used: usize,
    /// Number of tiles that the fit rejected.
    pub tiles_rejected: usize,
}

/// Centroid minus ideal position: X (magnification + distortion |X|²), with X in half frame widths.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename = "DisplacementFile")]
pub struct RadialDisplacement {
    // It includes the shift of the centroid by coma.
    /// Relative change of scale.
    pub magnification: f64,
    /// Distortion per squared half frame width.
    pub distortion: f64,
    /// Standard error of `magnification`.
    pub magnification_sigma: f64,
    /// Standard error of `distortion`.
    pub distortion_sigma: f64,
}

impl RadialDisplacement {
    /// Fits magnification and distortion as least-squares lines in vergence (1/m) to pairs of vergence and displacement.
    ///
    /// To third order distortion is linear in vergence (docs/background/model.md section 5).
    pub fn fit_lines(measured: &[(f64, Self)]) -> [VergenceSeries; 2] {
        let fit_line = |point: fn(&Self) -> (f64, f64)| {
            let points = measured.iter().map(|(vergence_per_m, displacement)| {
                let (value, sigma) = point(displacement);
                VergencePoint {
                    vergence_per_m: *vergence_per_m,
                    value,
                    sigma,
                }
            });
            VergenceSeries::fit_line(&points.collect::<Vec<_>>())
        };
        [
            fit_line(|d| (d.magnification, d.magnification_sigma)),
            fit_line(|d| (d.distortion, d.distortion_sigma)),
        ]
    }
}

impl MomentsChannel {
    /// Returns the depth law of S1..S10; `None` if the only plane has an unknown distance.
    ///
    /// Two planes need [`super::LensProfile::defocus_px_per_dioptre`].
    pub(super) fn depth_law(
        &self,
        defocus_px_per_dioptre: Option<f64>,
    ) -> Result<Option<DepthLaw>> {
        let planes: Vec<_> = self
            .planes
            .iter()
            .filter_map(|plane| {
                Some(DepthPlane {
                    vergence_per_m: plane.distance.vergence_per_m()?,
                    s: plane.s,
                    s_sigma: plane.s_sigma,
                })
            })
            .collect();
        if planes.is_empty() {
            return Ok(None);
        }
        DepthLaw::fit(&planes, defocus_px_per_dioptre)
            .map(Some)
            .map_err(|error| error.within(&format!("channel {}", self.name)))
    }
}
