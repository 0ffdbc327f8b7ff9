//! Concurrent renders.

use std::ffi::CStr;
use std::sync::Arc;

use openfx::sys::generic::core::kOfxActionPurgeCaches;
use openfx::sys::image_effect_v1::image_effect::*;

use super::{Check, Report, fixture};
use crate::drive::{Frame, Instance, RenderRequest};
use crate::host::profile::Profile;
use crate::picture::{Picture, Rect, plate};
use crate::scene::{Feed, Input};
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "concurrency",
    about: "frames rendered concurrently, on one instance and on several, equal those rendered one by one",
    run,
};

/// The number of concurrent frames.
const FRAMES: u32 = 5;

/// The number of attempts to make a race show.
const ATTEMPTS: u32 = 4;

fn request(frame: u32) -> RenderRequest {
    RenderRequest {
        time: f64::from(frame),
        ..RenderRequest::default()
    }
}

/// Renders each request on a thread of its own.
fn render_concurrently<'i>(
    jobs: impl Iterator<Item = (RenderRequest, &'i Instance<'i>)>,
) -> Vec<Result<Frame, String>> {
    std::thread::scope(|scope| {
        let threads: Vec<_> = jobs
            .map(|(request, instance)| scope.spawn(move || instance.render_checked(&request)))
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

/// Checks four concurrent tiles of one frame.
fn check_tiles(instance: &Instance<'_>, expected: &Picture, report: &mut Report) {
    let w = expected.bounds;
    let (x, y) = ((w.x1 + w.x2) / 2, (w.y1 + w.y2) / 2);
    let tiles = [
        Rect::new(w.x1, w.y1, x, y),
        Rect::new(x, w.y1, w.x2, y),
        Rect::new(w.x1, y, x, w.y2),
        Rect::new(x, y, w.x2, w.y2),
    ];
    let requests = tiles.map(|tile| RenderRequest {
        crop_inputs: true,
        ..RenderRequest::of_window(tile)
    });
    let jobs = requests.into_iter().map(|request| (request, instance));
    for frame in render_concurrently(jobs) {
        report.expect_renders_same(expected, frame, "concurrent tiles of one frame");
    }
}

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, report| {
        let safety = (loaded.descriptor.properties).texts(kOfxImageEffectPluginRenderThreadSafety);
        let is = |name: &CStr| safety.iter().any(|s| s.as_bytes() == name.to_bytes());
        if is(kOfxImageEffectRenderUnsafe) {
            report.skip("the plugin declares that it renders one frame at a time");
            return Ok(());
        }
        let pictures = (1..=FRAMES)
            .map(|n| Arc::new(plate(fixture::BOUNDS, 4, n)))
            .collect();
        let source = Input::new(Feed::Pictures(pictures));
        let scene = fixture::scene().connect("Source", source);
        let one = fixture::blurring_instance(loaded, subject, &scene)?;
        let expected = (0..FRAMES)
            .map(|n| Ok(one.render_checked(&request(n))?.picture))
            .collect::<Result<Vec<_>, String>>()?;
        let several = (0..FRAMES)
            .map(|_| fixture::blurring_instance(loaded, subject, &scene))
            .collect::<Result<Vec<_>, _>>()?;
        let mut cases = vec![("on several instances", several.iter().collect::<Vec<_>>())];
        let is_fully_safe = is(kOfxImageEffectRenderFullySafe);
        if is_fully_safe {
            cases.push(("on one instance", vec![&one]));
        } else {
            report.skip("the plugin declares that an instance renders one frame at a time");
        }
        for (what, instances) in cases {
            for _ in 0..ATTEMPTS {
                // A plugin may keep results, which need no work at the same time.
                one.act(kOfxActionPurgeCaches);
                let jobs = (0..FRAMES)
                    .map(request)
                    .zip(instances.iter().copied().cycle());
                for (n, frame) in render_concurrently(jobs).into_iter().enumerate() {
                    report.expect_renders_same(&expected[n], frame, &format!("frame {n} {what}"));
                }
            }
        }
        one.act(kOfxActionPurgeCaches);
        if loaded.supports_tiles() && is_fully_safe {
            check_tiles(&one, &expected[0], report);
        }
        for instance in several {
            instance.destroy()?;
        }
        one.destroy()
    })
}
