//! The camera that took the photographs: what the user states, and what the files state otherwise.

use std::path::{Path, PathBuf};

use clap::Args;
use seidel_core::profile::LensDescription;
use seidel_core::{LensProfile, ObjectDistance};
use seidel_image_io::photograph::{StatedCamera, stated_camera};
use seidel_optics::camera::Camera;

use super::by_option;
use crate::commands::{CommandError, parse_distance};
use crate::pictures::significant;

/// Options about the camera, which go into the set and the lens profile.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Camera")]
pub(in crate::commands) struct CameraArgs {
    /// Focal length in millimetres; as the photograph states it if omitted, as all options about the camera
    #[arg(long, alias = "focal-mm", value_name = "MM")]
    focal_length_mm: Option<f64>,
    /// f-number
    #[arg(long, value_name = "N")]
    f_number: Option<f64>,
    /// Distance in focus in metres from the entrance pupil, or `inf`
    #[arg(long, alias = "focus-m", value_name = "METRES", value_parser = parse_distance)]
    focus_distance: Option<ObjectDistance>,
    /// Pixel pitch of the sensor in micrometres
    #[arg(long, value_name = "P")]
    pitch_um: Option<f64>,
    /// Width of a pixel over its height in the scene: 2 for footage of a 2x anamorphic lens before it is desqueezed
    #[arg(long, value_name = "RATIO")]
    pixel_aspect: Option<f64>,
}

/// The known camera of a set of photographs.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct CameraData {
    pub(super) camera: Camera,
    pub(super) pixel_pitch_um: Option<f64>,
}

/// Difference of focal lengths and f-numbers of photographs of one setting, relative: files round them.
const SAME_SETTING: f64 = 0.02;

impl CameraArgs {
    /// Checks the ranges of the options.
    fn check(&self) -> Result<(), CommandError> {
        let values = [
            ("focal_length_mm", self.focal_length_mm, 0.5..=5000.0),
            ("f_number", self.f_number, 0.5..=256.0),
            ("pitch_um", self.pitch_um, 0.2..=100.0),
            ("pixel_aspect", self.pixel_aspect, 0.25..=4.0),
        ];
        for (name, value, range) in values {
            if let Some(value) = value.filter(|v| !range.contains(v)) {
                return Err(by_option(seidel_core::Error::new(
                    name,
                    format!("is {value}"),
                    format!("give {} to {}", range.start(), range.end()),
                )));
            }
        }
        Ok(())
    }

    /// Returns the camera of the photographs at `paths`, of `width` pixels.
    ///
    /// # Errors
    /// Options out of range; a file that cannot be read; photographs that state different focal lengths or f-numbers.
    pub(super) fn of(&self, paths: &[PathBuf], width: usize) -> Result<CameraData, CommandError> {
        self.check()?;
        let stated = self.stated(paths, width)?;
        let first = stated.first().cloned().unwrap_or_default();
        let of_file = first.focus_m.and_then(|m| ObjectDistance::metres(m).ok());
        let focus = self.focus_distance.or(of_file);
        Ok(CameraData {
            camera: Camera {
                focal_length_mm: self.focal_length_mm.or(first.focal_length_mm),
                f_number: self.f_number.or(first.f_number),
                focus_distance: focus.unwrap_or(ObjectDistance::Unknown),
                squeeze: self.pixel_aspect,
                lens_model: first.lens_model,
                lens_serial_number: first.lens_serial_number,
                ..Camera::default()
            },
            pixel_pitch_um: self.pitch_um.or(first.pixel_pitch_um),
        })
    }

    /// Returns what each file states, where no option overrides it.
    fn stated(&self, paths: &[PathBuf], width: usize) -> Result<Vec<StatedCamera>, CommandError> {
        let each = paths.iter().map(|path| stated_camera(path, width));
        let stated: Vec<StatedCamera> = each.collect::<Result<_, _>>()?;
        let focal_lengths: Vec<_> = stated.iter().map(|s| s.focal_length_mm).collect();
        let f_numbers: Vec<_> = stated.iter().map(|s| s.f_number).collect();
        for (option, is_given, values) in [
            (
                "focal-length-mm",
                self.focal_length_mm.is_some(),
                focal_lengths,
            ),
            ("f-number", self.f_number.is_some(), f_numbers),
        ] {
            let known = paths.iter().zip(values);
            let mut known = known.filter_map(|(path, value)| Some((path, value?)));
            let Some((first, expected)) = known.next().filter(|_| !is_given) else {
                continue;
            };
            if let Some((other, found)) =
                known.find(|(_, found)| (found / expected - 1.0).abs() > SAME_SETTING)
            {
                return Err(CommandError::Usage(format!(
                    "{} states --{option} {found}, {} states {expected}: measure photographs of one lens at one setting together, or give --{option}",
                    other.display(),
                    first.display()
                )));
            }
        }
        Ok(stated)
    }

