//! Frames rendered in pieces.

use openfx::sys::image_effect_v1::image_effect::*;

use super::{Check, Report, stage};
use crate::drive::Request;
use crate::host::profile::Profile;
use crate::picture::Rect;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "tiles",
    about: "a frame in tiles of any shape and order is the whole frame, bit for bit",
    run,
};

/// The window in pieces of that size.
fn pieces(window: Rect, width: i32, height: i32) -> Vec<Rect> {
    let mut all = Vec::new();
    let mut y = window.y1;
    while y < window.y2 {
        let mut x = window.x1;
        while x < window.x2 {
            all.push(Rect::new(x, y, x + width, y + height).and(&window));
            x += width;
        }
        y += height;
    }
    all
}

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    stage::on(subject, report, Profile::complete(), |loaded, report| {
        if loaded
            .descriptor
            .properties
            .int(kOfxImageEffectPropSupportsTiles)
            == Some(0)
        {
            report.skip("the plugin says that it renders no tiles");
            return Ok(());
        }
        for scene in [stage::scene(), stage::with_all(loaded, stage::scene())?] {
            let instance = stage::blurring(loaded, subject, &scene)?;
            stage::use_all(&instance, subject)?;
            let whole = instance.render(&Request::default())?.good()?;
            let window = whole.window;
            for (width, height) in [(16, 16), (7, 64), (64, 3), (1000, 1000)] {
                for crop in [false, true] {
                    for backwards in [false, true] {
                        let mut tiles = pieces(window, width, height);
                        if backwards {
                            tiles.reverse();
                        }
                        let request = Request {
                            tiles,
                            crop,
                            tight: backwards,
                            ..Request::default()
                        };
                        let title = format!(
                            "tiles of {width} x {height}, inputs cropped: {crop}, last first: {backwards}"
                        );
                        match instance.render(&request)?.good() {
                            Ok(frame) => {
                                report
                                    .none(whole.picture.difference(&frame.picture, window), &title);
                            }
                            Err(why) => report.fault(format!("{title}: {why}")),
                        }
                    }
                }
            }
            instance.destroy()?;
        }
        Ok(())
    })
}
