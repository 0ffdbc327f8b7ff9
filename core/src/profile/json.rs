//! The JSON form of a lens profile.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

use super::{Displacement, LensProfile, MomentsChannel, MomentsPlane, Provenance};
use crate::camera::Camera;
use crate::distance::ObjectDistance;
use crate::error::{Error, Result};
use crate::field::{Frame, ImagePoint};
use crate::lens::MomentCoefficients;

const FORMAT: &str = "seidel-lens";
const VERSION: u32 = 1;

/// A lens profile: what `seidel fit` learned of a lens.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "LensProfile")]
struct ProfileFile {
    /// Always `seidel-lens`.
    format: String,
    /// Version of the format: 1.
    version: u32,
    /// What kind of description follows. `moments`: S1..S10 per channel and object distance.
    kind: Kind,
    /// Width and height of the full frame, pixels.
    image_size: [u32; 2],
    /// Where the optical axis meets the frame, pixels from its top-left outer corner.
    optical_axis: [f64; 2],
    /// Sensor pixel pitch, micrometres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pixel_pitch_um: Option<f64>,
    /// What is known of the camera.
    #[serde(default)]
    camera: CameraFile,
    /// The colour channels.
    channels: Vec<ChannelFile>,
    /// Where the profile came from.
    provenance: ProvenanceFile,
}

/// Kinds of lens description that this version reads.
#[derive(Debug, Serialize, Deserialize, JsonSchema, Clone, Copy, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
enum Kind {
    /// S1..S10 per channel and object distance.
    Moments,
}

/// What is known of a camera; every key may be left out.
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
}

/// One colour channel.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct ChannelFile {
    /// Channel name, such as `R` or `Y`.
    name: String,
    /// The object distances at which the channel was measured.
    planes: Vec<PlaneFile>,
}

/// One channel at one object distance.
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
    /// S1..S5 (px²) and S6..S10 (px³) for field positions in half frame widths from the axis; the
    /// optical PSF, before integration over pixels.
    s: [f64; 10],
    /// Standard errors of S1..S10, same units.
    s_sigma: [f64; 10],
    /// Where PSFs land, if known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    displacement: Option<DisplacementFile>,
    /// Tiles that took part in the fit.
    tiles_used: usize,
    /// Tiles that were rejected.
    tiles_rejected: usize,
}

/// Centroid less ideal position: X (magnification + distortion |X|²), X in half frame widths.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct DisplacementFile {
    /// Relative change of scale.
    magnification: f64,
    /// Distortion per squared half frame width.
    distortion: f64,
    /// Standard error of `magnification`.
    magnification_sigma: f64,
    /// Standard error of `distortion`.
    distortion_sigma: f64,
}

/// Where a profile came from.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct ProvenanceFile {
    /// Program and version that made the profile.
    program: String,
    /// Names of the observation sets it was fitted to.
    sources: Vec<String>,
    /// Settings of the fit, in words.
    settings: String,
}

/// Tells a key that is `null` (`Some(None)`) from one left out (`None`, by `default`).
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

/// The JSON schema of the format, pretty-printed.
pub fn schema() -> String {
    let schema = schemars::schema_for!(ProfileFile);
    serde_json::to_string_pretty(&schema).expect("a schema is plain JSON")
}

pub(super) fn read(text: &str) -> Result<LensProfile> {
    let not_json = |e: serde_json::Error| {
        Error::new(
            format!("line {} column {}", e.line(), e.column()),
            e.to_string(),
            "compare with the schema that `seidel lens schema` prints",
        )
    };
    // Format, version and kind first: a later version may have keys this one does not know.
    let any: serde_json::Value = serde_json::from_str(text).map_err(not_json)?;
    check_head(&any)?;
    let file: ProfileFile = serde_json::from_str(text).map_err(not_json)?;
    from_file(file)
}

