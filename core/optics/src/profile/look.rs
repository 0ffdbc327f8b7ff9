//! Looks: artistic changes of the pupil and the colour of a lens, each in the numbers of an effect of the model.

mod change;

use std::fmt;

use super::controls::SensorShift;
use super::{LensDescription, LensProfile};
use crate::camera::Camera;
use crate::error::{Error, ErrorKind, Result};
use crate::lens::AperturePicture;
use change::Change;

/// A change of the look of a lens. The default leaves the lens as measured, to the bit.
///
/// It acts on the lens as its controls have set it: a look does not change with the f-number.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    /// Iris blades in place of the lens's own: effect `aperture_polygon`. `None` keeps those.
    pub blades: Option<Blades>,
    /// A picture of the aperture, its transmission over the pupil: background discs show it upright, foreground discs turned by
    /// 180 degrees. It darkens light that the iris lets through.
    pub picture: Option<AperturePicture>,
    /// Height of defocused discs over their width, times that of the lens, as of an anamorphic lens of this squeeze: effect
    /// `anamorphic`.
    pub squeeze: f64,
    /// Radius of an opaque disc in the middle of the pupil over that of the pupil: effect `obstruction`. Zero keeps that of
    /// the lens.
    pub obstruction: f64,
    /// Cat's eyes towards the corners: effect `vignetting`. From -1, round discs over the whole field, over 0, as the lens, to
    /// 1: two more circles of the size of the pupil, which shift over it by 0.6 of its radius at the side of the frame.
    pub cats_eye: f64,
    /// Spherical aberration added to that of the lens: from -1, background discs with soft edges, to 1, with bright rims as of
    /// bubbles. At 1 it moves the ray at the rim of the pupil by 0.8 % of half the frame width. Focus moves along to the
    /// sharpest image.
    pub spherical: f64,
    /// Factor on the difference of focus between channels: longitudinal colour.
    pub axial_colour: f64,
    /// Factor on the difference of magnification and distortion between channels.
    pub lateral_colour: f64,
    /// Tilt of the lens against the sensor, degrees, as of a tilt-shift lens: effect `sensor_tilt`. By Scheimpflug's rule the plane of
    /// focus turns about a line through the pupil, and comes nearer along [`Self::tilt_direction_deg`]; negative values turn it the
    /// other way. The picture stays in place.
    pub tilt_deg: f64,
    /// Direction in the picture along which the plane of focus comes nearer, degrees from image x (right) towards y (down).
    pub tilt_direction_deg: f64,
}

/// Iris blades.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blades {
    /// Number of blades, 3 to 13; 0 for a round iris.
    pub count: u32,
    /// Curvature of the blades: 0 straight, 1 one circle.
    pub roundness: f64,
    /// Direction of one corner, degrees from image x (right) towards y (down).
    pub rotation_deg: f64,
}

/// The valid values of a number of a look.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LookRange {
    /// Smallest value.
    pub least: f64,
    /// Largest value.
    pub most: f64,
    /// The value that leaves the lens as it is.
    pub neutral: f64,
}

impl LookRange {
    const fn new(least: f64, most: f64, neutral: f64) -> Self {
        Self {
            least,
            most,
            neutral,
        }
    }

    /// Checks that `value` of the number `name` lies in the range.
    ///
    /// # Errors
    /// A value outside the range, or that is not a number.
    pub fn check(&self, name: &str, value: f64) -> Result<()> {
        if (self.least..=self.most).contains(&value) {
            return Ok(());
        }
        Err(Error::new(
            format!("look: {name}"),
            format!("is {value}"),
            format!(
                "give {} to {}; {} leaves the lens as it is",
                self.least, self.most, self.neutral
            ),
        ))
    }
}

impl Blades {
    /// Smallest and largest number of blades.
    pub const COUNTS: (u32, u32) = (3, 13);
    /// Valid curvatures.
    pub const ROUNDNESS: LookRange = LookRange::new(0.0, 1.0, 0.0);
    /// Valid directions, degrees.
    pub const ROTATION_DEG: LookRange = LookRange::new(-180.0, 180.0, 0.0);

