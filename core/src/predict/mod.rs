//! What a lens profile says about any point: S1..S10 across depth, PSF moments, centroids.

mod like;

pub use like::predict_like;

use crate::distance::ObjectDistance;
use crate::error::{Error, Result};
use crate::field::{FieldPoint, Frame};
use crate::lens::{DepthLaw, MomentCoefficients};
use crate::profile::{LensProfile, MomentsChannel};
use crate::psf::LocalBlur;
use crate::render::{BlurField, PlacedBlur};

/// A lens profile made ready to ask: one depth law a channel.
#[derive(Debug, Clone)]
pub struct Predictor {
    frame: Frame,
    names: Vec<String>,
    channels: Vec<Channel>,
    knows_depth: bool,
}

#[derive(Debug, Clone)]
struct Channel {
    law: Law,
    /// Magnification and distortion as lines in vergence: (value at 0, slope).
    displacement: [(f64, f64); 2],
}

#[derive(Debug, Clone)]
enum Law {
    Constant(MomentCoefficients),
    Depth(DepthLaw),
}

impl Predictor {
    /// Prepares `profile`.
    ///
    /// # Errors
    /// Planes from which no depth law can be made.
    pub fn new(profile: &LensProfile) -> Result<Self> {
        let laws = profile.depth_laws()?;
        let channels = profile
            .channels
            .iter()
            .zip(laws)
            .map(|(channel, law)| Channel {
                law: law.map_or_else(|| Law::Constant(channel.planes[0].s), Law::Depth),
                displacement: displacement_lines(channel),
            })
            .collect();
        Ok(Self {
            frame: profile.frame,
            names: profile.channels.iter().map(|c| c.name.clone()).collect(),
            channels,
            knows_depth: profile.channels.iter().all(|c| c.planes.len() > 1),
        })
    }

    /// Index of the lens channel called `name`.
    ///
    /// # Errors
    /// A name the lens has not.
    pub fn channel_index(&self, name: &str) -> Result<usize> {
        self.names.iter().position(|n| n == name).ok_or_else(|| {
            Error::new(
                format!("channel {name}"),
                "is not in the lens profile",
                format!("use a lens with it; this one has {}", self.names.join(", ")),
            )
        })
    }

    /// Names of the channels.
    pub fn channel_names(&self) -> &[String] {
        &self.names
    }

    /// The vergence at which to ask for an object at `distance`; any will do for a lens whose blur does
    /// not depend on depth.
    ///
    /// # Errors
    /// An unknown distance where the blur depends on it.
    pub fn vergence(&self, distance: ObjectDistance) -> Result<f64> {
        match distance.vergence_per_m() {
            Some(v) => Ok(v),
            None if !self.knows_depth => Ok(0.0),
            None => Err(Error::new(
                "object distance",
                "is unknown, but the lens's blur depends on it",
                "give depth_m (null for infinity)",
            )),
        }
    }

    /// Whether the blur depends on depth: more than one object distance was measured.
    pub fn knows_depth(&self) -> bool {
        self.knows_depth
    }

    /// S1..S10 of `channel` at vergence `vergence_per_m`.
    pub fn coefficients(&self, channel: usize, vergence_per_m: f64) -> MomentCoefficients {
        match &self.channels[channel].law {
            Law::Constant(s) => *s,
            Law::Depth(law) => law.at(vergence_per_m),
        }
    }
}

impl BlurField for Predictor {
    fn frame(&self) -> Frame {
        self.frame
    }

    fn channel_count(&self) -> usize {
        self.channels.len()
    }

    fn blur_at(&self, channel: usize, at: FieldPoint, vergence_per_m: f64) -> PlacedBlur {
        let line = |(value, slope): (f64, f64)| value + slope * vergence_per_m;
        let [magnification, distortion] = self.channels[channel].displacement;
        let scale = line(magnification) + line(distortion) * (at.x * at.x + at.y * at.y);
        let unit = self.frame.half_width_px();
        PlacedBlur {
            blur: LocalBlur::of_moments(
                self.coefficients(channel, vergence_per_m).moments(at),
                at.meridian(),
            ),
            displacement_px: (at.x * scale * unit, at.y * scale * unit),
        }
    }
}

/// Least-squares lines in vergence through the planes' magnification and distortion: distortion is
/// linear in v to third order (docs/model.md 5b), and one plane makes it constant.
fn displacement_lines(channel: &MomentsChannel) -> [(f64, f64); 2] {
    let points: Vec<(f64, [f64; 2])> = channel
        .planes
        .iter()
        .filter_map(|plane| {
            let d = plane.displacement?;
            Some((
                plane.distance.vergence_per_m().unwrap_or(0.0),
                [d.magnification, d.distortion],
            ))
        })
        .collect();
    let count = points.len() as f64;
    if points.is_empty() {
        return [(0.0, 0.0); 2];
    }
    [0, 1].map(|k| {
        let mean_v = points.iter().map(|p| p.0).sum::<f64>() / count;
        let mean = points.iter().map(|p| p.1[k]).sum::<f64>() / count;
        let spread: f64 = points.iter().map(|p| (p.0 - mean_v).powi(2)).sum();
        let slope = if spread > 0.0 {
            points
                .iter()
                .map(|p| (p.0 - mean_v) * (p.1[k] - mean))
                .sum::<f64>()
                / spread
        } else {
            0.0
        };
        (mean - slope * mean_v, slope)
    })
}
