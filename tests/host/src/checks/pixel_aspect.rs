//! Pixels that are not square.

use super::{Check, Report, stage};
use crate::drive::Request;
use crate::host::profile::Profile;
use crate::picture::{Picture, Rect};
use crate::scene::Scene;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "pixel_aspect",
    about: "where pixels are twice as wide a blur has half as many of them across, and as many up",
    run,
};

/// Standard deviations of the light across and up, in pixels.
pub(super) fn spread(picture: &Picture) -> (f64, f64) {
    let mut sums = [0.0_f64; 5];
    for (x, y) in picture.bounds.pixels() {
        let light = f64::from(picture.pixel(x, y)[0]);
        let (x, y) = (f64::from(x), f64::from(y));
        for (sum, term) in sums.iter_mut().zip([1.0, x, y, x * x, y * y]) {
            *sum += light * term;
        }
    }
    let [all, x, y, xx, yy] = sums;
    let deviation =
        |first: f64, second: f64| (second / all - (first / all).powi(2)).max(0.0).sqrt();
    (deviation(x, xx), deviation(y, yy))
}

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    stage::on(subject, report, Profile::complete(), |loaded, report| {
        // The same frame: 64 by 48 square pixels, 32 by 48 wide ones. The light is two square pixels wide.
        let light = |width: i32, columns: std::ops::Range<i32>| {
            Picture::made(Rect::new(0, 0, width, 48), 4, |x, y, c| {
                let lit = columns.contains(&x) && y == 24;
                if lit || c == 3 { 1.0 } else { 0.0 }
            })
        };
        let scenes = [
            Scene::of(light(64, 32..34)),
            Scene::with_par(light(32, 16..17), 2.0),
        ];
        let mut spreads = Vec::new();
        for scene in scenes {
            let frame = stage::rendered(loaded, subject, &scene, &Request::default())?;
            spreads.push((spread(&frame.picture), frame.window));
        }
        let [(square, one), (wide, two)] = spreads[..] else {
            return Err("two frames were rendered".to_owned());
        };
        report.expect(one.width().abs_diff(2 * two.width()) <= 4, || {
            format!("Output is {one:?} of square pixels and {two:?} of wide ones")
        });
        let tolerance = subject.kind.half_width;
        let (across, up) = (wide.0 / square.0, wide.1 / square.1);
        report.expect((across - 0.5).abs() <= tolerance, || {
            format!("a blur of wide pixels is {across:.3} as many across as one of square pixels, not 0.5")
        });
        report.expect((up - 1.0).abs() <= tolerance, || {
            format!("a blur of wide pixels is {up:.3} as many high as one of square pixels, not 1")
        });
        Ok(())
    })
}
