//! Pictures of a pixel, and of none.

use super::{Check, Report, stage};
use crate::drive::{Request, status_name};
use crate::host::profile::Profile;
use crate::picture::{Rect, plate};
use crate::scene::Scene;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "tiny",
    about: "pictures of one pixel, one row or none are rendered, and windows of nothing",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    stage::on(subject, report, Profile::complete(), |loaded, report| {
        for (width, height) in [(1, 1), (1, 9), (9, 1), (2, 2)] {
            let scene = Scene::of(plate(Rect::new(0, 0, width, height), 4, 1));
            let done = stage::rendered(loaded, subject, &scene, &Request::default());
            report.none(done.err(), &format!("a picture of {width} x {height}"));
        }
        // Nothing is the right picture of nothing; that it is said to fail is right as well.
        let nothing = Scene::of(plate(Rect::new(0, 0, 0, 0), 4, 1));
        for (what, scene, window) in [
            ("an empty Source", nothing, Some(Rect::new(0, 0, 4, 4))),
            (
                "an empty window",
                stage::scene(),
                Some(Rect::new(5, 5, 5, 5)),
            ),
        ] {
            let instance = stage::blurring(loaded, subject, &scene)?;
            let frame = instance.render(&Request {
                window,
                ..Request::default()
            })?;
            report.expect([0, 1].contains(&frame.status), || {
                format!("{what}: Render gave {}", status_name(frame.status))
            });
            for fault in frame.faults {
                report.fault(format!("{what}: {fault}"));
            }
            instance.destroy()?;
        }
        Ok(())
    })
}