    /// Returns `count` straight blades with a corner to the right.
    pub fn straight(count: u32) -> Self {
        Self {
            count,
            roundness: Self::ROUNDNESS.neutral,
            rotation_deg: Self::ROTATION_DEG.neutral,
        }
    }

    fn check(&self) -> Result<()> {
        let (least, most) = Self::COUNTS;
        if self.count != 0 && !(least..=most).contains(&self.count) {
            return Err(Error::new(
                "look: blades",
                format!("are {}", self.count),
                format!("give {least} to {most}, or 0 for a round iris"),
            ));
        }
        Self::ROUNDNESS.check("roundness", self.roundness)?;
        Self::ROTATION_DEG.check("rotation", self.rotation_deg)
    }
}

impl Default for Look {
    fn default() -> Self {
        Self {
            blades: None,
            picture: None,
            squeeze: Self::SQUEEZE.neutral,
            obstruction: Self::OBSTRUCTION.neutral,
            cats_eye: Self::CATS_EYE.neutral,
            spherical: Self::SPHERICAL.neutral,
            axial_colour: Self::COLOUR.neutral,
            lateral_colour: Self::COLOUR.neutral,
            tilt_deg: Self::TILT_DEG.neutral,
            tilt_direction_deg: Self::TILT_DIRECTION_DEG.neutral,
        }
    }
}

impl Look {
    /// Valid values of [`Look::squeeze`].
    pub const SQUEEZE: LookRange = LookRange::new(0.4, 2.5, 1.0);
    /// Valid values of [`Look::obstruction`].
    pub const OBSTRUCTION: LookRange = LookRange::new(0.0, 0.9, 0.0);
    /// Valid values of [`Look::cats_eye`].
    pub const CATS_EYE: LookRange = LookRange::new(-1.0, 1.0, 0.0);
    /// Valid values of [`Look::spherical`].
    pub const SPHERICAL: LookRange = LookRange::new(-1.0, 1.0, 0.0);
    /// Valid values of [`Look::axial_colour`] and [`Look::lateral_colour`].
    pub const COLOUR: LookRange = LookRange::new(-4.0, 4.0, 1.0);
    /// Valid values of [`Look::tilt_deg`].
    pub const TILT_DEG: LookRange = LookRange::new(-30.0, 30.0, 0.0);
    /// Valid values of [`Look::tilt_direction_deg`].
    pub const TILT_DIRECTION_DEG: LookRange = LookRange::new(-180.0, 180.0, 90.0);

    /// Returns whether the look leaves every lens as it is.
    pub fn is_neutral(&self) -> bool {
        // The direction of no tilt changes nothing.
        let neutral = Self {
            tilt_direction_deg: self.tilt_direction_deg,
            ..Self::default()
        };
        *self == neutral
    }

    fn check(&self) -> Result<()> {
        self.blades.as_ref().map_or(Ok(()), Blades::check)?;
        Self::SQUEEZE.check("squeeze", self.squeeze)?;
        Self::OBSTRUCTION.check("obstruction", self.obstruction)?;
        Self::CATS_EYE.check("cat's eye", self.cats_eye)?;
        Self::SPHERICAL.check("spherical aberration", self.spherical)?;
        Self::COLOUR.check("axial colour", self.axial_colour)?;
        Self::COLOUR.check("lateral colour", self.lateral_colour)?;
        Self::TILT_DEG.check("tilt", self.tilt_deg)?;
        Self::TILT_DIRECTION_DEG.check("tilt direction", self.tilt_direction_deg)
    }
}

