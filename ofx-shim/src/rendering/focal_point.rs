//! Focusing on what is under a point.

use super::Call;
use crate::clips::DEPTH;
use crate::depth::Samples;
use crate::geometry::Scale;
use crate::host::{ParameterValue, Result};
use crate::knobs::{Knobs, focus};
use crate::sys::effect::RENDER_SCALE;

/// Sets the focus plane to the depth under the focal point, where there is one. Only for the main thread.
pub(crate) fn focus(call: &Call, time: f64) -> Result<()> {
    let knobs = Knobs::at(&call.effect, time);
    let Some(clip) = call.effect.clip(DEPTH).filter(|clip| clip.is_connected()) else {
        return Ok(());
    };
    let Some(image) = clip.image(time)? else {
        return Ok(());
    };
    let render_scale = call.arguments.doubles(RENDER_SCALE).unwrap_or([1.0; 2]);
    let aspect = image.pixel_aspect.or(clip.pixel_aspect()).unwrap_or(1.0);
    let scale = Scale::new(render_scale, aspect);
    let (x, y) = knobs.pair(&focus::POINT);
    let pixel = ((x * scale.x).floor() as i32, (y * scale.y).floor() as i32);
    let Some(value) = Samples::new(&image, &knobs).at(pixel) else {
        return Ok(());
    };
    if !value.is_finite() {
        return Ok(());
    }
    call.effect.parameters().set(
        c"Focus here",
        &[
            (focus::PLANE.name, ParameterValue::Double(f64::from(value))),
            (focus::FOCUS.name, ParameterValue::Int(focus::AT_DEPTH)),
        ],
    );
    Ok(())
}
