//! Clips that are not connected, or say that they are and give nothing.

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::kOfxImageClipPropOptional;

use super::{Check, Report, stage};
use crate::drive::Request;
use crate::host::profile::Profile;
use crate::scene::{Feed, Input};
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "empty_clips",
    about: "an optional clip that gives nothing is as one that is not connected; Source that gives nothing crashes nothing",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    stage::on(subject, report, Profile::complete(), |loaded, report| {
        let feeds = [
            ("not connected", Feed::Unconnected),
            ("failing", Feed::Fails),
            ("without an image", Feed::NullHandle),
            ("without data", Feed::NullData),
        ];
        let context = loaded.context(true)?;
        let descriptor = loaded.describe_in(&context)?;
        let optional: Vec<String> = (descriptor.clips().iter())
            .filter(|clip| clip.properties.int(kOfxImageClipPropOptional) == Some(1))
            .map(|clip| clip.name.clone())
            .collect();
        let request = Request {
            window: Some(stage::SIZE),
            ..Request::default()
        };
        let plain = stage::rendered(loaded, subject, &stage::scene(), &request)?;
        for clip in optional {
            for (what, feed) in &feeds {
                let scene = stage::scene().and(&clip, Input::of(feed.clone()));
                match stage::rendered(loaded, subject, &scene, &request) {
                    Ok(frame) => report.none(
                        plain.picture.difference(&frame.picture, frame.window),
                        &format!("{clip} {what}"),
                    ),
                    Err(why) => report.fault(format!("{clip} {what}: {why}")),
                }
                // Looked at all the same: anything but a crash or a wrong frame.
                let instance = stage::blurring(loaded, subject, &scene)?;
                stage::use_all(&instance, subject)?;
                let frame = instance.render(&request)?;
                for fault in frame.faults {
                    report.fault(format!("{clip} {what} and looked at: {fault}"));
                }
                instance.destroy()?;
            }
        }
        for (what, feed) in &feeds {
            let scene = stage::scene().and("Source", Input::of(feed.clone()));
            let instance = stage::blurring(loaded, subject, &scene)?;
            let frame = instance.render(&request)?;
            report.expect([kOfxStatOK, kOfxStatFailed].contains(&frame.status), || {
                format!(
                    "Source {what}: Render gave {}",
                    crate::drive::status_name(frame.status)
                )
            });
            for fault in frame.faults {
                report.fault(format!("Source {what}: {fault}"));
            }
            instance.destroy()?;
        }
        descriptor.end(loaded.host);
        Ok(())
    })
}