/// The changes of the look in words, for provenance.
impl fmt::Display for Look {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let blades = self.blades.map(|blades| match blades.count {
            0 => "round iris".to_owned(),
            count => format!(
                "{count} blades, roundness {}, rotation {} degrees",
                blades.roundness, blades.rotation_deg
            ),
        });
        let numbers = [
            ("squeeze", self.squeeze, Self::SQUEEZE),
            ("obstruction", self.obstruction, Self::OBSTRUCTION),
            ("cat's eye", self.cats_eye, Self::CATS_EYE),
            ("spherical", self.spherical, Self::SPHERICAL),
            ("axial colour", self.axial_colour, Self::COLOUR),
            ("lateral colour", self.lateral_colour, Self::COLOUR),
        ];
        let changed = numbers.iter().filter(|(_, v, range)| *v != range.neutral);
        let picture = self.picture.as_ref().map(|_| "aperture picture".to_owned());
        let tilt = (self.tilt_deg != Self::TILT_DEG.neutral).then(|| {
            let (angle, direction) = (self.tilt_deg, self.tilt_direction_deg);
            format!("tilt {angle} degrees towards {direction} degrees")
        });
        let parts = (blades.into_iter())
            .chain(picture)
            .chain(changed.map(|(name, value, _)| format!("{name} {value}")))
            .chain(tilt);
        f.write_str(&parts.collect::<Vec<_>>().join(", "))
    }
}

impl LensProfile {
    /// Returns the same lens with `look`, which acts on the lens as its controls are set.
    ///
    /// The result has no held-out score, and its effect parameters may exceed the limits of profiles in files. A file cannot hold
    /// a picture of the aperture: see [`Self::check_storable`].
    ///
    /// # Errors
    /// [`ErrorKind::Unsupported`] for a profile of the kind `moments`, which has no pupil. Rejects values out of range, a
    /// positive cat's eye on a lens that has `vignetting` twice, and a tilt of a lens of unknown focal length or
    /// f-number.
    pub fn with_look(&self, look: &Look) -> Result<Self> {
        if look.is_neutral() {
            return Ok(self.clone());
        }
        look.check()?;
        let LensDescription::Pupil(channels) = &self.description else {
            return Err(Error::new(
                "look",
                "needs a lens profile of the kind `pupil`; this one has the kind `moments`, which says nothing about the pupil",
                "fit the lens with the reduced model, or leave the look as measured",
            )
            .with_kind(ErrorKind::Unsupported));
        };
        let change = Change {
            look,
            half_width_px: self.frame.half_width_px(),
            rise: self.sensor_rise(look.tilt_deg)?,
        };
        let mut provenance = self.provenance.clone();
        provenance.settings = format!("{}; look: {look}", provenance.settings);
        Ok(Self {
            description: LensDescription::Pupil(change.channels(channels)?),
            held_out: None,
            provenance,
            ..self.clone()
        })
    }

    /// Returns the shift, half a frame width off the axis, of a sensor tilted by `degrees`; `None` for no tilt.
    fn sensor_rise(&self, degrees: f64) -> Result<Option<SensorShift>> {
        if degrees == 0.0 {
            return Ok(None);
        }
        // Defocus is in px: the pixel pitch cancels.
        let rise_px = degrees.to_radians().tan() * self.frame.half_width_px();
        let Camera {
            focal_length_mm,
            f_number,
            ..
        } = self.camera;
        SensorShift::new(rise_px, focal_length_mm, f_number, Some(1.0)).map(Some)
    }

    /// Checks that a file can hold the profile.
    ///
    /// # Errors
    /// [`ErrorKind::Unsupported`] for a lens with a picture of the aperture.
    pub fn check_storable(&self) -> Result<()> {
        if (self.pupil_channels().iter()).all(|channel| channel.picture.is_none()) {
            return Ok(());
        }
        Err(Error::new(
            "look: aperture picture",
            "cannot be stored in a lens profile",
            "save the lens without the picture, and give the picture with each render",
        )
        .with_kind(ErrorKind::Unsupported))
    }
}

#[cfg(test)]
mod tests;
