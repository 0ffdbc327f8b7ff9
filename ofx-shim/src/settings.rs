//! The parameters as lens, settings and geometry of the core.

mod look;

use std::sync::Arc;

use seidel_core::{
    ChannelScale, Controls, DepthMeaning, Displacement, Edges, FocusControls, Grain, Lens,
    LensScale, ObjectDistance, OcclusionSettings, PlateGeometry, Quality, Rectangle,
    RemovalSettings, Saturation, Settings,
};

use crate::depth::DepthEncoding;
use crate::geometry::PlateScale;
use crate::host::{Failure, Result};
use crate::knobs::{Knob, Knobs, depth, focus, lens, remove, render};
use crate::lens::{LensOrigin, built_in, load};
use look::put_look;
pub(crate) use look::put_look_with;

/// Quality that the host asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum HostQuality {
    Full,
    /// A draft, if Draft While Editing is on.
    Draft,
}

/// Returns the lens chosen by the parameters `menu` and `file`.
///
/// # Errors
/// No file chosen, and a file that cannot be read or is not a lens profile.
pub(crate) fn chosen_lens(knobs: &Knobs, menu: &Knob, file: &Knob) -> Result<Arc<Lens>> {
    let origin = match knobs.choice(menu) {
        built_in::FILE => LensOrigin::File(knobs.text(file).trim().to_owned()),
        index => LensOrigin::BuiltIn(index),
    };
    if origin == LensOrigin::File(String::new()) {
        let label = file.label.to_string_lossy();
        return Err(Failure::failed(format!(
            "{label}: no file is chosen; choose one, or a lens that comes with Seidel."
        )));
    }
    load(&origin, knobs.hidden(&lens::RELOADS))
}

/// Returns the settings for the lens `profile`, with the look if the mode is Apply.
///
/// # Errors
/// Parameters that the lens cannot follow, by name.
pub(crate) fn settings(
    knobs: &Knobs,
    profile: &Lens,
    scale: PlateScale,
    quality: HostQuality,
) -> Result<Settings> {
    let mut settings = Settings::default();
    settings.amount = knobs.number(&lens::AMOUNT);
    settings.channel_scales = channel_scales(knobs, profile)?;
    settings.displacement = match knobs.choice(&lens::GEOMETRY) {
        0 => Displacement::None,
        1 => Displacement::Lateral,
        _ => Displacement::Full,
    };
    let focus_distance = focus_distance_m(knobs)?;
    settings.controls = Controls {
        focal_length_mm: unless_zero(knobs.number(&lens::FOCAL_LENGTH)),
        focus_distance: focus_distance.map(ObjectDistance::metres).transpose()?,
        f_number: unless_zero(knobs.number(&lens::F_STOP)),
        sensor_shift_um: unless_zero(knobs.number(&lens::SENSOR_SHIFT)),
    };
    settings.focus = FocusControls {
        focus_per_m: None,
        depth_of_field_m: knobs.number(&focus::DEPTH_OF_FIELD),
        front: knobs.number(&focus::FRONT),
        back: knobs.number(&focus::BACK),
        maximum_px: unless_zero(knobs.number(&focus::MAX_SIZE) * scale.y),
    };
    let (right, up) = knobs.pair(&lens::AXIS_OFFSET);
    settings.axis_offset_px = (right * scale.x, -up * scale.y + scale.row_offset);
    settings.quality = match knobs.choice(&render::QUALITY) {
        0 => Quality::Draft,
        1 => Quality::Final,
        _ => Quality::Exact,
    };
    if quality == HostQuality::Draft && knobs.is_on(&render::AUTO_DRAFT) {
        settings.quality = Quality::Draft;
    }
    settings.edges = match knobs.choice(&render::EDGES) {
        0 => Some(Edges::Mirror),
        1 => Some(Edges::Black),
        2 => Some(Edges::Extend),
        _ => None,
    };
    settings.occlusion = knobs.is_on(&render::OCCLUSION).then(|| OcclusionSettings {
        fill_foreground: knobs.is_on(&render::FILL_FOREGROUND),
        blur_inside: knobs.is_on(&render::BLUR_INSIDE),
    });
    settings.removal = removal(knobs);
    if knobs.choice(&lens::MODE) == lens::APPLY {
        put_look(knobs, profile, &mut settings)?;
    }
    Ok(settings)
}

