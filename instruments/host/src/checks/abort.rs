//! Aborted renders.

use std::sync::atomic::Ordering;

use openfx::sys::generic::core::*;

use super::{Check, Report, fixture};
use crate::drive::{RenderRequest, status_name};
use crate::host::profile::Profile;
use crate::picture::{Rect, plate};
use crate::scene::Scene;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "abort",
    about: "an aborted render stops and releases everything, and the next render is correct",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, report| {
        let host = loaded.host;
        let scene = Scene::new(plate(Rect::new(0, 0, 90, 160), 4, 1));
        let instance = fixture::blurring_instance(loaded, subject, &scene)?;
        let request = RenderRequest::default();
        host.abort_after(None);
        let expected = instance.render_checked(&request)?.picture;
        let polls = host.counters.abort_polls.load(Ordering::SeqCst);
        if polls == 0 {
            if subject.kind.polls_abort {
                report.fault("a whole render never calls abort");
            } else {
                report.skip("the render is too short to call abort");
            }
        }
        for after in [0, 1, polls / 2] {
            let case = format!("aborted after {after} polls");
            // A plugin may keep results, which need no work that could be aborted.
            instance.act(kOfxActionPurgeCaches);
            host.abort_after(Some(after));
            let frame = instance.render(&request)?;
            let total = host.counters.abort_polls.load(Ordering::SeqCst);
            let replies = host.counters.abort_replies.load(Ordering::SeqCst);
            host.abort_after(None);
            report.expect([kOfxStatOK, kOfxStatFailed].contains(&frame.status), || {
                format!("{case}, Render returned {}", status_name(frame.status))
            });
            for fault in frame.faults.iter().filter(|f| !f.contains("not written")) {
                report.fault(format!("{case}: {fault}"));
            }
            // Each thread may poll once more, and poll again before it stops.
            let max_replies = 2 * host.profile.processors as usize + 2;
            report.expect(replies <= max_replies, || {
                format!("{case}, the render went on for {total} polls of {polls}")
            });
            let frame = instance.render_checked(&request)?;
            report.expect_same(&expected, &frame, &format!("after a render {case}"));
        }
        instance.destroy()
    })
}
