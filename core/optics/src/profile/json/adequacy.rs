//! Adequacy of a model in JSON.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{distance, optional_metres, present};
use crate::error::{Error, Result};
use crate::profile::{Adequacy, FieldPattern, FieldZone, ResidualPattern, WorstPlace};

/// Adequacy of the model for the lens, by held-out PSFs. A gap is the squared error of a tile's pixels over the
/// squared norm of the tile, mean over tiles.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Adequacy")]
pub(super) struct AdequacyFile {
    /// Gap that the noise of the tiles explains.
    noise_gap: f64,
    /// Gap less that of noise: up to 0.005 the model describes the lens, up to 0.03 in part.
    excess_gap: f64,
    /// Part of the excess that a smooth field of residuals removes: a better model could describe it.
    systematic_gap: f64,
    /// The place of the largest excess.
    worst: WorstFile,
    /// The pattern of the residuals.
    pattern: PatternFile,
}

/// The channel, distance and field zone of the largest excess.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "WorstPlace")]
struct WorstFile {
    /// Channel name.
    channel: String,
    /// Object distance in metres from the entrance pupil; null is infinity, left out is unknown.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        deserialize_with = "present"
    )]
    #[schemars(with = "Option<f64>")]
    depth_m: Option<Option<f64>>,
    /// `centre`, `middle` or `edge`: thirds of the field by radius.
    zone: String,
    /// Mean excess there.
    excess_gap: f64,
    /// Mean excess of all other held-out tiles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    elsewhere_gap: Option<f64>,
}

/// The shape that the residuals of most energy have.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "ResidualPattern")]
struct PatternFile {
    /// Number of periods about the centroid: 0 for rings, 1 for one side against the other, 2 for two axes.
    periods: usize,
    /// Share of the residuals' energy that has so many periods.
    share: f64,
    /// `constant`, `meridional` (turning with the meridian) or `varying` over the field.
    field: String,
}

impl AdequacyFile {
    pub(super) fn new(adequacy: &Adequacy) -> Self {
        let Adequacy { worst, pattern, .. } = adequacy;
        Self {
            noise_gap: adequacy.noise_gap,
            excess_gap: adequacy.excess_gap,
            systematic_gap: adequacy.systematic_gap,
            worst: WorstFile {
                channel: worst.channel.clone(),
                depth_m: optional_metres(worst.distance),
                zone: worst.zone.id().to_owned(),
                excess_gap: worst.excess_gap,
                elsewhere_gap: worst.elsewhere_gap,
            },
            pattern: PatternFile {
                periods: pattern.periods,
                share: pattern.share,
                field: pattern.field.id().to_owned(),
            },
        }
    }

    pub(super) fn adequacy(self) -> Result<Adequacy> {
        let zone = FieldZone::ALL
            .into_iter()
            .find(|z| z.id() == self.worst.zone);
        let field = FieldPattern::ALL
            .into_iter()
            .find(|p| p.id() == self.pattern.field);
        Ok(Adequacy {
            noise_gap: self.noise_gap,
            excess_gap: self.excess_gap,
            systematic_gap: self.systematic_gap,
            worst: WorstPlace {
                distance: distance("depth_m", self.worst.depth_m)?,
                zone: zone.ok_or_else(|| {
                    unknown("zone", &self.worst.zone, FieldZone::ALL.map(FieldZone::id))
                })?,
                channel: self.worst.channel,
                excess_gap: self.worst.excess_gap,
                elsewhere_gap: self.worst.elsewhere_gap,
            },
            pattern: ResidualPattern {
                periods: self.pattern.periods,
                share: self.pattern.share,
                field: field.ok_or_else(|| {
                    let known = FieldPattern::ALL.map(FieldPattern::id);
                    unknown("field", &self.pattern.field, known)
                })?,
            },
        })
    }
}

fn unknown(field: &str, value: &str, known: [&str; 3]) -> Error {
    Error::new(
        format!("held_out adequacy {field}"),
        format!("is `{value}`"),
        format!("use one of: {}", known.join(", ")),
    )
}
