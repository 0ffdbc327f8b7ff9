//! Drawing of the overlay by the draw suite.

use super::focus_handle;
use super::lens_placement::LensPlacement;
use super::psf_ellipses::{Ellipse, ellipses};
use crate::host::{Call, Result};
use crate::knobs::{Knobs, output};
use crate::sys::draw::{
    COLOUR_ACTIVE, COLOUR_DESELECTED, LINE_LOOP, LINES, OfxDrawSuiteV1, OfxRGBAColourF,
};
use crate::sys::interact::DRAW_CONTEXT;
use crate::sys::{Handle, OfxPointD};

/// Number of corners of a polygon that stands for an ellipse.
const CORNERS: i32 = 32;
/// Half the size of a cross and radius of the handle, in screen pixels.
const MARK_RADIUS: f64 = 8.0;

/// The host's draw context.
struct Canvas {
    suite: OfxDrawSuiteV1,
    context: Handle,
    /// Size of a screen pixel in canonical coordinates.
    pixel: (f64, f64),
}

/// Draws the overlay; returns whether the host passed a draw context.
pub(super) fn draw(call: &Call, overlay: Handle) -> Result<bool> {
    let Some(canvas) = Canvas::new(call) else {
        return Ok(false);
    };
    let time = call.time();
    let knobs = Knobs::at(&call.effect, time);
    let placement = LensPlacement::new(call, &knobs, time)?;
    if let Some(placement) = placement.filter(|_| knobs.is_on(&output::SHOW_LENS)) {
        canvas.set_colour(COLOUR_DESELECTED);
        let instance = call.effect.handle.addr();
        for ellipse in ellipses(instance, &placement)?.iter() {
            canvas.lines(LINE_LOOP, &outline(ellipse, &placement));
        }
        canvas.cross(placement.canonical(placement.optical_axis()?));
    }
    if !focus_handle::is_drawn_by_host(call) {
        canvas.set_colour(COLOUR_ACTIVE);
        let (x, y) = focus_handle::position(&knobs, overlay);
        canvas.cross(OfxPointD { x, y });
        let circle = polygon(|cos, sin| OfxPointD {
            x: x + canvas.pixel.0 * MARK_RADIUS * cos,
            y: y + canvas.pixel.1 * MARK_RADIUS * sin,
        });
        canvas.lines(LINE_LOOP, &circle);
    }
    Ok(true)
}

/// Returns the corners of an ellipse in canonical coordinates.
fn outline(ellipse: &Ellipse, placement: &LensPlacement) -> Vec<OfxPointD> {
    let [a, b] = ellipse.axes;
    polygon(|cos, sin| {
        placement.canonical((
            ellipse.centre.0 + a.0 * cos + b.0 * sin,
            ellipse.centre.1 + a.1 * cos + b.1 * sin,
        ))
    })
}

/// Returns the corners that `corner` computes from the cosine and the sine of equally spaced angles.
fn polygon(corner: impl Fn(f64, f64) -> OfxPointD) -> Vec<OfxPointD> {
    let corners = (0..CORNERS).map(|k| {
        let (sin, cos) = (f64::from(k) / f64::from(CORNERS) * std::f64::consts::TAU).sin_cos();
        corner(cos, sin)
    });
    corners.collect()
}

impl Canvas {
    fn new(call: &Call) -> Option<Self> {
        let canvas = Self {
            suite: call.host.suites.draw?,
            context: call.arguments.pointer(DRAW_CONTEXT)?,
            pixel: focus_handle::pixel_scale(call),
        };
        if let Some(set_width) = canvas.suite.set_line_width {
            // SAFETY: a function of the host, and the context of this action; so in all calls of this file.
            unsafe { set_width(canvas.context, 0.0) };
        }
        Some(canvas)
    }

    /// Sets the colour to one of the host's standard colours.
    fn set_colour(&self, standard: i32) {
        let (Some(get), Some(set)) = (self.suite.get_colour, self.suite.set_colour) else {
            return;
        };
        let mut colour = OfxRGBAColourF {
            r: 1.0,
            g: 1.0,
            b: 1.0,
            a: 1.0,
        };
        // SAFETY: as above; both functions get the address of a colour.
        unsafe {
            get(self.context, standard, &raw mut colour);
            set(self.context, &raw const colour);
        }
    }

    fn lines(&self, primitive: i32, points: &[OfxPointD]) {
        if let Some(draw) = self.suite.draw {
            let count = points.len() as i32;
            // SAFETY: as above; `count` is the number of points.
            unsafe { draw(self.context, primitive, points.as_ptr(), count) };
        }
    }

    fn cross(&self, centre: OfxPointD) {
        let (x, y) = (MARK_RADIUS * self.pixel.0, MARK_RADIUS * self.pixel.1);
        let end = |x: f64, y: f64| OfxPointD {
            x: centre.x + x,
            y: centre.y + y,
        };
        let ends = [end(-x, 0.0), end(x, 0.0), end(0.0, -y), end(0.0, y)];
        self.lines(LINES, &ends);
    }
}
