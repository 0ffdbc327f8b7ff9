//! Focus on the object under a point of the viewer.

use crate::clips::DEPTH;
use crate::depth::encoded_depth_at;
use crate::geometry::Scale;
use crate::host::{Call, ParameterValue, Result};
use crate::knobs::{Knobs, focus};
use crate::sys::effect::RENDER_SCALE;

/// Sets the focus plane to the depth under the focal point, if it is known. Called on the main thread only, since it
/// changes parameters.
///
/// # Errors
/// A depth image of unexpected components or samples.
pub(crate) fn focus_on_point(call: &Call) -> Result<()> {
    let time = call.time();
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
    let (x, y) = ((x * scale.x).floor() as i32, (y * scale.y).floor() as i32);
    let depth = encoded_depth_at(&image.samples(), &knobs, x, y);
    let Some(depth) = depth.filter(|depth| depth.is_finite()) else {
        return Ok(());
    };
    call.effect.parameters().set(
        c"Focus here",
        &[
            (focus::PLANE.name, ParameterValue::Double(f64::from(depth))),
            (focus::FOCUS.name, ParameterValue::Int(focus::AT_DEPTH)),
        ],
    );
    Ok(())
}
