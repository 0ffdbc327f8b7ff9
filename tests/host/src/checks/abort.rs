//! Renders that are to stop.

use std::sync::atomic::Ordering;

use openfx::sys::generic::core::*;

use super::{Check, Report, stage};
use crate::drive::{Request, status_name};
use crate::host::profile::Profile;
use crate::picture::{Rect, plate};
use crate::scene::Scene;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "abort",
    about: "a render that is told to stop does, lets go of everything, and the next one is right",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    stage::on(subject, report, Profile::complete(), |loaded, report| {
        let host = loaded.host;
        let scene = Scene::of(plate(Rect::new(0, 0, 90, 160), 4, 1));
        let instance = stage::blurring(loaded, subject, &scene)?;
        let request = Request::default();
        host.lose_patience_after(None);
        let expected = instance.render(&request)?.good()?;
        let polls = host.counts.polls.load(Ordering::SeqCst);
        if polls == 0 {
            if subject.kind.polls {
                report.fault("a whole render never asks whether to stop");
            } else {
                report.skip("the render is too short to ask whether to stop");
            }
        }
        for after in [0, 1, polls / 2] {
            host.lose_patience_after(Some(after));
            let frame = instance.render(&request)?;
            let asked = host.counts.polls.load(Ordering::SeqCst);
            let told = host.counts.polls_told.load(Ordering::SeqCst);
            host.lose_patience_after(None);
            report.expect([kOfxStatOK, kOfxStatFailed].contains(&frame.status), || {
                format!(
                    "told to stop after {after} polls Render gave {}",
                    status_name(frame.status)
                )
            });
            for fault in frame.faults.iter().filter(|f| !f.contains("not written")) {
                report.fault(format!("told to stop after {after} polls: {fault}"));
            }
            // Every thread may ask once more, and the one that was told may look again.
            let enough = 2 * host.profile.processors as usize + 2;
            if told > enough {
                report.fault(format!(
                    "told to stop after {after} of {polls} polls, it asked {asked} times in all"
                ));
            }
            let again = instance.render(&request)?.good()?;
            report.none(
                expected.picture.difference(&again.picture, again.window),
                &format!("after a render that was told to stop after {after} polls"),
            );
        }
        instance.destroy()
    })
}
