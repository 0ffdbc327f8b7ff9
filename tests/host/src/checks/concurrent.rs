//! Several frames at once.

use std::sync::Arc;

use openfx::sys::image_effect_v1::image_effect::*;

use super::{Check, Report, stage};
use crate::drive::{Frame, Instance, Request};
use crate::host::profile::Profile;
use crate::picture::{Rect, plate};
use crate::scene::{Feed, Input, Scene};
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "concurrent",
    about: "frames rendered at once, on one instance and on several, are those rendered one by one",
    run,
};

const FRAMES: u32 = 5;

fn at_once(instances: &[&Instance<'_>]) -> Vec<Result<Frame, String>> {
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..FRAMES)
            .map(|n| {
                let instance = instances[n as usize % instances.len()];
                scope.spawn(move || {
                    instance
                        .render(&Request {
                            time: f64::from(n),
                            ..Request::default()
                        })?
                        .good()
                })
            })
            .collect();
        threads
            .into_iter()
            .map(|thread| {
                thread
                    .join()
                    .unwrap_or_else(|_| Err("the host panicked".to_owned()))
            })
            .collect()
    })
}

/// One frame as four tiles at once.
fn quarters(instance: &Instance<'_>, whole: &Frame, report: &mut Report) {
    let w = whole.window;
    let (x, y) = ((w.x1 + w.x2) / 2, (w.y1 + w.y2) / 2);
    let tiles = [
        Rect::new(w.x1, w.y1, x, y),
        Rect::new(x, w.y1, w.x2, y),
        Rect::new(w.x1, y, x, w.y2),
        Rect::new(x, y, w.x2, w.y2),
    ];
    let frames: Vec<Result<Frame, String>> = std::thread::scope(|scope| {
        let render = |tile: Rect| {
            let request = Request {
                window: Some(tile),
                crop: true,
                ..Request::default()
            };
            instance.render(&request)?.good()
        };
        let threads = tiles.map(|tile| scope.spawn(move || render(tile)));
        threads
            .map(|thread| (thread.join()).unwrap_or_else(|_| Err("the host panicked".to_owned())))
            .into()
    });
    for frame in frames {
        match frame {
            Ok(frame) => report.none(
                whole.picture.difference(&frame.picture, frame.window),
                "tiles of one frame at once",
            ),
            Err(why) => report.fault(format!("tiles of one frame at once: {why}")),
        }
    }
}

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    stage::on(subject, report, Profile::complete(), |loaded, report| {
        let safety = (loaded.descriptor.properties).texts(kOfxImageEffectPluginRenderThreadSafety);
        let is = |name: &std::ffi::CStr| safety.iter().any(|s| s.as_bytes() == name.to_bytes());
        if is(kOfxImageEffectRenderUnsafe) {
            report.skip("the plugin says that it renders one frame at a time");
            return Ok(());
        }
        let pictures = (1..=FRAMES)
            .map(|n| Arc::new(plate(stage::SIZE, 4, n)))
            .collect();
        let source = Input::of(Feed::Pictures(pictures));
        let scene: Scene = stage::scene().and("Source", source);
        let one = stage::blurring(loaded, subject, &scene)?;
        let mut expected = Vec::new();
        for n in 0..FRAMES {
            let request = Request {
                time: f64::from(n),
                ..Request::default()
            };
            expected.push(one.render(&request)?.good()?);
        }
        let others: Vec<_> = (0..FRAMES)
            .map(|_| stage::blurring(loaded, subject, &scene))
            .collect::<Result<_, _>>()?;
        let mut cases = vec![("on several instances", others.iter().collect::<Vec<_>>())];
        if is(kOfxImageEffectRenderFullySafe) {
            cases.push(("on one instance", vec![&one]));
        } else {
            report.skip("the plugin says that an instance renders one frame at a time");
        }
        for (what, instances) in cases {
            for _ in 0..4 {
                for (n, frame) in at_once(&instances).into_iter().enumerate() {
                    match frame {
                        Ok(frame) => report.none(
                            expected[n].picture.difference(&frame.picture, frame.window),
                            &format!("frame {n} {what}"),
                        ),
                        Err(why) => report.fault(format!("frame {n} {what}: {why}")),
                    }
                }
            }
        }
        let tiles = loaded
            .descriptor
            .properties
            .int(kOfxImageEffectPropSupportsTiles)
            != Some(0);
        if tiles && is(kOfxImageEffectRenderFullySafe) {
            quarters(&one, &expected[0], report);
        }
        for instance in others {
            instance.destroy()?;
        }
        one.destroy()
    })
}
