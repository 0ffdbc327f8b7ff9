//! Prediction from lens profiles: PSFs and their displacement at any field position, channel and depth.

mod set;

pub use set::predict_set;

use crate::blur_field::{BlurField, DisplacedBlur};
use crate::distance::ObjectDistance;
use crate::error::{Error, ErrorKind, Result};
use crate::field::{FieldPoint, Frame};
use crate::lens::{DepthLaw, MomentCoefficients, VergenceSeries};
use crate::profile::{
    LensDescription, LensProfile, MomentsChannel, PupilChannel, RadialDisplacement,
};
use crate::psf::{self, LocalBlur, PsfModel, Pupil, SkewNormal};
use crate::sensor::Tone;

/// A lens profile prepared for evaluation; it implements [`BlurField`].
#[derive(Debug, Clone)]
pub struct Predictor {
    frame: Frame,
    names: Vec<String>,
    channels: Channels,
    depends_on_depth: bool,
}

#[derive(Debug, Clone)]
enum Channels {
    Moments(Vec<Moments>),
    Pupil(Vec<PupilChannel>),
}

/// A channel of a lens of the kind `moments`.
#[derive(Debug, Clone)]
struct Moments {
    law: Law,
    /// Magnification and distortion as lines in vergence.
    displacement: [VergenceSeries; 2],
}

#[derive(Debug, Clone)]
enum Law {
    Constant(MomentCoefficients),
    Depth(DepthLaw),
}

impl Predictor {
    /// Prepares `profile` for evaluation.
    ///
    /// # Errors
    /// Rejects planes that determine no depth law.
    pub fn new(profile: &LensProfile) -> Result<Self> {
        let (channels, depends_on_depth) = match &profile.description {
            LensDescription::Moments(channels) => {
                let ready = channels.iter().zip(profile.depth_laws()?);
                let ready = ready.map(|(channel, law)| Moments {
                    law: law.map_or_else(|| Law::Constant(channel.planes[0].s), Law::Depth),
                    displacement: displacement_lines(channel),
                });
                let depends_on_depth = channels.iter().all(|c| c.planes.len() > 1);
                (Channels::Moments(ready.collect()), depends_on_depth)
            }
            LensDescription::Pupil(channels) => (
                Channels::Pupil(channels.clone()),
                channels.iter().any(|c| c.alpha.degree() > 0),
            ),
        };
        Ok(Self {
            frame: profile.frame,
            names: profile
                .channel_names()
                .into_iter()
                .map(str::to_owned)
                .collect(),
            channels,
            depends_on_depth,
        })
    }

    /// Returns the index of the channel called `name`.
    ///
    /// # Errors
    /// Rejects a name that the lens does not have; the message lists its channels.
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

    /// Returns the vergence of an object at `distance`, in 1/m, as the argument of [`BlurField::blur_at`].
    ///
    /// # Errors
    /// Rejects an unknown distance if the blur depends on depth.
    pub fn vergence(&self, distance: ObjectDistance) -> Result<f64> {
        match distance.vergence_per_m() {
            Some(v) => Ok(v),
            None if !self.depends_on_depth => Ok(0.0),
            None => Err(Error::new(
                "object distance",
                "is unknown, but the lens's blur depends on it",
                "give depth_m (null for infinity)",
            )),
        }
    }

    /// Returns whether the blur depends on depth: whether the lens was measured at more than one object distance.
    pub fn depends_on_depth(&self) -> bool {
        self.depends_on_depth
    }

    /// Returns whether the lens has wavefronts and pupils (the kind `pupil`), which some PSF models need.
    pub fn has_rays(&self) -> bool {
        matches!(self.channels, Channels::Pupil(_))
    }

    /// Checks that `model` can draw this lens.
    ///
    /// # Errors
    /// [`ErrorKind::Unsupported`] for a model that needs rays if the lens has the kind `moments`.
    pub fn check_model(&self, model: &dyn PsfModel) -> Result<()> {
        if !model.needs_rays() || self.has_rays() {
            return Ok(());
        }
        let id = model.id();
        let others = psf::ALL.iter().filter(|m| !m.needs_rays());
        let others: Vec<_> = others.map(|m| m.id()).collect();
        Err(Error::new(
            format!("PSF model `{id}`"),
            "needs a lens profile of the kind `pupil`; this one has the kind `moments`",
            format!(
                "fit the lens with the reduced model, or use one of: {}",
                others.join(", ")
            ),
        )
        .with_kind(ErrorKind::Unsupported))
    }

    /// Returns the most accurate PSF model for this lens.
    pub fn default_model(&self) -> &'static dyn PsfModel {
        if self.has_rays() { &Pupil } else { &SkewNormal }
    }
}

impl BlurField for Predictor {
    fn frame(&self) -> Frame {
        self.frame
    }

    fn channel_count(&self) -> usize {
        self.names.len()
    }

    fn tone(&self, channel: usize) -> Tone {
        match &self.channels {
            Channels::Moments(_) => Tone::default(),
            Channels::Pupil(channels) => {
                // The tone does not depend on the field position.
                let middle = FieldPoint::new(0.0, 0.0);
                let channel = &channels[channel];
                channel
                    .pupil_at(middle, channel.measured_vergence.0)
                    .sensor
                    .tone
            }
        }
    }

    fn blur_at(&self, channel: usize, at: FieldPoint, vergence_per_m: f64) -> DisplacedBlur {
        let unit = self.frame.half_width_px();
        match &self.channels {
            Channels::Moments(channels) => {
                let (blur, stretch) = channels[channel].blur_at(at, vergence_per_m);
                DisplacedBlur {
                    blur,
                    displacement_px: (at.x * stretch * unit, at.y * stretch * unit),
                }
            }
            Channels::Pupil(channels) => {
                let channel = &channels[channel];
                let (moments, pupil) = channel.moments_and_pupil_at(at, vergence_per_m);
                DisplacedBlur {
                    blur: LocalBlur {
                        moments,
                        meridian: at.meridian(),
                        pupil: Some(pupil),
                        pixel_aspect: 1.0,
                    },
                    displacement_px: channel.displacement_at(at, vergence_per_m, unit),
                }
            }
        }
    }
}

impl Moments {
    fn blur_at(&self, at: FieldPoint, vergence_per_m: f64) -> (LocalBlur, f64) {
        let s = match &self.law {
            Law::Constant(s) => *s,
            Law::Depth(law) => law.at(vergence_per_m),
        };
        let [magnification, distortion] = &self.displacement;
        let h2 = at.x * at.x + at.y * at.y;
        let stretch = magnification.at(vergence_per_m) + distortion.at(vergence_per_m) * h2;
        (
            LocalBlur::from_moments(s.moments(at), at.meridian()),
            stretch,
        )
    }
}

/// Returns magnification and distortion of a channel as lines in vergence, fitted to its planes.
fn displacement_lines(channel: &MomentsChannel) -> [VergenceSeries; 2] {
    let measured = channel.planes.iter().filter_map(|plane| {
        let v = plane.distance.vergence_per_m().unwrap_or(0.0);
        Some((v, plane.displacement?))
    });
    RadialDisplacement::fit_lines(&measured.collect::<Vec<_>>())
}

#[cfg(test)]
mod tests;
