//! What the plugin does besides: other modes, other outputs.

use openfx::sys::image_effect_v1::image_effect::*;

use super::{Check, Report, stage};
use crate::drive::Request;
use crate::host::profile::{Profile, Rows};
use crate::picture::Rect;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "variants",
    about: "other modes write whole frames, the same for any rows, number of threads, region and tile",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    if subject.kind.variants.is_empty() {
        report.skip("no other settings are known");
        return Ok(());
    }
    stage::on(subject, report, Profile::complete(), |loaded, report| {
        let tiles = loaded
            .descriptor
            .properties
            .int(kOfxImageEffectPropSupportsTiles)
            != Some(0);
        let size = stage::SIZE;
        let whole = Request {
            window: Some(size),
            ..Request::default()
        };
        let mut others = vec![
            ("again", whole.clone(), 3),
            ("with one thread", whole.clone(), 1),
            (
                "from the top down",
                Request {
                    rows: Some(Rows::NegativeOdd),
                    ..whole.clone()
                },
                3,
            ),
            (
                "with inputs cropped",
                Request {
                    crop: true,
                    ..whole.clone()
                },
                3,
            ),
        ];
        if tiles {
            let middle = (size.x1 + size.x2) / 2;
            let halves = vec![
                Rect::new(middle, size.y1, size.x2, size.y2),
                Rect::new(size.x1, size.y1, middle, size.y2),
            ];
            let request = Request {
                tiles: halves,
                crop: true,
                ..whole.clone()
            };
            others.push(("in two halves", request, 3));
        }
        for scene in [stage::scene(), stage::with_all(loaded, stage::scene())?] {
            for knobs in subject.kind.variants {
                let instance = stage::blurring(loaded, subject, &scene)?;
                stage::set(&instance, knobs)?;
                let first = match instance.render(&whole)?.good() {
                    Ok(first) => first,
                    Err(why) => {
                        report.fault(format!("{knobs:?}: {why}"));
                        continue;
                    }
                };
                for (what, request, threads) in &others {
                    loaded.host.set_threads(*threads, false);
                    match instance.render(request)?.good() {
                        Ok(frame) => report.none(
                            first.picture.difference(&frame.picture, size),
                            &format!("{knobs:?} {what}"),
                        ),
                        Err(why) => report.fault(format!("{knobs:?} {what}: {why}")),
                    }
                }
                instance.destroy()?;
            }
        }
        Ok(())
    })
}
