//! Drawing by the draw suite.

use super::axis::axis;
use super::grid::{Ellipse, grid};
use super::pen;
use super::place::Place;
use crate::actions::Call;
use crate::host::{Host, Result};
use crate::knobs::{Knobs, output};
use crate::sys::draw::{
    COLOUR_ACTIVE, COLOUR_DESELECTED, LINE_LOOP, LINES, OfxDrawSuiteV1, OfxRGBAColourF,
};
use crate::sys::interact::{DRAW_CONTEXT, PIXEL_SCALE};
use crate::sys::property::TIME;
use crate::sys::{Handle, OfxPointD};

/// Corners of a round line.
const CORNERS: i32 = 32;
/// Half a cross, screen pixels.
const CROSS: f64 = 8.0;

/// What is drawn on.
struct Pen {
    suite: OfxDrawSuiteV1,
    context: Handle,
    /// Size of a screen pixel, canonical.
    pixel: (f64, f64),
}

/// Draws the overlay; whether there was anything to draw on.
pub(super) fn draw(call: &Call, overlay: Handle) -> Result<bool> {
    let Some(pen) = Pen::new(call.host, call) else {
        return Ok(false);
    };
    let time = call.arguments.double(TIME, 0).unwrap_or(0.0);
    let knobs = Knobs::of(&call.effect, time);
    let place = Place::new(call, &knobs, time)?;
    if let Some(place) = place.as_ref().filter(|_| knobs.is_on(&output::SHOW_LENS)) {
        pen.colour(COLOUR_DESELECTED);
        let instance = call.effect.handle.addr();
        for ellipse in grid(instance, place)?.iter() {
            pen.lines(LINE_LOOP, &outline(ellipse, place));
        }
        pen.cross(place.canonical(axis(place)));
    }
    if !pen::is_drawn_by_host(call) {
        pen.colour(COLOUR_ACTIVE);
        let (x, y) = pen::position(&knobs, overlay);
        let middle = OfxPointD { x, y };
        pen.cross(middle);
        let corners = (0..CORNERS).map(|k| {
            let angle = f64::from(k) / f64::from(CORNERS) * std::f64::consts::TAU;
            OfxPointD {
                x: x + pen.pixel.0 * CROSS * angle.cos(),
                y: y + pen.pixel.1 * CROSS * angle.sin(),
            }
        });
        pen.lines(LINE_LOOP, &corners.collect::<Vec<_>>());
    }
    Ok(true)
}

/// The corners of an ellipse, canonical.
fn outline(ellipse: &Ellipse, place: &Place) -> Vec<OfxPointD> {
    let corner = |k: i32| {
        let (sin, cos) = (f64::from(k) / f64::from(CORNERS) * std::f64::consts::TAU).sin_cos();
        let [a, b] = ellipse.axes;
        place.canonical((
            ellipse.middle.0 + a.0 * cos + b.0 * sin,
            ellipse.middle.1 + a.1 * cos + b.1 * sin,
        ))
    };
    (0..CORNERS).map(corner).collect()
}

impl Pen {
    fn new(host: &Host, call: &Call) -> Option<Self> {
        let pen = Self {
            suite: host.suites.draw?,
            context: call.arguments.pointer(DRAW_CONTEXT)?,
            pixel: pen::pixel_scale(call.arguments.doubles(PIXEL_SCALE)),
        };
        if let Some(width) = pen.suite.set_line_width {
            // SAFETY: the host vouches for its function and the context of this action.
            unsafe { width(pen.context, 0.0) };
        }
        Some(pen)
    }

    /// Draws with a colour of the host's from now on.
    fn colour(&self, standard: i32) {
        let (Some(get), Some(set)) = (self.suite.get_colour, self.suite.set_colour) else {
            return;
        };
        let mut colour = OfxRGBAColourF {
            r: 1.0,
            g: 1.0,
            b: 1.0,
            a: 1.0,
        };
        // SAFETY: as above; the places are good.
        unsafe {
            get(self.context, standard, &raw mut colour);
            set(self.context, &raw const colour);
        }
    }

    fn lines(&self, primitive: i32, points: &[OfxPointD]) {
        if let Some(draw) = self.suite.draw {
            // SAFETY: as above; as many points as are said.
            unsafe {
                draw(
                    self.context,
                    primitive,
                    points.as_ptr(),
                    points.len() as i32,
                )
            };
        }
    }

    fn cross(&self, at: OfxPointD) {
        let (x, y) = (CROSS * self.pixel.0, CROSS * self.pixel.1);
        let moved = |x: f64, y: f64| OfxPointD {
            x: at.x + x,
            y: at.y + y,
        };
        let ends = [moved(-x, 0.0), moved(x, 0.0), moved(0.0, -y), moved(0.0, y)];
        self.lines(LINES, &ends);
    }
}
