//! Validation of lens profiles beyond the keys of the file.

use super::{HeldOut, LensDescription, LensProfile, MomentsChannel, ProfileEffect, PupilChannel};
use crate::distance::ObjectDistance;
use crate::effects;
use crate::error::{Error, Result};
use crate::lens::VergenceSeries;

/// Largest variance of the symmetric blur of a lens. Real ones are below 10 px²; a PSF of this one takes 10 MB.
const MAX_BLUR_VARIANCE_PX2: f64 = 1e4;

/// Largest distance off the chief ray that a ray through the rim of the pupil may land, px, at the edge of the frame. Frames are
/// smaller.
const MAX_RAY_PX: f64 = 1e5;

impl LensProfile {
    /// Checks the conditions that involve more than one key.
    pub(super) fn check(&self) -> Result<()> {
        names(&self.channel_names())?;
        self.camera.check_wavelengths(&self.channel_names())?;
        match &self.description {
            LensDescription::Moments(channels) => {
                for (index, channel) in channels.iter().enumerate() {
                    moments(channel).map_err(|e| e.within(&place(index, &channel.name)))?;
                }
                self.depth_laws()?;
            }
            LensDescription::Pupil(channels) => {
                for (index, channel) in channels.iter().enumerate() {
                    pupil(channel).map_err(|e| e.within(&place(index, &channel.name)))?;
                }
            }
        }
        self.held_out.as_ref().map_or(Ok(()), held_out)
    }
}

fn place(index: usize, name: &str) -> String {
    format!("channels[{index}] ({name})")
}

fn names(names: &[&str]) -> Result<()> {
    if names.is_empty() {
        return Err(Error::new(
            "channels",
            "is empty",
            "a lens has at least one channel",
        ));
    }
    for (index, name) in names.iter().enumerate() {
        if names[..index].contains(name) {
            return Err(Error::new(
                place(index, name),
                "occurs twice",
                "name every channel once",
            ));
        }
    }
    Ok(())
}

fn moments(channel: &MomentsChannel) -> Result<()> {
    if channel.planes.is_empty() {
        return Err(Error::new(
            "planes",
            "is empty",
            "a channel has at least one object distance",
        ));
    }
    let mut distances = channel.planes.iter().map(|p| p.distance);
    if channel.planes.len() > 1 && distances.any(|d| d == ObjectDistance::Unknown) {
        return Err(Error::new(
            "planes",
            "mixes known and unknown object distances",
            "give depth_m for every plane, or keep one plane without it",
        ));
    }
    for (number, plane) in channel.planes.iter().enumerate() {
        let moved = plane
            .displacement
            .map_or([0.0; 2], |d| [d.magnification, d.distortion]);
        let all = plane.s.0.iter().chain(&plane.s_sigma).chain(&moved);
        finite(all).map_err(|e| e.within(&format!("planes[{number}]")))?;
    }
    Ok(())
}

fn pupil(channel: &PupilChannel) -> Result<()> {
    let (low, high) = channel.measured_vergence;
    if !(low.is_finite() && high.is_finite() && 0.0 <= low && low <= high) {
        return Err(Error::new(
            "measured_vergence_per_m",
            format!("is [{low}, {high}]"),
            "give the least and the largest 1/distance that were measured, in 1/m, 0 for infinity",
        ));
    }
    for (name, values) in channel.series() {
        series(values).map_err(|e| e.within(name))?;
    }
    blur_variance(channel).map_err(|e| e.within("blur_variance_px2"))?;
    rays(channel)?;
    let order = |carried: &ProfileEffect| effects::acting_position(carried.effect);
    for (list, name) in [
        (&channel.effects, "effects"),
        (&channel.added, "added_effects"),
    ] {
        for pair in list.windows(2) {
            if order(&pair[0]) >= order(&pair[1]) {
                let all: Vec<_> = effects::ALL.iter().map(|e| e.id()).collect();
                return Err(Error::new(
                    name,
                    format!(
                        "has `{}` before `{}`",
                        pair[0].effect.id(),
                        pair[1].effect.id()
                    ),
                    format!("give every effect once, in this order: {}", all.join(", ")),
                ));
            }
        }
    }
    let mut unique = (channel.effects.iter()).filter(|c| c.effect.description().is_unique);
    let twice = unique.find(|own| channel.added.iter().any(|c| order(c) == order(own)));
    if let Some(twice) = twice {
        return Err(Error::new(
            "added_effects",
            format!("has `{}`, which `effects` has as well", twice.effect.id()),
            "give it in one of them",
        ));
    }
    for carried in channel.effects.iter().chain(&channel.added) {
        effect(carried, channel.measured_vergence)
            .map_err(|e| e.within(&format!("effect `{}`", carried.effect.id())))?;
    }
    Ok(())
}