    /// Returns in words what is taken from the metadata of the first photograph, at `path`; `None` for nothing.
    pub(super) fn remark(&self, path: &Path, data: &CameraData) -> Option<String> {
        let camera = &data.camera;
        let number = |value: f64| significant(value, 4);
        let taken = [
            (
                self.focal_length_mm.is_none(),
                camera.focal_length_mm.map(|f| format!("{} mm", number(f))),
            ),
            (
                self.f_number.is_none(),
                camera.f_number.map(|n| format!("f/{}", number(n))),
            ),
            (
                self.focus_distance.is_none(),
                camera
                    .focus_distance
                    .vergence_per_m()
                    .map(|_| format!("focus at {}", camera.focus_distance)),
            ),
            (
                self.pitch_um.is_none(),
                data.pixel_pitch_um
                    .map(|p| format!("pixels of {} µm", number(p))),
            ),
            (true, camera.lens_model.clone()),
        ];
        let taken = taken.into_iter().filter(|(is_free, _)| *is_free);
        let taken: Vec<String> = taken.filter_map(|(_, text)| text).collect();
        (!taken.is_empty()).then(|| {
            format!(
                "{}: its metadata state {}, which go into the lens profile; options such as --f-number override them",
                path.display(),
                taken.join(", ")
            )
        })
    }
}

impl CameraData {
    /// Puts what is known into a camera and its pixel pitch, which keep the rest.
    pub(super) fn fill(self, camera: &mut Camera, pixel_pitch_um: &mut Option<f64>) {
        let known = self.camera;
        *pixel_pitch_um = self.pixel_pitch_um.or(*pixel_pitch_um);
        camera.focal_length_mm = known.focal_length_mm.or(camera.focal_length_mm);
        camera.f_number = known.f_number.or(camera.f_number);
        if known.focus_distance != ObjectDistance::Unknown {
            camera.focus_distance = known.focus_distance;
        }
        camera.squeeze = known.squeeze.or(camera.squeeze);
        camera.lens_model = known.lens_model.or(camera.lens_model.take());
        camera.lens_serial_number = known
            .lens_serial_number
            .or(camera.lens_serial_number.take());
    }
}

/// Factor between the defocus that the camera's data give and the measured one that calls for a look at the data, and the least
/// defocus in px at which it is compared.
const MAX_FACTOR: f64 = 1.5;
const LEAST_DEFOCUS_PX: f64 = 2.0;

/// Gives a lens that was measured at `distance` alone the change of defocus with distance of a thin lens, and says so. Leaves
/// others, and those of an incomplete camera, as they are; for these returns what is missing.
///
/// The radius of the disc of a point at vergence v is `R s (v - v0)`, with the radius R of the pupil, the distance s from the
/// pupil to the sensor and the vergence v0 in focus. The measured defocus stays.
pub(super) fn extend_one_distance(
    lens: &mut LensProfile,
    distance: ObjectDistance,
) -> Option<String> {
    let at = distance.vergence_per_m()?;
    let camera = &lens.camera;
    let missing: Vec<&str> = [
        ("--focal-length-mm", camera.focal_length_mm.is_none()),
        ("--f-number", camera.f_number.is_none()),
        (
            "--focus-distance",
            camera.focus_distance.vergence_per_m().is_none(),
        ),
        ("--pitch-um", lens.pixel_pitch_um.is_none()),
    ]
    .into_iter()
    .filter_map(|(option, is_missing)| is_missing.then_some(option))
    .collect();
    if !missing.is_empty() {
        return Some(format!(
            "the lens is that of {distance} alone: its blur is the same at all distances, and its focus cannot be set. Give {}, or photograph at two distances",
            missing.join(", ")
        ));
    }
    let (focal_mm, f_number) = (camera.focal_length_mm?, camera.f_number?);
    let focus = camera.focus_distance.vergence_per_m()?;
    let focal_m = focal_mm * 1e-3;
    let image_m = focal_m / (1.0 - focal_m * focus);
    let slope = focal_m / (2.0 * f_number) * image_m / (lens.pixel_pitch_um? * 1e-6);
    if !(slope.is_finite() && slope > 0.0) {
        return Some(format!(
            "--focus-distance lies within the focal length of {focal_mm} mm: the change of blur with distance is not known"
        ));
    }
    let expected = slope * (at - focus);
    let LensDescription::Pupil(channels) = &mut lens.description else {
        return None;
    };
    let measured = channels.iter().map(|c| c.alpha.at(at)).sum::<f64>() / channels.len() as f64;
    // A fit may find the pupil inverted, which gives the same PSFs.
    let sign = if measured * expected < 0.0 { -1.0 } else { 1.0 };
    for channel in channels {
        let alpha = &mut channel.alpha;
        if alpha.degree() > 0 {
            return None;
        }
        alpha.coefficients[0] -= sign * slope * at;
        alpha.coefficients.push(sign * slope);
        alpha.sigma.push(0.0);
    }
    let law = format!("a thin lens of {focal_mm} mm and f/{f_number}");
    lens.provenance
        .settings
        .push_str(&format!("; defocus beyond {distance} by {law}"));
    let (measured, expected) = (measured.abs(), expected.abs());
    let factor = (measured / expected).max(expected / measured);
    if measured.max(expected) > LEAST_DEFOCUS_PX && factor > MAX_FACTOR {
        return Some(format!(
            "the camera's data give a blur of {:.1} px in diameter at {distance}, the photographs show {:.1}: check --focal-length-mm, --f-number, --focus-distance, --pitch-um and --distance. Blur at other distances is that of {law}",
            2.0 * expected,
            2.0 * measured
        ));
    }
    Some(format!(
        "photographs of one distance: the lens is measured at {distance}; blur at other distances is that of {law}. A second distance measures it"
    ))
}

#[cfg(test)]
mod tests;
