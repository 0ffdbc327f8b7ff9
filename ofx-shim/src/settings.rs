//! Knobs as settings of the library.

use seidel_c::{SEIDEL_ALPHA_UNPREMULTIPLIED, SEIDEL_QUALITY_DRAFT, SeidelSettings};

use crate::depth::Reading;
use crate::ffi;
use crate::geometry::{Field, Scale};
use crate::host::{Failure, Result};
use crate::knobs::{Knobs, depth, focus, lens, remove, render};
use crate::lens::Info;

/// Settings with what they point to.
pub(crate) struct Setup {
    settings: SeidelSettings,
    channel_scales: Vec<f64>,
}

/// What of a render settings depend on beside knobs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Circumstances {
    /// Of the whole frame.
    pub(crate) scale: Scale,
    pub(crate) field: Field,
    pub(crate) unpremultiplied: bool,
    /// Whether the host wants no more than a draft.
    pub(crate) draft: bool,
    pub(crate) threads: u32,
}

fn metres(value: f64) -> f64 {
    if value >= depth::INFINITE_DISTANCE {
        f64::INFINITY
    } else {
        value
    }
}

/// NaN, "as it is", for a knob that stands at zero.
fn unless_zero(value: f64) -> f64 {
    if value == 0.0 { f64::NAN } else { value }
}

impl Setup {
    /// Those for a lens.
    ///
    /// # Errors
    /// Knobs that cannot be so, by name.
    pub(crate) fn new(knobs: &Knobs, info: &Info, about: &Circumstances) -> Result<Self> {
        let mut settings = ffi::settings()?;
        let scales = channel_scales(knobs, info)?;
        settings.amount = knobs.number(&lens::AMOUNT);
        settings.channel_scales = scales.as_ptr();
        settings.channel_scale_count = scales.len() as u32;
        settings.geometry = knobs.choice(&lens::GEOMETRY) as u32;
        settings.f_number = unless_zero(knobs.number(&lens::F_STOP));
        settings.sensor_shift_um = unless_zero(knobs.number(&lens::SENSOR_SHIFT));
        settings.depth_of_field = knobs.number(&focus::DEPTH_OF_FIELD);
        settings.front_multiplier = knobs.number(&focus::FRONT);
        settings.back_multiplier = knobs.number(&focus::BACK);
        settings.quality = knobs.choice(&render::QUALITY) as u32;
        if about.draft && knobs.is_on(&render::AUTO_DRAFT) {
            settings.quality = SEIDEL_QUALITY_DRAFT;
        }
        settings.edges = knobs.choice(&render::EDGES) as u32;
        settings.occlusion = u32::from(knobs.is_on(&render::OCCLUSION));
        settings.fill_foreground = u32::from(knobs.is_on(&render::FILL_FOREGROUND));
        settings.blur_inside = u32::from(knobs.is_on(&render::BLUR_INSIDE));
        if about.unpremultiplied {
            settings.alpha = SEIDEL_ALPHA_UNPREMULTIPLIED;
        }
        settings.scrub = u32::from(knobs.is_on(&render::SCRUB));
        settings.distance = metres(knobs.number(&depth::DISTANCE));
        Reading::new(knobs).put(&mut settings);
        settings.focus_distance = focus_distance(knobs)?.unwrap_or(f64::NAN);
        settings.strength = knobs.number(&remove::STRENGTH);
        settings.grain = knobs.choice(&remove::GRAIN) as u32;
        settings.noise[0] = unless_zero(knobs.number(&remove::NOISE));
        settings.clip = knobs.choice(&remove::CLIP) as u32;
        settings.clip_level = knobs.number(&remove::CLIP_LEVEL);
        settings.threads = about.threads;
        lengths(&mut settings, knobs, about);
        Ok(Self {
            settings,
            channel_scales: scales,
        })
    }

    /// What its pointer to scales points to.
    pub(crate) fn scales(&self) -> &[f64] {
        &self.channel_scales
    }

    /// Good as long as this is.
    pub(crate) fn settings(&self) -> &SeidelSettings {
        &self.settings
    }
}

/// What is counted in pixels: knobs count at full resolution.
fn lengths(settings: &mut SeidelSettings, knobs: &Knobs, about: &Circumstances) {
    let Scale { x, y } = about.scale;
    // A field has half the rows; its rows lie a quarter of one off the middle of the two that they stand for.
    let (y, shift) = match about.field {
        Field::Whole => (y, 0.0),
        Field::Lower => (y / 2.0, -0.25),
        Field::Upper => (y / 2.0, 0.25),
    };
    settings.pixel_aspect = y / x;
    let (right, up) = knobs.pair(&lens::AXIS_OFFSET);
    settings.axis_offset_x = right * x;
    settings.axis_offset_y = -up * y + shift;
    settings.lens_scale = unless_zero(knobs.number(&lens::LENS_SCALE) * y);
    settings.maximum_size = unless_zero(knobs.number(&focus::MAX_SIZE) * y);
    settings.along_ray = unless_zero(knobs.number(&depth::RAY_FOCAL) * x);
}

/// What the lens is to be focused at, nothing for what it was.
fn focus_distance(knobs: &Knobs) -> Result<Option<f64>> {
    Ok(match knobs.choice(&focus::FOCUS) {
        focus::AT_DISTANCE => Some(metres(knobs.number(&focus::DISTANCE))),
        focus::AT_DEPTH => Reading::new(knobs).focus_metres()?,
        _ => None,
    })
}

/// Vergence of the focus plane, 1/m.
///
/// # Errors
/// A lens of which it is not known.
pub(crate) fn focus_vergence(knobs: &Knobs, info: &Info) -> Result<f64> {
    let distance = focus_distance(knobs)?.unwrap_or(info.focus_distance);
    if distance.is_nan() {
        return Err(Failure::failed(
            "Focus: it is not known what the lens was focused at; set Focus to Focus Distance.",
        ));
    }
    Ok(1.0 / distance)
}

fn channel_scales(knobs: &Knobs, info: &Info) -> Result<Vec<f64>> {
    let scales = [&lens::RED_SCALE, &lens::GREEN_SCALE, &lens::BLUE_SCALE];
    let scales = scales.map(|knob| knobs.number(knob));
    if scales == [1.0; 3] {
        return Ok(Vec::new());
    }
    let of = |name: &String| {
        let index = ["R", "G", "B"].iter().position(|own| own == name);
        index.map(|index| scales[index])
    };
    let all: Option<Vec<f64>> = info.channels.iter().map(of).collect();
    all.ok_or_else(|| {
        Failure::failed(format!(
            "Red, Green and Blue Scale: the lens has the channels {}; set them to 1.",
            info.channels.join(", ")
        ))
    })
}