fn check_head(any: &serde_json::Value) -> Result<()> {
    let text = |key: &str| any.get(key).map(ToString::to_string);
    let or_missing = |value: Option<String>| value.unwrap_or_else(|| "missing".to_owned());
    if any.get("format").and_then(|v| v.as_str()) != Some(FORMAT) {
        return Err(Error::new(
            "format",
            format!("is {}", or_missing(text("format"))),
            format!("give a lens profile, whose format is \"{FORMAT}\", as `seidel fit` writes it"),
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
    if any.get("kind").and_then(|v| v.as_str()) != Some("moments") {
        return Err(Error::new(
            "kind",
            format!("is {}", or_missing(text("kind"))),
            "this program reads the kind \"moments\"",
        ));
    }
    Ok(())
}

fn from_file(file: ProfileFile) -> Result<LensProfile> {
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
        },
        channels: file
            .channels
            .into_iter()
            .map(|channel| {
                Ok(MomentsChannel {
                    planes: channel
                        .planes
                        .into_iter()
                        .map(|plane| plane_from_file(&channel.name, plane))
                        .collect::<Result<_>>()?,
                    name: channel.name,
                })
            })
            .collect::<Result<_>>()?,
        provenance: Provenance {
            program: file.provenance.program,
            sources: file.provenance.sources,
            settings: file.provenance.settings,
        },
    };
    profile.check()?;
    Ok(profile)
}

fn plane_from_file(channel: &str, plane: PlaneFile) -> Result<MomentsPlane> {
    Ok(MomentsPlane {
        distance: distance("depth_m", plane.depth_m)
            .map_err(|e| e.within(&format!("channel {channel}")))?,
        s: MomentCoefficients(plane.s),
        s_sigma: plane.s_sigma,
        displacement: plane.displacement.map(|d| Displacement {
            magnification: d.magnification,
            distortion: d.distortion,
            magnification_sigma: d.magnification_sigma,
            distortion_sigma: d.distortion_sigma,
        }),
        tiles_used: plane.tiles_used,
        tiles_rejected: plane.tiles_rejected,
    })
}

pub(super) fn write(profile: &LensProfile) -> String {
    let axis = profile.frame.axis();
    let file = ProfileFile {
        format: FORMAT.to_owned(),
        version: VERSION,
        kind: Kind::Moments,
        image_size: [profile.frame.width_px(), profile.frame.height_px()],
        optical_axis: [axis.x_px, axis.y_px],
        pixel_pitch_um: profile.pixel_pitch_um,
        camera: CameraFile {
            focal_length_mm: profile.camera.focal_length_mm,
            f_number: profile.camera.f_number,
            focus_distance_m: optional_metres(profile.camera.focus_distance),
            wavelength_nm: profile.camera.wavelength_nm.clone(),
        },
        channels: profile
            .channels
            .iter()
            .map(|channel| ChannelFile {
                name: channel.name.clone(),
                planes: channel.planes.iter().map(plane_to_file).collect(),
            })
            .collect(),
        provenance: ProvenanceFile {
            program: profile.provenance.program.clone(),
            sources: profile.provenance.sources.clone(),
            settings: profile.provenance.settings.clone(),
        },
    };
    let mut text = serde_json::to_string_pretty(&file).expect("a profile is plain JSON");
    text.push('\n');
    text
}

fn plane_to_file(plane: &MomentsPlane) -> PlaneFile {
    PlaneFile {
        depth_m: optional_metres(plane.distance),
        s: plane.s.0,
        s_sigma: plane.s_sigma,
        displacement: plane.displacement.map(|d| DisplacementFile {
            magnification: d.magnification,
            distortion: d.distortion,
            magnification_sigma: d.magnification_sigma,
            distortion_sigma: d.distortion_sigma,
        }),
        tiles_used: plane.tiles_used,
        tiles_rejected: plane.tiles_rejected,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn profile() -> LensProfile {
        let plane = |distance, s1| MomentsPlane {
            distance,
            s: MomentCoefficients([s1, 0.5, -0.25, 0.1, 0.2, 0.0, 0.3, 0.4, -0.5, 0.6]),
            s_sigma: [0.01; 10],
            displacement: Some(Displacement {
                magnification: 1e-3,
                distortion: -2e-3,
                magnification_sigma: 1e-5,
                distortion_sigma: 1e-5,
            }),
            tiles_used: 99,
            tiles_rejected: 1,
        };
        LensProfile {
            frame: Frame::new(1920, 1080, None).expect("valid"),
            pixel_pitch_um: Some(4.0),
            camera: Camera {
                focus_distance: ObjectDistance::Infinity,
                ..Camera::default()
            },
            channels: vec![MomentsChannel {
                name: "G".into(),
                planes: vec![
                    plane(ObjectDistance::Infinity, 3.0),
                    plane(ObjectDistance::Metres(2.5), 7.0),
                ],
            }],
            provenance: Provenance {
                program: "seidel 0.1.0".into(),
                sources: vec!["set".into()],
                settings: "moments".into(),
            },
        }
    }

    #[test]
    fn profiles_survive_the_round_trip() {
        let profile = profile();
        assert_eq!(
            LensProfile::from_json(&profile.to_json()),
            Ok(profile.clone())
        );
        let mut unknown = profile;
        unknown.camera.focus_distance = ObjectDistance::Unknown;
        unknown.channels[0].planes.truncate(1);
        unknown.channels[0].planes[0].distance = ObjectDistance::Unknown;
        let text = unknown.to_json();
        assert!(!text.contains("depth_m"), "unknown distances are left out");
        assert_eq!(LensProfile::from_json(&text), Ok(unknown));
    }

    #[test]
    fn damaged_profiles_are_refused_with_the_place() {
        let good = profile().to_json();
        for (from, to, place) in [
            ("seidel-lens", "other", "format"),
            ("\"version\": 1", "\"version\": 2", "version"),
            ("\"kind\": \"moments\"", "\"kind\": \"reduced\"", "kind"),
            ("\"tiles_used\"", "\"tiles\"", "line"),
            (
                "\"image_size\": [\n    1920",
                "\"image_size\": [\n    0",
                "image_size",
            ),
            ("\"depth_m\": 2.5", "\"depth_m\": -2.5", "depth_m"),
            ("\"depth_m\": 2.5", "\"depth_m\": null", "channel G"),
            (
                "\"pixel_pitch_um\": 4.0",
                "\"pixel_pitch_um\": 0.0",
                "pixel_pitch_um",
            ),
            ("3.0", "1e999", "line"),
        ] {
            let bad = good.replacen(from, to, 1);
            assert_ne!(bad, good, "{from} stands in the text");
            let error = LensProfile::from_json(&bad).expect_err(to);
            assert!(error.to_string().contains(place), "{error}");
        }
        let unknown_key = LensProfile::from_json(&good.replacen("\"tiles_used\"", "\"tiles\"", 1))
            .expect_err("an unknown key");
        assert!(unknown_key.problem.contains("tiles"), "{unknown_key}");
    }

    #[test]
    fn the_schema_names_every_key() {
        let schema = schema();
        for key in [
            "depth_m",
            "s_sigma",
            "optical_axis",
            "provenance",
            "distortion",
        ] {
            assert!(schema.contains(key), "{key}");
        }
    }

    proptest! {
        #[test]
        fn damaged_text_never_panics(cut in 0usize..2000, byte in any::<u8>(), at in 0usize..2000) {
            let mut bytes = profile().to_json().into_bytes();
            let at = at % bytes.len();
            bytes[at] = byte;
            bytes.truncate(bytes.len().saturating_sub(cut));
            if let Ok(text) = String::from_utf8(bytes) {
                let _ = LensProfile::from_json(&text);
            }
        }
    }
}
