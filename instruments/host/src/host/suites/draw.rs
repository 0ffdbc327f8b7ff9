//! The draw suite, which records what overlays draw.

use std::ffi::{c_char, c_int};

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::draw_suite::*;
use openfx::sys::image_effect_v1::interact::kOfxInteractActionDraw;
use openfx::sys::image_effect_v1::pixels::OfxRGBAColourF;

use super::interact::Overlay;
use super::pointers::{string, with_object, write_result};
use crate::host::action::current_action;
use crate::host::{Host, locked};

/// Everything that an overlay has drawn.
#[derive(Clone, Debug, Default)]
pub struct Drawing {
    /// Calls of `draw`, in order.
    pub shapes: Vec<Shape>,
    /// Calls of `drawText`, in order.
    pub texts: Vec<String>,
    /// The current colour.
    colour: Option<[f32; 3]>,
}

/// A call of `draw`.
#[derive(Clone, Debug)]
pub struct Shape {
    /// The primitive that joins the points.
    pub primitive: OfxDrawPrimitive,
    /// The points, in canonical coordinates.
    pub points: Vec<(f64, f64)>,
    /// Red, green and blue.
    pub colour: [f32; 3],
}

impl Shape {
    /// Returns its lines as pairs of point indices. Closed shapes are approximated by a polygon of their points.
    #[must_use]
    pub fn lines(&self) -> Vec<(usize, usize)> {
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

/// Calls `work` if the context is valid and the draw action is under way.
fn while_drawing(
    context: OfxDrawContextHandle,
    call: &str,
    work: impl FnOnce(&Host) -> OfxStatus,
) -> OfxStatus {
    with_object::<Overlay>(context as usize, call, |host, _| {
        if current_action().is_none_or(|action| !action.is(kOfxInteractActionDraw)) {
            host.record_misuse(format!("{call} was called outside the draw action"));
            return kOfxStatFailed;
        }
        work(host)
    })
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
    while_drawing(context, "getColour", |_| {
        // SAFETY: the plugin provides memory for a colour.
        unsafe { write_result(colour, standard, "getColour") }
    })
}

unsafe extern "C" fn set_colour(
    context: OfxDrawContextHandle,
    colour: *const OfxRGBAColourF,
) -> OfxStatus {
    while_drawing(context, "setColour", |host| {
        if colour.is_null() {
            host.record_misuse("setColour was given NULL");
            return kOfxStatErrValue;
        }
        // SAFETY: the plugin passes a colour.
        let colour = unsafe { colour.read_unaligned() };
        locked(&host.drawing).colour = Some([colour.r, colour.g, colour.b]);
        kOfxStatOK
    })
}

unsafe extern "C" fn set_line_width(context: OfxDrawContextHandle, width: f32) -> OfxStatus {
    while_drawing(context, "setLineWidth", |host| {
        if width.is_nan() || width < 0.0 {
            host.record_misuse(format!("setLineWidth was given {width}"));
        }
        kOfxStatOK
    })
}

unsafe extern "C" fn set_line_stipple(
    context: OfxDrawContextHandle,
    pattern: OfxDrawLineStipplePattern,
) -> OfxStatus {
    while_drawing(context, "setLineStipple", |_| {
        if pattern <= kOfxDrawLineStipplePatternDotDash {
            kOfxStatOK
        } else {
            kOfxStatErrValue
        }
    })
}

unsafe extern "C" fn draw(
    context: OfxDrawContextHandle,
    primitive: OfxDrawPrimitive,
    points: *const OfxPointD,
    count: c_int,
) -> OfxStatus {
    while_drawing(context, "draw", |host| {
        let count = usize::try_from(count).unwrap_or(0);
        if primitive > kOfxDrawPrimitiveEllipse || points.is_null() || count == 0 {
            host.record_misuse(format!(
                "draw was given primitive {primitive} with {count} points"
            ));
            return kOfxStatErrValue;
        }
        let points: Vec<(f64, f64)> = (0..count)
            .map(|i| {
                // SAFETY: the plugin passes `count` points.
                let point = unsafe { points.add(i).read_unaligned() };
                (point.x, point.y)
            })
            .collect();
        if !points.iter().all(|(x, y)| x.is_finite() && y.is_finite()) {
            host.record_misuse("draw was given a point that is not finite");
        }
        let mut drawing = locked(&host.drawing);
        let colour = drawing.colour.unwrap_or([1.0; 3]);
        drawing.shapes.push(Shape {
            primitive,
            points,
            colour,
        });
        kOfxStatOK
    })
}

unsafe extern "C" fn draw_text(
    context: OfxDrawContextHandle,
    text: *const c_char,
    _position: *const OfxPointD,
    _alignment: c_int,
) -> OfxStatus {
    while_drawing(context, "drawText", |host| {
        // SAFETY: the plugin passes a string.
        let text = unsafe { string(text) };
        locked(&host.drawing).texts.push(text);
        kOfxStatOK
    })
}
