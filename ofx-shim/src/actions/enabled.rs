//! The parameters that have an effect, as others are set.

use seidel_core::{Blades, KnobUse, Mode, Settings};

use crate::geometry::PlateScale;
use crate::host::Effect;
use crate::knobs::{
    Knob, Knobs, colour, depth, focus, lens, look, named, output, remove, render, table,
};
use crate::lens::built_in;
use crate::settings::chosen_lens;
use crate::sys::param::ENABLED;

/// Enables the parameters that have an effect, and disables the others. Called on the main thread only.
pub(super) fn update(effect: &Effect, time: f64) {
    let knobs = Knobs::at(effect, time);
    // A lens that cannot be read leaves its controls enabled: the render says what is wrong.
    let chosen = chosen_lens(&knobs, &lens::LENS, &lens::PROFILE).ok();
    let mode = mode(&knobs);
    let look_lens = if mode == Mode::Relens {
        chosen_lens(&knobs, &lens::TO_LENS, &lens::TO_PROFILE).ok()
    } else {
        chosen.clone()
    };
    let settings = settings_as_far_as_valid(&knobs);
    let case = KnobUse {
        mode,
        lens: chosen.as_deref(),
        look_lens: look_lens.as_deref(),
        settings: &settings,
    };
    let parameters = effect.parameters();
    let enable = |knob: &Knob, is_enabled: bool| {
        if let Some(properties) = parameters.properties_of(knob.name) {
            properties.set_int(ENABLED, 0, i32::from(is_enabled));
        }
    };
    for (row, knob) in table() {
        enable(knob, (row.has_effect)(&case));
    }
    for (knob, is_enabled) in own_states(&knobs, &case) {
        enable(knob, is_enabled);
    }
}

fn mode(knobs: &Knobs) -> Mode {
    match knobs.choice(&lens::MODE) {
        lens::REMOVE => Mode::Remove,
        lens::RELENS => Mode::Relens,
        _ => Mode::Apply,
    }
}

/// Returns the settings of the knobs of the core's table; those out of range have their defaults.
fn settings_as_far_as_valid(knobs: &Knobs) -> Settings {
    let mut settings = Settings::default();
    let blades = look::blade_count(knobs.choice(&look::BLADES));
    settings.look.blades = blades.map(Blades::straight);
    for (row, knob) in table() {
        // The render says what is wrong.
        let _ = knobs.put_knob(row, knob, PlateScale::FULL, &mut settings);
    }
    settings
}

/// Returns the states of the node's own knobs, and that of Grain, which depends on one of them.
fn own_states(knobs: &Knobs, case: &KnobUse) -> [(&'static Knob, bool); 25] {
    let mode = case.mode;
    let from_file = |knob| knobs.choice(knob) == built_in::FILE;
    let uses_depth = knobs.is_on(&depth::USE_DEPTH);
    let by_ocio = knobs.choice(&colour::SOURCE_ENCODING) == colour::BY_OCIO;
    let focused = knobs.choice(&focus::FOCUS);
    let math = knobs.choice(&depth::MATH);
    let has_rays = (case.look_lens).is_none_or(|lens| lens.predictor().has_rays());
    let has_look = has_rays && mode != Mode::Remove;
    let has_data = !knobs.text(&lens::DATA).trim().is_empty();
    let removes_all = mode == Mode::Remove && !knobs.is_on(&remove::ONLY_CHROMA);
    [
        (
            &output::CHANNELS,
            knobs.choice(&output::OUTPUT) == output::RESULT,
        ),
        (&look::PRESET, has_look),
        (&look::BLADES, has_look),
        (&look::USE_APERTURE, has_look),
        (&lens::PROFILE, from_file(&lens::LENS)),
        (&lens::TO_LENS, mode == Mode::Relens),
        (
            &lens::TO_PROFILE,
            mode == Mode::Relens && from_file(&lens::TO_LENS),
        ),
        (&lens::DATA_START, has_data),
        (&lens::SHOW_DATA, has_data),
        (&depth::CHANNEL, uses_depth),
        (&depth::MATH, uses_depth),
        (&depth::UNIT, uses_depth && !depth::is_direct(math)),
        (&depth::NEAR, uses_depth && depth::has_near(math)),
        (&depth::FAR, uses_depth && depth::has_far(math)),
        (&focus::DISTANCE, focused == focus::AT_DISTANCE),
        (&focus::PLANE, focused != focus::AT_DISTANCE),
        (&colour::CONFIG, by_ocio),
        (&colour::SOURCE_SPACE, by_ocio),
        (&colour::WORKING_SPACE, by_ocio),
        (&render::USE_HOLDOUT, mode == Mode::Apply),
        (&remove::ONLY_CHROMA, mode != Mode::Relens),
        (named("grain"), removes_all),
        (&remove::CHECK_LENS, mode != Mode::Apply),
        (&output::MASK_INVERT, knobs.is_on(&output::USE_MASK)),
        (
            &output::MASK_SCALES,
            knobs.is_on(&output::USE_MASK) && mode == Mode::Apply,
        ),
    ]
}
