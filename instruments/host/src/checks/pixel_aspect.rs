//! Pixels that are not square.

use std::ops::Range;

use super::{Check, Report, fixture};
use crate::drive::RenderRequest;
use crate::host::profile::Profile;
use crate::picture::{Picture, Rect};
use crate::scene::Scene;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "pixel_aspect",
    about: "in pixels twice as wide, a blur is half as many pixels wide and as many high",
    run,
};

/// The standard deviation of the light in a picture, in pixels.
#[derive(Clone, Copy)]
pub(super) struct Spread {
    pub(super) x: f64,
    pub(super) y: f64,
}

/// Returns the spread of the first channel.
pub(super) fn spread(picture: &Picture) -> Spread {
    let mut sums = [0.0_f64; 5];
    for (x, y) in picture.bounds.pixels() {
        let light = f64::from(picture.pixel(x, y)[0]);
        let (x, y) = (f64::from(x), f64::from(y));
        for (sum, term) in sums.iter_mut().zip([1.0, x, y, x * x, y * y]) {
            *sum += light * term;
        }
    }
    let [total, x, y, xx, yy] = sums;
    let deviation =
        |first: f64, second: f64| (second / total - (first / total).powi(2)).max(0.0).sqrt();
    Spread {
        x: deviation(x, xx),
        y: deviation(y, yy),
    }
}

/// Returns a black picture with light in some columns of one row.
fn light(width: i32, columns: Range<i32>) -> Picture {
    Picture::from_fn(Rect::new(0, 0, width, 48), 4, |x, y, c| {
        let is_lit = columns.contains(&x) && y == 24;
        if is_lit || c == 3 { 1.0 } else { 0.0 }
    })
}

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, report| {
        let render = |scene| fixture::render(loaded, subject, &scene, &RenderRequest::default());
        // The same frame and light in 64 by 48 square pixels and in 32 by 48 wide ones.
        let square = render(Scene::new(light(64, 32..34)))?;
        let wide = render(Scene::with_par(light(32, 16..17), 2.0))?;
        let widths = (square.window.width(), wide.window.width());
        report.expect(widths.0.abs_diff(2 * widths.1) <= 4, || {
            format!(
                "the output is {:?} in square pixels and {:?} in wide ones",
                square.window, wide.window
            )
        });
        let (square, wide) = (spread(&square.picture), spread(&wide.picture));
        let ratio = Spread {
            x: wide.x / square.x,
            y: wide.y / square.y,
        };
        let tolerance = subject.kind.pixel_aspect_tolerance;
        report.expect((ratio.x - 0.5).abs() <= tolerance, || {
            format!(
                "the width of a blur in wide pixels is {:.3} of that in square ones, not 0.5",
                ratio.x
            )
        });
        report.expect((ratio.y - 1.0).abs() <= tolerance, || {
            format!(
                "the height of a blur in wide pixels is {:.3} of that in square ones, not 1",
                ratio.y
            )
        });
        Ok(())
    })
}
