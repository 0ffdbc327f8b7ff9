//! The JSON format of lens profiles: the parts common to all kinds. The channels of each kind have their own file.

mod adequacy;
mod held_out;
mod moments;
mod pupil;

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer, Serialize};

use super::{LensDescription, LensProfile, Provenance};
use crate::camera::Camera;
use crate::distance::ObjectDistance;
use crate::error::{Error, Result};
use crate::field::{Frame, ImagePoint};
use held_out::HeldOutFile;
use moments::MomentsChannelFile;
use pupil::PupilChannelFile;

const FORMAT: &str = "seidel-lens";
const VERSION: u32 = 1;

/// A lens profile: a lens fitted by `seidel fit`.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "LensProfile")]
struct ProfileFile<C> {
    /// Always `seidel-lens`.
    format: String,
    /// Version of the format: 1.
    version: u32,
    /// The kind of description that the channels hold.
    kind: Kind,
    /// Width and height of the full frame, pixels.
    image_size: [u32; 2],
    /// Position of the optical axis, pixels from the outer top-left corner of the frame.
    optical_axis: [f64; 2],
    /// Sensor pixel pitch, micrometres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pixel_pitch_um: Option<f64>,
    /// Known settings of the camera.
    #[serde(default)]
    camera: CameraFile,
    /// The colour channels.
    channels: Vec<C>,
    /// The score on PSFs that the fit held out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    held_out: Option<HeldOutFile>,
    /// The origin of the profile.
    provenance: Provenance,
}

/// Kinds of lens description that this version reads.
#[derive(Debug, Serialize, Deserialize, JsonSchema, Clone, Copy, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
enum Kind {
    /// S1..S10 per channel and object distance.
    Moments,
    /// Wavefront and pupil: parameters that are polynomials in vergence, and effects.
    Pupil,
}

impl Kind {
    const ALL: [(&str, Self); 2] = [("moments", Self::Moments), ("pupil", Self::Pupil)];
}

/// A colour channel, in the form of the kind of the profile.
#[derive(JsonSchema)]
#[serde(untagged)]
enum ChannelFile {
    /// A channel of the kind `moments`.
    #[expect(dead_code, reason = "used for the schema only")]
    Moments(MomentsChannelFile),
    /// A channel of the kind `pupil`.
    #[expect(dead_code, reason = "used for the schema only")]
    Pupil(Box<PupilChannelFile>),
}

/// Known settings of the camera; every key is optional.
#[derive(Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct CameraFile {
    /// Focal length, millimetres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    focal_length_mm: Option<f64>,
    /// F-number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    f_number: Option<f64>,
    /// Focused distance in metres from the entrance pupil; null is infinity, left out is unknown.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        deserialize_with = "present"
    )]
    #[schemars(with = "Option<f64>")]
    focus_distance_m: Option<Option<f64>>,
    /// Wavelength by channel, nanometres.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    wavelength_nm: BTreeMap<String, f64>,
    /// Squeeze of an anamorphic lens: 2 for a 2x lens.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    squeeze: Option<f64>,
    /// Name of the lens.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    lens_model: Option<String>,
    /// Serial number of the lens.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    lens_serial_number: Option<String>,
}

/// Deserialises a present key: `null` becomes `Some(None)`, while a missing key stays `None` by `default`.
fn present<'de, D: Deserializer<'de>>(d: D) -> std::result::Result<Option<Option<f64>>, D::Error> {
    Option::<f64>::deserialize(d).map(Some)
}

fn distance(key: &str, value: Option<Option<f64>>) -> Result<ObjectDistance> {
    match value {
        None => Ok(ObjectDistance::Unknown),
        Some(None) => Ok(ObjectDistance::Infinity),
        Some(Some(metres)) => ObjectDistance::metres(metres).map_err(|e| e.within(key)),
    }
}

fn optional_metres(distance: ObjectDistance) -> Option<Option<f64>> {
    match distance {
        ObjectDistance::Unknown => None,
        ObjectDistance::Infinity => Some(None),
        ObjectDistance::Metres(m) => Some(Some(m)),
    }
}

/// Returns the JSON schema of the format, pretty-printed.
pub fn schema() -> String {
    let schema = schemars::schema_for!(ProfileFile<ChannelFile>);
    serde_json::to_string_pretty(&schema).expect("a schema is plain JSON")
}

pub(super) fn read(text: &str) -> Result<LensProfile> {
    // Checks format, version and kind first: a later version may have unknown keys.
    match check_head(&parse(text)?)? {
        Kind::Moments => profile(parse(text)?, |channels| {
            let channels = channels.into_iter().map(MomentsChannelFile::channel);
            Ok(LensDescription::Moments(channels.collect::<Result<_>>()?))
        }),
        Kind::Pupil => profile(parse(text)?, |channels| {
            let channels = channels.into_iter().map(PupilChannelFile::channel);
            Ok(LensDescription::Pupil(channels.collect::<Result<_>>()?))
        }),
    }
}

