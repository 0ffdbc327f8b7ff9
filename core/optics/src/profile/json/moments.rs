//! Channels of the kind `moments` in JSON.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{distance, optional_metres, present};
use crate::error::Result;
use crate::lens::MomentCoefficients;
use crate::profile::{MomentsChannel, MomentsPlane, RadialDisplacement};

/// A colour channel of the kind `moments`.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "MomentsChannel")]
pub(super) struct MomentsChannelFile {
    /// Channel name, such as `R` or `Y`.
    name: String,
    /// The measured object distances.
    planes: Vec<PlaneFile>,
}

/// A channel at one object distance.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct PlaneFile {
    /// Object distance in metres from the entrance pupil; null is infinity, left out is unknown.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        deserialize_with = "present"
    )]
    #[schemars(with = "Option<f64>")]
    depth_m: Option<Option<f64>>,
    /// S1..S5 (px²) and S6..S10 (px³) of the optical PSF, before integration over pixels, for field positions in half
    /// frame widths from the axis.
    s: [f64; 10],
    /// Standard errors of S1..S10, in the same units.
    s_sigma: [f64; 10],
    /// Radial displacement of the centroids, if known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    displacement: Option<RadialDisplacement>,
    /// Number of tiles that the fit used.
    tiles_used: usize,
    /// Number of tiles that the fit rejected.
    tiles_rejected: usize,
}

impl MomentsChannelFile {
    pub(super) fn new(channel: &MomentsChannel) -> Self {
        Self {
            name: channel.name.clone(),
            planes: channel.planes.iter().map(PlaneFile::new).collect(),
        }
    }

    pub(super) fn channel(self) -> Result<MomentsChannel> {
        let planes = self.planes.into_iter().map(|plane| {
            plane
                .plane()
                .map_err(|e| e.within(&format!("channel {}", self.name)))
        });
        Ok(MomentsChannel {
            planes: planes.collect::<Result<_>>()?,
            name: self.name,
        })
    }
}

impl PlaneFile {
    fn new(plane: &MomentsPlane) -> Self {
        Self {
            depth_m: optional_metres(plane.distance),
            s: plane.s.0,
            s_sigma: plane.s_sigma,
            displacement: plane.displacement,
            tiles_used: plane.tiles_used,
            tiles_rejected: plane.tiles_rejected,
        }
    }

    fn plane(self) -> Result<MomentsPlane> {
        Ok(MomentsPlane {
            distance: distance("depth_m", self.depth_m)?,
            s: MomentCoefficients(self.s),
            s_sigma: self.s_sigma,
            displacement: self.displacement,
            tiles_used: self.tiles_used,
            tiles_rejected: self.tiles_rejected,
        })
    }
}
