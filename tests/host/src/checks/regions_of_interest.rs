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
    of(subject, report, Profile::complete(), "")?;
    let late = Profile {
        late_regions: true,
        ..Profile::complete()
    };
    of(
        subject,
        report,
        late,
        "without a region before the render, ",
    )
}

fn of(subject: &Subject, report: &mut Report, profile: Profile, host: &str) -> Result<(), String> {
    stage::on(subject, report, profile, |loaded, report| {
        let says = loaded
            .descriptor
            .properties
            .int(kOfxImageEffectPropSupportsTiles);
        // The host that has no regions yet is openfx-runner: it cuts inputs for every plugin.
        let tiles = says != Some(0) || loaded.host.profile.late_regions;
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
                    &format!("{what}, {host}window {window:?}"),
                );
            }
        }
        instance.destroy()
    })
}
