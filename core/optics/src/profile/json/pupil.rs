//! Channels of the kind `pupil` in JSON.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::effects;
use crate::error::{Error, Result};
use crate::lens::VergenceSeries;
use crate::profile::{ProfileEffect, PupilChannel};

/// A colour channel of the kind `pupil`.
///
/// Without effects, the ray through u in the unit pupil disc lands off the chief ray by (alpha + beta |u|² + delta |X|²)
/// u + gamma X (X.u) - phi (|u|² X + 2 u (X.u)). PSF lengths are in frame pixels, field positions X in half frame widths
/// from the axis.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "PupilChannel")]
pub(super) struct PupilChannelFile {
    /// Channel name, such as `R` or `Y`.
    name: String,
    /// Defocus, px.
    alpha: SeriesFile,
    /// Spherical aberration, px.
    beta: SeriesFile,
    /// Astigmatism, px per squared half frame width.
    gamma: SeriesFile,
    /// Field curvature, px per squared half frame width.
    delta: SeriesFile,
    /// Coma, px per half frame width.
    phi: SeriesFile,
    /// Variance of the symmetric blur along any direction, px², before integration over pixels.
    blur_variance_px2: SeriesFile,
    /// Relative change of scale: centroid minus ideal position is X (magnification + distortion |X|²).
    magnification: SeriesFile,
    /// Distortion per squared half frame width.
    distortion: SeriesFile,
    /// Smallest and largest measured vergence (1/distance), 1/m. Beyond, alpha is linear and the other series are
    /// constant.
    measured_vergence_per_m: [f64; 2],
    /// Pupil radius over the slope of the chief ray half a frame width off the axis, m; 0 or left out if the camera is
    /// unknown.
    #[serde(default)]
    stop_lever_m: f64,
    /// Wavelength over pixel pitch, for diffraction; 0 or left out if either is unknown.
    #[serde(default)]
    wavelength_px: f64,
    /// Fitted effects, in the order in which they act; each at most once.
    effects: Vec<EffectFile>,
    /// Effects added after the fit, such as those that a diagnosis found, in the same order. Magnification and distortion
    /// are those of the lens without them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    added_effects: Vec<EffectFile>,
}

/// A polynomial in vergence (1/distance, 1/m).
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "VergenceSeries")]
struct SeriesFile {
    /// Coefficients, lowest power first; at least one.
    coefficients: Vec<f64>,
    /// Standard errors of the coefficients, as many; 0 if unknown.
    sigma: Vec<f64>,
    /// Residuals at measured vergences: [vergence in 1/m, value to add], by increasing vergence; linear between, constant
    /// beyond.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    remainders: Vec<[f64; 2]>,
}

/// An effect beyond the third-order model.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Effect")]
struct EffectFile {
    /// Identifier of the effect, such as `higher_order` or `vignetting`.
    id: String,
    /// All of its parameters, by name.
    parameters: BTreeMap<String, SeriesFile>,
}

impl PupilChannelFile {
    pub(super) fn new(channel: &PupilChannel) -> Self {
        let (low, high) = channel.measured_vergence;
        Self {
            name: channel.name.clone(),
            alpha: SeriesFile::new(&channel.alpha),
            beta: SeriesFile::new(&channel.beta),
            gamma: SeriesFile::new(&channel.gamma),
            delta: SeriesFile::new(&channel.delta),
            phi: SeriesFile::new(&channel.phi),
            blur_variance_px2: SeriesFile::new(&channel.blur_variance_px2),
            magnification: SeriesFile::new(&channel.magnification),
            distortion: SeriesFile::new(&channel.distortion),
            measured_vergence_per_m: [low, high],
            stop_lever_m: channel.stop_lever_m,
            wavelength_px: channel.wavelength_px,
            effects: channel.effects.iter().map(EffectFile::new).collect(),
            added_effects: (channel.added.iter().map(EffectFile::new))
                .chain(channel.picture.iter().map(|_| EffectFile::of_picture()))
                .collect(),
        }
    }

    pub(super) fn channel(self) -> Result<PupilChannel> {
        let [low, high] = self.measured_vergence_per_m;
        let carried = |files: Vec<EffectFile>| {
            let effects = files.into_iter().map(EffectFile::effect);
            effects
                .collect::<Result<_>>()
                .map_err(|e| e.within(&format!("channel {}", self.name)))
        };
        Ok(PupilChannel {
            effects: carried(self.effects)?,
            added: carried(self.added_effects)?,
            picture: None,
            wavelength_px: self.wavelength_px,
            name: self.name,
            alpha: self.alpha.series(),
            beta: self.beta.series(),
            gamma: self.gamma.series(),
            delta: self.delta.series(),
            phi: self.phi.series(),
            blur_variance_px2: self.blur_variance_px2.series(),
            magnification: self.magnification.series(),
            distortion: self.distortion.series(),
            measured_vergence: (low, high),
            stop_lever_m: self.stop_lever_m,
        })
    }
}

impl SeriesFile {
    fn new(series: &VergenceSeries) -> Self {
        Self {
            coefficients: series.coefficients.clone(),
            sigma: series.sigma.clone(),
            remainders: series.remainders.iter().map(|&(v, r)| [v, r]).collect(),
        }
    }

    fn series(self) -> VergenceSeries {
        VergenceSeries {
            coefficients: self.coefficients,
            sigma: self.sigma,
            remainders: self.remainders.into_iter().map(|[v, r]| (v, r)).collect(),
        }
    }
}

impl EffectFile {
    fn new(carried: &ProfileEffect) -> Self {
        let parameters = carried.effect.parameters().iter().zip(&carried.values);
        Self {
            id: carried.effect.id().to_owned(),
            parameters: parameters
                .map(|(parameter, values)| (parameter.name.to_owned(), SeriesFile::new(values)))
                .collect(),
        }
    }

    /// An effect that no reader knows, so that a profile is not read without its picture.
    fn of_picture() -> Self {
        Self {
            id: "aperture_picture".to_owned(),
            parameters: BTreeMap::new(),
        }
    }

    fn effect(mut self) -> Result<ProfileEffect> {
        let effect = effects::by_id(&self.id)?;
        let place = format!("effect `{}`", self.id);
        let names: Vec<_> = effect.parameters().iter().map(|p| p.name).collect();
        // Profiles of earlier versions lack the parameters that an effect has gained since.
        let values = (effect.parameters().iter())
            .map(|parameter| {
                let given = self.parameters.remove(parameter.name);
                given.map_or_else(
                    || VergenceSeries::constant(parameter.neutral),
                    SeriesFile::series,
                )
            })
            .collect();
        match self.parameters.keys().next() {
            Some(unknown) => Err(Error::new(
                place,
                format!("has no parameter `{unknown}`"),
                format!("use {}", names.join(", ")),
            )),
            None => Ok(ProfileEffect { effect, values }),
        }
    }
}