fn removal(knobs: &Knobs) -> RemovalSettings {
    RemovalSettings {
        noise: unless_zero(knobs.number(&remove::NOISE))
            .into_iter()
            .collect(),
        saturation: match knobs.choice(&remove::CLIP) {
            0 => Saturation::Auto,
            1 => Saturation::Never,
            _ => Saturation::Level(knobs.number(&remove::CLIP_LEVEL)),
        },
        strength: knobs.number(&remove::STRENGTH),
        grain: if knobs.choice(&remove::GRAIN) == 0 {
            Grain::Keep
        } else {
            Grain::Solved
        },
    }
}

/// Returns the place of a plate with these pixels in the frame of the lens.
pub(crate) fn plate_geometry(
    knobs: &Knobs,
    scale: PlateScale,
    format: Rectangle,
    extent: Rectangle,
) -> PlateGeometry {
    PlateGeometry {
        display: format,
        data: extent,
        pixel_aspect: scale.y / scale.x,
        lens_scale: lens_scale(knobs, scale),
    }
}

fn lens_scale(knobs: &Knobs, scale: PlateScale) -> LensScale {
    let film_back = unless_zero(knobs.number(&lens::FILM_BACK)).map(LensScale::FilmBack);
    let ratio = unless_zero(knobs.number(&lens::LENS_SCALE) * scale.y).map(LensScale::PixelRatio);
    film_back.or(ratio).unwrap_or_default()
}

/// Returns the meaning of depth samples of `encoding` after conversion by [`DepthConversion`](crate::depth::DepthConversion).
pub(crate) fn depth_meaning(
    knobs: &Knobs,
    encoding: &DepthEncoding,
    scale: PlateScale,
) -> DepthMeaning {
    DepthMeaning {
        convention: encoding.convention(),
        along_ray: unless_zero(knobs.number(&depth::RAY_FOCAL) * scale.x),
    }
}

/// Returns the distance of everything where no depth pass is used, metres.
pub(crate) fn plate_distance_m(knobs: &Knobs) -> f64 {
    metres(knobs.number(&depth::DISTANCE))
}

/// Returns the vergence of the focus plane, 1/m.
///
/// # Errors
/// A lens whose focus distance is not known, left as measured.
pub(crate) fn focus_vergence_per_m(knobs: &Knobs, profile: &Lens) -> Result<f64> {
    let distance = focus_distance_m(knobs)?.or_else(|| measured_focus_m(profile));
    let distance = distance.ok_or_else(|| {
        Failure::failed(
            "Focus: the distance at which the lens was focused is not known; set Focus to Focus Distance.",
        )
    })?;
    Ok(1.0 / distance)
}

/// Returns the distance at which the lens was focused when it was measured, metres, if it is known.
fn measured_focus_m(profile: &Lens) -> Option<f64> {
    let focus = profile.profile().camera.focus_distance;
    focus.vergence_per_m().map(|vergence| 1.0 / vergence)
}

/// Returns the distance at which the lens is to be focused, metres, or `None` for that of the measurement.
fn focus_distance_m(knobs: &Knobs) -> Result<Option<f64>> {
    Ok(match knobs.choice(&focus::FOCUS) {
        focus::AT_DISTANCE => Some(metres(knobs.number(&focus::DISTANCE))),
        focus::AT_DEPTH => DepthEncoding::new(knobs).focus_plane_m()?,
        _ => None,
    })
}

/// Returns the scale of each channel of the lens, or none if all are 1.
fn channel_scales(knobs: &Knobs, profile: &Lens) -> Result<Vec<ChannelScale>> {
    let scales = [
        ("R", knobs.number(&lens::RED_SCALE)),
        ("G", knobs.number(&lens::GREEN_SCALE)),
        ("B", knobs.number(&lens::BLUE_SCALE)),
    ];
    if scales.iter().all(|(_, scale)| *scale == 1.0) {
        return Ok(Vec::new());
    }
    let channels = profile.predictor().channel_names();
    let scale_of = |channel: &String| {
        let (_, scale) = scales.iter().find(|(name, _)| name == channel)?;
        Some(ChannelScale {
            channel: channel.clone(),
            scale: *scale,
        })
    };
    let all: Option<Vec<_>> = channels.iter().map(scale_of).collect();
    all.ok_or_else(|| {
        Failure::failed(format!(
            "Red, Green and Blue Scale: the lens has the channels {}; set them to 1.",
            channels.join(", ")
        ))
    })
}

/// The metres of a distance parameter, whose upper end stands for infinity.
fn metres(value: f64) -> f64 {
    if value >= depth::INFINITE_DISTANCE {
        f64::INFINITY
    } else {
        value
    }
}

/// The value of a parameter at which zero stands for "as it is".
fn unless_zero(value: f64) -> Option<f64> {
    (value != 0.0).then_some(value)
}
