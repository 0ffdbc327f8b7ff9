//! The parameters that have an effect, as others are set.

use crate::host::Effect;
use crate::knobs::{Knob, Knobs, colour, depth, focus, lens, look, output, remove, render};
use crate::lens::built_in;
use crate::settings::chosen_lens;
use crate::sys::param::ENABLED;

/// Enables the parameters that have an effect, and disables the others. Called on the main thread only.
pub(super) fn update(effect: &Effect, time: f64) {
    let knobs = Knobs::at(effect, time);
    let mode = knobs.choice(&lens::MODE);
    let relens = mode == lens::RELENS;
    let has_removal = mode != lens::APPLY;
    let from_file = |knob| knobs.choice(knob) == built_in::FILE;
    let uses_depth = knobs.is_on(&depth::USE_DEPTH);
    let by_ocio = knobs.choice(&colour::SOURCE_ENCODING) == colour::BY_OCIO;
    let focused = knobs.choice(&focus::FOCUS);
    let math = knobs.choice(&depth::MATH);
    let chosen = chosen_lens(&knobs, &lens::LENS, &lens::PROFILE).ok();
    // A lens that cannot be read leaves its controls enabled: the render says what is wrong.
    let has_rays = chosen.as_ref().is_none_or(|l| l.predictor().has_rays());
    let has_aperture = (chosen.as_ref()).is_none_or(|l| l.profile().camera.f_number.is_some());
    let has_focal_length =
        (chosen.as_ref()).is_none_or(|l| l.profile().camera.focal_length_mm.is_some());
    let has_pitch = (chosen.as_ref()).is_none_or(|l| l.profile().pixel_pitch_um.is_some());
    let has_blades = look::blade_count(knobs.choice(&look::BLADES)).is_some_and(|count| count > 0);
    // The look of a removal is that of the lens.
    let has_look = mode != lens::REMOVE;
    let looked_at = if relens {
        chosen_lens(&knobs, &lens::TO_LENS, &lens::TO_PROFILE).ok()
    } else {
        chosen
    };
    let has_pupil = has_look && looked_at.is_none_or(|l| l.predictor().has_rays());
    let blooms = has_look && knobs.number(&look::BLOOM) > 0.0;
    let states: [(&Knob, bool); 46] = [
        (
            &output::CHANNELS,
            knobs.choice(&output::OUTPUT) == output::RESULT,
        ),
        (&look::BLADES, has_pupil),
        (&look::ROUNDNESS, has_pupil && has_blades),
        (&look::ROTATION, has_pupil && has_blades),
        (&look::USE_APERTURE, has_pupil),
        (&look::SQUEEZE, has_pupil),
        (&look::OBSTRUCTION, has_pupil),
        (&look::CATS_EYE, has_pupil),
        (&look::SPHERICAL, has_pupil),
        (&look::AXIAL_COLOUR, has_pupil),
        (&look::LATERAL_COLOUR, has_pupil),
        (&look::BLOOM, has_look),
        (&look::BLOOM_LEVEL, blooms),
        (&look::BLOOM_RADIUS, blooms),
        (&lens::PROFILE, from_file(&lens::LENS)),
        (&lens::TO_LENS, relens),
        (&lens::TO_PROFILE, relens && from_file(&lens::TO_LENS)),
        (&depth::CHANNEL, uses_depth),
        (&depth::MATH, uses_depth),
        (&depth::UNIT, uses_depth && !depth::is_direct(math)),
        (&depth::NEAR, uses_depth && depth::has_near(math)),
        (&depth::FAR, uses_depth && depth::has_far(math)),
        (&lens::FOCAL_LENGTH, has_rays && has_focal_length),
        (&lens::FILM_BACK, has_pitch),
        (&lens::LENS_SCALE, knobs.number(&lens::FILM_BACK) == 0.0),
        (&lens::F_STOP, has_rays && has_aperture),
        (&lens::SENSOR_SHIFT, has_rays),
        (&focus::DISTANCE, focused == focus::AT_DISTANCE),
        (&focus::PLANE, focused != focus::AT_DISTANCE),
        (&colour::CONFIG, by_ocio),
        (&colour::SOURCE_SPACE, by_ocio),
        (&colour::WORKING_SPACE, by_ocio),
        (&render::EDGES, !has_removal),
        (&render::EXPAND, !has_removal),
        (&render::OCCLUSION, !has_removal),
        (&render::FILL_FOREGROUND, !has_removal),
        (&render::BLUR_INSIDE, !has_removal),
        (&render::USE_HOLDOUT, !has_removal),
        (&remove::STRENGTH, mode == lens::REMOVE),
        (&remove::ONLY_CHROMA, mode == lens::REMOVE),
        (
            &remove::GRAIN,
            mode == lens::REMOVE && !knobs.is_on(&remove::ONLY_CHROMA),
        ),
        (&remove::NOISE, has_removal),
        (&remove::CLIP, has_removal),
        (
            &remove::CLIP_LEVEL,
            has_removal && knobs.choice(&remove::CLIP) == remove::CLIP_BY_LEVEL,
        ),
        (&remove::CHECK_LENS, has_removal),
        (&output::MASK_INVERT, knobs.is_on(&output::USE_MASK)),
    ];
    let parameters = effect.parameters();
    for (knob, is_enabled) in states {
        if let Some(properties) = parameters.properties_of(knob.name) {
            properties.set_int(ENABLED, 0, i32::from(is_enabled));
        }
    }
}
