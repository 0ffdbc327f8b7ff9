//! The score on held-out PSFs in JSON.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::adequacy::AdequacyFile;
use super::{distance, optional_metres, present};
use crate::error::Result;
use crate::profile::{HeldOut, HeldOutGroup};

/// The score of a lens on PSFs that its fit held out.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "HeldOut")]
pub(super) struct HeldOutFile {
    /// Number of held-out tiles, over all channels and distances.
    tiles: usize,
    /// The rule that selected them, in words.
    rule: String,
    /// Mean over tiles of the forward-blur signal-to-noise ratio, dB.
    snr_db: f64,
    /// Mean over tiles of the squared error of the pixels over the squared norm of the tile.
    pixel_gap: f64,
    /// Mean over tiles of the share of light that the model puts into the wrong pixels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    misplaced_light: Option<f64>,
    /// Mean signal-to-noise ratio of the nearest fitted tiles in place of the model, dB.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    neighbours_snr_db: Option<f64>,
    /// The scores by channel and distance.
    groups: Vec<GroupFile>,
    /// Adequacy of the model for the lens.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    adequacy: Option<AdequacyFile>,
}

/// The score of one channel at one object distance.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "HeldOutGroup")]
struct GroupFile {
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
    /// Number of held-out tiles.
    tiles: usize,
    /// Mean forward-blur signal-to-noise ratio of these tiles, dB.
    snr_db: f64,
    /// Mean squared error over squared norm of these tiles.
    pixel_gap: f64,
    /// Mean share of the light of these tiles that the model puts into the wrong pixels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    misplaced_light: Option<f64>,
}

impl HeldOutFile {
    pub(super) fn new(held_out: &HeldOut) -> Self {
        Self {
            tiles: held_out.tiles,
            rule: held_out.rule.clone(),
            snr_db: held_out.snr_db,
            pixel_gap: held_out.pixel_gap,
            groups: held_out
                .groups
                .iter()
                .map(|group| GroupFile {
                    channel: group.channel.clone(),
                    depth_m: optional_metres(group.distance),
                    tiles: group.tiles,
                    snr_db: group.snr_db,
                    pixel_gap: group.pixel_gap,
                    misplaced_light: group.misplaced_light,
                })
                .collect(),
            misplaced_light: held_out.misplaced_light,
            neighbours_snr_db: held_out.neighbours_snr_db,
            adequacy: held_out.adequacy.as_ref().map(AdequacyFile::new),
        }
    }

    pub(super) fn held_out(self) -> Result<HeldOut> {
        let groups = self.groups.into_iter().map(|group| {
            Ok(HeldOutGroup {
                distance: distance("depth_m", group.depth_m)
                    .map_err(|e| e.within(&format!("held_out channel {}", group.channel)))?,
                channel: group.channel,
                tiles: group.tiles,
                snr_db: group.snr_db,
                pixel_gap: group.pixel_gap,
                misplaced_light: group.misplaced_light,
            })
        });
        Ok(HeldOut {
            tiles: self.tiles,
            rule: self.rule,
            snr_db: self.snr_db,
            pixel_gap: self.pixel_gap,
            groups: groups.collect::<Result<_>>()?,
            misplaced_light: self.misplaced_light,
            neighbours_snr_db: self.neighbours_snr_db,
            adequacy: self.adequacy.map(AdequacyFile::adequacy).transpose()?,
        })
    }
}
