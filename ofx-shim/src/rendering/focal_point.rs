//! Focus on the object under a point of the viewer.

use crate::clips::DEPTH;
use crate::depth::encoded_depth_at;
use crate::geometry::Scale;
use crate::host::{Call, Change, ParameterValue, Result};
use crate::knobs::{Knobs, focus};
use crate::sys::effect::RENDER_SCALE;

/// Returns the changes that set the focus plane to the depth under `point`, in canonical coordinates; none if that is not known.
///
/// # Errors
/// A depth image of unexpected components or samples.
pub(crate) fn focus_at(call: &Call, point: (f64, f64)) -> Result<Vec<Change>> {
    let time = call.time();
    let knobs = Knobs::at(&call.effect, time);
    let Some(clip) = call.effect.clip(DEPTH).filter(|clip| clip.is_connected()) else {
        return Ok(Vec::new());
    };
    let Some(image) = clip.image(time)? else {
        return Ok(Vec::new());
    };
    let render_scale = call.arguments.doubles(RENDER_SCALE).unwrap_or([1.0; 2]);
    let aspect = image.pixel_aspect.or(clip.pixel_aspect()).unwrap_or(1.0);
    let scale = Scale::new(render_scale, aspect);
    let (x, y) = (point.0 * scale.x, point.1 * scale.y);
    let depth = encoded_depth_at(&image.samples(), &knobs, x.floor() as i32, y.floor() as i32);
    let Some(depth) = depth.filter(|depth| depth.is_finite()) else {
        return Ok(Vec::new());
    };
    Ok(vec![
        (focus::PLANE.name, ParameterValue::Double(f64::from(depth))),
        (focus::FOCUS.name, ParameterValue::Int(focus::AT_DEPTH)),
    ])
}
