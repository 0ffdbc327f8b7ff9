//! Lens profiles of designs: the thin lens law for defocus, and the aberrations of the design.

use seidel_core::Camera;
use seidel_core::profile::{LensDescription, ProfileEffect, Provenance, PupilChannel};
use seidel_optics::distance::ObjectDistance;
use seidel_optics::effects::{self, Effect};
use seidel_optics::field::{FieldPoint, Frame};
use seidel_optics::lens::VergenceSeries;
use seidel_optics::profile::LensProfile;
use seidel_optics::sharpest_vergence;

use super::designs::Design;

/// Channels and their wavelengths, nm.
const CHANNELS: [(&str, f64); 3] = [("R", 620.0), ("G", 540.0), ("B", 460.0)];

/// Returns the profile of `design`.
///
/// # Errors
/// An effect or a parameter that does not exist, and values that no profile may have.
pub(super) fn profile(design: &Design) -> Result<LensProfile, String> {
    let in_design = |problem: String| format!("{}: {problem}", design.name);
    let frame = Frame::new(design.frame_px[0], design.frame_px[1], None)
        .map_err(|e| in_design(e.to_string()))?;
    let channels: Result<Vec<PupilChannel>, String> =
        (0..CHANNELS.len()).map(|k| channel(design, k)).collect();
    let mut channels = channels.map_err(in_design)?;
    focus_sharpest(&mut channels, 1.0 / design.focus_m)
        .ok_or_else(|| in_design("is sharpest nowhere".to_owned()))?;
    let profile = LensProfile {
        frame,
        pixel_pitch_um: Some(design.pitch_um()),
        camera: Camera {
            focal_length_mm: Some(design.focal_mm),
            f_number: Some(design.f_number),
            focus_distance: ObjectDistance::Metres(design.focus_m),
            wavelength_nm: CHANNELS.map(|(name, wave)| (name.to_owned(), wave)).into(),
            squeeze: design.squeeze,
            ..Camera::default()
        },
        description: LensDescription::Pupil(channels),
        held_out: None,
        provenance: Provenance {
            // No version: the files change when a design does.
            program: "cargo xtask library".to_owned(),
            sources: vec![format!("lens library, {}", design.name)],
            settings: "designed, not measured".to_owned(),
            ..Provenance::default()
        },
    };
    // The checks of files.
    LensProfile::from_json(&profile.to_json()).map_err(|e| in_design(e.to_string()))
}

/// Moves the sensor so that the sharpest plane of the axis is at vergence `focus`, 1/m: aberrations of the design put it beside the
/// paraxial focus.
fn focus_sharpest(channels: &mut [PupilChannel], focus: f64) -> Option<()> {
    let axis = FieldPoint::new(0.0, 0.0);
    for _ in 0..10 {
        let variance = |v: f64| -> f64 {
            let all = channels.iter().map(|c| c.moments_at(axis, v).trace());
            all.sum()
        };
        let off = sharpest_vergence(variance)? - focus;
        for channel in &mut *channels {
            channel.alpha.coefficients[0] += channel.alpha.slope(focus) * off;
        }
    }
    Some(())
}

impl Design {
    /// Returns the pixel pitch of the frame, micrometres.
    fn pitch_um(&self) -> f64 {
        self.sensor_mm[0] * 1e3 / f64::from(self.frame_px[0])
    }

    /// Returns the radius of the disc of a point on the axis, frame pixels per 1/m of vergence: the shift of the image, times
    /// the radius of the pupil over the image distance.
    fn defocus_px_m(&self) -> f64 {
        let focal_m = self.focal_mm * 1e-3;
        let image_m = focal_m / (1.0 - focal_m / self.focus_m);
        image_m * focal_m / (2.0 * self.f_number) / (self.pitch_um() * 1e-6)
    }

    /// Returns the pupil radius over the slope of the chief ray at the edge of the frame, m.
    fn stop_lever_m(&self) -> f64 {
        let focal_m = self.focal_mm * 1e-3;
        let slope = self.sensor_mm[0] * 1e-3 / 2.0 / focal_m;
        focal_m / (2.0 * self.f_number) / slope
    }
}

fn channel(design: &Design, k: usize) -> Result<PupilChannel, String> {
    let constant = VergenceSeries::constant;
    let (name, wavelength_nm) = CHANNELS[k];
    let slope = design.defocus_px_m();
    // The mean of the channels has its paraxial focus at the focused distance.
    let mean = design.axial.iter().sum::<f64>() / design.axial.len() as f64;
    let at_infinity = design.axial[k] - mean - slope / design.focus_m;
    let mut carried: Vec<ProfileEffect> = Vec::new();
    for own in effects::ALL {
        let values = design.effects.iter().find(|(id, _)| *id == own.id());
        let two_planes = (design.squeeze).filter(|_| own.id() == effects::DoublePlane.id());
        if values.is_some() || two_planes.is_some() {
            let parameters = values.map_or(&[][..], |(_, parameters)| parameters);
            let along_x = two_planes.map(|squeeze| {
                // Cylinders in front divide the focal length and the pupil along x by the squeeze.
                let less = slope * (1.0 / (squeeze * squeeze) - 1.0);
                VergenceSeries::new(vec![-less / design.focus_m, less])
            });
            carried.push(ProfileEffect {
                effect: *own,
                values: series(*own, parameters, along_x)?,
            });
        }
    }
    let unknown = |(id, _): &&(&str, _)| !effects::ALL.iter().any(|own| own.id() == *id);
    if let Some((id, _)) = design.effects.iter().find(unknown) {
        return Err(format!("there is no effect {id}"));
    }
    Ok(PupilChannel {
        name: name.to_owned(),
        alpha: VergenceSeries::new(vec![at_infinity, slope]),
        beta: constant(design.beta[k]),
        gamma: constant(design.gamma),
        delta: constant(design.delta),
        phi: constant(design.coma[k]),
        blur_variance_px2: constant(design.blur_variance_px2),
        effects: carried,
        added: Vec::new(),
        picture: None,
        magnification: constant(design.lateral[k]),
        distortion: constant(design.distortion),
        stop_lever_m: design.stop_lever_m(),
        wavelength_px: wavelength_nm * 1e-3 / design.pitch_um(),
        measured_vergence: (0.0, 1.0 / design.nearest_m),
    })
}

/// Returns the series of all parameters of `effect`: the given ones, and for an anamorphic lens the difference of defocus
/// between its sections.
fn series(
    effect: &dyn effects::Effect,
    given: &[(&str, f64)],
    defocus_along_x: Option<VergenceSeries>,
) -> Result<Vec<VergenceSeries>, String> {
    let parameters = effect.parameters();
    let unknown = |(name, _): &&(&str, f64)| !parameters.iter().any(|own| own.name == *name);
    if let Some((name, _)) = given.iter().find(unknown) {
        return Err(format!("{} has no parameter {name}", effect.id()));
    }
    let values = parameters.iter().map(|parameter| {
        let value = given.iter().find(|(name, _)| *name == parameter.name);
        match (&defocus_along_x, value) {
            (Some(series), None) if parameter.name == "w2000" => series.clone(),
            (_, Some((_, value))) => VergenceSeries::constant(*value),
            (_, None) => VergenceSeries::constant(parameter.neutral),
        }
    });
    Ok(values.collect())
}
