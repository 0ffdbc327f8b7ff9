//! The keys of a manifest that describe the set as a whole.

use std::collections::BTreeMap;

use seidel_optics::camera::Camera;
use seidel_optics::error::Fault;
use seidel_optics::field::{Frame, ImagePoint};
use seidel_optics::mosaic::Mosaic;
use serde_json::{Map, Value};

use super::fields::Fields;
use super::{FORMAT, MOSAIC_VERSION, VERSION};

const SET_KEYS: [&str; 9] = [
    "format",
    "version",
    "image_size",
    "optical_axis",
    "pixel_pitch_um",
    "channels",
    "camera",
    "mosaic",
    "observations",
];

const CAMERA_KEYS: [&str; 5] = [
    "focal_length_mm",
    "f_number",
    "focus_distance_m",
    "wavelength_nm",
    "squeeze",
];

/// The entry of the set as a whole.
pub(super) struct SetEntry<'a> {
    pub(super) frame: Frame,
    pub(super) axis_stated: bool,
    pub(super) pixel_pitch_um: Option<f64>,
    pub(super) channels: Vec<String>,
    pub(super) camera: Camera,
    pub(super) mosaic: Option<Mosaic>,
    pub(super) observations: &'a [Value],
}

/// Reads the keys of the set; `None` if a fault prevents reading the observations.
pub(super) fn read<'a>(root: &'a Value, faults: &mut Vec<Fault>) -> Option<SetEntry<'a>> {
    let mut fields = Fields::of_value(root, None, "manifest", faults)?;
    // A file of another format or version has other keys, so only this fault is reported.
    fields.required("format", &format!("\"{FORMAT}\""))?;
    let remedy = format!("give a PSF observation set, whose format is \"{FORMAT}\"");
    fields.parsed("format", &remedy, |value| {
        value.as_str().filter(|name| *name == FORMAT)
    })?;
    fields.required("version", &VERSION.to_string())?;
    let remedy = format!(
        "only versions {VERSION} and {MOSAIC_VERSION} are read; write the set in one of them"
    );
    let is_known = |version: &u64| [VERSION, MOSAIC_VERSION].contains(version);
    let version = fields.parsed("version", &remedy, |value| value.as_u64().filter(is_known))?;
    fields.check_keys(&SET_KEYS);
    let mosaic = mosaic(&mut fields, version == MOSAIC_VERSION);
    let size = image_size(&mut fields);
    let axis = optical_axis(&mut fields);
    let axis_stated = fields.get("optical_axis").is_some();
    let pixel_pitch_um = fields.positive("pixel_pitch_um", "the pixel pitch in micrometres");
    let channels = fields.required_parsed(
        "channels",
        "a list of image channel names, such as [\"R\", \"G\", \"B\"] or [\"Y\"]",
        |value| {
            let name = |v: &Value| Some(v.as_str().filter(|n| !n.is_empty())?.to_owned());
            value.as_array()?.iter().map(name).collect()
        },
    );
    let observations =
        fields.required_parsed("observations", "a list of observations", Value::as_array);
    let frame = size.and_then(|(width, height)| {
        Frame::new(width, height, axis)
            .map_err(|error| fields.fault(&error.place, error.problem, error.remedy))
            .ok()
    });
    let remedy = "give an object, or leave it out";
    let camera = match fields.parsed("camera", remedy, Value::as_object) {
        Some(object) => camera(fields.inside(object, "camera.")),
        None => Camera::default(),
    };
    Some(SetEntry {
        frame: frame?,
        axis_stated,
        pixel_pitch_um,
        channels: channels?,
        camera,
        mosaic,
        observations: observations?,
    })
}

/// Reads the mosaic, which sets of [`MOSAIC_VERSION`] have and no others.
fn mosaic(fields: &mut Fields<'_, '_>, is_needed: bool) -> Option<Mosaic> {
    const WHAT: &str = "the colours of the frame's top-left 2 x 2 pixels, such as \"RGGB\"";
    if is_needed {
        fields.required("mosaic", WHAT)?;
    } else {
        fields.get("mosaic")?;
        let problem = format!("is not a key of version {VERSION}");
        let remedy = format!("write the set as version {MOSAIC_VERSION}, or leave the key out");
        fields.fault("mosaic", problem, remedy);
    }
    fields.parsed("mosaic", &format!("give {WHAT}"), |value| {
        Mosaic::parse(value.as_str()?).ok()
    })
}

fn image_size(fields: &mut Fields<'_, '_>) -> Option<(u32, u32)> {
    const WHAT: &str = "[width, height] of the full frame in whole pixels";
    let value = fields.required("image_size", WHAT)?;
    let pixels = |value: &Value| {
        let number = value.as_f64()?;
        let whole = number.fract() == 0.0 && (1.0..=f64::from(u32::MAX)).contains(&number);
        whole.then_some(number as u32)
    };
    let pair = match value.as_array().map(Vec::as_slice) {
        Some([width, height]) => pixels(width).zip(pixels(height)),
        _ => None,
    };
    if pair.is_none() {
        fields.fault("image_size", format!("is {value}"), format!("give {WHAT}"));
    }
    pair
}

fn optical_axis(fields: &mut Fields<'_, '_>) -> Option<ImagePoint> {
    const REMEDY: &str = "give [x, y] in frame pixels, or leave it out for the frame's centre";
    let [x, y]: &[Value; 2] = fields.parsed("optical_axis", REMEDY, |value| {
        value.as_array()?.as_slice().try_into().ok()
    })?;
    let x = fields.number_of("optical_axis", x, REMEDY);
    let y = fields.number_of("optical_axis", y, REMEDY);
    Some(ImagePoint::new(x?, y?))
}

fn camera(mut fields: Fields<'_, '_>) -> Camera {
    fields.check_keys(&CAMERA_KEYS);
    Camera {
        focal_length_mm: fields.positive("focal_length_mm", "millimetres"),
        f_number: fields.positive("f_number", "a number"),
        focus_distance: fields.distance("focus_distance_m"),
        squeeze: fields.positive("squeeze", "a number"),
        wavelength_nm: wavelengths(&mut fields).unwrap_or_default(),
    }
}

/// Reads the wavelengths by channel, nm.
fn wavelengths(fields: &mut Fields<'_, '_>) -> Option<BTreeMap<String, f64>> {
    const REMEDY: &str = "give an object of nanometres by channel, or leave it out";
    let by_channel: &Map<String, Value> =
        fields.parsed("wavelength_nm", REMEDY, Value::as_object)?;
    let mut fields = fields.inside(by_channel, "camera.wavelength_nm.");
    let wavelength = |name: &String| Some((name.clone(), fields.positive(name, "nanometres")?));
    Some(by_channel.keys().filter_map(wavelength).collect())
}