/// Checks that the symmetric blur can be drawn: the memory of a PSF grows with its variance.
fn blur_variance(channel: &PupilChannel) -> Result<()> {
    for v in checked_vergences(channel.measured_vergence) {
        let variance = channel.blur_variance_px2.at(v);
        if variance > MAX_BLUR_VARIANCE_PX2 {
            return Err(Error::new(
                "coefficients",
                format!("give a variance of {variance} px² at vergence {v} 1/m"),
                format!("keep it up to {MAX_BLUR_VARIANCE_PX2} px², or fit the lens again"),
            ));
        }
    }
    Ok(())
}

/// Checks that rays land near the frame: sums of larger numbers lose the frame in rounding.
fn rays(channel: &PupilChannel) -> Result<()> {
    let of_rays = ["alpha", "beta", "gamma", "delta", "phi"];
    for (name, values) in channel.series() {
        if !of_rays.contains(&name) {
            continue;
        }
        for v in checked_vergences(channel.measured_vergence) {
            let value = values.at(v);
            if value.abs() > MAX_RAY_PX {
                let error = Error::new(
                    "coefficients",
                    format!("give {value} px at vergence {v} 1/m"),
                    format!("keep it from -{MAX_RAY_PX} to {MAX_RAY_PX} px, or fit the lens again"),
                );
                return Err(error.within(name));
            }
        }
    }
    Ok(())
}

/// Returns the vergences at which a series is checked, over the measured range.
fn checked_vergences(measured: (f64, f64)) -> impl Iterator<Item = f64> {
    const STEPS: usize = 8;
    let (low, high) = measured;
    (0..=STEPS).map(move |step| low + (high - low) * step as f64 / STEPS as f64)
}

fn effect(carried: &ProfileEffect, measured_vergence: (f64, f64)) -> Result<()> {
    let parameters = carried.effect.parameters();
    if parameters.len() != carried.values.len() {
        return Err(Error::new(
            "parameters",
            format!("has {} of {}", carried.values.len(), parameters.len()),
            "give every parameter",
        ));
    }
    for (parameter, values) in parameters.iter().zip(&carried.values) {
        series(values).map_err(|e| e.within(parameter.name))?;
        // A fit that ended at a limit may exceed it by rounding.
        let slack = 1e-9 * (parameter.most - parameter.least);
        for v in checked_vergences(measured_vergence) {
            let value = values.at(v);
            if !(parameter.least - slack..=parameter.most + slack).contains(&value) {
                return Err(Error::new(
                    parameter.name,
                    format!("is {value} {} at vergence {v} 1/m", parameter.unit),
                    format!(
                        "keep it from {} to {} over the measured range",
                        parameter.least, parameter.most
                    ),
                ));
            }
        }
    }
    Ok(())
}

fn series(values: &VergenceSeries) -> Result<()> {
    let (count, errors) = (values.coefficients.len(), values.sigma.len());
    if count == 0 {
        return Err(Error::new(
            "coefficients",
            "is empty",
            "give at least the value at infinity",
        ));
    }
    if errors != count {
        return Err(Error::new(
            "sigma",
            format!("has {errors} standard errors for {count} coefficients"),
            "give one each, 0 where nothing is known",
        ));
    }
    finite(values.coefficients.iter().chain(&values.sigma))?;
    let remainders = &values.remainders;
    finite(remainders.iter().flat_map(|(v, r)| [v, r]))?;
    if remainders
        .iter()
        .zip(remainders.iter().skip(1))
        .any(|(a, b)| a.0 >= b.0)
    {
        return Err(Error::new(
            "remainders",
            "are not sorted by increasing vergence",
            "sort them and give one a vergence",
        ));
    }
    match values.sigma.iter().find(|s| **s < 0.0) {
        Some(negative) => Err(Error::new(
            "sigma",
            format!("holds {negative}"),
            "a standard error is not negative",
        )),
        None => Ok(()),
    }
}

fn held_out(held_out: &HeldOut) -> Result<()> {
    let of_groups = held_out.groups.iter().flat_map(|g| {
        let scores = [g.snr_db, g.pixel_gap];
        scores.into_iter().chain(g.misplaced_light)
    });
    let of_adequacy = held_out.adequacy.iter().flat_map(|a| {
        let gaps = [a.noise_gap, a.excess_gap, a.systematic_gap];
        gaps.into_iter()
            .chain([a.worst.excess_gap, a.pattern.share])
            .chain(a.worst.elsewhere_gap)
    });
    let all: Vec<f64> = of_groups
        .chain([held_out.snr_db, held_out.pixel_gap])
        .chain(held_out.misplaced_light)
        .chain(held_out.neighbours_snr_db)
        .chain(of_adequacy)
        .collect();
    finite(&all).map_err(|e| e.within("held_out"))
}

fn finite<'a>(values: impl IntoIterator<Item = &'a f64>) -> Result<()> {
    match values.into_iter().find(|v| !v.is_finite()) {
        Some(bad) => Err(Error::new(
            "a number",
            format!("is {bad}"),
            "fit the lens again",
        )),
        None => Ok(()),
    }
}