fn parse<T: DeserializeOwned>(text: &str) -> Result<T> {
    serde_json::from_str(text).map_err(|e| {
        let place = format!("line {} column {}", e.line(), e.column());
        let message = e.to_string();
        // The place stands before the message.
        let problem = message.strip_suffix(&format!(" at {place}"));
        Error::new(
            place,
            problem.unwrap_or(&message).to_owned(),
            "compare with the JSON schema of lens profiles",
        )
    })
}

fn check_head(any: &serde_json::Value) -> Result<Kind> {
    let text = |key: &str| any.get(key).map(ToString::to_string);
    let or_missing = |value: Option<String>| value.unwrap_or_else(|| "missing".to_owned());
    if any.get("format").and_then(|v| v.as_str()) != Some(FORMAT) {
        return Err(Error::new(
            "format",
            format!("is {}", or_missing(text("format"))),
            format!("give a lens profile as a fit writes it, whose format is \"{FORMAT}\""),
        ));
    }
    if any.get("version").and_then(serde_json::Value::as_u64) != Some(u64::from(VERSION)) {
        return Err(Error::new(
            "version",
            format!("is {}", or_missing(text("version"))),
            format!(
                "this program reads version {VERSION}: use the program that wrote the profile, or fit the lens again"
            ),
        ));
    }
    let kind = any.get("kind").and_then(|v| v.as_str());
    let known = Kind::ALL.iter().find(|(name, _)| kind == Some(name));
    known.map(|(_, kind)| *kind).ok_or_else(|| {
        let names = Kind::ALL.map(|(name, _)| format!("\"{name}\""));
        Error::new(
            "kind",
            format!("is {}", or_missing(text("kind"))),
            format!("this program reads the kinds {}", names.join(" and ")),
        )
    })
}

fn profile<C>(
    file: ProfileFile<C>,
    description: impl FnOnce(Vec<C>) -> Result<LensDescription>,
) -> Result<LensProfile> {
    let positive = |key: &str, value: Option<f64>| match value {
        Some(v) if !(v.is_finite() && v > 0.0) => Err(Error::new(
            key,
            format!("is {v}"),
            "give a number greater than zero, or leave it out",
        )),
        other => Ok(other),
    };
    let [width, height] = file.image_size;
    let [x, y] = file.optical_axis;
    let profile = LensProfile {
        frame: Frame::new(width, height, Some(ImagePoint::new(x, y)))?,
        pixel_pitch_um: positive("pixel_pitch_um", file.pixel_pitch_um)?,
        camera: Camera {
            focal_length_mm: positive("camera.focal_length_mm", file.camera.focal_length_mm)?,
            f_number: positive("camera.f_number", file.camera.f_number)?,
            focus_distance: distance("camera.focus_distance_m", file.camera.focus_distance_m)?,
            wavelength_nm: file.camera.wavelength_nm,
            squeeze: positive("camera.squeeze", file.camera.squeeze)?,
            lens_model: file.camera.lens_model,
            lens_serial_number: file.camera.lens_serial_number,
        },
        description: description(file.channels)?,
        held_out: file.held_out.map(HeldOutFile::held_out).transpose()?,
        provenance: file.provenance,
    };
    profile.check()?;
    Ok(profile)
}

pub(super) fn write(profile: &LensProfile) -> String {
    match &profile.description {
        LensDescription::Moments(channels) => {
            let channels = channels.iter().map(MomentsChannelFile::new).collect();
            write_kind(profile, Kind::Moments, channels)
        }
        LensDescription::Pupil(channels) => {
            let channels = channels.iter().map(PupilChannelFile::new).collect();
            write_kind(profile, Kind::Pupil, channels)
        }
    }
}

fn write_kind<C: Serialize>(profile: &LensProfile, kind: Kind, channels: Vec<C>) -> String {
    let axis = profile.frame.axis();
    let file = ProfileFile {
        format: FORMAT.to_owned(),
        version: VERSION,
        kind,
        image_size: [profile.frame.width_px(), profile.frame.height_px()],
        optical_axis: [axis.x_px, axis.y_px],
        pixel_pitch_um: profile.pixel_pitch_um,
        camera: CameraFile {
            focal_length_mm: profile.camera.focal_length_mm,
            f_number: profile.camera.f_number,
            focus_distance_m: optional_metres(profile.camera.focus_distance),
            wavelength_nm: profile.camera.wavelength_nm.clone(),
            squeeze: profile.camera.squeeze,
            lens_model: profile.camera.lens_model.clone(),
            lens_serial_number: profile.camera.lens_serial_number.clone(),
        },
        channels,
        held_out: profile.held_out.as_ref().map(HeldOutFile::new),
        provenance: profile.provenance.clone(),
    };
    let mut text = serde_json::to_string_pretty(&file).expect("a profile is plain JSON");
    text.push('\n');
    text
}

#[cfg(test)]
mod tests;
