//! Other modes of the plugin.

use super::{Check, Report, fixture};
use crate::drive::RenderRequest;
use crate::host::profile::{Profile, RowLayout};
use crate::picture::Rect;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "variants",
    about: "other modes render whole frames, the same for any row layout, number of threads, crop and tiling",
    run,
};

/// Another way to render the same frame.
struct Variation {
    name: &'static str,
    request: RenderRequest,
    processors: usize,
}

fn variations(with_tiles: bool) -> Vec<Variation> {
    let bounds = fixture::BOUNDS;
    let whole = || RenderRequest::of_window(bounds);
    let variation = |name, request| Variation {
        name,
        request,
        processors: 3,
    };
    // Two renders show what four would: a picture that changes from render to render differs from that of one thread, too.
    let mut variations = vec![
        Variation {
            processors: 1,
            ..variation("again, with one thread", whole())
        },
        variation(
            "from the top down with cropped inputs",
            RenderRequest {
                rows: Some(RowLayout::NegativeOdd),
                crop_inputs: true,
                ..whole()
            },
        ),
    ];
    if with_tiles {
        let middle = (bounds.x1 + bounds.x2) / 2;
        let request = RenderRequest {
            tiles: vec![
                Rect::new(middle, bounds.y1, bounds.x2, bounds.y2),
                Rect::new(bounds.x1, bounds.y1, middle, bounds.y2),
            ],
            crop_inputs: true,
            ..whole()
        };
        variations.push(variation("in two tiles", request));
    }
    variations
}

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    if subject.kind.variants.is_empty() {
        report.skip("no other modes are known");
        return Ok(());
    }
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, report| {
        let variations = variations(loaded.supports_tiles());
        let connected = fixture::connect_all(loaded, fixture::scene())?;
        let more = subject.kind.connected_variants;
        for (scene, more) in [(fixture::scene(), &[][..]), (connected, more)] {
            for settings in subject.kind.variants.iter().chain(more) {
                let instance = fixture::blurring_instance(loaded, subject, &scene)?;
                fixture::apply(&instance, settings)?;
                let whole = RenderRequest::of_window(fixture::BOUNDS);
                let expected = match instance.render_checked(&whole) {
                    Ok(frame) => frame.picture,
                    Err(fault) => {
                        report.fault(format!("{settings:?}: {fault}"));
                        continue;
                    }
                };
                for variation in &variations {
                    loaded.host.set_processors(variation.processors);
                    let frame = instance.render_checked(&variation.request);
                    let case = format!("{settings:?} {}", variation.name);
                    report.expect_renders_same(&expected, frame, &case);
                }
                instance.destroy()?;
            }
        }
        Ok(())
    })
}
