//! Whether what is asked for is enough.

use openfx::sys::image_effect_v1::image_effect::*;

use super::{Check, Report, stage};
use crate::drive::Request;
use crate::host::profile::Profile;
use crate::picture::Rect;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "regions_of_interest",
    about: "inputs cut to the regions of interest give the same picture as whole ones",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    stage::on(subject, report, Profile::complete(), |loaded, report| {
        let tiles = loaded
            .descriptor
            .properties
            .int(kOfxImageEffectPropSupportsTiles)
            != Some(0);
        let mut windows = vec![None];
        if tiles {
            let size = stage::SIZE;
            windows.push(Some(Rect::new(20, 15, 28, 22)));
            windows.push(Some(Rect::new(0, 0, 3, 3)));
            windows.push(Some(Rect::new(size.x2 - 5, 0, size.x2, size.y2)));
        }
        let scene = stage::with_all(loaded, stage::scene())?;
        let instance = stage::blurring(loaded, subject, &scene)?;
        let mut settings = vec![("as it is", None)];
        settings.extend(subject.kind.depth.map(|knobs| ("with depth", Some(knobs))));
        settings.extend(subject.kind.mask.map(|knobs| ("with a mask", Some(knobs))));
        for (what, knobs) in settings {
            if let Some(knobs) = knobs {
                stage::set(&instance, knobs)?;
            }
            for window in &windows {
                let frame = |crop| {
                    instance.render(&Request {
                        window: *window,
                        crop,
                        ..Request::default()
                    })
                };
                let (whole, cut) = (frame(false)?.good()?, frame(true)?.good()?);
                report.none(
                    whole.picture.difference(&cut.picture, whole.window),
                    &format!("{what}, window {window:?}"),
                );
            }
        }
        instance.destroy()
    })
}
