//! Images fetched and released.

use openfx::sys::generic::core::*;

use super::{Check, Report, stage};
use crate::drive::Request;
use crate::host::profile::Profile;
use crate::scene::{Feed, Input};
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "images",
    about: "every image is released once, Output's is fetched once, whatever comes of the render",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    stage::on(subject, report, Profile::complete(), |loaded, report| {
        let scene = stage::with_all(loaded, stage::scene())?;
        let instance = stage::blurring(loaded, subject, &scene)?;
        stage::use_all(&instance, subject)?;
        let request = Request {
            window: Some(stage::SIZE),
            ..Request::default()
        };
        let frame = instance.render(&request)?;
        let outputs = frame
            .fetched
            .iter()
            .filter(|clip| *clip == "Output")
            .count();
        report.expect(outputs == 1, || {
            format!("the image of Output is fetched {outputs} times in a render")
        });
        frame.good()?;
        // Whatever else comes of these.
        let mut cases = vec![("stopped at once", scene.clone(), true)];
        for (what, feed) in [
            ("that fails", Feed::Fails),
            ("without an image", Feed::NullHandle),
            ("without data", Feed::NullData),
        ] {
            for clip in instance
                .effect
                .clips()
                .iter()
                .filter(|c| c.name != "Output")
            {
                let scene = scene.clone().and(&clip.name, Input::of(feed.clone()));
                cases.push((what, scene, false));
            }
        }
        for (what, scene, stop) in cases {
            instance.connect(&scene);
            loaded.host.lose_patience_after(stop.then_some(0));
            let frame = instance.render(&request)?;
            for fault in frame.faults.iter().filter(|f| f.contains("not released")) {
                report.fault(format!("{what}: {fault}"));
            }
            report.expect(frame.status != kOfxStatErrFatal, || {
                format!("{what}: Render gave kOfxStatErrFatal")
            });
        }
        loaded.host.lose_patience_after(None);
        instance.destroy()
    })
}
