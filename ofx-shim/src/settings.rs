//! The parameters as lens, settings and geometry of the core.

use std::sync::Arc;

use seidel_core::{
    Blades, ChannelScale, DepthMeaning, HostGroup, Lens, MaskScales, ObjectDistance, PlateGeometry,
    Quality, Rectangle, RelensSide, Settings,
};

use crate::depth::DepthEncoding;
use crate::file_reference;
use crate::geometry::PlateScale;
use crate::host::{Failure, Result};
use crate::knobs::{Knob, Knobs, depth, focus, lens, look, output, remove, render};
use crate::lens::{LensOrigin, built_in, load};
use crate::lens_data::LensData;

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
        built_in::FILE => {
            LensOrigin::File(file_reference::lens(knobs.text(file).trim()).to_owned())
        }
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

/// Returns whether the mask scales the blur, not the weight of the result.
pub(crate) fn mask_scales_blur(knobs: &Knobs) -> bool {
    let is_apply = knobs.choice(&lens::MODE) == lens::APPLY;
    is_apply && knobs.choice(&output::MASK_SCALES) == output::SCALES_BLUR
}

/// Returns the settings for the lens `profile`, which is on this `side` in the mode Relens; with the look if the mode is Apply.
///
/// # Errors
/// Parameters out of range, and those that the lens cannot follow, by name.
pub(crate) fn settings(
    knobs: &Knobs,
    profile: &Lens,
    scale: PlateScale,
    quality: HostQuality,
    side: RelensSide,
) -> Result<Settings> {
    let mut settings = Settings::default();
    for group in [
        HostGroup::Lens,
        HostGroup::Focus,
        HostGroup::Render,
        HostGroup::Remove,
    ] {
        knobs.put(group, scale, &mut settings)?;
    }
    settings.channel_scales = channel_scales(knobs, profile)?;
    let focus_distance = focus_distance_m(knobs)?;
    settings.controls.focus_distance = focus_distance.map(ObjectDistance::metres).transpose()?;
    if let Some(data) = LensData::read(knobs, profile)? {
        data.put(&mut settings)?;
    }
    let (right, up) = knobs.pair(&lens::AXIS_OFFSET);
    settings.axis_offset_px = (right * scale.x, -up * scale.y + scale.row_offset);
    if quality == HostQuality::Draft && knobs.is_on(&render::AUTO_DRAFT) {
        settings.quality = Quality::Draft;
    }
    if knobs.choice(&lens::MODE) == lens::RELENS {
        knobs.put(HostGroup::Relens, scale, &mut settings)?;
        settings = settings.of_side(side);
    }
    if knobs.choice(&lens::MODE) == lens::APPLY {
        settings.only_chroma = knobs.is_on(&remove::ONLY_CHROMA);
        if mask_scales_blur(knobs) {
            settings.mask_scales = MaskScales::Blur;
        }
        put_look(knobs, profile, scale, &mut settings)?;
    }
    Ok(settings)
}

/// Puts look and bloom for the lens `profile` into `settings`, without a picture of the aperture.
///
/// # Errors
/// A look of a lens that has no rays.
pub(crate) fn put_look(
    knobs: &Knobs,
    profile: &Lens,
    scale: PlateScale,
    settings: &mut Settings,
) -> Result<()> {
    let count = look::blade_count(knobs.choice(&look::BLADES));
    settings.look.blades = count.map(Blades::straight);
    knobs.put(HostGroup::Look, scale, settings)?;
    let chosen = &settings.look;
    if chosen.is_neutral() || profile.predictor().has_rays() {
        return Ok(());
    }
    Err(Failure::failed(format!(
        "Look: {chosen}: this lens was fitted with --model moments, which says nothing about its pupil; set Blades to Tilt Direction to their defaults, or choose a lens that comes with Seidel or one fitted with --model reduced."
    )))
}

/// Returns the place of a plate with these pixels in the frame of the lens.
pub(crate) fn plate_geometry(
    settings: &Settings,
    scale: PlateScale,
    format: Rectangle,
    extent: Rectangle,
) -> PlateGeometry {
    PlateGeometry {
        display: format,
        data: extent,
        pixel_aspect: scale.y / scale.x,
        lens_scale: settings.lens_scale,
    }
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
        averaged_px: knobs.number(&depth::FILTER) * scale.x,
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
    let mut distance = focus_distance_m(knobs)?;
    if distance.is_none() {
        let data = LensData::read(knobs, profile)?;
        distance = data.and_then(|data| data.focus_m());
    }
    let distance = distance.or_else(|| measured_focus_m(profile));
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
