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
    /// All but texts, in the order they were drawn.
    pub strokes: Vec<Stroke>,
    /// Texts.
    pub texts: Vec<String>,
    /// What is drawn with from now on.
    colour: Option<[f32; 3]>,
}

/// One call of `draw`.
#[derive(Clone, Debug)]
pub struct Stroke {
    /// What the points are joined to.
    pub primitive: OfxDrawPrimitive,
    /// Canonical.
    pub points: Vec<(f64, f64)>,
    /// Red, green and blue.
    pub colour: [f32; 3],
}

impl Stroke {
    /// The lines of it, by the indices of their ends; shapes are as their corners.
    #[must_use]
    pub fn ends(&self) -> Vec<(usize, usize)> {
        let count = self.points.len();
        match self.primitive {
            p if p == kOfxDrawPrimitiveLines => {
                (0..count / 2).map(|k| (2 * k, 2 * k + 1)).collect()
            }
            p if p == kOfxDrawPrimitiveLineStrip => (1..count).map(|k| (k - 1, k)).collect(),
            _ => (0..count).map(|k| (k, (k + 1) % count)).collect(),
        }
    }
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
    which: OfxStandardColour,
    colour: *mut OfxRGBAColourF,
) -> OfxStatus {
    let (r, g, b) = match which {
        w if w == kOfxStandardColourOverlayActive => (1.0, 0.7, 0.0),
        w if w == kOfxStandardColourOverlayDeselected => (0.2, 0.8, 1.0),
        _ => (1.0, 1.0, 1.0),
    };
    let standard = OfxRGBAColourF { r, g, b, a: 1.0 };
    match drawing(context, "getColour") {
        // SAFETY: the plugin gives room for a colour.
        Ok(_) => unsafe { put(colour, standard, "getColour") },
        Err(status) => status,
    }
}

unsafe extern "C" fn set_colour(
    context: OfxDrawContextHandle,
    colour: *const OfxRGBAColourF,
) -> OfxStatus {
    let host = match drawing(context, "setColour") {
        Ok(host) => host,
        Err(status) => return status,
    };
    if colour.is_null() {
        host.misused("setColour was given NULL".to_owned());
        return kOfxStatErrValue;
    }
    // SAFETY: the plugin gives a colour.
    let colour = unsafe { colour.read_unaligned() };
    locked(&host.strokes).colour = Some([colour.r, colour.g, colour.b]);
    kOfxStatOK
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
    let given = (0..count).map(|i| {
        // SAFETY: the plugin gives as many points as it says.
        let point = unsafe { points.add(i).read_unaligned() };
        (point.x, point.y)
    });
    let points: Vec<_> = given.collect();
    if points
        .iter()
        .any(|(x, y)| !(x.is_finite() && y.is_finite()))
    {
        host.misused("draw was given a point that is not finite".to_owned());
    }
    let mut strokes = locked(&host.strokes);
    let colour = strokes.colour.unwrap_or([1.0; 3]);
    strokes.strokes.push(Stroke {
        primitive,
        points,
        colour,
    });
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
