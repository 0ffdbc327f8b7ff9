//! The draw suite: strokes are kept as they were asked for.

use std::ffi::{c_char, c_int};

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::draw_suite::*;
use openfx::sys::image_effect_v1::pixels::OfxRGBAColourF;

use super::interact::Overlay;
use super::pointers::{found, put, text};
use crate::host::{Host, locked, under};

/// What was drawn.
#[derive(Clone, Debug, Default)]
pub struct Strokes {
    /// Number of points of each primitive.
    pub primitives: Vec<usize>,
    /// Texts.
    pub texts: Vec<String>,
}

pub(super) fn suite() -> OfxDrawSuiteV1 {
    OfxDrawSuiteV1 {
        getColour: Some(get_colour),
        setColour: Some(set_colour),
        setLineWidth: Some(set_line_width),
        setLineStipple: Some(set_line_stipple),
        draw: Some(draw),
        drawText: Some(draw_text),
    }
}

/// The host, if the context is one and something is being drawn.
fn drawing(context: OfxDrawContextHandle, call: &str) -> Result<std::sync::Arc<Host>, OfxStatus> {
    let (host, _) = found::<Overlay>(context as usize, call)?;
    if under::now().is_none_or(|under| under.action != "OfxInteractActionDraw") {
        host.misused(format!("{call} was called outside the draw action"));
        return Err(kOfxStatFailed);
    }
    Ok(host)
}

unsafe extern "C" fn get_colour(
    context: OfxDrawContextHandle,
    _which: OfxStandardColour,
    colour: *mut OfxRGBAColourF,
) -> OfxStatus {
    let white = OfxRGBAColourF {
        r: 1.0,
        g: 1.0,
        b: 1.0,
        a: 1.0,
    };
    match drawing(context, "getColour") {
        // SAFETY: the plugin gives room for a colour.
        Ok(_) => unsafe { put(colour, white, "getColour") },
        Err(status) => status,
    }
}

unsafe extern "C" fn set_colour(
    context: OfxDrawContextHandle,
    _colour: *const OfxRGBAColourF,
) -> OfxStatus {
    drawing(context, "setColour").err().unwrap_or(kOfxStatOK)
}

unsafe extern "C" fn set_line_width(context: OfxDrawContextHandle, width: f32) -> OfxStatus {
    match drawing(context, "setLineWidth") {
        Ok(host) => {
            if width.is_nan() || width < 0.0 {
                host.misused(format!("setLineWidth was given {width}"));
            }
            kOfxStatOK
        }
        Err(status) => status,
    }
}

unsafe extern "C" fn set_line_stipple(
    context: OfxDrawContextHandle,
    pattern: OfxDrawLineStipplePattern,
) -> OfxStatus {
    match drawing(context, "setLineStipple") {
        Ok(_) if pattern <= kOfxDrawLineStipplePatternDotDash => kOfxStatOK,
        Ok(_) => kOfxStatErrValue,
        Err(status) => status,
    }
}

unsafe extern "C" fn draw(
    context: OfxDrawContextHandle,
    primitive: OfxDrawPrimitive,
    points: *const OfxPointD,
    count: c_int,
) -> OfxStatus {
    let host = match drawing(context, "draw") {
        Ok(host) => host,
        Err(status) => return status,
    };
    let count = usize::try_from(count).unwrap_or(0);
    if primitive > kOfxDrawPrimitiveEllipse || points.is_null() || count == 0 {
        host.misused(format!(
            "draw was given primitive {primitive} of {count} points"
        ));
        return kOfxStatErrValue;
    }
    // SAFETY: the plugin gives as many points as it says.
    let finite = (0..count).all(|i| unsafe {
        let point = points.add(i).read_unaligned();
        point.x.is_finite() && point.y.is_finite()
    });
    if !finite {
        host.misused("draw was given a point that is not finite".to_owned());
    }
    locked(&host.strokes).primitives.push(count);
    kOfxStatOK
}

unsafe extern "C" fn draw_text(
    context: OfxDrawContextHandle,
    words: *const c_char,
    _at: *const OfxPointD,
    _alignment: c_int,
) -> OfxStatus {
    match drawing(context, "drawText") {
        Ok(host) => {
            // SAFETY: the plugin gives a string.
            locked(&host.strokes).texts.push(unsafe { text(words) });
            kOfxStatOK
        }
        Err(status) => status,
    }
}
