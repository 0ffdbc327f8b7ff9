//! Fetching and releasing images.

use openfx::sys::generic::core::*;

use super::{Check, Report, fixture};
use crate::drive::RenderRequest;
use crate::host::profile::Profile;
use crate::scene::{Feed, Input, Scene};
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "image_release",
    about: "every image is released once and that of Output is fetched once, even if the render fails",
    run,
};

/// A render that may fail.
struct Case {
    name: String,
    scene: Scene,
    /// Whether the first poll aborts the render.
    aborts: bool,
}

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, report| {
        let scene = fixture::connect_all(loaded, fixture::scene())?;
        let instance = fixture::blurring_instance(loaded, subject, &scene)?;
        fixture::use_depth_and_mask(&instance, subject)?;
        let request = RenderRequest::of_window(fixture::BOUNDS);
        let frame = instance.render_checked(&request)?;
        let clips = frame.fetched_clips.iter();
        let outputs = clips.filter(|clip| *clip == "Output").count();
        report.expect(outputs == 1, || {
            format!("a render fetches the image of Output {outputs} times")
        });
        let mut cases = vec![Case {
            name: "an aborted render".to_owned(),
            scene: scene.clone(),
            aborts: true,
        }];
        let clips = instance.effect.clips();
        for clip in clips.iter().filter(|clip| clip.name != "Output") {
            for (what, feed) in [
                ("fails", Feed::Fails),
                ("has no image", Feed::NullHandle),
                ("has no data", Feed::NullData),
            ] {
                cases.push(Case {
                    name: format!("{} {what}", clip.name),
                    scene: scene.clone().connect(&clip.name, Input::new(feed)),
                    aborts: false,
                });
            }
        }
        for case in cases {
            instance.connect(&case.scene);
            loaded.host.abort_after(case.aborts.then_some(0));
            let frame = instance.render(&request)?;
            for fault in frame.faults.iter().filter(|f| f.contains("not released")) {
                report.fault(format!("{}: {fault}", case.name));
            }
            report.expect(frame.status != kOfxStatErrFatal, || {
                format!("{}: Render returned kOfxStatErrFatal", case.name)
            });
        }
        loaded.host.abort_after(None);
        instance.destroy()
    })
}
