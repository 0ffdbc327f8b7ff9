//! The regions of interest.

use super::{Check, Report, fixture};
use crate::drive::RenderRequest;
use crate::host::profile::Profile;
use crate::picture::Rect;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "regions_of_interest",
    about: "inputs cropped to the regions of interest give the same picture as whole ones",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    check(subject, report, Profile::complete(), "complete host")?;
    let late = Profile {
        late_regions: true,
        ..Profile::complete()
    };
    check(subject, report, late, "no regions of clips before a render")
}

fn check(
    subject: &Subject,
    report: &mut Report,
    profile: Profile,
    host: &str,
) -> Result<(), String> {
    fixture::with_plugin(subject, report, profile, |loaded, report| {
        let mut windows = vec![None];
        // The host with late regions is openfx-runner, which crops the inputs of all plugins.
        if loaded.supports_tiles() || loaded.host.profile.late_regions {
            let bounds = fixture::BOUNDS;
            windows.push(Some(Rect::new(20, 15, 28, 22)));
            windows.push(Some(Rect::new(0, 0, 3, 3)));
            windows.push(Some(Rect::new(bounds.x2 - 5, 0, bounds.x2, bounds.y2)));
        }
        let scene = fixture::connect_all(loaded, fixture::scene())?;
        let instance = fixture::blurring_instance(loaded, subject, &scene)?;
        let mut settings = vec![("blur", None)];
        settings.extend(subject.kind.depth.map(|depth| ("with depth", Some(depth))));
        settings.extend(subject.kind.mask.map(|mask| ("with a mask", Some(mask))));
        for (what, settings) in settings {
            if let Some(settings) = settings {
                fixture::apply(&instance, settings)?;
            }
            for window in &windows {
                let request = RenderRequest {
                    window: *window,
                    ..RenderRequest::default()
                };
                let whole = instance.render_checked(&request)?;
                let cropped = instance.render_checked(&RenderRequest {
                    crop_inputs: true,
                    ..request
                })?;
                let case = format!("{what}, {host}, window {window:?}");
                report.expect_same(&whole.picture, &cropped, &case);
            }
        }
        instance.destroy()
    })
}
