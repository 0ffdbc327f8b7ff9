//! Clips that are not connected, or connected without images.

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::{
    kOfxImageClipPropOptional, kOfxImageEffectContextGeneral,
};

use super::{Check, Report, fixture};
use crate::drive::{RenderRequest, status_name};
use crate::host::profile::Profile;
use crate::scene::{Feed, Input};
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "empty_clips",
    about: "an optional clip without image counts as unconnected; a Source without image does not crash",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, report| {
        let feeds = [
            ("not connected", Feed::Unconnected),
            ("failing", Feed::Fails),
            ("without an image", Feed::NullHandle),
            ("without data", Feed::NullData),
        ];
        let context = loaded.context_like(kOfxImageEffectContextGeneral)?;
        let descriptor = loaded.describe_in(&context)?;
        let optional: Vec<String> = (descriptor.clips().iter())
            .filter(|clip| clip.properties.int(kOfxImageClipPropOptional) == Some(1))
            .map(|clip| clip.name.clone())
            .collect();
        let request = RenderRequest::of_window(fixture::BOUNDS);
        let plain = fixture::render(loaded, subject, &fixture::scene(), &request)?.picture;
        for clip in optional {
            for (what, feed) in &feeds {
                let scene = fixture::scene().connect(&clip, Input::new(feed.clone()));
                let frame = fixture::render(loaded, subject, &scene, &request);
                report.expect_renders_same(&plain, frame, &format!("{clip} {what}"));
                // When the clip is in use, the render may fail, but must not write wrong pixels.
                let instance = fixture::blurring_instance(loaded, subject, &scene)?;
                fixture::use_depth_and_mask(&instance, subject)?;
                for fault in instance.render(&request)?.faults {
                    report.fault(format!("{clip} {what} and in use: {fault}"));
                }
                instance.destroy()?;
            }
        }
        for (what, feed) in &feeds {
            let scene = fixture::scene().connect("Source", Input::new(feed.clone()));
            let instance = fixture::blurring_instance(loaded, subject, &scene)?;
            let frame = instance.render(&request)?;
            report.expect([kOfxStatOK, kOfxStatFailed].contains(&frame.status), || {
                format!(
                    "Source {what}: Render returned {}",
                    status_name(frame.status)
                )
            });
            for fault in frame.faults {
                report.fault(format!("Source {what}: {fault}"));
            }
            instance.destroy()?;
        }
        descriptor.invalidate(loaded.host);
        Ok(())
    })
}
